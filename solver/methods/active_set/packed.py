"""G on the neighbourhood of the contact only, without a transform of all nodes: the two parts of a `grid.split`.

`near`: blocks of nodes around the contact are moved together until gaps are as wide as its range, and are convolved by
one short transform. `far`: spread to the blocks by the spline, convolved there, and gathered by it, so the whole is
symmetric. What is left out is known, see `Split.error`.
"""

from functools import cached_property

import numpy as np

from ...arrays import Array64, Indices
from ...grid.split import Split
from ...transforms.plain import Pair


def transformed_blocks(blocks: int) -> int:
    """The shortest length, of eight to an octave, that holds so many blocks: plans for them serve again."""
    unit = max(1, (1 << (blocks - 1).bit_length()) // 16)
    return -(-blocks // unit) * unit


class Packed:
    """G between the nodes of some blocks, which must leave a gap wider than the split's range somewhere.

    blocks: their numbers in ascending order, shape (B,). length: of its longer transforms.
    """

    def __init__(self, split: Split, blocks: Indices) -> None:
        self.split, self.blocks = split, blocks
        reach = -(-split.range // split.block)
        gaps = np.diff(blocks, append=blocks[0] + split.num_blocks)
        start = int(np.argmax(gaps)) + 1  # the widest gap is left open
        steps = np.minimum(np.roll(gaps, -start)[:-1], reach + 1)
        position = np.append(0, np.cumsum(steps))
        self._position = np.roll(position, start)
        self.length = split.block * transformed_blocks(
            -(-((int(position[-1]) + 1) * split.block + split.range) // split.block)
        )

    @cached_property
    def _near(self) -> Array64:
        kernel = np.zeros(self.length)
        kernel[: self.split.near.size] = self.split.near
        kernel[1 - self.split.near.size :] = self.split.near[:0:-1]
        pair = self._pair
        pair.real[:] = kernel
        pair.forward()
        return pair.modes.real / self.length

    @cached_property
    def _pair(self) -> Pair:
        return Pair(self.length)

    @cached_property
    def _coarse(self) -> Pair:
        """Transforms with one point for each block."""
        return Pair(self.split.num_blocks)

    @cached_property
    def _spread_to(self) -> Indices:
        return np.asarray((self.blocks[:, None] + self.split.columns) % self.split.num_blocks)

    def __call__(self, values: Array64) -> Array64:
        """G values, up to a constant; both on the nodes of the blocks, shape (B, block)."""
        split, near, pair, coarse = self.split, self._near, self._pair, self._coarse
        packed = pair.real.reshape(-1, split.block)
        packed[:] = 0
        packed[self._position] = values
        pair.forward()
        pair.modes *= near
        pair.inverse()
        shares, coarse.real[:] = values @ split.weights, 0
        for column, share in zip(self._spread_to.T, shares.T, strict=True):
            coarse.real[column] += share  # no block twice in a column
        coarse.forward()
        coarse.modes *= split.far
        coarse.inverse()
        return np.asarray(packed[self._position] + coarse.real[self._spread_to] @ split.weights.T)
