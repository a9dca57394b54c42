"""The Warp kernel that adds up the chunks' sums of FIRE before its control step, for a GPU: there the chunks are short,
and one thread alone would take longer with their sums than all others with the rest.
"""

import warp as wp

from . import layout

wp.set_module_options({"enable_backward": False})

Doubles = wp.array[wp.float64]
FOLDED_LENGTH = wp.constant(layout.FOLDED)


@wp.kernel
def fold_sums(sums: Doubles, acceleration_sums: Doubles, folded: Doubles):
    """Each part of `sums`, and the sums of `fire_control` besides, as `FOLDED_LENGTH` sums, one after the other, by as
    many blocks of threads for each; always in the same order, so that a solve repeats bit for bit.
    """
    tid = wp.tid()
    block = tid // wp.block_dim()
    part = block // FOLDED_LENGTH
    stride = FOLDED_LENGTH * wp.block_dim()
    chunks = sums.shape[0] // layout.PARTS
    s = wp.float64(0.0)
    for i in range(tid - part * stride, chunks, stride):
        if part < layout.PARTS:
            s += sums[part * chunks + i]
        else:
            s += acceleration_sums[i]
    wp.tile_store(folded, wp.tile_sum(wp.tile(s)), offset=block)
