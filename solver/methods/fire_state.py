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

import numpy as np

from ...kernels import layout, sequence
from ..arrays import Array, Array64
from ..grid.problem import Problem
from ..transforms.backend import Backend
from .method import PATIENCE, Method

Operator = tuple[Callable[[], None], ...]

LOOK_AFTER = 50
"""Iterations after which, at most, a GPU's state is looked at (one that has converged, or diverged, is not changed by
those that follow), and the change joins its base in mixed precision."""


class Fire(Method):
    """State of a relaxation by plain FIRE: u, v and work, each of shape (padded N,) in the problem's units."""

    # Bitzek's constants; dt_max is `safety` over the root of the stiffest mode over its mass
    safety, dt_start, n_min, f_inc, f_dec, alpha_start, f_alpha = 1.5, 0.5, 5, 1.1, 0.5, 0.1, 0.99
    repeat: Callable[["Fire", int], None] | None = None
    """Where iterations can be repeated without a look at the control state: does so, at most so many times."""
    transform_pairs = 0.0
    pairs_per_iteration = 1
    probe_every = sys.maxsize
    """From one iteration that does more than its parts to the next; the first is one."""
    buffers = 6
    """How many arrays of N values it has, those of the transforms included."""

    def __init__(self, problem: Problem, transforms: Backend, tolerance: float, own_load: bool = False) -> None:
        """tolerance: on the rms equilibrium residual over the mean pressure; own_load: the mean pressure may be
        replaced by a load that differs from node to node, `load`, shape (padded N,) [p].
        """
        n = self.num_points = problem.num_points
        self.problem, self.transforms, self.tolerance = problem, transforms, tolerance
        # all zeros behind N: the padding lies on a wall at 0 and is held there by the mean pressure
        self.u, self.v, self.height = (transforms.buffer() for _ in range(3))
        self.work = transforms.buffer()  # K u
        self.padding = self.u.size - n
        self._inverse = transforms.inverse(self.work)
        self._apply_stiffness = self._operator(self.u, problem.stiffness)
        s = np.zeros(layout.STATE_LENGTH)
        s[layout.N_MIN], s[layout.F_INC], s[layout.F_DEC] = self.n_min, self.f_inc, self.f_dec
        s[layout.ALPHA] = s[layout.ALPHA_START] = self.alpha_start
        s[layout.F_ALPHA], s[layout.TOLERANCE], s[layout.NUM_POINTS] = self.f_alpha, tolerance, self.u.size
        s[layout.RESIDUAL] = np.inf
        self.state = transforms.take(s)
        self._prepare(own_load)
        transforms.put(self.height, problem.height)
        self.start(np.zeros(n))

    def start(self, displacement: Array64) -> None:
        self.transforms.put(self.u, displacement)
        self.v[:] = 0
        self.stop_at_wall()

    def _operator(self, source: Array, symbol: Array64) -> Operator:
        """Forward transform of `source`, multiplication by `symbol`, shape (N//2 + 1,), inverse transform to `work`."""
        return self.transforms.forward(source), self.transforms.multiplication(symbol), self._inverse

    def _limit_step(self, stiffest: float, longest: float = math.inf) -> None:
        """Limit dt by the stiffest mode, and by a longest step."""
        s = self.state
        s[layout.STIFFEST] = stiffest
        s[layout.DT_MAX] = min(self.safety / math.sqrt(stiffest), longest)
        dt = s[layout.DT] or self.dt_start * s[layout.DT_MAX]
        s[layout.DT] = min(dt, s[layout.DT_MAX])

    def _arrays(self) -> dict[str, Array]:
        """The arrays of a step by the names that the sequences of kernels have for them."""
        sums = self.transforms.sums(layout.PARTS * self.u.size)
        return {"elastic": self.work, "h": self.height, "sums": sums, "state": self.state, "u": self.u, "v": self.v}

    def _prepare(self, own_load: bool) -> None:
        """The differences between the methods: further buffers, recorded kernels, the first dt."""
        arrays = self._arrays()
        if own_load:
            self.force, self.load = self.transforms.buffer(), self.transforms.buffer()
            self.load[:] = 1
            arrays |= {"force": self.force, "load": self.load}
        self._move = self.transforms.record(sequence("loaded_move" if own_load else "plain_move", arrays))
        self._limit_step(float(self.problem.stiffness.max()))

    @property
    def displacement(self) -> Array64:
        n, height = self.num_points, self.problem.height
        u, wall = self.transforms.fetch(self.u[:n]), self.transforms.fetch(self.height[:n])
        return np.where(u >= wall, height, np.minimum(u.astype(np.float64), height))

    @property
    def residual(self) -> float:
        """Rms free force over the mean pressure, of u before the last step; once stopped, of u itself."""
        return float(self.state[layout.RESIDUAL])

    @property
    def iteration(self) -> int:
        return int(self.state[layout.ITERATION])

    @property
    def stopped(self) -> bool:
        return bool(self.state[layout.STOPPED])

    @property
    def patience(self) -> int | None:
        return PATIENCE + 20 * math.isqrt(self.num_points)  # sqrt(N) is FIRE's own pace

    @property
    def parts(self) -> Operator:
        """The steps of an iteration, in order."""
        return *self._apply_stiffness, self._move

    def steps(self, most: int) -> None:
        """One iteration, or up to `most` where they are repeated without a look at the control state."""
        if self.repeat is None:
            self.step()
        else:
            self.repeat(self, most)

    def step(self) -> None:
        self._apply(self.parts)
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
        self.transform_pairs += 1
