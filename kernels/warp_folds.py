"""The Warp kernel that adds up the chunks' sums of FIRE before its control step, for a GPU: there the chunks are short,
and one thread alone would take longer with their sums than all others with the rest.
"""

import warp as wp

from .layout import FOLDED

wp.set_module_options({"enable_backward": False})

Doubles = wp.array[wp.float64]
FOLDED_LENGTH = wp.constant(FOLDED)


@wp.func
def sum_every(parts: Doubles, first: int, stride: int):
    """Sum of every so many parts, from the first on."""
    s = wp.float64(0.0)
    for i in range(first, parts.shape[0], stride):
        s += parts[i]
    return s


@wp.kernel
def fold_sums(
    force_sums: Doubles,
    held_sums: Doubles,
    power_sums: Doubles,
    velocity_sums: Doubles,
    acceleration_sums: Doubles,
    folded: Doubles,
):
    """Each of the five arrays of sums as `FOLDED_LENGTH` sums, one after the other, by as many blocks of threads for
    each; always in the same order, so that a solve repeats bit for bit.
    """
    tid = wp.tid()
    block = tid // wp.block_dim()
    which = block // FOLDED_LENGTH
    first = tid - which * FOLDED_LENGTH * wp.block_dim()
    stride = FOLDED_LENGTH * wp.block_dim()
    s = wp.float64(0.0)
    if which == 0:
        s = sum_every(force_sums, first, stride)
    elif which == 1:
        s = sum_every(held_sums, first, stride)
    elif which == 2:
        s = sum_every(power_sums, first, stride)
    elif which == 3:
        s = sum_every(velocity_sums, first, stride)
    else:
        s = sum_every(acceleration_sums, first, stride)
    wp.tile_store(folded, wp.tile_sum(wp.tile(s)), offset=block)
