"""From a scene to a certified solution."""

import math
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import kernels
from . import checks
from .active_set import ActiveSet
from .certificate import Certificate, certify
from .fire import Fire, MassWeightedFire
from .nested import Level, discretisation_error, grids, iteration_error, measure_level, prolong
from .observables import Observables, observe
from .problem import Problem
from .provenance import package_version, provenance
from .relaxation import Method, Progress, Status, relax
from .scene import Scene
from .stiffness import stiffness
from .transforms import Transforms, save_wisdom

Array64 = NDArray[np.float64]

_METHODS: dict[str, type[ActiveSet] | type[Fire]] = {
    "active-set": ActiveSet,
    "mass-weighted-fire": MassWeightedFire,
    "fire": Fire,
}

METHODS = tuple(_METHODS)
"""Names of the methods, fastest first; the first is the default."""

_BYTES_PER_POINT = 250  # at the peak; measured: 130 (plain FIRE, float32), 210 (active set), 310 (contact everywhere)

_SMALLEST_WARP = 2**13  # points; smaller coarse grids run on the twins
_COARSE_TOLERANCE, _COARSE_SLACK = 1e-5, 0.1  # so that the next grid starts with the right set of nodes

DEFAULT_MAX_ITERATIONS = {"active-set": 2_000, "mass-weighted-fire": 20_000, "fire": 200_000}


