"""FIRE, plain and mass-weighted, on Warp kernels between pyFFTW transforms.

Plain FIRE (E. Bitzek et al., Phys. Rev. Lett. 97, 170201 (2006)) integrates v += dt F, u += dt v with semi-implicit
Euler, steers the velocity along the force, and stops when the power v.F turns negative. The force F is the net force on
the free nodes only: the wall's share would bias the power and the step control. After each step the hard wall projects:
where u > h, u = h and v = 0. dt is limited by the stiffest mode, so the iterations grow like sqrt(N).

Mass-weighted FIRE gives each mode its own inertia, a = M^-1 F with M = K, so that all modes move at one pace and the
iterations do not grow with N. The wall lives in real space and M^-1 in Fourier space; the order in which they act
matters. Here it is a two-metric projection (D. P. Bertsekas, SIAM J. Control Optim. 20, 221 (1982)):

    a = P M^-1 P r,   P = restriction to the free nodes.

Without the first P the wall's force leaks into the motion, without the second held nodes drift off the wall; either way
the fixed point is wrong. The mean mode has no stiffness and gets the softest mode's mass, min K.

The step. On the free nodes the spectrum of P M^-1 P K P is 1 but for a few outliers that the contact edges make; for an
incompressible thin layer one of them grows like a/d. dt_max = safety/sqrt(lambda_max) (2 is the stability limit), with
lambda_max from a few power iterations that are repeated as the contact changes. For plain FIRE lambda_max = K_max.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ..kernels import CHUNK, Call, layout, padded_length, record
from .problem import Problem
from .transforms import Transforms

Array64 = NDArray[np.float64]
Progress = Callable[[int, float], None]
"""Called with (iteration, rms free residual over the mean pressure)."""


class Status(StrEnum):
    """How a solve ended. Only `CONVERGED` is certified at the tolerance asked."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "iteration limit"
    STAGNATED = "stagnated"
    DIVERGED = "diverged"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class FireParameters:
    """Constants under Bitzek's names, dimensionless; `safety` is dt_max sqrt(lambda_max), dt_start is over dt_max."""

    safety: float = 1.5
    dt_start: float = 0.5
    n_min: int = 5
    f_inc: float = 1.1
    f_dec: float = 0.5
    alpha_start: float = 0.1
    f_alpha: float = 0.99


# Once dt_max is safe by measurement, cutting dt in half at every turn only loses time: measured on 46 scenes (Hertz and
# rough, nu = -0.9 to 0.5, d = 1e-4 to inf, cold), n_min = 1 and f_dec = 0.8 need 0.78 of the transforms of Bitzek's 5,
# 0.5.
PARAMETERS = {"fire": FireParameters(), "mass-weighted-fire": FireParameters(n_min=1, f_dec=0.8)}

_PROBE_EVERY = 100  # iterations between estimates of lambda_max
_PROBE_STEPS = 6  # power iterations each


