"""Warp kernels of FIRE and the hard wall, float32 and float64 from one generic source; on their form, see
`compiled`.

The unknown u is the displacement towards the indenter, limited by the wall u <= h. Pressures are in units of the mean
external pressure, so the net force on a node is r = 1 - (K u). A node is *held* where u = h and r > 0 (the wall carries
it) and *free* elsewhere. Memory traffic takes the time here: whether u = h is read off the velocity, which a step
leaves at `TOUCHING` on the wall.
"""

from typing import Any

import warp as wp

from . import layout

wp.set_module_options({"enable_backward": False})

Field = wp.array[Any]
Doubles = wp.array[wp.float64]
CHUNK_LENGTH = wp.constant(layout.CHUNK)
LANES = wp.constant(1)
SPAN = wp.constant(layout.CHUNK)
ON_WALL = wp.constant(layout.TOUCHING)
BLOCK = wp.constant(32)


@wp.func
def advance(u: Any, v: Any, a: Any, h: Any, mix: Any, gain: Any, dt: Any):
    """FIRE's update of one node: v = mix v + gain a, u += dt v, then the hard wall: a node that reaches u = h is put on
    it and stopped, with a velocity that marks it.
    """
    new = mix * v + gain * a
    there = u + dt * new
    hit = there >= h
    return wp.where(hit, h, there), wp.where(hit, type(v)(ON_WALL), new)


@wp.func
def free_part(r: Any, v: Any):
    """Net force on a free node, and 1 for a held one: on the wall and pressed against it."""
    held = v == type(v)(ON_WALL) and r > type(r)(0.0)
    return wp.where(held, type(r)(0.0), r), wp.where(held, type(r)(1.0), type(r)(0.0))


@wp.func
def keep(sums: Doubles, tid: int, squares: Any, held: Any, power: Any, vv: Any):
    """Put the sums of a chunk where `layout.PARTS` has them."""
    chunks = sums.shape[0] // layout.PARTS
    sums[layout.FORCE * chunks + tid] = wp.float64(squares)
    sums[layout.HOLDING * chunks + tid] = wp.float64(held)
    sums[layout.POWER * chunks + tid] = wp.float64(power)
    sums[layout.VELOCITY * chunks + tid] = wp.float64(vv)


@wp.kernel
def net_force(load: Field, elastic: Field, velocity: Field, force: Field, sums: Doubles):
    """Free part f of r = load - K u, with the chunk's sums f.f, v.f and v.v and its number of held nodes."""
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    squares = elastic.dtype(0.0)
    count = elastic.dtype(0.0)
    power = elastic.dtype(0.0)
    vv = elastic.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        v = velocity[i]
        f, held = free_part(load[i] - elastic[i], v)
        force[i] = f
        squares += f * f
        count += held
        power += v * f
        vv += v * v
    keep(sums, tid, squares, count, power, vv)


@wp.kernel
def plain_sums(elastic: Field, velocity: Field, sums: Doubles):
    """Plain FIRE's sums f.f, v.f, v.v and the number of held nodes; the force is made again in `plain_step`."""
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    squares = elastic.dtype(0.0)
    count = elastic.dtype(0.0)
    power = elastic.dtype(0.0)
    vv = elastic.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        v = velocity[i]
        f, held = free_part(elastic.dtype(1.0) - elastic[i], v)
        squares += f * f
        count += held
        power += v * f
        vv += v * v
    keep(sums, tid, squares, count, power, vv)


@wp.kernel
def restrict_to_free(force: Field, field: Field, squares: Doubles):
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
def total(sums: Doubles, part: int, chunks: int):
    """Sum of a part over all chunks; most of them in blocks, whose fixed length lets LLVM vectorise the loop."""
    s = wp.float64(0.0)
    first = part * chunks
    blocks = chunks // BLOCK
    for k in range(blocks):
        start = first + k * BLOCK
        for j in range(BLOCK):
            s += sums[start + j]
    for i in range(first + blocks * BLOCK, first + chunks):
        s += sums[i]
    return s


@wp.kernel
def fire_control(sums: Doubles, acceleration_sums: Doubles, state: Doubles):
    """One thread: add the chunks' sums, apply FIRE's power rule, leave mix, gain and dt for the step.

    acceleration_sums: a.a of every chunk, in the first places.
    """
    chunks = sums.shape[0] // layout.PARTS
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    held = total(sums, layout.HOLDING, chunks)
    free = wp.max(state[layout.NUM_POINTS] - held, one)
    residual = wp.sqrt(total(sums, layout.FORCE, chunks) / free)
    state[layout.RESIDUAL] = residual
    state[layout.HELD] = held
    mix = zero
    gain = zero
    # not (>) also catches NaN: a diverged or converged state is stopped, so that u stays the one of the residual
    if not (residual > state[layout.TOLERANCE]) or residual > wp.float64(1.0e30):
        state[layout.STOPPED] = one
    else:
        dt = state[layout.DT]
        alpha = state[layout.ALPHA]
        if total(sums, layout.POWER, chunks) > zero:
            state[layout.N_POSITIVE] = state[layout.N_POSITIVE] + one
            if state[layout.N_POSITIVE] > state[layout.N_MIN]:
                dt = wp.min(dt * state[layout.F_INC], state[layout.DT_MAX])
                alpha = alpha * state[layout.F_ALPHA]
            squares = wp.max(total(acceleration_sums, 0, chunks), wp.float64(1.0e-300))
            ratio = wp.sqrt(total(sums, layout.VELOCITY, chunks) / squares)
            # the mixing term is itself a gradient step: beyond 2/(dt lambda_max) it would blow up the stiffest mode
            mix = one - alpha
            gain = wp.min(alpha * ratio, one / (dt * state[layout.STIFFEST]))
        else:
            state[layout.N_POSITIVE] = zero
            alpha = state[layout.ALPHA_START]
            if state[layout.ITERATION] > zero:
                dt = dt * state[layout.F_DEC]
        state[layout.DT] = wp.max(dt, wp.float64(0.02) * state[layout.DT_MAX])
        state[layout.ALPHA] = alpha
        gain = gain + state[layout.DT]
        state[layout.ITERATION] = state[layout.ITERATION] + one
    state[layout.MIX] = mix
    state[layout.GAIN] = gain


@wp.kernel
def fire_step(acceleration: Field, h: Field, state: Doubles, u: Field, v: Field):
    """v = mix v + gain a, u += dt v, then the hard wall: FIRE's fused update and projection in one pass."""
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    mix = u.dtype(state[layout.MIX])
    gain = u.dtype(state[layout.GAIN])
    dt = u.dtype(state[layout.DT])
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        ui, vi = advance(u[i], v[i], acceleration[i], h[i], mix, gain, dt)
        u[i] = ui
        v[i] = vi


@wp.kernel
def plain_step(elastic: Field, h: Field, state: Doubles, u: Field, v: Field):
    """`fire_step` with the free force, made from K u, as the acceleration."""
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    mix = u.dtype(state[layout.MIX])
    gain = u.dtype(state[layout.GAIN])
    dt = u.dtype(state[layout.DT])
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        f, _held = free_part(u.dtype(1.0) - elastic[i], v[i])
        ui, vi = advance(u[i], v[i], f, h[i], mix, gain, dt)
        u[i] = ui
        v[i] = vi
