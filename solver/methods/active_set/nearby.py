"""Blocks of nodes around a contact, with the response of the surface there, which the packed operator carries along."""

import numpy as np

from ...arrays import Array64, Indices
from ...grid.split import Split
from .packed import Packed

_HALO = 4  # nodes on either side of the contact whose gap is watched, too; less than a block
_TOO_MANY = 2.0  # blocks over those that are needed, beyond which fewer are taken
_WORTH = 0.5  # length of the packed transforms over that of the field's, up to which they are faster


class Nearby:
    """The nodes of some blocks, in order, shape (nodes,) for all fields. height: h of all nodes, shape (N,) [u]."""

    def __init__(self, operator: Packed, height: Array64) -> None:
        self._operator, self._block = operator, operator.split.block
        self.nodes = (operator.blocks[:, None] * self._block + np.arange(self._block)).ravel()
        self._index = np.full(operator.split.num_blocks, -1)
        self._index[operator.blocks] = np.arange(operator.blocks.size)
        self.height = height[self.nodes]
        """h [u]."""
        self.response = np.zeros(self.nodes.size)
        """G sigma, up to a constant [u]."""
        self.pair_length = (operator.length + operator.split.num_blocks) / height.size
        """Length of the transforms over N (dimensionless)."""
        self.error = operator.split.error
        """Of an image, see `Split`."""

    def covers(self, nodes: Indices) -> bool:
        """Whether all these nodes are among them."""
        return bool((self._index[nodes // self._block] >= 0).all())

    def places(self, nodes: Indices) -> Indices:
        """Where these nodes have their values."""
        block, inside = np.divmod(nodes, self._block)
        return np.asarray(self._index[block] * self._block + inside)

    def image(self, places: Indices, pressure: Array64) -> Array64:
        """The response to a pressure at these places, 0 elsewhere [u]."""
        values = np.zeros(self.nodes.size)
        values[places] = pressure
        return self._operator(values.reshape(-1, self._block)).ravel()


def surround(split: Split, nodes: Indices, height: Array64, held: Nearby | None) -> Nearby | None:
    """The blocks around some nodes; None where the packed transforms would take as long as the field's.

    held: blocks that serve again if they hold the nodes and are not many more than needed.
    """
    near = np.zeros(split.num_blocks, dtype=bool)
    for step in (-_HALO, 0, _HALO):
        near[(nodes + step) // split.block % split.num_blocks] = True
    needed = int(near.sum()) * split.block
    if held and held.nodes.size <= _TOO_MANY * needed and held.covers(nodes):
        return held
    if needed > _WORTH * height.size:
        return None
    operator = Packed(split, np.flatnonzero(near))
    worth = operator.length + split.num_blocks <= _WORTH * height.size
    return Nearby(operator, height) if worth else None
