"""Active set: preconditioned conjugate gradients on the contact, the set of contact nodes updated on the way.

Unknown is the contact pressure sigma >= 0 on the contact nodes C, with the load fixed. There the gap h + G sigma must
be one constant, the rigid approach; elsewhere it must not be less. Conjugate gradients on G_CC (M. R. Hestenes and E.
Stiefel, 1952) with the preconditioner of `preconditioner` take one transform pair an iteration, because the response G
sigma is carried along on all nodes. Whenever the residual has fallen to a given part (the forcing term) of what it was
when the set last changed, the set is updated (primal-dual active set, M. Hintermueller et al., SIAM J. Optim. 13, 865
(2002)): nodes that pull are dropped, nodes that penetrate are added. The search ends when neither happens at the
tolerance asked for. When a set comes back, the next ones are decided on more accurate solutions; when that does not
help either, the search gives up.

The residual is the preconditioned one, an estimate of the pressure's error: rms over all nodes, over the mean pressure.

Mixed precision: directions and their images in float32, response and pressure in float64. The response is made anew
from the pressure, by float64 transforms, when what the images' rounding may have put into the residual comes close to
it, and before the end.
"""

import math

import numpy as np

from ....kernels import CHUNK, Call, layout, record
from ...arrays import Array64, Indices
from ...grid.problem import Problem, foundation_pressure, rounding_floor
from ..method import Method
from .compliance import Compliance
from .contact_set import ContactSet
from .ends import moved_ends
from .greens_function import GreensFunction
from .preconditioner import PatchDeflation
from .storage import Whole

_FORCING_TERM = 0.05  # part of a new set's residual at which it is updated
_TIGHTER, _TIGHTEST = 0.1, 1e-7  # factor of the forcing term when a set comes back, and where the search gives up
_SAFETY = 0.4  # of the tolerance, where to stop: the free residual is up to twice the pressure's error
_HARDER = 0.2  # factor of that when the certificate found it too large
_OVER_FLOOR = 0.3  # of what rounding leaves as free residual: what it leaves as error of the pressure
_OVER_DRIFT = 3.0  # times the rounding of float32 images: where the response has to be made anew
_MOST_ITERATIONS = 150  # on one set: then rounding keeps the residual up; more where patches share an unknown
_FEW_PATCHES, _MOVES = 8, 6  # patches up to which ends are moved by prediction, and how often; more disturb each other


