"""Warp kernels of FIRE and the hard wall, float32 and float64 from one generic source; on their form, see
`compiled`.

The unknown u is the displacement towards the indenter, limited by the wall u <= h. Pressures are in units of the mean
external pressure, so the net force on a node is r = 1 - (K u). A node is *held* where u = h and r > 0 (the wall carries
it) and *free* elsewhere. Memory traffic is what costs here: whether u = h is read off the velocity, which a step
leaves at `TOUCHING` on the wall.
"""

from typing import Any

import warp as wp

from .layout import (
    ALPHA,
    ALPHA_START,
    CHUNK,
    DT,
    DT_MAX,
    F_ALPHA,
    F_DEC,
    F_INC,
    GAIN,
    HELD,
    ITERATION,
    MIX,
    N_MIN,
    N_POSITIVE,
    NUM_POINTS,
    RESIDUAL,
    STIFFEST,
    STOPPED,
    TOLERANCE,
    TOUCHING,
)

wp.set_module_options({"enable_backward": False})

CHUNK_LENGTH = wp.constant(CHUNK)
LANES = wp.constant(1)
SPAN = wp.constant(CHUNK)
ON_WALL = wp.constant(TOUCHING)
BLOCK = wp.constant(32)


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


@wp.kernel
def restrict_to_free(force: wp.array[Any], field: wp.array[Any], squares: wp.array[wp.float64]):
    """Put a field to 0 on held nodes (where the force is 0), in place, with the chunk's sum of its squares.

    It is done by a factor, because a choice between the value and 0 becomes a masked store, which is several times
    slower on some processors. An infinite value on a held node becomes NaN.
    """
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    sum_of_squares = field.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        x = field[i] * wp.where(force[i] == field.dtype(0.0), field.dtype(0.0), field.dtype(1.0))
        field[i] = x
        sum_of_squares += x * x
    squares[tid] = wp.float64(sum_of_squares)


@wp.func
def total(parts: wp.array[wp.float64]):
    """Sum of all parts; most of them in blocks, whose fixed length lets LLVM vectorise the loop."""
    s = wp.float64(0.0)
    blocks = parts.shape[0] // BLOCK
    for k in range(blocks):
        start = k * BLOCK
        for j in range(BLOCK):
            s += parts[start + j]
    for i in range(blocks * BLOCK, parts.shape[0]):
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
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    mix = u.dtype(state[MIX])
    gain = u.dtype(state[GAIN])
    dt = u.dtype(state[DT])
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
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
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    mix = u.dtype(state[MIX])
    gain = u.dtype(state[GAIN])
    dt = u.dtype(state[DT])
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        r = u.dtype(1.0) - elastic[i]
        f = wp.where(held(r, v[i]), u.dtype(0.0), r)
        ui, vi = advance(u[i], v[i], f, h[i], mix, gain, dt)
        u[i] = ui
        v[i] = vi
