"""Active set: preconditioned conjugate gradients on the contact, the set of contact nodes updated on the way.

Unknown is the contact pressure sigma >= 0 on the contact nodes C, with the load fixed. There the gap h + G sigma must
be one constant, the rigid approach; elsewhere it must not be less. Conjugate gradients on G_CC (M. R. Hestenes and E.
Stiefel, 1952) with the preconditioner of `deflation` take one transform pair an iteration, because the response G sigma
is carried along on all nodes. Whenever the residual has fallen to `inner` of what it was when the set last changed, the
set is updated (primal-dual active set, M. Hintermueller et al., SIAM J. Optim. 13, 865 (2002)): nodes that pull are
dropped, nodes that penetrate are added. The search ends when neither happens at the tolerance asked. When a set comes
back, the next ones are decided on more accurate solutions; when that does not help either, the search gives up.

The residual is the preconditioned one, an estimate of the pressure's error: rms over all nodes, over the mean pressure.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import CHUNK, Call, layout, record
from .deflation import GreensFunction, PatchDeflation
from .edges import edge_moves
from .patches import Indices, Patches
from .problem import Problem, foundation_pressure, rounding_floor
from .stiffness import Array64
from .transforms import Transforms

Array = NDArray[Any]

_FEW_TO_MOVE = 8  # patches up to which the ends of a cold start are moved by prediction; more disturb each other


class ActiveSet:
    """State: response w = G sigma, direction and work, shape (padded N,) each; pressure on the contact nodes [p].

    The gap is h + w - level. It is never stored: h may be large, and the rounding of h + w would end up in u.
    """

    inner = 0.05
    safety = 0.4  # of the tolerance, where to stop: the free residual is up to twice the pressure's error
    patience = 10**9  # the residual starts anew with every set; `longest` ends the search instead
    longest = 150  # iterations on one set: rounding keeps the residual up; more where patches share an unknown
    pair_length = 1.0  # of a transform pair, over N
    slack = 0.0  # nodes a patch may still have wrong on the average; for coarse grids

    def __init__(self, problem: Problem, transforms: Transforms, tolerance: float, backend: str = "warp") -> None:
        n = self._num_points = problem.num_points
        self.problem, self.transforms, self.backend, self.tolerance = problem, transforms, backend, tolerance
        self.target = self.safety * tolerance
        self._pairs, self._drift, self._floor = 0.0, 0.0, 0.0
        self.iteration, self.residual, self.frozen = 0, math.inf, False
        self._direction, self._work = transforms.buffer(), transforms.buffer()
        self._response, self._height, self._rest = self._fields()
        self._state = np.zeros(layout.GAP_STATE_LENGTH)
        self._counts = np.zeros(self._work.size // CHUNK)
        self._green = GreensFunction(problem.stiffness, n)
        self._compliance = self._operator(transforms, self._direction, self._work)
        self._wall = self._response, self._height, self._state
        self._advance = record(backend, [Call("advance_response", (self._work, self._state), (self._response,))])
        self._count = record(backend, [Call("count_below", self._wall, (self._counts,))])
        self._height[:] = 1e30  # the padding never touches
        self._put(self._height, problem.height)
        self._eps = float(np.finfo(self._response.dtype).eps)
        # a single node that penetrates so much takes a tenth of the tolerance as its force
        self._smallest_gap = 0.1 * tolerance / float(problem.stiffness.mean())
        self._full_pressure = np.zeros(n)
        self._contact = np.zeros(n, dtype=bool)
        self._patches: Patches | None = None
        self._nodes, self._pressure = np.zeros(0, dtype=np.int64), np.zeros(0)
        self._at = self._nodes
        self._preconditioner: PatchDeflation | None = None
        self._conjugate = np.zeros(0)

    def _fields(self) -> tuple[Array, Array, Array]:
        """Buffers for the response, the wall and the displacement."""
        return self.transforms.buffer(), self.transforms.buffer(), self._work

    # where nodes have their values in the fields, for those that share or reorder them

    def _places(self, nodes: Indices) -> Indices:
        return nodes

    def _nodes_at(self, places: Indices) -> Indices:
        return places

    def _put(self, field: Array, values: Array64) -> None:
        field[: self._num_points] = values

    def _get(self, field: Array) -> Array:
        return field[: self._num_points]

    def _operator(self, transforms: Transforms, source: Array, target: Array) -> tuple[Callable[[], None], ...]:
        """target = G source, in three steps."""
        forward, inverse = transforms.forward(source), transforms.inverse(target)
        coefficient = transforms.doubled(self._green.compliance / self._num_points)
        multiply = record(self.backend, [Call("spectral_multiply", (coefficient,), (transforms.spectrum,))])
        return forward, multiply, inverse

    def start(self, displacement: Array64) -> None:
        """Begin from the wall's force under a displacement, shape (N,) [u]."""
        force = self.problem.net_force(displacement)
        self.start_from_pressure(np.where(displacement >= self.problem.height, np.maximum(force, 0.0), 0.0))

    def start_cold(self) -> None:
        """Begin with the pressure of a Winkler foundation as stiff as the layer's longest wave."""
        self.start_from_pressure(foundation_pressure(self.problem))
        assert self._patches is not None
        self._jumps = 6 if self._patches.count <= _FEW_TO_MOVE else 0

    def start_from_pressure(self, pressure: Array64) -> None:
        """Begin from a contact pressure, shape (N,) [p]; without any, from `start_cold`."""
        if not pressure.any():
            self.start_cold()
            return
        self.frozen, self._inner, self._seen, self._jumps = False, self.inner, set[int](), 0
        self._contact[:] = pressure > 0
        self._full_pressure[:] = np.where(self._contact, pressure, 0.0)
        self._take_set()
        self._find_response()
        displacement = np.minimum(self._level - self._get(self._response), self.problem.height)
        self._floor = 0.3 * rounding_floor(self.problem.stiffness, displacement, self._response.dtype.name)

    def try_harder(self) -> None:
        """Go on to a smaller residual, after the certificate has found the free residual too large."""
        self.target *= 0.2
        self._floor *= 0.2
        self.frozen = False

    def _take_set(self) -> None:
        """Patches of the contact map; the preconditioner follows when it is needed."""
        if self._patches is not None:
            self._direction[self._at] = 0
        self._patches = Patches.of(self._contact)
        self._nodes = self._patches.nodes
        self._at = self._places(self._nodes)
        self._pressure = self._full_pressure[self._nodes]
        self._stale = True
        self._first, self._before, self._settled, self._tries = math.inf, 0.0, False, 0

    def _apply(self, values: Array64) -> None:
        """work = G values, given on the contact nodes."""
        self._direction[self._at] = values
        for part in self._compliance:
            part()
        self._pairs += self.pair_length

    @property
    def transform_pairs(self) -> float:
        """Transform pairs so far, short ones by their length."""
        return self._pairs + self._green.transformed / self._num_points

    def _find_response(self) -> None:
        """Scale the pressure to the load and take the response to it."""
        self._scale_to_load()
        self._apply(self._pressure)
        self._response[:] = self._work

    def _scale_to_load(self) -> None:
        load = float(self._pressure.sum())
        if not load > 0:  # a set of new nodes only, or a load that rounding has eaten
            self._pressure[:], load = 1, self._pressure.size
        self._pressure *= self._num_points / load

    def step(self) -> None:
        """One iteration of conjugate gradients, or an update of the set."""
        if self._patches is None:
            self.start_cold()
        assert self._patches is not None
        if self._preconditioner is None or self._stale:
            self._preconditioner = PatchDeflation(self._green, self._patches, self._preconditioner)
            self._stale = False
        touching = self._touching()
        r = float(touching.mean()) - touching
        z = self._precondition(r)
        self.residual = math.sqrt(float(z @ z) / self._num_points)
        if math.isinf(self._first):
            self._first = self.residual
        if self._drift and self.residual <= max(self.target, self._floor, 3 * self._drift):
            self._find_response()
            self._before = 0.0
            self.iteration += 1
            return
        target = max(self.target, self._floor)  # below, sets would be decided on rounding
        if self.residual <= max(target, 0.0 if self._settled else self._inner * self._first):
            if self._update_set():
                self.iteration += 1
                return
            self._settled = True
            if self.residual <= target:
                self.frozen = True
        self._tries += 1
        if not math.isfinite(self.residual):
            self.frozen = True
        elif self._tries > max(self.longest, self._preconditioner.share):
            self._leave_set()
        elif not self.frozen:
            self._advance_along(r, z)

    def _leave_set(self) -> None:
        """Rounding does not let this set be solved any further; it may be the wrong one."""
        self.iteration += 1
        self.frozen = not self._update_set()

    def _precondition(self, residual: Array64) -> Array64:
        assert self._preconditioner is not None
        return self._preconditioner.apply(residual)

    def _advance_along(self, r: Array64, z: Array64) -> None:
        rz = float(r @ z)
        self._conjugate = z + rz / self._before * self._conjugate if self._before else z
        self._before = rz
        d = self._conjugate
        self._apply(d)
        curvature = float(d @ self._work[self._at])
        if not curvature > 0:  # rounding: no way down any more
            self._leave_set()
            return
        self._state[layout.STEP] = step = rz / curvature
        self._pressure += step * d
        self._advance()
        self.iteration += 1

    @property
    def _level(self) -> float:
        return float(self._touching().mean())

    def _touching(self) -> Array64:
        """h + w on the contact nodes."""
        return self.problem.height[self._nodes] + self._response[self._at]

    def _update_set(self) -> bool:
        """Drop nodes that pull, add nodes that penetrate; False if there are none."""
        assert self._patches is not None
        dropped = self._nodes[self._pressure < 0]
        # less than the rounding of h + w: a set decided on that would never settle
        rounding = 8 * self._eps * float(np.abs(self._response[self._at]).max())
        self._state[layout.BOUND] = bound = self._level - max(self._smallest_gap, rounding)
        self._count()
        chunks = np.flatnonzero(self._counts)
        height, response = (array.reshape(-1, CHUNK)[chunks] for array in (self._height, self._response))
        row, column = np.nonzero(height + response < bound)
        below = self._nodes_at(chunks[row] * CHUNK + column)
        new = below[~self._contact[below]]
        if dropped.size + new.size <= self.slack * self._patches.count:
            return False
        self._contact[dropped] = False
        self._contact[new] = True
        if self._jumps:
            self._jump()
        kept = self._contact[self._nodes] & (self._pressure >= 0)
        if not kept.any() and not self._contact.any():
            kept[np.argmax(self._pressure)] = self._contact[self._nodes[np.argmax(self._pressure)]] = True
        self._full_pressure[self._nodes] = np.where(kept, self._pressure, 0.0)
        self._take_set()
        key = hash((self._patches.first.tobytes(), self._patches.last.tobytes()))
        if key in self._seen:  # decided on too rough a solution, or really going round in circles
            self._inner *= 0.1
            self._seen.clear()
            self.frozen = self._inner < 1e-7
        self._seen.add(key)
        if not kept.all():
            self._find_response()
        return True

    def _jump(self) -> None:
        """Move ends that are two nodes off or more to where the pressure there says that they belong."""
        assert self._patches is not None
        self._jumps -= 1
        patches, moves = self._patches, edge_moves(self._patches, self._pressure)
        for side, patch in zip(*np.nonzero(np.abs(moves) > 1), strict=True):
            move = int(moves[side, patch])
            outside = np.arange(min(move, 0), max(move, 0))  # in steps into the patch
            end, inward = (patches.first[patch], 1) if side == 0 else (patches.last[patch], -1)
            nearby = np.arange(-2 * abs(move), 0)
            self._contact[(end + inward * nearby) % self._num_points] = False
            self._contact[(end + inward * outside) % self._num_points] = move < 0

    @property
    def displacement(self) -> Array64:
        """u, shape (N,) [u], in float64; contact nodes stand on the exact wall. 0 before the first set."""
        if not self._nodes.size:
            return np.zeros(self._num_points)
        self._state[layout.LEVEL] = self._level
        record(self.backend, [Call("rest_on_wall", self._wall, (self._rest,))])()
        height = self.problem.height
        u = np.minimum(self._get(self._rest).astype(np.float64), height)
        u[self._nodes] = height[self._nodes]
        return u

    @property
    def contact_pressure(self) -> Array64:
        """sigma, shape (N,) [p]."""
        pressure = np.zeros(self._num_points)
        pressure[self._nodes] = np.maximum(self._pressure, 0.0)
        return pressure