class ActiveSet(Method):
    """The active set on one grid. The gap is h + w - level, w the response G sigma.

    It is never stored: h may be large, and the rounding of h + w would end up in the displacement.
    """

    iteration = 0
    residual = math.inf
    stopped = False
    patience = None  # the residual starts anew with every set

    def __init__(
        self,
        problem: Problem,
        tolerance: float,
        green: GreensFunction,
        storage: Whole,
        directions: Compliance,
        responses: Compliance,
        backend: str,
        wrong_nodes_per_patch: float = 0.0,
    ) -> None:
        """directions, responses: apply G to search directions and to the pressure; two objects in mixed precision."""
        self.problem, self.tolerance, self.backend = problem, tolerance, backend
        self._green, self._storage, self._wrong_nodes_per_patch = green, storage, wrong_nodes_per_patch
        self._directions, self._responses = directions, responses
        self._target = _SAFETY * tolerance
        self._floor = 0.0  # of the residual: below, sets would be decided on rounding
        self._drift = 0.0  # of the response, from the images' rounding; 0 unless in mixed precision
        self._rounding = 0.0  # of an image in float32, as pressure over the image
        if self.mixed:
            self._rounding = float(np.finfo(np.float32).eps) * math.sqrt(float(np.mean(problem.stiffness**2)))
        self._pairs = 0.0
        self._response, self._height = responses.new_field(), responses.new_field()
        self._height[:] = 1e30  # the padding never touches
        storage.put(self._height, problem.height)
        self._state = np.zeros(layout.GAP_STATE_LENGTH)
        self._counts = np.zeros(self._height.size // CHUNK)
        gap = self._response, self._height, self._state
        self._advance = record(backend, [Call("advance_response", (directions.target, self._state), (self._response,))])
        self._count = record(backend, [Call("count_below", gap, (self._counts,))])
        self._rest = record(backend, [Call("rest_on_wall", gap, (responses.target,))])
        # a single node that penetrates so much takes a tenth of the tolerance as its force
        self._smallest_gap = 0.1 * tolerance / float(problem.stiffness.mean())
        self._contact = np.zeros(problem.num_points, dtype=bool)
        self._pressure = np.zeros(problem.num_points)  # of all nodes when the set was new
        self._set: ContactSet | None = None
        self._last_preconditioner: PatchDeflation | None = None
        self._forcing_term, self._moves_left, self._earlier_sets = _FORCING_TERM, 0, set[int]()

    @property
    def mixed(self) -> bool:
        return self._directions is not self._responses

    @property
    def even(self) -> bool:
        return self._storage.length < self.problem.num_points

    @property
    def transform_pairs(self) -> float:
        """Transform pairs so far, short ones by their length."""
        return self._pairs + self._green.transformed / self.problem.num_points

    def start(self, displacement: Array64) -> None:
        """Begin from the wall's force under a displacement, shape (N,) [u]."""
        self.start_from_pressure(self.problem.wall_pressure(displacement))

    def start_cold(self) -> None:
        """Begin with the pressure of a Winkler foundation as stiff as the layer's longest wave."""
        self.start_from_pressure(foundation_pressure(self.problem))
        self._moves_left = _MOVES if self._now.patches.count <= _FEW_PATCHES else 0

    def start_from_pressure(self, pressure: Array64) -> None:
        """Begin from a contact pressure, shape (N,) [p]; without any, from `start_cold`."""
        if not pressure.any():
            self.start_cold()
            return
        pressure = self._storage.symmetric(pressure)
        self.stopped, self._forcing_term, self._moves_left, self._earlier_sets = False, _FORCING_TERM, 0, set()
        self._contact[:] = pressure > 0
        self._pressure[:] = np.where(self._contact, pressure, 0.0)
        self._take_set()
        self._renew_response()
        displacement = np.minimum(self._level - self._storage.get(self._response), self.problem.height)
        self._floor = _OVER_FLOOR * rounding_floor(self.problem.stiffness, displacement, self._response.dtype.name)

    def try_harder(self) -> bool:
        """Go on to a smaller residual, see `Method`."""
        self._target *= _HARDER
        self._floor *= _HARDER
        self.stopped = False
        return True

    def demand_every_node(self) -> None:
        self._wrong_nodes_per_patch, self.stopped = 0.0, False

    def step(self) -> None:
        """Solve on the set, by one iteration; where that has come far enough, update the set instead."""
        if self._set is None:
            self.start_cold()
        now = self._now
        if now.preconditioner is None:
            now.preconditioner = PatchDeflation(self._green, now.patches, self._last_preconditioner)
            self._last_preconditioner = now.preconditioner
        touching = self._touching()
        r = float(touching.mean()) - touching
        z = now.precondition(r)
        self.residual = math.sqrt(float(z @ z) / self.problem.num_points)
        if math.isinf(now.first_residual):
            now.first_residual = self.residual
        if self._drift and self.residual <= max(self._target, self._floor, _OVER_DRIFT * self._drift):
            self._renew_response()
            now.last_product = 0.0
            self.iteration += 1
        elif not self._updated():
            self._iterate(r, z)

    def _updated(self) -> bool:
        """Update the set if it is solved well enough for that; whether it changed. Stops where it is the last one."""
        now, target = self._now, max(self._target, self._floor)
        if not self.residual <= max(target, 0.0 if now.settled else self._forcing_term * now.first_residual):
            return False
        if self._update_set():
            self.iteration += 1
            return True
        now.settled = True
        if self.residual <= target:
            self.stopped = True
        return False

    def _iterate(self, r: Array64, z: Array64) -> None:
        """One iteration of conjugate gradients from the residual and the preconditioned one, unless there is an end."""
        now = self._now
        now.iterations += 1
        assert now.preconditioner is not None
        if not math.isfinite(self.residual):
            self.stopped = True
        elif now.iterations > max(_MOST_ITERATIONS, now.preconditioner.share):
            self._leave_set()
        elif not self.stopped:
            self._advance_along(r, z)

    def _leave_set(self) -> None:
        """Rounding does not let this set be solved any further; it may be the wrong one."""
        self.iteration += 1
        self.stopped = not self._update_set()

    def _advance_along(self, r: Array64, z: Array64) -> None:
        """A step along the next conjugate direction."""
        now, images = self._now, self._directions.target
        rz = float(r @ z)
        now.direction = d = z + rz / now.last_product * now.direction if now.last_product else z
        now.last_product = rz
        self._apply(self._directions, d)
        curvature = float(d @ images[now.places])
        if not curvature > 0:  # rounding: no way down any more
            self._leave_set()
            return
        self._state[layout.STEP] = step = rz / curvature
        now.pressure += step * d
        self._advance()
        self.iteration += 1
        if self.mixed:
            image = step * images[now.places].astype(np.float64)
            size = math.sqrt(float(image @ image) / self.problem.num_points)
            self._drift = math.hypot(self._drift, self._rounding * size)

    def _take_set(self) -> None:
        """A new set from the contact map and the pressure."""
        self._storage.make_symmetric(self._contact)
        self._set = ContactSet.of(self._contact, self._pressure, self._storage)

    def _apply(self, compliance: Compliance, pressure: Array64) -> None:
        compliance.apply(self._now.places, pressure)
        self._pairs += compliance.pair_length

    def _renew_response(self) -> None:
        """Scale the pressure to the load, and make the response to it anew."""
        now = self._now
        load = float(now.pressure.sum())
        if not load > 0:  # a set of new nodes only, or a load that rounding has eaten
            now.pressure[:], load = 1, now.pressure.size
        now.pressure *= self.problem.num_points / load
        self._apply(self._responses, now.pressure)
        self._response[:] = self._responses.target
        self._drift = 0.0

    @property
    def _now(self) -> ContactSet:
        """The present set."""
        assert self._set is not None
        return self._set

    @property
    def _level(self) -> float:
        """The rigid approach: h + w where they touch [u]."""
        return float(self._touching().mean())

    def _touching(self) -> Array64:
        """h + w on the contact nodes [u]."""
        return self.problem.height[self._now.nodes] + self._response[self._now.places]

    def _update_set(self) -> bool:
        """Drop nodes that pull, add nodes that penetrate; False if there are none, or no more than may be wrong."""
        now, contact = self._now, self._contact
        dropped, new = now.nodes[now.pressure < 0], self._penetrating()
        if dropped.size + new.size <= self._wrong_nodes_per_patch * now.patches.count:
            return False
        contact[dropped] = False
        contact[new] = True
        if self._moves_left:
            self._moves_left -= 1
            for nodes, touch in moved_ends(now.patches, now.pressure):
                contact[nodes] = touch
        kept = contact[now.nodes] & (now.pressure >= 0)
        if not kept.any() and not contact.any():
            kept[np.argmax(now.pressure)] = contact[now.nodes[np.argmax(now.pressure)]] = True
        self._pressure[now.nodes] = np.where(kept, now.pressure, 0.0)
        self._take_set()
        if self._now.key in self._earlier_sets:  # decided on too rough a solution, or really going round in circles
            self._forcing_term *= _TIGHTER
            self._earlier_sets.clear()
            self.stopped = self._forcing_term < _TIGHTEST
        self._earlier_sets.add(self._now.key)
        if not kept.all():
            self._renew_response()
        return True

    def _penetrating(self) -> Indices:
        """Nodes outside of the set that penetrate, shape (number of nodes,)."""
        # less than the rounding of h + w: a set decided on that would never settle
        eps = float(np.finfo(self._response.dtype).eps)
        rounding = 8 * eps * float(np.abs(self._response[self._now.places]).max())
        self._state[layout.BOUND] = bound = self._level - max(self._smallest_gap, rounding)
        self._count()
        chunks = np.flatnonzero(self._counts)
        height, response = (array.reshape(-1, CHUNK)[chunks] for array in (self._height, self._response))
        row, column = np.nonzero(height + response < bound)
        below = self._storage.nodes_at(chunks[row] * CHUNK + column)
        return below[~self._contact[below]]

    @property
    def displacement(self) -> Array64:
        """u, shape (N,) [u], in float64; contact nodes stand on the exact wall. 0 before the first set."""
        if self._set is None:
            return np.zeros(self.problem.num_points)
        self._state[layout.LEVEL] = self._level
        self._rest()
        height = self.problem.height
        u = np.minimum(self._storage.get(self._responses.target).astype(np.float64), height)
        u[self._now.nodes] = height[self._now.nodes]
        return u

    @property
    def contact_pressure(self) -> Array64:
        """sigma, shape (N,) [p]; 0 before the first set."""
        pressure = np.zeros(self.problem.num_points)
        if self._set is not None:
            pressure[self._set.nodes] = np.maximum(self._set.pressure, 0.0)
        return pressure
