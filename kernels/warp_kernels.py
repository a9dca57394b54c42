"""Warp kernels of the relaxation, float32 and float64 from one generic source.

Every array is one-dimensional and padded to a multiple of `CHUNK`; one thread works on one chunk. An inner loop whose
length is a compile-time power of two is what LLVM turns into vector code; a thread per element, a run-time bound or a
tail test stays scalar. The reassociation flags let it vectorise the sums as well.

A complex half spectrum is passed as its flat real view (re, im, re, im, ...), because Warp has no complex type.

The unknown u is the displacement towards the indenter, limited by the wall u <= h. Pressures are in units of the mean
external pressure, so the net force on a node is r = 1 - (K u). A node is *held* where u = h and r > 0 (the wall carries
it) and *free* elsewhere. Memory traffic is what costs here: whether u = h is read off the velocity, which a step
leaves at `TOUCHING` on the wall.
"""

import platform
from typing import Any

import warp as wp

from .layout import (
    ALPHA,
    ALPHA_START,
    BOUND,
    CHUNK,
    DT,
    DT_MAX,
    F_ALPHA,
    F_DEC,
    F_INC,
    GAIN,
    HELD,
    ITERATION,
    LEVEL,
    MIX,
    N_MIN,
    N_POSITIVE,
    NUM_POINTS,
    RESIDUAL,
    STEP,
    STIFFEST,
    STOPPED,
    TOLERANCE,
    TOUCHING,
)

# Left alone LLVM takes 512-bit vectors, which some processors split in two, and interleaves long loops too little: at
# 2^18 points `plain_step` took 20 % longer and most others 5 % (`linecontact study kernels`).
VECTORS = " -mprefer-vector-width=256 -mllvm -force-vector-interleave=4"

# Module flags replace the global string, so they are appended to it.
wp.set_module_options(
    {
        "enable_backward": False,
        "cpu_compiler_flags": (wp.config.cpu_compiler_flags or "")
        + " -mreassociate -fno-signed-zeros -ffp-contract=fast"
        + (VECTORS if platform.machine() in ("x86_64", "AMD64") else ""),
    }
)

