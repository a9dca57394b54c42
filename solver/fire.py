"""FIRE, plain and mass-weighted, on Warp kernels between pyFFTW transforms.

Plain FIRE (E. Bitzek et al., Phys. Rev. Lett. 97, 170201 (2006)) integrates v += dt F, u += dt v with semi-implicit
Euler, steers the velocity along the force, and stops when the power v.F turns negative (dt keeps above 0.02 dt_max
here). The force F is the net force on the free nodes only: the wall's share would bias the power and the step control.
After each step the hard wall projects: where u > h, u = h and v = 0 (the kernels leave a marker as good as 0,
`layout.TOUCHING`). dt is limited by the stiffest mode, so the iterations grow like sqrt(N).

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
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import CHUNK, Call, layout, record
from .problem import Problem
from .transforms import Transforms

Array = NDArray[Any]
Array64 = NDArray[np.float64]


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


class Fire:
    """State of a relaxation by plain FIRE: u, v and work, each of shape (padded N,) in the problem's units.

    tolerance: on the rms free residual over the mean pressure; backend: 'warp' or 'numpy' (the twins).
    """

    parameters = FireParameters()

    def __init__(self, problem: Problem, transforms: Transforms, tolerance: float, backend: str = "warp") -> None:
        n = self.num_points = problem.num_points
        self.problem, self.transforms, self.backend, self.tolerance = problem, transforms, backend, tolerance
        self.transform_pairs = 0.0
        # all zeros behind N: the padding lies on a wall at 0 and is held there by the mean pressure
        self.u, self.v, self.height = (transforms.buffer() for _ in range(3))
        self.work = transforms.buffer()  # K u
        self.padding = self.u.size - n
        self._inverse = transforms.inverse(self.work)
        self._apply_stiffness = self._operator(self.u, problem.stiffness)
        self._start_state()
        self._prepare()
        self.height[:n] = problem.height
        self.start(np.zeros(n))

    def start(self, displacement: Array64) -> None:
        """Begin at rest from u, shape (N,) [u], put below the wall."""
        self.u[: self.num_points] = displacement
        self.v[:] = 0
        self._stop_at_wall()

    def start_from_pressure(self, pressure: Array64) -> None:
        """Begin at rest from the displacement under a contact pressure, shape (N,) [p]."""
        self.start(self.problem.displacement_under(pressure))

    def _operator(self, source: Array, symbol: Array64) -> tuple[Callable[[], None], ...]:
        """Forward transform of `source`, multiplication by `symbol`, shape (N//2 + 1,), inverse transform to `work`."""
        coefficient = self.transforms.doubled(symbol / self.num_points)
        multiply = self._replay(Call("spectral_multiply", (coefficient,), (self.transforms.spectrum,)))
        return self.transforms.forward(source), multiply, self._inverse

    def _replay(self, *calls: Call) -> Callable[[], None]:
        return record(self.backend, calls)

    def _start_state(self) -> None:
        s, p = np.zeros(layout.STATE_LENGTH), self.parameters
        s[layout.N_MIN], s[layout.F_INC], s[layout.F_DEC] = p.n_min, p.f_inc, p.f_dec
        s[layout.ALPHA] = s[layout.ALPHA_START] = p.alpha_start
        s[layout.F_ALPHA] = p.f_alpha
        s[layout.TOLERANCE], s[layout.NUM_POINTS] = self.tolerance, self.u.size
        s[layout.RESIDUAL] = np.inf
        self.state = s

    def _limit_step(self, stiffest: float, longest: float = math.inf) -> None:
        s = self.state
        s[layout.STIFFEST] = stiffest
        s[layout.DT_MAX] = min(self.parameters.safety / math.sqrt(stiffest), longest)
        dt = s[layout.DT] or self.parameters.dt_start * s[layout.DT_MAX]
        s[layout.DT] = min(dt, s[layout.DT_MAX])

    def _sums(self, count: int) -> list[Array64]:
        return [np.zeros(self.u.size // CHUNK) for _ in range(count)]

    def _prepare(self) -> None:
        """What differs between the methods: further buffers, recorded kernels, the first dt."""
        force, held, power, velocity = sums = self._sums(4)
        self._move = self._replay(
            Call("plain_sums", (self.work, self.v), tuple(sums)),
            Call("fire_control", (force, held, power, velocity, force), (self.state,)),  # a = F
            Call("plain_step", (self.work, self.height, self.state), (self.u, self.v)),
        )
        self._limit_step(float(self.problem.stiffness.max()))

    @property
    def displacement(self) -> Array64:
        """u, shape (N,) [u], in float64; nodes on the wall of this precision stand on the exact wall."""
        n, height = self.num_points, self.problem.height
        return np.where(self.u[:n] >= self.height[:n], height, np.minimum(self.u[:n].astype(np.float64), height))

    @property
    def contact_pressure(self) -> Array64:
        """sigma >= 0 on the nodes on the wall, shape (N,) [p]."""
        u = self.displacement
        return np.where(u >= self.problem.height, np.maximum(self.problem.net_force(u), 0.0), 0.0)

    @property
    def residual(self) -> float:
        """rms free force over the mean pressure, of the displacement before the last step (of u itself once frozen)."""
        return float(self.state[layout.RESIDUAL])

    @property
    def iteration(self) -> int:
        """Steps taken so far."""
        return int(self.state[layout.ITERATION])

    @property
    def frozen(self) -> bool:
        """Converged or diverged: further steps change nothing."""
        return bool(self.state[layout.FROZEN])

    @property
    def patience(self) -> int:
        """Iterations without a new minimum of the residual after which there is no hope; sqrt(N) is FIRE's own pace."""
        return 1000 + 20 * math.isqrt(self.num_points)

    def parts(self) -> tuple[tuple[str, Callable[[], None]], ...]:
        """One iteration in order: ('FFTs' or 'rest', function)."""
        forward, multiply, inverse = self._apply_stiffness
        return ("FFTs", forward), ("rest", multiply), ("FFTs", inverse), ("rest", self._move)

    def step(self) -> None:
        """One FIRE iteration, one transform pair."""
        self._apply(self._apply_stiffness)
        self._move()
        self._after_step()

    def _after_step(self) -> None:
        if self.state[layout.HELD] <= self.padding:
            self._touch()

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

    def _apply(self, operator: tuple[Callable[[], None], ...]) -> None:
        for part in operator:
            part()
        self.transform_pairs += 1


class MassWeightedFire(Fire):
    """FIRE with M = K; has the force and a probe for lambda_max besides, and the acceleration in `work`.

    Once dt_max is safe by measurement, Bitzek's halving of dt at every turn only loses time: on 46 scenes (Hertz and
    rough, nu = -0.9 to 0.5, d = 1e-4 to inf, cold) n_min = 1 and f_dec = 0.8 needed 0.78 of the transforms of 5 and
    0.5.
    """

    parameters = FireParameters(n_min=1, f_dec=0.8)
    probe_every, probe_steps = 100, 6  # iterations between estimates of lambda_max, power iterations in each

    @property
    def patience(self) -> int:
        """As for `Fire`; the pace does not depend on N."""
        return 1000

    def _prepare(self) -> None:
        self.force, self.probe, self.load = (self.transforms.buffer() for _ in range(3))
        self.load[:] = 1
        mass = self.problem.stiffness.copy()
        mass[0] = mass[1:].min()
        self._apply_inverse_mass = self._operator(self.force, 1 / mass)
        self._probe_stiffness = (self.transforms.forward(self.probe), *self._apply_stiffness[1:])
        self._probe_inverse_mass = (self.transforms.forward(self.probe), *self._apply_inverse_mass[1:])
        force, held, power, velocity, acceleration = sums = self._sums(5)
        self._squares = acceleration  # free for the probe, between two steps
        self._find_force = self._replay(Call("net_force", (self.load, self.work, self.v), (self.force, force, held)))
        self._move = self._replay(
            Call("search_sums", (self.force, self.v), (self.work, power, velocity, acceleration)),
            Call("fire_control", tuple(sums), (self.state,)),
            Call("fire_step", (self.work, self.height, self.state), (self.u, self.v)),
        )
        self._restrict = self._replay(Call("restrict_to_free", (self.force, self.work), (self.probe, self._squares)))

    def step(self) -> None:
        """One FIRE iteration, two transform pairs."""
        self._apply(self._apply_stiffness)
        self._find_force()
        if self.iteration % self.probe_every == 0:
            self._measure_stiffest()
        self._apply(self._apply_inverse_mass)
        self._move()
        self._after_step()

    def _measure_stiffest(self) -> None:
        """lambda_max of P M^-1 P K P on the present free nodes by power iterations on `probe`, kept for next time."""
        if not self.probe.any():
            self.probe[: self.num_points] = np.random.default_rng(0).standard_normal(self.num_points)
            self._apply(self._probe_inverse_mass)  # white noise is mostly stiff modes: smooth it
            self._project_probe()
        growth = 1.0
        for _ in range(self.probe_steps):
            self._apply(self._probe_stiffness)
            self._restrict()
            self._apply(self._probe_inverse_mass)
            growth = self._project_probe()
        if math.isfinite(growth):
            self._limit_step(max(growth, 1.0), 1.0)  # no mode is softer than its mass: a longer step gains nothing

    def _project_probe(self) -> float:
        """probe = work on the free nodes, scaled to norm 1; the norm before scaling."""
        self._restrict()
        norm = math.sqrt(self._squares.sum())
        if norm > 0:
            self.probe /= self.probe.dtype.type(norm)
        return norm