@dataclass(frozen=True)
class Solution:
    """A displacement, what it means, how it was found and how wrong it can be.

    displacement, contact_pressure: shape (N,) [length], [pressure]; contact: shape (N,), nodes the wall carries.
    status: only `Status.CONVERGED` is certified at `tolerance`.
    handed_over: the active set could not certify its result, and mass-weighted FIRE went on from there.
    levels: the coarser grids, from coarse to fine; empty without nested grids. iterations: on all grids.
    transform_pairs: forward-inverse pairs in units of a pair on the finest grid, short and coarse ones by their length.
    seconds: wall time by stage ('setup', 'solve', 'certificate', 'total') [s].
    """

    scene: Scene
    method: str
    tolerance: float
    status: Status
    displacement: Array64
    contact_pressure: Array64
    contact: NDArray[np.bool_]
    observables: Observables
    certificate: Certificate
    iterations: int
    transform_pairs: float
    seconds: dict[str, float]
    threads: int
    planning: str
    backend: str
    handed_over: bool = False
    levels: tuple[Level, ...] = field(default_factory=tuple)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the fields, JSON-ready: numbers, text and flat objects; infinities become 'inf'."""
        record: dict[str, Any] = {"status": str(self.status)}
        record |= {name: _plain(value) for name, value in asdict(self.observables).items()}
        return record | {
            "iterations": self.iterations,
            "transform_pairs": round(self.transform_pairs, 3),
            "handed_over": self.handed_over,
            "levels": {
                str(level.num_points): {name: _plain(value) for name, value in level.to_dict().items()}
                for level in self.levels
            },
            "seconds": dict(self.seconds),
            "certificate": {name: _plain(value) for name, value in asdict(self.certificate).items()},
            "method": self.method,
            "precision": self.scene.precision,
            "tolerance": self.tolerance,
            "threads": self.threads,
            "planning": self.planning,
            "backend": self.backend,
            "scene": self.scene.to_dict(),
            "version": package_version(),
            "provenance": provenance(),
        }


def _plain(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)


def rounding_floor(problem: Problem, precision: str) -> float:
    """Estimate of the rms free residual over p below which rounding in u hides everything (dimensionless).

    A relative rounding error eps in u comes back as eps rms(K) |u|; |u| is taken from its fluctuation under a line
    load, rms(u) = sqrt(2 sum 1/K^2), which a spread-out contact stays below.
    """
    k = problem.stiffness[1:]
    eps = float(np.finfo(precision).eps)
    return 2.5 * eps * math.sqrt(float(np.mean(k**2))) * math.sqrt(2 * float(np.sum(k**-2.0)))


def default_tolerance(scene: Scene, problem: Problem | None = None) -> float:
    """1e-8 in float64; in float32 the larger of 1e-4 and twice what rounding leaves (dimensionless).

    Raises `ValueError` where rounding in float32 leaves no meaning in the residual.
    """
    if scene.precision == "float64":
        return 1e-8
    tolerance = max(1e-4, 2 * rounding_floor(problem or Problem.from_scene(scene), scene.precision))
    if tolerance > 0.2:
        raise ValueError(
            f"num_points is {scene.num_points}, where float32 leaves a residual of about {tolerance / 2:.1g}; allowed: "
            "fewer points, precision float64, or a tolerance of your own"
        )
    return tolerance


def solve(
    scene: Scene,
    *,
    method: str = METHODS[0],
    nested: bool | None = None,
    tolerance: float | None = None,
    max_iterations: int | None = None,
    initial: Array64 | None = None,
    threads: int = 1,
    planning: str = "estimate",
    backend: str = "warp",
    progress: Progress | None = None,
) -> Solution:
    """Solve a scene.

    method: one of `METHODS`.
    nested: start from the solution on coarser grids; by default for the active set only, and not with `initial`.
    tolerance: rms net force on free nodes over the mean pressure at which to stop, 1e-14 to 0.5 (dimensionless); by
        default `default_tolerance`.
    max_iterations: at least 1, all grids, lead-in and hand-over included; default by method.
    initial: displacement to start from, shape (N,) [length], for instance a neighbour's solution.
    threads: of FFTW. planning: FFTW's effort, 'estimate', 'measure' or 'patient'; what it finds is kept.
    backend: 'warp', or 'numpy' for the twins.
    progress: called about ten times a second with (iteration, residual).

    A solve that fails to converge, or is interrupted, returns too: see `Solution.status`. Raises `ValueError`.
    """
    begin = time.perf_counter()
    checks.choice("method", method, METHODS)
    if max_iterations is not None:
        max_iterations = checks.integer("max_iterations", max_iterations, "an integer >= 1", 1, 2**53)
    if nested is None:
        nested = method == METHODS[0] and initial is None
    run = _Run(scene, method, tolerance, initial, threads, planning, backend, max_iterations, progress)
    ready = time.perf_counter()
    try:
        status = run.drive(nested)
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    relaxed = time.perf_counter()
    status = run.certified(status)
    relaxed += run.seconds_more  # what the certificate asked for
    displacement = np.where(run.contact, scene.profile, run.state.displacement * run.problem.length_unit)
    pressure = run.pressure * scene.pressure
    observables = observe(scene, displacement, pressure, run.contact)
    observables = iteration_error(discretisation_error(observables, run.levels), run.certificate.free_residual)
    end = time.perf_counter()
    return Solution(
        scene=scene,
        method=method,
        tolerance=run.tolerance,
        status=status,
        displacement=displacement,
        contact_pressure=pressure,
        contact=run.contact,
        observables=observables,
        certificate=run.certificate,
        iterations=run.iterations,
        transform_pairs=run.transform_pairs,
        seconds={"setup": ready - begin, "solve": relaxed - ready, "certificate": end - relaxed, "total": end - begin},
        threads=threads,
        planning=planning,
        backend=backend,
        handed_over=run.handed_over,
        levels=tuple(run.levels),
    )


class _Run:
    """One solve: grids from coarse to fine, the method on each, the certificate, and the hand-over if that fails."""

    def __init__(
        self,
        scene: Scene,
        method: str,
        tolerance: float | None,
        initial: Array64 | None,
        threads: int,
        planning: str,
        backend: str,
        max_iterations: int | None,
        progress: Progress | None,
    ) -> None:
        if not isinstance(scene, Scene):
            raise ValueError(f"scene is {scene!r}; allowed: a Scene")
        checks.choice("backend", backend, kernels.BACKENDS)
        _check_memory(scene)
        self.scene, self.method, self.backend = scene, _METHODS[method], backend
        self.threads, self.planning, self.progress = threads, planning, progress
        self.problem = Problem.from_scene(scene)
        _check_range(scene, self.problem)
        if tolerance is None:
            tolerance = default_tolerance(scene, self.problem)
        self.tolerance = checks.real("tolerance", tolerance, "1e-14 < tolerance <= 0.5", 1e-14, 0.5)
        self.initial = None
        if initial is not None:
            displacement = _check_initial(initial, scene.num_points)
            # on the wall exactly, whatever the units' rounding
            on_wall = displacement >= scene.profile
            self.initial = np.where(on_wall, self.problem.height, displacement / self.problem.length_unit)
        # the certificate's own rounding must not turn a solution away
        self.state = self._method_on(self.problem, 0.95 * self.tolerance)
        if planning != "estimate":
            save_wisdom()
        self.limited = max_iterations is not None
        self.left = max_iterations or DEFAULT_MAX_ITERATIONS[method]
        self.iterations, self.transform_pairs = 0, 0.0
        self.levels: list[Level] = []
        self.handed_over, self.seconds_more = False, 0.0

    def _method_on(
        self, problem: Problem, tolerance: float, method: type[ActiveSet] | type[Fire] | None = None
    ) -> Method:
        # coarse grids cost little in float64, and what they pass on is better than float32's residual could tell
        precision = self.scene.precision if problem.num_points == self.scene.num_points else "float64"
        transforms = Transforms(problem.num_points, precision, self.threads, self.planning)
        # recording Warp's launches takes longer than a coarse grid's few passes
        backend = self.backend if problem.num_points >= min(_SMALLEST_WARP, self.scene.num_points) else "numpy"
        return (method or self.method)(problem, transforms, tolerance, backend)

    def _relax(self, state: Method) -> Status:
        """Relax, and add what it took to the account."""
        iterations, pairs = state.iteration, state.transform_pairs
        status = relax(state, iterations + self.left, self.progress) if self.left > 0 else Status.ITERATION_LIMIT
        self._account(state, state.iteration - iterations, state.transform_pairs - pairs)
        return status

    def _account(self, state: Method, iterations: int, pairs: float) -> None:
        self.left -= iterations
        self.iterations += iterations
        self.transform_pairs += pairs * state.problem.num_points / self.scene.num_points

    def drive(self, nested: bool) -> Status:
        """All grids; the last state is on the finest one."""
        if self.initial is not None:
            self.state.start(self.initial)
            return self._relax(self.state)
        sizes = grids(self.scene.num_points) if nested else [self.scene.num_points]
        pressure = None
        for size in sizes:
            finest = size == sizes[-1]
            state = self.state
            if not finest:
                double = self.scene.precision == "float64"
                tolerance = max(_COARSE_TOLERANCE, self.tolerance if double else 0.0)
                state = self._method_on(Problem.from_scene(self.scene, size), tolerance)
                if isinstance(state, ActiveSet):
                    state.slack = _COARSE_SLACK
            status = Status.CONVERGED
            if pressure is not None:
                state.start_from_pressure(prolong(pressure, size))
            elif isinstance(state, MassWeightedFire):
                status = self._lead_in(state)
            if status is not Status.INTERRUPTED:
                status = self._relax(state)
            if not finest:
                pressure = state.contact_pressure
                if status is Status.INTERRUPTED:
                    if pressure.any():
                        self.state.start_from_pressure(prolong(pressure, sizes[-1]))
                    return status
                self.levels.append(measure_level(self.scene, pressure, state))
        return status

    def certified(self, status: Status) -> Status:
        """The certificate's verdict. An active set that misses it tries harder, then hands over to FIRE."""
        good, begin, tries = self._certify(), time.perf_counter(), 0
        while not good and status is Status.CONVERGED and isinstance(self.state, ActiveSet) and tries < 3:
            self.state.try_harder()
            status, tries = self._relax(self.state), tries + 1
            good = self._certify()
        gave_up = not good and status not in (Status.INTERRUPTED, Status.ITERATION_LIMIT)
        if gave_up and isinstance(self.state, ActiveSet) and (self.left > 0 or not self.limited):
            status, good = self._hand_over()
        if tries or self.handed_over:
            self.seconds_more = time.perf_counter() - begin
        if status is Status.CONVERGED and not good:
            return Status.STAGNATED  # the method's own precision cannot see the difference
        if good and status in (Status.STAGNATED, Status.ITERATION_LIMIT):
            return Status.CONVERGED
        return status

    def _hand_over(self) -> tuple[Status, bool]:
        """Mass-weighted FIRE from where the active set ended; the better of the two stays."""
        self.handed_over = True
        if not self.limited:
            self.left = DEFAULT_MAX_ITERATIONS["mass-weighted-fire"]
        start, before = self.state.displacement, self.certificate.free_residual
        self.state = self._method_on(self.problem, 0.95 * self.tolerance, MassWeightedFire)
        self.state.start(start)
        status = self._relax(self.state)
        good = self._certify()
        if not good and self.certificate.free_residual > before:
            self.state.start(start)
            self._certify()
        return status, good

    def _certify(self) -> bool:
        self.certificate, self.pressure, self.contact = certify(self.problem, self.state.displacement)
        c = self.certificate
        return c.free_residual <= self.tolerance and math.isfinite(c.energy_error_bound)

    def _lead_in(self, state: MassWeightedFire) -> Status:
        """Bring `state` near the solution of a thin, nearly incompressible layer by way of more compressible ones.

        Such a layer's softest and longest modes differ by (L/d)^3 in stiffness; from u = 0 mass-weighted FIRE bounces
        off the wall and may never settle. Measured for nu = 1/2, d = 1e-3 to 1e-5, n = 1.5 to 8: with this ladder, each
        rung solved to 1e-2, every solve converged.
        """
        k, layer = state.problem.stiffness[1:], self.scene.layer
        status = Status.CONVERGED
        if k[0] < 1e3 * k.min():
            return status
        for poisson_ratio in (0.4, 0.48, 0.498):
            if poisson_ratio < layer.poisson_ratio and status is not Status.INTERRUPTED:
                softer = stiffness(state.num_points, layer.thickness / self.scene.period, poisson_ratio)
                rung = MassWeightedFire(replace(state.problem, stiffness=softer), state.transforms, 1e-2, self.backend)
                rung.start(state.displacement)
                status = relax(rung, min(500, self.left), self.progress)
                self._account(rung, rung.iteration, rung.transform_pairs)
                if status is not Status.DIVERGED:
                    state.start(rung.displacement)
        return status