class Fire:
    """State of one relaxation: u, v, force, acceleration, each of shape (padded N,) in the problem's units.

    method: 'fire' or 'mass-weighted-fire'; tolerance: on the rms free residual over the mean pressure; initial: u to
    start from, shape (N,) [p L/E*], put below the wall, default 0; backend: 'warp' or 'numpy' (the twins).
    """

    def __init__(
        self,
        problem: Problem,
        transforms: Transforms,
        method: str,
        tolerance: float,
        initial: Array64 | None = None,
        backend: str = "warp",
    ) -> None:
        self.num_points = problem.num_points
        self.mass_weighted = method == "mass-weighted-fire"
        self.tolerance = tolerance
        self.transform_pairs = 0
        buffer = transforms.buffer
        # all zeros behind N: the padding lies on a wall at 0 and is held there by the mean pressure
        self.u, self.v, self.force, self.height, self.probe = (buffer() for _ in range(5))
        self.work = buffer()  # K u, then the acceleration
        self.padding = self.u.size - self.num_points
        self._to_spectrum = {id(a): transforms.forward(a) for a in (self.u, self.force, self.probe)}
        self._to_work = transforms.inverse(self.work)
        self._coefficients(problem, transforms)
        self._start_state(problem, PARAMETERS[method])
        self._record(transforms, backend)
        self._problem_height = problem.height
        self.height[: self.num_points] = problem.height
        if initial is not None:
            self.u[: self.num_points] = initial
        self._stop_at_wall()

    def _coefficients(self, problem: Problem, transforms: Transforms) -> None:
        n = self.num_points
        mass = problem.stiffness.copy()
        mass[0] = problem.stiffness[1:].min()
        self.stiffness = transforms.buffer(n + 2)
        self.stiffness[: n + 2] = np.repeat(problem.stiffness / n, 2)
        self.inverse_mass = transforms.buffer(n + 2)
        if self.mass_weighted:
            self.inverse_mass[: n + 2] = np.repeat(1 / (mass * n), 2)

    def _start_state(self, problem: Problem, parameters: FireParameters) -> None:
        s = self.state = np.zeros(layout.STATE_LENGTH)
        s[layout.N_MIN], s[layout.F_INC], s[layout.F_DEC] = parameters.n_min, parameters.f_inc, parameters.f_dec
        s[layout.ALPHA] = s[layout.ALPHA_START] = parameters.alpha_start
        s[layout.F_ALPHA] = parameters.f_alpha
        s[layout.TOLERANCE], s[layout.NUM_POINTS] = self.tolerance, self.u.size
        s[layout.RESIDUAL] = np.inf
        self._parameters = parameters
        if not self.mass_weighted:
            self._limit_step(float(problem.stiffness.max()))

    def _limit_step(self, stiffest: float) -> None:
        s = self.state
        s[layout.STIFFEST] = stiffest
        natural = 1.0 if self.mass_weighted else math.inf  # no mode is softer than its mass
        s[layout.DT_MAX] = min(self._parameters.safety / math.sqrt(stiffest), natural)
        dt = s[layout.DT] or self._parameters.dt_start * s[layout.DT_MAX]
        s[layout.DT] = min(dt, s[layout.DT_MAX])

    def _record(self, transforms: Transforms, backend: str) -> None:
        chunks = padded_length(self.num_points) // CHUNK
        sums = {name: np.zeros(chunks) for name in ("force", "held", "power", "velocity", "acceleration")}
        self._squares = np.zeros(chunks)
        if not self.mass_weighted:
            sums["acceleration"] = sums["force"]  # the acceleration is the force
        control = Call("fire_control", tuple(sums.values()), (self.state,))
        wall, motion = (self.work, self.height, self.state), (self.u, self.v)
        force = Call("net_force", (self.work, self.v), (self.force, sums["force"], sums["held"]))
        if self.mass_weighted:
            search = Call("search_sums", (self.force, self.v), (self.work, *list(sums.values())[2:]))
            move = [search, control, Call("fire_step", wall, motion)]
        else:
            search = Call("plain_sums", (self.work, self.v), tuple(sums.values())[:4])
            move = [search, control, Call("plain_step", wall, motion)]
        restrict = Call("restrict_to_free", (self.force, self.work), (self.probe, self._squares))

        def multiply(coefficient: NDArray[np.floating]) -> Callable[[], None]:
            return record(backend, [Call("spectral_multiply", (coefficient,), (transforms.spectrum,))])

        self._multiply_stiffness = multiply(self.stiffness)
        self._multiply_inverse_mass = multiply(self.inverse_mass)
        self._find_force = record(backend, [force])
        self._move = record(backend, move)
        self._restrict = record(backend, [restrict])

    @property
    def displacement(self) -> Array64:
        """u, shape (N,) [p L/E*], in float64; nodes on the wall of this precision stand on the exact wall."""
        n = self.num_points
        u = np.minimum(self.u[:n].astype(np.float64), self._problem_height)
        on_wall = self.u[:n] >= self.height[:n]
        u[on_wall] = self._problem_height[on_wall]
        return u

    @property
    def residual(self) -> float:
        """rms free force over the mean pressure, of the displacement before the last step (of u itself once frozen)."""
        return float(self.state[layout.RESIDUAL])

    @property
    def iteration(self) -> int:
        return int(self.state[layout.ITERATION])

    @property
    def frozen(self) -> bool:
        """Converged or diverged: further steps change nothing."""
        return bool(self.state[layout.FROZEN])

    def step(self) -> None:
        """One FIRE iteration: one transform pair, two if mass-weighted."""
        self._apply(self.u, self._multiply_stiffness)
        if self.mass_weighted:
            self._find_force()
            if self.iteration % _PROBE_EVERY == 0:
                self._measure_stiffest()
            self._apply(self.force, self._multiply_inverse_mass)
        self._move()
        if self.state[layout.HELD] <= self.padding:
            self._touch()

    def timed_step(self) -> dict[str, float]:
        """`step` of plain FIRE with the seconds spent in 'transforms' and in the 'rest', for benchmarks."""
        marks = [time.perf_counter()]
        for part in (self._to_spectrum[id(self.u)], self._multiply_stiffness, self._to_work, self._move):
            part()
            marks.append(time.perf_counter())
        forward, multiply, inverse, move = np.diff(marks)
        return {"transforms": float(forward + inverse), "rest": float(multiply + move)}

    def _touch(self) -> None:
        """After a lift-off: a rigid shift back to first touch, which costs no elastic energy (K = 0 there)."""
        n = self.num_points
        lift = (self.height[:n] - self.u[:n]).min()
        if lift > 0:
            self.u[:n] += lift
            self.v[:n] += max(0.0, -float(self.v[:n].mean()))
            self._stop_at_wall()

    def _stop_at_wall(self) -> None:
        """Put u below the wall and mark the nodes that touch it, as a step does."""
        hit = self.u >= self.height
        self.u[hit], self.v[hit] = self.height[hit], layout.TOUCHING

    def _apply(self, source: NDArray[np.floating], multiply: Callable[[], None]) -> None:
        """work = operator applied to `source`, one transform pair."""
        self._to_spectrum[id(source)]()
        multiply()
        self._to_work()
        self.transform_pairs += 1

    def _measure_stiffest(self) -> None:
        """lambda_max of P M^-1 P K P on the present free nodes by power iterations on `probe`, kept for next time."""
        if not self.probe.any():
            self.probe[: self.num_points] = np.random.default_rng(0).standard_normal(self.num_points)
            self._apply(self.probe, self._multiply_inverse_mass)  # white noise is mostly stiff modes: smooth it
            self._project_probe()
        growth = 1.0
        for _ in range(_PROBE_STEPS):
            self._apply(self.probe, self._multiply_stiffness)
            self._restrict()
            self._apply(self.probe, self._multiply_inverse_mass)
            growth = self._project_probe()
        if math.isfinite(growth):
            self._limit_step(max(growth, 1.0))

    def _project_probe(self) -> float:
        """probe = work on the free nodes, scaled to norm 1; the norm before scaling."""
        self._restrict()
        norm = math.sqrt(self._squares.sum())
        if norm > 0:
            self.probe /= self.probe.dtype.type(norm)
        return norm


def relax(state: Fire, max_iterations: int, progress: Progress | None = None) -> Status:
    """Step until the residual meets the tolerance, and say how it ended.

    Other ends: `max_iterations`; no new minimum of the residual for long (the limit of the precision); overflow;
    Ctrl-C. The state stays usable after each of them.
    """
    patience = 1000 if state.mass_weighted else 1000 + 20 * math.isqrt(state.num_points)
    best, best_at, shown = math.inf, 0, time.monotonic()
    try:
        while state.iteration < max_iterations:
            state.step()
            if state.frozen:
                return Status.CONVERGED if state.residual <= state.tolerance else Status.DIVERGED
            if state.residual < 0.99 * best:
                best, best_at = state.residual, state.iteration
            elif state.iteration - best_at > patience:
                return Status.STAGNATED
            if progress and time.monotonic() - shown > 0.1:
                shown = time.monotonic()
                progress(state.iteration, state.residual)
    except KeyboardInterrupt:
        return Status.INTERRUPTED
    return Status.ITERATION_LIMIT
