"""The response of the surface to the contact pressure, w = G sigma, carried along near the contact or on all nodes.

The gap is h + w - level, the level being the rigid approach. It is never stored: h may be large, and the rounding of
h + w would end up in the displacement.

Where the packed operator pays (`nearby`), every step adds its error to the response, which drifts away from the
pressure that it belongs to, until it is made anew on all nodes. So it does in mixed precision, where elsewhere search
directions and their images are float32 and the response is float64.
"""

import math
from functools import cached_property

import numpy as np

from ...arrays import Array64, Indices
from ...grid.problem import Problem, rounding_floor
from ...grid.split import Split
from .contact_set import ContactSet
from .everywhere import Everywhere
from .nearby import Nearby, surround

_SAMPLE = 2**14  # nodes that tell the size of u


class Surface:
    """w = G sigma of one grid, and what is read off it. Units are the problem's."""

    def __init__(self, problem: Problem, split: Split | None, everywhere: Everywhere) -> None:
        """everywhere: the response on all nodes. split: of G, to work near the contact only where that pays; None: on
        all nodes.
        """
        self._problem, self._split = problem, split
        self._nearby: Nearby | None = None
        self._all = everywhere
        self.mixed = everywhere.mixed
        self.pairs = 0.0
        """Transform pairs so far, short ones by their length."""
        self.drift = 0.0
        """Error that images have added since the response was made, as rms pressure over p; 0 in float64 on all nodes.
        """

    @cached_property
    def _rounding(self) -> float:
        """What rounding to float32 adds to an image, as rms pressure over the rms of the image [p/u]."""
        return float(np.finfo(np.float32).eps) * math.sqrt(float(np.mean(self._problem.stiffness**2)))

    def rest(self) -> None:
        """Give back the transforms of all nodes; they are made anew when they are needed."""
        self._all.rest()

    @property
    def plain(self) -> bool:
        """Whether the response is made on all nodes and in float64."""
        return self._nearby is None and self.exact

    @property
    def exact(self) -> bool:
        """Whether the response on all nodes is made in float64."""
        return bool(self._all.field.dtype == np.float64)

    def _scale(self, now: ContactSet) -> None:
        load = float(now.pressure.sum())
        if not load > 0:  # a set of new nodes only, or a load that rounding has eaten
            now.pressure[:], load = 1, now.pressure.size
        now.pressure *= self._problem.num_points / load

    def renew(self, now: ContactSet) -> None:
        """Scale the pressure of a set to the load, and make the response to it anew on all nodes."""
        self._scale(now)
        now.places = now.nodes
        self._all.renew(now.places, now.pressure)
        self.pairs += 1
        self.drift = 0.0
        self._surround(now, now.nodes)

    def leave_nearby(self, now: ContactSet) -> bool:
        """From now on work on all nodes; False if that is so already."""
        if self._nearby is None:
            return False
        self.stay_everywhere(now)
        return True

    def stay_everywhere(self, now: ContactSet) -> None:
        """Make the response to the pressure of a set anew, and never work near the contact only from now on."""
        self._split = self._nearby = None
        self.renew(now)

    def _surround(self, now: ContactSet, nodes: Indices) -> None:
        """From now on carry the response along near these nodes only, if that pays."""
        if self._split:
            self._nearby = surround(self._split, nodes, self._problem.height, self._nearby)
        if self._nearby:
            self._nearby.response[:] = self._all.field[self._nearby.nodes]
        now.places = self._nearby.places(now.nodes) if self._nearby else now.nodes

    def follow(self, before: ContactSet, now: ContactSet, changed: bool) -> None:
        """Turn to another set. changed: whether its pressure differs from that before, because nodes were dropped."""
        earlier = self._nearby
        if earlier and not self.drift and not earlier.covers(now.nodes):
            self._surround(now, np.union1d(before.nodes, now.nodes))
        nearby = self._nearby
        if nearby is None or not nearby.covers(now.nodes):
            now.places = now.nodes
            if changed or earlier:
                self.renew(now)
            return
        now.places = nearby.places(now.nodes)
        if changed:
            self._scale(now)
            change = np.zeros(nearby.nodes.size)
            change[nearby.places(before.nodes)] -= before.pressure
            change[now.places] += now.pressure
            self._advance_nearby(nearby, 1.0, change, nearby.image(np.arange(change.size), change))

    def go_along(self, now: ContactSet, direction: Array64) -> bool:
        """Step along a search direction to where the energy is least; False if rounding has left no way down."""
        nearby = self._nearby
        if nearby:
            whole = nearby.image(now.places, direction)
            image = whole[now.places]
        else:
            image = self._all.image(now.places, direction)
            self.pairs += 1
        curvature = float(direction @ image)
        if not curvature > 0:
            return False
        step = now.last_product / curvature
        now.pressure += step * direction
        if nearby:
            self._advance_nearby(nearby, step, direction, whole)
            return True
        self._all.advance(step)
        if self.mixed:
            change = step * image.astype(np.float64)
            size = math.sqrt(float(change @ change) / self._problem.num_points)
            self.drift = math.hypot(self.drift, self._rounding * size)
        return True

    def _advance_nearby(self, nearby: Nearby, step: float, direction: Array64, image: Array64) -> None:
        size = abs(step) * math.sqrt(float(direction @ direction) / self._problem.num_points)
        self.drift = math.hypot(self.drift, nearby.error * size)  # first: an interruption must not hide it
        nearby.response += step * image
        self.pairs += nearby.pair_length

    def touching(self, now: ContactSet) -> Array64:
        """h + w on the contact nodes, shape (contact nodes,) [u]."""
        field = self._nearby.response if self._nearby else self._all.field
        return np.asarray(self._problem.height[now.nodes] + field[now.places])

    def level(self, now: ContactSet) -> float:
        """The rigid approach: h + w where they touch [u]."""
        return float(self.touching(now).mean())

    def penetrating(self, now: ContactSet, smallest: float) -> Indices:
        """Nodes outside of a set that penetrate by more than `smallest` [u], shape (nodes,)."""
        # a smaller penetration would be decided by the rounding of h + w, and the set would never settle
        nearby, field = self._nearby, self._all.field
        size = float(np.abs((nearby.response if nearby else field)[now.places]).max())
        bound = self.level(now) - max(smallest, 8 * float(np.finfo(field.dtype).eps) * size)
        if nearby and self.drift:  # of the other nodes only an old response is known
            below = np.asarray(nearby.nodes[nearby.height + nearby.response < bound])
        else:
            below = self._all.below(bound)
        return below[~now.patches.hold(below)]

    def floor(self, now: ContactSet) -> float:
        """The rms equilibrium residual over p that rounding leaves here (dimensionless)."""
        sample = np.arange(0, self._problem.num_points, max(1, self._problem.num_points // _SAMPLE))
        response = self._all.field[sample]
        displacement = np.minimum(self.level(now) - response, self._problem.height[sample])
        return rounding_floor(self._problem.stiffness, displacement, response.dtype.name)

    def displacement(self, now: ContactSet) -> Array64:
        """u, shape (N,) [u], in float64; contact nodes stand on the exact wall."""
        if self._nearby and self.drift:
            self.renew(now)
        height = self._problem.height
        # not `level`: an interruption may have come before `places`
        level = float((height[now.nodes] + self._all.field[now.nodes]).mean())
        u = level - self._all.field[: height.size].astype(np.float64, copy=False)
        np.minimum(u, height, out=u)
        u[now.nodes] = height[now.nodes]
        return u