def _check_range(scene: Scene, problem: Problem) -> None:
    """Reject layers so thin that their stiffness overflows the precision."""
    stiffest, limit = float(problem.stiffness.max()), 1e-8 * float(np.finfo(scene.precision).max)
    if not stiffest < limit:
        raise ValueError(
            f"thickness is {scene.layer.thickness!r} at period {scene.period!r}; allowed: thicker, the stiffness "
            f"reaches {stiffest:.1e} E*/L and {scene.precision} ends at {limit:.1e}"
        )


def _check_initial(initial: Array64, num_points: int) -> Array64:
    allowed = f"allowed: an array of {num_points} finite real numbers"
    try:
        array = np.asarray(initial)
        real = array.astype(np.float64) if array.dtype.kind in "fiu" else None
    except (TypeError, ValueError):
        real = None
    if real is None or real.shape != (num_points,):
        raise ValueError(f"initial has shape {np.shape(initial)}; {allowed}")
    if not np.isfinite(real).all():
        raise ValueError(f"initial holds a value that is not finite; {allowed}")
    return real


def _check_memory(scene: Scene) -> None:
    """Reject grids that the machine's free memory cannot hold: 20 to 25 arrays of N values at the peak."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        available = next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable")) * 1024
    except (OSError, StopIteration, ValueError):
        return  # not Linux: no estimate
    needed = _BYTES_PER_POINT * scene.num_points
    if needed > available:
        raise ValueError(
            f"num_points is {scene.num_points}, needing about {needed / 2**30:.1f} GiB; allowed: what fits into the "
            f"{available / 2**30:.1f} GiB that are free"
        )
