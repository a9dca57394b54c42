"""FIRE, the published study's method, on Warp kernels between pyFFTW transforms.

FIRE (E. Bitzek et al., Phys. Rev. Lett. 97, 170201 (2006)) integrates v += dt F, u += dt v with semi-implicit Euler,
steers the velocity along the force, and stops when the power v.F turns negative (dt keeps above 0.02 dt_max here). The
force F is the net force on the free nodes only: the wall's share would bias the power and the step control. After each
step the hard wall projects: where u > h, u = h and v = 0 (the kernels leave a marker as good as 0, `layout.TOUCHING`).
dt is limited by the stiffest mode, dt_max = safety/sqrt(K_max) (2 is the stability limit), so the iterations grow like
sqrt(N).
"""

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...kernels import Call, layout, sequence
from ..arrays import Array, Array64
from ..grid.problem import Problem
from ..transforms.backend import Backend
from .method import Method

Operator = tuple[Callable[[], None], ...]


@dataclass(frozen=True)
class FireParameters:
    """FIRE's constants, under Bitzek's names; all dimensionless."""

    safety: float = 1.5
    """dt_max sqrt(lambda_max), lambda_max the stiffest mode over its mass."""
    dt_start: float = 0.5
    """First time step over dt_max."""
    n_min: int = 5
    """Steps downhill before dt grows."""
    f_inc: float = 1.1
    """Factor by which dt grows."""
    f_dec: float = 0.5
    """Factor by which dt shrinks when the power turns negative."""
    alpha_start: float = 0.1
    """First share of the velocity that is steered along the force."""
    f_alpha: float = 0.99
    """Factor by which that share shrinks."""


