"""The pressure on a set of contact nodes, and the surface's response to it, w = G sigma, carried along near the contact
or on all nodes.

The gap is h + w - level, the level being the rigid approach. It is never stored: h may be large, and the rounding of
h + w would end up in the displacement.
"""

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import Array, Array64, Indices, Mask
from ...grid.patches import Patches
from ...grid.problem import Problem
from ...grid.split import Split
from .fields import Everywhere, Nearby, surround
from .search import NodeSet


@dataclass(eq=False, kw_only=True)
class ContactSet(NodeSet):
    """A set of contact nodes and the pressure on them, in the compact order of `Patches`. The active set makes a new
    one whenever it changes the set.
    """

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
        """Drop nodes that pull, add new ones without pressure: the next set, and whether nodes were dropped."""
        kept: Mask = self.pressure >= 0
        # where m nodes pull at the end of a patch, some 2m lie outside of the contact: 2m - 1 are dropped
        place, first, label = np.arange(kept.size), self.patches.offset, self.patches.label
        low = 2 * np.minimum.reduceat(np.where(kept, place, kept.size), first) - first
        high = 2 * np.maximum.reduceat(place * kept, first) - (first + self.patches.size - 1)
        kept &= (low >= high)[label] | ((place > low[label] - 2) & (place < high[label] + 2))
        if not (new.size or kept.any()):
            kept[np.argmax(self.pressure)] = True
        nodes = np.sort(np.concatenate([self.nodes[kept], new]), kind="stable")  # merges two ordered parts
        pressure = np.zeros(nodes.size)
        pressure[np.searchsorted(nodes, self.nodes[kept])] = self.pressure[kept]
        return ContactSet.of(nodes, pressure, self.patches.num_points), not kept.all()


class Surface:
    """w = G sigma of one grid, with gaps and displacements by it. Units are the problem's.

    Every step near the contact adds its error to the response, which drifts away from the pressure that it belongs to,
    until it is made anew on all nodes.
    """

    def __init__(self, problem: Problem, split: Split | None, everywhere: Everywhere) -> None:
        """everywhere: the response on all nodes; split: of G, to work near the contact where that pays; None: never."""
        self._problem, self.split, self._all = problem, split, everywhere
        self._at: Everywhere | Nearby = everywhere
        self.drift = 0.0
        """Error that images have added since the response was made, as rms pressure over p; 0 on all nodes."""

    @property
    def nearby(self) -> bool:
        """Whether the response is carried along near the contact only."""
        return self._at is not self._all

    def _scale(self, now: ContactSet) -> None:
        load = float(now.pressure.sum())
        if not load > 0:  # a set of new nodes only, or a load that rounding has eaten
            now.pressure[:], load = 1, now.pressure.size
        now.pressure *= self._problem.num_points / load

    def renew(self, now: ContactSet) -> None:
        """Scale the pressure of a set to the load, and make the response to it anew on all nodes."""
        self._scale(now)
        self._all.renew(now.nodes, now.pressure)
        self.drift = 0.0
        nearby = self.split and surround(self.split, now.nodes, self._problem.height, self._all.field)
        self._at, now.places = nearby or self._all, nearby.places(now.nodes) if nearby else now.nodes

    def follow(self, before: ContactSet, now: ContactSet, changed: bool) -> None:
        """Turn to another set. changed: whether its pressure differs from that before, because nodes were dropped."""
        at = self._at
        if isinstance(at, Nearby) and at.covers(now.nodes):
            now.places = at.places(now.nodes)
            if changed:
                self._scale(now)
                change = np.zeros(at.nodes.size)
                change[at.places(before.nodes)] -= before.pressure
                change[now.places] += now.pressure
                self._image(slice(None), change)
                self._advance(1.0, change)
        elif changed or at is not self._all:
            self.renew(now)

    def go_along(self, now: ContactSet, direction: Array64) -> bool:
        """Step along a search direction to where the energy is least; False if rounding has left no way down."""
        image = self._image(now.places, direction)
        curvature = float(direction @ image)
        if not curvature > 0:
            return False
        step = now.last_product / curvature
        now.pressure += step * direction
        self._advance(step, direction)
        return True

    def _image(self, places: Indices | slice, direction: Array64) -> Array:
        """The response to a pressure at these places, there [u]."""
        if isinstance(self._at, Nearby):
            self._all.pairs += self._at.pair_length
        return self._at.image(places, direction)

    def _advance(self, step: float, direction: Array64) -> None:
        """Add the latest image, of that direction, times a step to the response."""
        if isinstance(self._at, Nearby):
            size = abs(step) * float(np.linalg.norm(direction)) / math.sqrt(self._problem.num_points)
            self.drift = math.hypot(self.drift, self._at.error * size)  # first: an interruption must not hide it
        self._at.advance(step)

    def touching(self, now: ContactSet) -> Array64:
        """h + w on the contact nodes, shape (contact nodes,) [u]."""
        return np.asarray(self._problem.height[now.nodes] + self._at.field[now.places])

    def penetrating(self, now: ContactSet, smallest: float) -> Indices:
        """Nodes outside of a set that penetrate by more than `smallest` [u], shape (nodes,)."""
        # a smaller penetration would be decided by the rounding of h + w, and the set would never settle
        size = float(np.abs(self._at.field[now.places]).max())
        smallest = max(smallest, 8 * float(np.finfo(self._all.field.dtype).eps) * size)
        known = self._at if self.drift else self._all  # of the other nodes only an old response
        below = known.below(float(self.touching(now).mean()) - smallest)
        outside = np.ones(self._problem.num_points, dtype=np.bool_)
        outside[now.nodes] = False
        return below[outside[below]]

    def displacement(self, now: ContactSet) -> Array64:
        """u, shape (N,) [u], in float64; contact nodes stand on the exact wall."""
        if self.nearby and self.drift:
            self.renew(now)
        height = self._problem.height
        # not `touching`: an interruption may have come before `places`
        level = float((height[now.nodes] + self._all.field[now.nodes]).mean())
        u = level - self._all.field[: height.size].astype(np.float64, copy=False)
        np.minimum(u, height, out=u)
        u[now.nodes] = height[now.nodes]
        return u
