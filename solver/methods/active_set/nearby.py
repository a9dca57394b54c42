"""The response near the contact only, without a transform of all nodes: by the two parts of a `grid.split`.

`near`: blocks of nodes around the contact are moved together until gaps are as wide as its range, and are convolved by
one short transform. `far`: spread to the blocks by the spline, convolved there, and gathered by it.
"""

from functools import cached_property

import numpy as np

from ...arrays import Array64, Indices
from ...grid.split import Split
from ...transforms.plain import Pair

_HALO = 4  # nodes on either side of the contact whose gap is watched, too; less than a block
_WORTH = 0.5  # length of the packed transforms over that of the field's, up to which they are faster


def transformed_blocks(blocks: int) -> int:
    """The shortest length, of eight to an octave, that holds so many blocks: plans for them serve again."""
    unit = max(1, (1 << (blocks - 1).bit_length()) // 16)
    return -(-blocks // unit) * unit


class Nearby:
    """The response w = G sigma, up to a constant, on some blocks of nodes, which must leave a gap wider than the
    split's range somewhere.
    """

    def __init__(self, split: Split, blocks: Indices, height: Array64) -> None:
        """blocks: their numbers in ascending order, shape (B,); height: h of all nodes, shape (N,) [u]."""
        self._split, self._blocks = split, blocks
        gaps = np.diff(blocks, append=blocks[0] + split.num_blocks)
        start = int(np.argmax(gaps)) + 1  # the widest gap is left open
        steps = np.minimum(np.roll(gaps, -start)[:-1], -(-split.range // split.block) + 1)
        position = np.append(0, np.cumsum(steps))
        self._position = np.roll(position, start)
        last = (int(position[-1]) + 1) * split.block
        self._length = split.block * transformed_blocks(-(-(last + split.range) // split.block))
        self.pair_length = (self._length + split.num_blocks) / height.size
        """Length of the transforms over N (dimensionless)."""
        self.error = split.error
        """Of an image, see `Split`."""
        self.nodes = (blocks[:, None] * split.block + np.arange(split.block)).ravel()
        """Of the blocks, in order, shape (nodes,) like `field`."""
        self._index = np.full(split.num_blocks, -1)
        self._index[blocks] = np.arange(blocks.size)
        self._height = height[self.nodes]
        self.field = np.zeros(self.nodes.size)
        """w [u]."""
        self._image = np.zeros(0)

    @cached_property
    def _transforms(self) -> tuple[Pair, Array64, Pair]:
        """Those of the blocks moved together, the symbol of `near` for them, and those of one point for each block."""
        pair, near, kernel = Pair(self._length), self._split.near, np.zeros(self._length)
        kernel[: near.size] = near
        kernel[1 - near.size :] = near[:0:-1]
        return pair, pair.transform(kernel).real / self._length, Pair(self._split.num_blocks)

    @cached_property
    def _spread_to(self) -> Indices:
        return np.asarray((self._blocks[:, None] + self._split.columns) % self._split.num_blocks)

    def apply(self, values: Array64) -> Array64:
        """G values, up to a constant; both on the nodes of the blocks, shape (B, block)."""
        split, (pair, near, coarse) = self._split, self._transforms
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

    def covers(self, nodes: Indices) -> bool:
        """Whether all these nodes are among those of the blocks."""
        return bool((self._index[nodes // self._split.block] >= 0).all())

    def places(self, nodes: Indices) -> Indices:
        """Where these nodes have their values."""
        block, inside = np.divmod(nodes, self._split.block)
        return np.asarray(self._index[block] * self._split.block + inside)

    def image(self, places: Indices | slice, direction: Array64) -> Array64:
        """The response to a pressure at these places, 0 elsewhere, there [u]."""
        values = np.zeros(self.nodes.size)
        values[places] = direction
        self._image = self.apply(values.reshape(-1, self._split.block)).ravel()
        return self._image[places]

    def advance(self, step: float) -> None:
        """Add the latest image times a step."""
        self.field += step * self._image

    def below(self, bound: float) -> Indices:
        """Nodes of the blocks where h + w is below a bound [u]."""
        return np.asarray(self.nodes[self._height + self.field < bound])


def surround(split: Split, nodes: Indices, height: Array64) -> Nearby | None:
    """The blocks around some nodes; None where the packed transforms would take as long as the field's."""
    near = np.zeros(split.num_blocks, dtype=bool)
    for step in (-_HALO, 0, _HALO):
        near[(nodes + step) // split.block % split.num_blocks] = True
    if near.sum() > _WORTH * split.num_blocks:
        return None
    found = Nearby(split, np.flatnonzero(near), height)
    return found if found.pair_length <= _WORTH else None
