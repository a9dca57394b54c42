"""What belongs to one set of contact nodes; the active set makes a new one whenever it changes the set."""

from dataclasses import dataclass

import numpy as np

from ...arrays import Array64, Indices, Mask
from ...grid.patches import Patches
from .search import NodeSet


@dataclass(eq=False, kw_only=True)
class ContactSet(NodeSet):
    """A set of contact nodes and the pressure on them, in the compact order of `Patches`."""

    pressure: Array64
    """Contact pressure, shape (contact nodes,) [p]; negative where the wall would have to pull."""
    places: Indices
    """Where they have their values in the response that is carried along, shape (contact nodes,)."""
    eliminated: bool = False
    """Whether the pressure is or was that by elimination."""

    @classmethod
    def of(cls, nodes: Indices, pressure: Array64, num_points: int) -> "ContactSet":
        """The set of nodes in ascending order, with their pressure [p], shape (contact nodes,) each; num_points: N."""
        patches = Patches.of_nodes(nodes, num_points)
        if patches.nodes[0] != nodes[0]:  # a patch goes on at node 0
            pressure = np.roll(pressure, -int(np.searchsorted(nodes, patches.nodes[0])))
        return cls(patches=patches, pressure=pressure, places=patches.nodes)

    def changed(self, new: Indices) -> tuple["ContactSet", bool]:
        """Drop nodes that pull and add new ones, on which there is no pressure: the next set, and whether nodes were
        dropped.

        Where m nodes pull at the end of a patch, about 2m lie outside of the contact (it shrinks by half of that with
        every update): 2m - 1 are dropped.
        """
        kept: Mask = self.pressure >= 0
        place, first = np.arange(kept.size), self.patches.offset
        last = first + self.patches.size - 1
        inner = np.minimum.reduceat(np.where(kept, place, kept.size), first), np.maximum.reduceat(place * kept, first)
        beyond = 2 * inner[0] - first, 2 * inner[1] - last
        label = self.patches.label
        bears = (inner[0] <= inner[1]) & (beyond[0] < beyond[1])
        kept &= ~bears[label] | ((place > beyond[0][label] - 2) & (place < beyond[1][label] + 2))
        if not (new.size or kept.any()):
            kept[np.argmax(self.pressure)] = True
        nodes = np.sort(np.concatenate([self.nodes[kept], new]), kind="stable")  # merges two ordered parts
        pressure = np.zeros(nodes.size)
        pressure[np.searchsorted(nodes, self.nodes[kept])] = self.pressure[kept]
        return ContactSet.of(nodes, pressure, self.patches.num_points), not kept.all()
