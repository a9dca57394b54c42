"""The Warp kernels of FIRE that make four sums in one pass, float32 and float64 from one generic source; on their
form, see `compiled`.
"""

from typing import Any

import warp as wp

from .layout import CHUNK
from .warp_fire import held

wp.set_module_options({"enable_backward": False})

CHUNK_LENGTH = wp.constant(CHUNK)
LANES = wp.constant(1)
SPAN = wp.constant(CHUNK)


@wp.kernel
def net_force(
    load: wp.array[Any],
    elastic: wp.array[Any],
    velocity: wp.array[Any],
    force: wp.array[Any],
    force_sums: wp.array[wp.float64],
    held_sums: wp.array[wp.float64],
    power_sums: wp.array[wp.float64],
    velocity_sums: wp.array[wp.float64],
):
    """Free part f of r = load - K u, with the chunk's sums f.f, v.f and v.v and its number of held nodes."""
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    squares = elastic.dtype(0.0)
    count = elastic.dtype(0.0)
    power = elastic.dtype(0.0)
    vv = elastic.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        r = load[i] - elastic[i]
        v = velocity[i]
        on_wall = held(r, v)
        f = wp.where(on_wall, elastic.dtype(0.0), r)
        force[i] = f
        squares += f * f
        count += wp.where(on_wall, elastic.dtype(1.0), elastic.dtype(0.0))
        power += v * f
        vv += v * v
    force_sums[tid] = wp.float64(squares)
    held_sums[tid] = wp.float64(count)
    power_sums[tid] = wp.float64(power)
    velocity_sums[tid] = wp.float64(vv)


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
    start = tid // LANES * SPAN + tid % LANES
    squares = elastic.dtype(0.0)
    count = elastic.dtype(0.0)
    power = elastic.dtype(0.0)
    vv = elastic.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
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