CHUNK_LENGTH = wp.constant(CHUNK)
HALF_CHUNK = wp.constant(CHUNK // 2)
ON_WALL = wp.constant(TOUCHING)


@wp.func
def project_wall(u: Any, v: Any, h: Any):
    """Hard wall: a node that reaches u = h is put on it and stopped, with a velocity that marks it."""
    hit = u >= h
    return wp.where(hit, h, u), wp.where(hit, type(v)(ON_WALL), v)


@wp.func
def advance(u: Any, v: Any, a: Any, h: Any, mix: Any, gain: Any, dt: Any):
    """FIRE's update of one node: v = mix v + gain a, u += dt v, then the wall."""
    new = mix * v + gain * a
    return project_wall(u + dt * new, new, h)


@wp.func
def held(r: Any, v: Any):
    """On the wall and pressed against it."""
    return v == type(v)(ON_WALL) and r > type(r)(0.0)


@wp.kernel
def spectral_multiply(coefficient: wp.array[Any], spectrum: wp.array[Any]):
    """spectrum *= coefficient on the flat real view; the coefficient of a mode stands there twice (re, im)."""
    start = wp.tid() * CHUNK_LENGTH
    for j in range(CHUNK_LENGTH):
        i = start + j
        spectrum[i] = coefficient[i] * spectrum[i]


@wp.kernel
def mirror_multiply(straight: wp.array[Any], crossed: wp.array[Any], spectrum: wp.array[Any]):
    """re = straight re + crossed im, im = straight im + crossed re: any real-linear map of a mode with equal entries
    across, on flat real views; what an even field's operator does to the modes of its packed half."""
    start = wp.tid() * CHUNK_LENGTH
    for j in range(HALF_CHUNK):
        i = start + 2 * j
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
    """Free part of r = load - K u, with the chunk's sum of its squares and its number of held nodes."""
    tid = wp.tid()
    start = tid * CHUNK_LENGTH
    squares = elastic.dtype(0.0)
    count = elastic.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j
        r = load[i] - elastic[i]
        on_wall = held(r, velocity[i])
        f = wp.where(on_wall, elastic.dtype(0.0), r)
        force[i] = f
        squares += f * f
        count += wp.where(on_wall, elastic.dtype(1.0), elastic.dtype(0.0))
    force_sums[tid] = wp.float64(squares)
    held_sums[tid] = wp.float64(count)


@wp.kernel
def plain_sums(
    elastic: wp.array[Any],
    velocity: wp.array[Any],
    force_sums: wp.array[wp.float64],
    held_sums: wp.array[wp.float64],
    power_sums: wp.array[wp.float64],
    velocity_sums: wp.array[wp.float64],
):
    """Plain FIRE's sums f.f, v.f, v.v and the number of held nodes; the force is made again in `plain_step`."""
    tid = wp.tid()
    start = tid * CHUNK_LENGTH
    squares = elastic.dtype(0.0)
    count = elastic.dtype(0.0)
    power = elastic.dtype(0.0)
    vv = elastic.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j
        r = elastic.dtype(1.0) - elastic[i]
        v = velocity[i]
        on_wall = held(r, v)
        f = wp.where(on_wall, elastic.dtype(0.0), r)
        squares += f * f
        count += wp.where(on_wall, elastic.dtype(1.0), elastic.dtype(0.0))
        power += v * f
        vv += v * v
    force_sums[tid] = wp.float64(squares)
    held_sums[tid] = wp.float64(count)
    power_sums[tid] = wp.float64(power)
    velocity_sums[tid] = wp.float64(vv)


@wp.kernel
def search_sums(
    force: wp.array[Any],
    velocity: wp.array[Any],
    acceleration: wp.array[Any],
    power_sums: wp.array[wp.float64],
    velocity_sums: wp.array[wp.float64],
    acceleration_sums: wp.array[wp.float64],
):
    """Restrict the acceleration to the free nodes (in place) and sum v.f, v.v and a.a over the chunk."""
    tid = wp.tid()
    start = tid * CHUNK_LENGTH
    power = force.dtype(0.0)
    vv = force.dtype(0.0)
    aa = force.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j
        f = force[i]
        v = velocity[i]
        a = wp.where(f == force.dtype(0.0), force.dtype(0.0), acceleration[i])
        acceleration[i] = a
        power += v * f
        vv += v * v
        aa += a * a
    power_sums[tid] = wp.float64(power)
    velocity_sums[tid] = wp.float64(vv)
    acceleration_sums[tid] = wp.float64(aa)


@wp.kernel
def restrict_to_free(
    force: wp.array[Any],
    field: wp.array[Any],
    restricted: wp.array[Any],
    squares: wp.array[wp.float64],
):
    """restricted = field on free nodes and 0 on held ones (where the force is 0), with the sum of its squares."""
    tid = wp.tid()
    start = tid * CHUNK_LENGTH
    sum_of_squares = field.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j
        x = wp.where(force[i] == field.dtype(0.0), field.dtype(0.0), field[i])
        restricted[i] = x
        sum_of_squares += x * x
    squares[tid] = wp.float64(sum_of_squares)


@wp.func
def total(parts: wp.array[wp.float64]):
    s = wp.float64(0.0)
    for i in range(parts.shape[0]):
        s += parts[i]
    return s


@wp.kernel
def fire_control(
    force_sums: wp.array[wp.float64],
    held_sums: wp.array[wp.float64],
    power_sums: wp.array[wp.float64],
    velocity_sums: wp.array[wp.float64],
    acceleration_sums: wp.array[wp.float64],
    state: wp.array[wp.float64],
):
    """One thread: add the chunks' sums, apply FIRE's power rule, leave mix, gain and dt for the step."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    held = total(held_sums)
    free = wp.max(state[NUM_POINTS] - held, one)
    residual = wp.sqrt(total(force_sums) / free)
    state[RESIDUAL] = residual
    state[HELD] = held
    # not (>) also catches NaN: a diverged or converged state is stopped, so that u stays what the residual is of
    if not (residual > state[TOLERANCE]) or residual > wp.float64(1.0e30):
        state[STOPPED] = one
        state[MIX] = zero
        state[GAIN] = zero
    else:
        dt = state[DT]
        alpha = state[ALPHA]
        mix = zero
        gain = zero
        if total(power_sums) > zero:
            state[N_POSITIVE] = state[N_POSITIVE] + one
            if state[N_POSITIVE] > state[N_MIN]:
                dt = wp.min(dt * state[F_INC], state[DT_MAX])
                alpha = alpha * state[F_ALPHA]
            ratio = wp.sqrt(total(velocity_sums) / wp.max(total(acceleration_sums), wp.float64(1.0e-300)))
            # the mixing term is itself a gradient step: beyond 2/(dt lambda_max) it would blow up the stiffest mode
            mix = one - alpha
            gain = wp.min(alpha * ratio, one / (dt * state[STIFFEST]))
        else:
            state[N_POSITIVE] = zero
            alpha = state[ALPHA_START]
            if state[ITERATION] > zero:
                dt = dt * state[F_DEC]
        state[DT] = wp.max(dt, wp.float64(0.02) * state[DT_MAX])
        state[ALPHA] = alpha
        state[MIX] = mix
        state[GAIN] = gain + state[DT]
        state[ITERATION] = state[ITERATION] + one


@wp.kernel
def fire_step(
    acceleration: wp.array[Any],
    h: wp.array[Any],
    state: wp.array[wp.float64],
    u: wp.array[Any],
    v: wp.array[Any],
):
    """v = mix v + gain a, u += dt v, then the hard wall: FIRE's fused update and projection in one pass."""
    start = wp.tid() * CHUNK_LENGTH
    mix = u.dtype(state[MIX])
    gain = u.dtype(state[GAIN])
    dt = u.dtype(state[DT])
    for j in range(CHUNK_LENGTH):
        i = start + j
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
    """`fire_step` with the free force, made from K u, as the acceleration."""
    start = wp.tid() * CHUNK_LENGTH
    mix = u.dtype(state[MIX])
    gain = u.dtype(state[GAIN])
    dt = u.dtype(state[DT])
    for j in range(CHUNK_LENGTH):
        i = start + j
        r = u.dtype(1.0) - elastic[i]
        f = wp.where(held(r, v[i]), u.dtype(0.0), r)
        ui, vi = advance(u[i], v[i], f, h[i], mix, gain, dt)
        u[i] = ui
        v[i] = vi


@wp.kernel
def advance_response(change: wp.array[Any], state: wp.array[wp.float64], response: wp.array[Any]):
    """w += step (G d): the response w = G sigma follows a step along the direction d; the gap is h + w - level.

    In mixed precision the change is float32 and the response float64.
    """
    start = wp.tid() * CHUNK_LENGTH
    step = response.dtype(state[STEP])
    for j in range(CHUNK_LENGTH):
        i = start + j
        response[i] = response[i] + step * response.dtype(change[i])


@wp.kernel
def count_below(response: wp.array[Any], h: wp.array[Any], state: wp.array[wp.float64], counts: wp.array[wp.float64]):
    """Nodes of the chunk where h + w is below the bound."""
    tid = wp.tid()
    start = tid * CHUNK_LENGTH
    bound = h.dtype(state[BOUND])
    count = h.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j
        count += wp.where(h[i] + response[i] < bound, h.dtype(1.0), h.dtype(0.0))
    counts[tid] = wp.float64(count)


@wp.kernel
def rest_on_wall(response: wp.array[Any], h: wp.array[Any], state: wp.array[wp.float64], u: wp.array[Any]):
    """u = level - w, projected onto the hard wall u <= h."""
    start = wp.tid() * CHUNK_LENGTH
    level = h.dtype(state[LEVEL])
    for j in range(CHUNK_LENGTH):
        i = start + j
        displaced = level - response[i]
        u[i] = wp.where(displaced < h[i], displaced, h[i])
