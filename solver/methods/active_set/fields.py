"""The field that an operator makes of values on some nodes and adds to: with G the response w = G sigma to a contact
pressure, with K the force K u of a displacement.

`Everywhere` makes it on all nodes, by transforms of their number; `Nearby` makes the response near the contact only, by
the two parts of a `grid.split`, as docs/architecture.md describes it.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ....kernels import Call, layout, record
from ...arrays import Array, Array64, Indices, chunks
from ...grid.cached import MOST_POINTS
from ...grid.split import Split
from ...transforms.plain import pair
from ...transforms.planned import plan_transforms
from ..method import ExecutionConfig

_HALO = 4  # nodes on either side of the contact whose gap is watched, too; less than a block
_WORTH = 0.5  # length of the packed transforms over that of the field's, up to which they are faster


class Operator:
    """G = 1/K without the mean mode, or K, applied by one pair of transforms."""

    def __init__(self, symbol: Array64, num_points: int, config: ExecutionConfig) -> None:
        transforms = plan_transforms(num_points, config.precision, config.threads, config.planning, config.backend)
        self.new_field = transforms.buffer
        self.target = transforms.field()
        forward, inverse = transforms.forward(self.target), transforms.inverse(self.target)
        self._parts = forward, transforms.multiplication(symbol), inverse

    def apply(self, places: Indices | slice, values: Array64) -> Array:
        """`target` after it was these values at these places and 0 elsewhere."""
        self.target[:] = 0
        self.target[places] = values
        for part in self._parts:
            part()
        return self.target


class Everywhere:
    """The field of an operator, on all nodes: w [u] or K u [p]. It serves after `begin`, one solve at a time."""

    def __init__(self, symbol: Array64, num_points: int, config: ExecutionConfig) -> None:
        """symbol: of the operator, shape (N//2 + 1,); num_points: N."""
        self._symbol, self._num_points, self._config = symbol, num_points, config
        self.field = self._operator.new_field()
        """Shape (N,) and padding."""
        self.pairs = 0.0
        """Transform pairs in this solve, short ones by their length over N."""
        self._state = np.zeros(layout.STEP + 1)

    def begin(self, height: Array64) -> None:
        """Turn to a scene. height: h, shape (N,) [u]."""
        self.pairs = 0.0
        self.field[:] = 0  # of an earlier solve
        self._height: Array = height.astype(self.field.dtype, copy=False)

    @cached_property
    def _operator(self) -> Operator:
        return Operator(self._symbol, self._num_points, self._config)

    @cached_property
    def _advance(self) -> Callable[[], None]:
        call = Call("advance_response", (self._operator.target, self._state), (self.field,))
        return record(self._config.backend, [call])

    def rest(self) -> None:
        """Give back the operator on a large grid; it is made anew when it is needed."""
        for name in ("_advance", "_operator") if self._num_points > MOST_POINTS else ():
            self.__dict__.pop(name, None)

    def renew(self, places: Indices | slice, values: Array64) -> None:
        """Make the field of values at these places, 0 elsewhere."""
        self.pairs += 1
        self.field[:] = self._operator.apply(places, values)

    def image(self, places: Indices | slice, direction: Array64) -> Array:
        """The image of a search direction at these places, there."""
        self.pairs += 1
        return np.asarray(self._operator.apply(places, direction)[places])

    def advance(self, step: float) -> None:
        """Add the latest image times a step."""
        self._state[layout.STEP] = step
        self._advance()

    def below(self, bound: float) -> Indices:
        """Nodes where h + w is below a bound [u]."""
        height, field = self._height, self.field[: self._num_points]
        return np.concatenate([np.flatnonzero(height[p] + field[p] < bound) + p.start for p in chunks(height.size)])


def transformed_blocks(blocks: int) -> int:
    """The shortest length, of eight to an octave, that holds so many blocks: plans for them serve again."""
    unit = max(1, (1 << (blocks - 1).bit_length()) // 16)
    return -(-blocks // unit) * unit


class Nearby:
    """The response w = G sigma, up to a constant, on some blocks of nodes, which must leave a gap wider than the
    split's range somewhere.
    """

    def __init__(self, split: Split, blocks: Indices, height: Array64, field: Array) -> None:
        """blocks: their numbers in ascending order, shape (B,); height, field: h and w of all nodes, shape (N,) [u]."""
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
        self.field = field[self.nodes].astype(np.float64, copy=False)
        """w [u]."""
        self._image = np.zeros(0)

    @cached_property
    def _near(self) -> Array64:
        """The symbol of `near` for the blocks moved together."""
        near, kernel = self._split.near, np.zeros(self._length)
        kernel[: near.size] = near
        kernel[1 - near.size :] = near[:0:-1]
        return np.asarray(pair(self._length).transform(kernel).real / self._length)

    @cached_property
    def _spread_to(self) -> Indices:
        return np.asarray((self._blocks[:, None] + self._split.columns) % self._split.num_blocks)

    def apply(self, values: Array64) -> Array64:
        """G values, up to a constant; both on the nodes of the blocks, shape (B, block)."""
        split, near = self._split, self._near
        blocks = pair(self._length)
        packed = blocks.real.reshape(-1, split.block)
        packed[:] = 0
        packed[self._position] = values
        blocks.filter(near)
        close = packed[self._position]
        coarse = pair(split.num_blocks)  # the same one where the lengths are the same
        shares, coarse.real[:] = values @ split.weights, 0
        for column, share in zip(self._spread_to.T, shares.T, strict=True):
            coarse.real[column] += share  # no block twice in a column
        coarse.filter(split.far)
        return np.asarray(close + coarse.real[self._spread_to] @ split.weights.T)

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


def surround(split: Split, nodes: Indices, height: Array64, field: Array) -> Nearby | None:
    """The blocks around some nodes; None where the packed transforms would take as long as the field's."""
    near = np.zeros(split.num_blocks, dtype=bool)
    for step in (-_HALO, 0, _HALO):
        near[(nodes + step) // split.block % split.num_blocks] = True
    if near.sum() > _WORTH * split.num_blocks:
        return None
    found = Nearby(split, np.flatnonzero(near), height, field)
    return found if found.pair_length <= _WORTH else None
