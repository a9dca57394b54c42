"""The kernels of `linecontact.kernels` with one thread per element, as one would write them first: the baseline.

Same names and arguments. The chunks' sums are added up by atomics, in float64, onto what is there.
"""

from typing import Any

import warp as wp
from linecontact.kernels.layout import BOUND, CHUNK, DT, GAIN, LEVEL, MIX, STEP
from linecontact.kernels.warp_fire import advance, held

wp.set_module_options({"enable_backward": False})

CHUNK_LENGTH = wp.constant(CHUNK)


@wp.func
def add(sums: wp.array[wp.float64], i: int, value: Any):
    """To the sum of the chunk that holds element i."""
    wp.atomic_add(sums, i // CHUNK_LENGTH, wp.float64(value))


@wp.func
def free_force(load: Any, elastic: Any, v: Any):
    """r = load - K u, 0 on held nodes, and 1 there."""
    r = load - elastic
    on_wall = held(r, v)
    zero = type(elastic)(0.0)
    return wp.where(on_wall, zero, r), wp.where(on_wall, type(elastic)(1.0), zero)


@wp.kernel
def spectral_multiply(coefficient: wp.array[Any], spectrum: wp.array[Any]):
    """spectrum *= coefficient."""
    i = wp.tid()
    spectrum[i] = coefficient[i] * spectrum[i]


@wp.kernel
def mirror_multiply(straight: wp.array[Any], crossed: wp.array[Any], spectrum: wp.array[Any]):
    """A mode's real and imaginary part from both of them; the thread of the real part does both."""
    i = wp.tid()
    if i % 2 == 0:
        re = spectrum[i]
        im = spectrum[i + 1]
        spectrum[i] = straight[i] * re + crossed[i] * im
        spectrum[i + 1] = straight[i + 1] * im + crossed[i + 1] * re


@wp.kernel
def net_force(
    load: wp.array[Any],
    elastic: wp.array[Any],
    velocity: wp.array[Any],
    force: wp.array[Any],
    force_sums: wp.array[wp.float64],
    held_sums: wp.array[wp.float64],
):
    """Free force, its squares, held nodes."""
    i = wp.tid()
    f, count = free_force(load[i], elastic[i], velocity[i])
    force[i] = f
    add(force_sums, i, f * f)
    add(held_sums, i, count)


@wp.kernel
def plain_sums(
    elastic: wp.array[Any],
    velocity: wp.array[Any],
    force_sums: wp.array[wp.float64],
    held_sums: wp.array[wp.float64],
    power_sums: wp.array[wp.float64],
    velocity_sums: wp.array[wp.float64],
):
    """f.f, held nodes, v.f, v.v."""
    i = wp.tid()
    v = velocity[i]
    f, count = free_force(elastic.dtype(1.0), elastic[i], v)
    add(force_sums, i, f * f)
    add(held_sums, i, count)
    add(power_sums, i, v * f)
    add(velocity_sums, i, v * v)


@wp.kernel
def search_sums(
    force: wp.array[Any],
    velocity: wp.array[Any],
    acceleration: wp.array[Any],
    power_sums: wp.array[wp.float64],
    velocity_sums: wp.array[wp.float64],
    acceleration_sums: wp.array[wp.float64],
):
    """Acceleration on the free nodes; v.f, v.v, a.a."""
    i = wp.tid()
    f = force[i]
    v = velocity[i]
    a = wp.where(f == force.dtype(0.0), force.dtype(0.0), acceleration[i])
    acceleration[i] = a
    add(power_sums, i, v * f)
    add(velocity_sums, i, v * v)
    add(acceleration_sums, i, a * a)


@wp.kernel
def restrict_to_free(
    force: wp.array[Any], field: wp.array[Any], restricted: wp.array[Any], squares: wp.array[wp.float64]
):
    """Field on the free nodes and its squares."""
    i = wp.tid()
    x = wp.where(force[i] == field.dtype(0.0), field.dtype(0.0), field[i])
    restricted[i] = x
    add(squares, i, x * x)


@wp.kernel
def fire_step(
    acceleration: wp.array[Any],
    h: wp.array[Any],
    state: wp.array[wp.float64],
    u: wp.array[Any],
    v: wp.array[Any],
):
    """FIRE's update and the wall."""
    i = wp.tid()
    mix, gain, dt = u.dtype(state[MIX]), u.dtype(state[GAIN]), u.dtype(state[DT])
    ui, vi = advance(u[i], v[i], acceleration[i], h[i], mix, gain, dt)
    u[i] = ui
    v[i] = vi


@wp.kernel
def plain_step(
    elastic: wp.array[Any],
    h: wp.array[Any],
    state: wp.array[wp.float64],
    u: wp.array[Any],
    v: wp.array[Any],
):
    """FIRE's update along the free force, and the wall."""
    i = wp.tid()
    mix, gain, dt = u.dtype(state[MIX]), u.dtype(state[GAIN]), u.dtype(state[DT])
    f, _ = free_force(u.dtype(1.0), elastic[i], v[i])
    ui, vi = advance(u[i], v[i], f, h[i], mix, gain, dt)
    u[i] = ui
    v[i] = vi


@wp.kernel
def advance_response(change: wp.array[Any], state: wp.array[wp.float64], response: wp.array[Any]):
    """w += step (G d)."""
    i = wp.tid()
    response[i] = response[i] + response.dtype(state[STEP]) * change[i]


@wp.kernel
def count_below(response: wp.array[Any], h: wp.array[Any], state: wp.array[wp.float64], counts: wp.array[wp.float64]):
    """Nodes where h + w is below the bound."""
    i = wp.tid()
    bound = h.dtype(state[BOUND])
    add(counts, i, wp.where(h[i] + response[i] < bound, h.dtype(1.0), h.dtype(0.0)))


@wp.kernel
def rest_on_wall(response: wp.array[Any], h: wp.array[Any], state: wp.array[wp.float64], u: wp.array[Any]):
    """u = min(level - w, h)."""
    i = wp.tid()
    u[i] = wp.min(h.dtype(state[LEVEL]) - response[i], h[i])