class Fire(Method):
    """State of a relaxation by plain FIRE: u, v and work, each of shape (padded N,) in the problem's units."""

    parameters = FireParameters()
    repeat: Callable[["Fire", int], None] | None = None
    """Where iterations can be repeated without a look at the control state: does so, at most so many times."""
    pairs_per_iteration = 1
    buffers = 6
    """How many arrays of N values it has, those of the transforms included."""

    def __init__(self, problem: Problem, transforms: Backend, tolerance: float, own_load: bool = False) -> None:
        """tolerance: on the rms free residual over the mean pressure; own_load: the mean pressure may be replaced by
        a load that differs from node to node, `load`, shape (padded N,) [p].
        """
        n = self.num_points = problem.num_points
        self.problem, self.transforms, self.tolerance = problem, transforms, tolerance
        self._pairs = 0.0
        # all zeros behind N: the padding lies on a wall at 0 and is held there by the mean pressure
        self.u, self.v, self.height = (transforms.buffer() for _ in range(3))
        self.work = transforms.buffer()  # K u
        self.padding = self.u.size - n
        self._inverse = transforms.inverse(self.work)
        self._apply_stiffness = self._operator(self.u, problem.stiffness)
        self._start_state()
        self._prepare(own_load)
        transforms.put(self.height, problem.height)
        self.start(np.zeros(n))

    def start(self, displacement: Array64) -> None:
        """Begin at rest from u, shape (N,) [u], put below the wall."""
        self.transforms.put(self.u, displacement)
        self.v[:] = 0
        self.stop_at_wall()

    def start_from_pressure(self, pressure: Array64) -> None:
        """Begin at rest from the displacement under a contact pressure, shape (N,) [p]."""
        self.start(self.problem.displacement_under(pressure))

    def _operator(self, source: Array, symbol: Array64) -> Operator:
        """Forward transform of `source`, multiplication by `symbol`, shape (N//2 + 1,), inverse transform to `work`."""
        multiply = self.transforms.multiplication(symbol, self.work)
        return self.transforms.forward(source), multiply, self._inverse

    def _replay(self, *calls: Call) -> Callable[[], None]:
        return self.transforms.record(calls)

    def _start_state(self) -> None:
        s, p = np.zeros(layout.STATE_LENGTH), self.parameters
        s[layout.N_MIN], s[layout.F_INC], s[layout.F_DEC] = p.n_min, p.f_inc, p.f_dec
        s[layout.ALPHA] = s[layout.ALPHA_START] = p.alpha_start
        s[layout.F_ALPHA] = p.f_alpha
        s[layout.TOLERANCE], s[layout.NUM_POINTS] = self.tolerance, self.u.size
        s[layout.RESIDUAL] = np.inf
        self.state = self.transforms.take(s)

    def _limit_step(self, stiffest: float, longest: float = math.inf) -> None:
        """Limit dt by the stiffest mode, and by a longest step."""
        s = self.state
        s[layout.STIFFEST] = stiffest
        s[layout.DT_MAX] = min(self.parameters.safety / math.sqrt(stiffest), longest)
        dt = s[layout.DT] or self.parameters.dt_start * s[layout.DT_MAX]
        s[layout.DT] = min(dt, s[layout.DT_MAX])

    def _arrays(self, **more: Array) -> dict[str, Array]:
        """The arrays of a step by the names that the sequences of kernels have for them."""
        sums = (f"{name}_sums" for name in ("force", "held", "power", "velocity", "acceleration"))
        found: dict[str, Array] = {name: self.transforms.sums(self.u.size) for name in sums}
        return found | {"elastic": self.work, "h": self.height, "state": self.state, "u": self.u, "v": self.v} | more

    def _prepare(self, own_load: bool) -> None:
        """What differs between the methods: further buffers, recorded kernels, the first dt."""
        if own_load:
            self.force, self.load = self.transforms.buffer(), self.transforms.buffer()
            self.load[:] = 1
            arrays = self._arrays(force=self.force, load=self.load)
            self._move = self._replay(*sequence("loaded_move", arrays))
        else:
            self._move = self._replay(*sequence("plain_move", self._arrays()))
        self._limit_step(float(self.problem.stiffness.max()))

    @property
    def displacement(self) -> Array64:
        """u, shape (N,) [u], in float64; nodes on the wall of this precision stand on the exact wall."""
        n, height = self.num_points, self.problem.height
        u, wall = self.transforms.fetch(self.u[:n]), self.transforms.fetch(self.height[:n])
        return np.where(u >= wall, height, np.minimum(u.astype(np.float64), height))

    @property
    def contact_pressure(self) -> Array64:
        """sigma >= 0 on the nodes on the wall, shape (N,) [p]."""
        return self.problem.wall_pressure(self.displacement)

    @property
    def transform_pairs(self) -> float:
        return self._pairs

    @property
    def residual(self) -> float:
        """Rms free force over the mean pressure, of u before the last step; once stopped, of u itself."""
        return float(self.state[layout.RESIDUAL])

    @property
    def iteration(self) -> int:
        return int(self.state[layout.ITERATION])

    @property
    def stopped(self) -> bool:
        """Converged or diverged: further steps change nothing."""
        return bool(self.state[layout.STOPPED])

    @property
    def patience(self) -> int | None:
        """Iterations without a new minimum of the residual after which there is no hope; sqrt(N) is FIRE's own pace."""
        return 1000 + 20 * math.isqrt(self.num_points)

    @property
    def parts(self) -> Operator:
        """What one iteration does, in order."""
        return *self._apply_stiffness, self._move

    @property
    def alike(self) -> int:
        """How many iterations from here on do nothing but their parts."""
        return sys.maxsize

    def steps(self, most: int) -> None:
        """One iteration, or up to `most` where they are repeated without a look at the control state."""
        if self.repeat is None:
            self.step()
        else:
            self.repeat(self, most)

    def step(self) -> None:
        """One FIRE iteration, one transform pair."""
        self._apply(self._apply_stiffness)
        self._move()
        self.after_step()

    def after_step(self) -> None:
        """After a lift-off: a rigid shift back to first touch, which costs no elastic energy (K = 0 there)."""
        if self.state[layout.HELD] > self.padding:
            return
        n = self.num_points
        lift = (self.height[:n] - self.u[:n]).min()
        if lift > 0:
            self.u[:n] += lift
            self.v[:n] += max(0.0, -float(self.v[:n].mean()))
            self.stop_at_wall()

    def stop_at_wall(self) -> None:
        """Put u below the wall and mark the nodes that touch it, as a step does."""
        hit = self.u >= self.height
        self.u[:], self.v[hit] = np.where(hit, self.height, self.u), layout.TOUCHING

    def _apply(self, operator: Operator) -> None:
        for part in operator:
            part()
        self.add_pairs(1)

    def add_pairs(self, count: float) -> None:
        """Add pairs of transforms to those that were done."""
        self._pairs += count
