"""Contact patches: runs of neighbouring contact nodes on the periodic grid."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Array64, Indices, Mask


@dataclass(frozen=True, eq=False)
class Patches:
    """The M patches of one contact.

    The compact order of contact nodes goes patch by patch; quantities on contact nodes have shape (contact nodes,).
    """

    num_points: int
    """N, grid points in the period."""
    first: Indices
    """First node of each patch, shape (M,), from 0 to N - 1."""
    last: Indices
    """Last node of each patch, shape (M,); it may be N or more and then lies beyond the end of the period."""

    @classmethod
    def of(cls, contact: Mask) -> "Patches":
        """Patches of a contact map, shape (N,)."""
        return cls.of_nodes(np.flatnonzero(contact), contact.size)

    @classmethod
    def of_nodes(cls, nodes: Indices, num_points: int) -> "Patches":
        """Patches of contact nodes, shape (contact nodes,), in ascending order from 0 to `num_points` - 1."""
        breaks = np.flatnonzero(np.diff(nodes) > 1)
        first, last = np.append(nodes[:1], nodes[breaks + 1]), np.append(nodes[breaks], nodes[-1:])
        if breaks.size and nodes[0] == 0 and nodes[-1] == num_points - 1:  # the last patch goes on at node 0
            first, last = first[1:], np.append(last[1:-1], last[0] + num_points)
        return cls(num_points, first, last)

    @property
    def count(self) -> int:
        """Number of patches M."""
        return self.first.size

    @property
    def full(self) -> bool:
        """Whether every node is in contact."""
        return bool(self.count == 1 and self.size[0] == self.num_points)

    @cached_property
    def size(self) -> Indices:
        """Nodes of each patch, shape (M,)."""
        return self.last - self.first + 1

    @cached_property
    def offset(self) -> Indices:
        """Compact index of each patch's first node, shape (M,)."""
        return np.cumsum(self.size) - self.size

    @cached_property
    def gap(self) -> Indices:
        """Nodes of the gaps to the left and right of patches, shape (2, M)."""
        after = np.append(self.first[1:], self.first[:1] + self.num_points) - self.last - 1
        return np.concatenate((after[-1:], after)).take([np.arange(self.count), np.arange(1, self.count + 1)])

    @cached_property
    def label(self) -> Indices:
        """Patch of each contact node, in compact order."""
        return np.repeat(np.arange(self.count), self.size)

    @cached_property
    def step(self) -> Indices:
        """Steps of each contact node from the first one of its patch, in compact order."""
        return np.arange(self.label.size) - np.repeat(self.offset, self.size)

    @cached_property
    def nodes(self) -> Indices:
        """Grid index of each contact node, in compact order."""
        places = self.first[self.label] + self.step
        return np.where(places < self.num_points, places, places - self.num_points)

    def sums(self, values: Array64) -> Array64:
        """Sum over each patch of values on contact nodes, shape (M,)."""
        return np.add.reduceat(values, self.offset)
