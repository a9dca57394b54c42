"""The response of the surface to the contact pressure, w = G sigma, carried along on all nodes.

The gap is h + w - level, the level being the rigid approach. It is never stored: h may be large, and the rounding of
h + w would end up in the displacement.

In mixed precision search directions and their images are float32, the response float64. Every step adds the image's
rounding to the response, which drifts away from the pressure that it belongs to, until it is made anew.
"""

import math

import numpy as np

from ....kernels import CHUNK, Call, layout, record
from ...arrays import Array64, Indices
from ...grid.problem import Problem, rounding_floor
from .compliance import Compliance
from .contact_set import ContactSet
from .storage import Whole


class Response:
    """w = G sigma of one grid, and what is read off it. Units are the problem's."""

    def __init__(
        self, problem: Problem, storage: Whole, directions: Compliance, responses: Compliance, backend: str
    ) -> None:
        """directions, responses: apply G to search directions and to the pressure; two objects in mixed precision."""
        self._problem, self._storage = problem, storage
        self._directions, self._responses = directions, responses
        self.mixed = directions is not responses
        self.pairs = 0.0
        """Transform pairs so far, short ones by their length."""
        self.drift = 0.0
        """Rounding that images have added since the response was made, as rms pressure over p; 0 unless mixed."""
        self._rounding = 0.0
        if self.mixed:
            self._rounding = float(np.finfo(np.float32).eps) * math.sqrt(float(np.mean(problem.stiffness**2)))
        self._field, self._height = responses.new_field(), responses.new_field()
        self._height[:] = 1e30  # the padding never touches
        storage.put(self._height, problem.height)
        self._state = np.zeros(layout.GAP_STATE_LENGTH)
        self._counts = np.zeros(self._height.size // CHUNK)
        gap = self._field, self._height, self._state
        self._advance = record(backend, [Call("advance_response", (directions.target, self._state), (self._field,))])
        self._count = record(backend, [Call("count_below", gap, (self._counts,))])
        self._rest = record(backend, [Call("rest_on_wall", gap, (responses.target,))])

    @property
    def even(self) -> bool:
        """Whether the fields hold half of the nodes."""
        return self._storage.length < self._problem.num_points

    def renew(self, now: ContactSet) -> None:
        """Scale the pressure of a set to the load, and make the response to it anew."""
        load = float(now.pressure.sum())
        if not load > 0:  # a set of new nodes only, or a load that rounding has eaten
            now.pressure[:], load = 1, now.pressure.size
        now.pressure *= self._problem.num_points / load
        self._apply(self._responses, now.places, now.pressure)
        self._field[:] = self._responses.target
        self.drift = 0.0

    def go_along(self, now: ContactSet, direction: Array64) -> bool:
        """Step along a search direction to where the energy is least; False if rounding has left no way down."""
        self._apply(self._directions, now.places, direction)
        image = self._directions.target[now.places]
        curvature = float(direction @ image)
        if not curvature > 0:
            return False
        self._state[layout.STEP] = step = now.last_product / curvature
        now.pressure += step * direction
        self._advance()
        if self.mixed:
            change = step * image.astype(np.float64)
            size = math.sqrt(float(change @ change) / self._problem.num_points)
            self.drift = math.hypot(self.drift, self._rounding * size)
        return True

    def _apply(self, compliance: Compliance, places: Indices, values: Array64) -> None:
        compliance.apply(places, values)
        self.pairs += compliance.pair_length

    def touching(self, now: ContactSet) -> Array64:
        """h + w on the contact nodes, shape (contact nodes,) [u]."""
        return np.asarray(self._problem.height[now.nodes] + self._field[now.places])

    def level(self, now: ContactSet) -> float:
        """The rigid approach: h + w where they touch [u]."""
        return float(self.touching(now).mean())

    def penetrating(self, now: ContactSet, smallest: float) -> Indices:
        """Nodes outside of a set that penetrate by more than `smallest` [u], shape (nodes,), in ascending order."""
        # a smaller penetration would be decided by the rounding of h + w, and the set would never settle
        rounding = 8 * float(np.finfo(self._field.dtype).eps) * float(np.abs(self._field[now.places]).max())
        self._state[layout.BOUND] = bound = self.level(now) - max(smallest, rounding)
        self._count()
        chunks = np.flatnonzero(self._counts)
        height, response = (array.reshape(-1, CHUNK)[chunks] for array in (self._height, self._field))
        row, column = np.nonzero(height + response < bound)
        return np.setdiff1d(self._storage.nodes_at(chunks[row] * CHUNK + column), now.nodes)

    def floor(self, now: ContactSet) -> float:
        """The rms free residual over p that rounding leaves here (dimensionless)."""
        displacement = np.minimum(self.level(now) - self._storage.get(self._field), self._problem.height)
        return rounding_floor(self._problem.stiffness, displacement, self._field.dtype.name)

    def displacement(self, now: ContactSet) -> Array64:
        """u, shape (N,) [u], in float64; contact nodes stand on the exact wall."""
        self._state[layout.LEVEL] = self.level(now)
        self._rest()
        height = self._problem.height
        u = np.minimum(self._storage.get(self._responses.target).astype(np.float64), height)
        u[now.nodes] = height[now.nodes]
        return u
