"""From a scene to a certified solution."""

import math
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import kernels
from . import checks
from .certificate import Certificate, certify
from .fire import Fire, MassWeightedFire
from .observables import Observables, observe
from .problem import Problem
from .provenance import package_version, provenance
from .relaxation import Progress, Status, relax
from .scene import Scene
from .stiffness import stiffness
from .transforms import Transforms, save_wisdom

Array64 = NDArray[np.float64]

_METHODS: dict[str, type[Fire]] = {"mass-weighted-fire": MassWeightedFire, "fire": Fire}

METHODS = tuple(_METHODS)
"""Names of the methods, fastest first; the first is the default."""

_BYTES_PER_POINT = 200  # at the certificate's peak; measured: 130 (plain, float32) to 190 (mass-weighted, float64)

DEFAULT_MAX_ITERATIONS = {"mass-weighted-fire": 20_000, "fire": 200_000}


@dataclass(frozen=True)
class Solution:
    """A displacement, what it means, how it was found and how wrong it can be.

    displacement, contact_pressure: shape (N,) [length], [pressure]; contact: shape (N,), nodes the wall carries.
    status: only `Status.CONVERGED` is certified at `tolerance`.
    transform_pairs: forward-inverse pairs at the finest grid; seconds: wall time by stage ('setup', 'solve',
    'certificate', 'total') [s].
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
    transform_pairs: int
    seconds: dict[str, float]
    threads: int
    planning: str
    backend: str

    def to_dict(self) -> dict[str, Any]:
        """Everything but the fields, JSON-ready: numbers, text and flat objects; infinities become 'inf'."""
        record: dict[str, Any] = {"status": str(self.status)}
        record |= {name: _plain(value) for name, value in asdict(self.observables).items()}
        return record | {
            "iterations": self.iterations,
            "transform_pairs": self.transform_pairs,
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
    tolerance: rms net force on free nodes over the mean pressure at which to stop, 1e-14 to 0.5 (dimensionless); by
        default `default_tolerance`.
    max_iterations: at least 1, lead-in included; default by method.
    initial: displacement to start from, shape (N,) [length], for instance a neighbour's solution; default 0.
    threads: of FFTW. planning: FFTW's effort, 'estimate', 'measure' or 'patient'; what it finds is kept.
    backend: 'warp', or 'numpy' for the twins.
    progress: called about ten times a second with (iteration, residual).

    A solve that fails to converge, or is interrupted, returns too: see `Solution.status`. Raises `ValueError`.
    """
    begin = time.perf_counter()
    checks.choice("method", method, METHODS)
    if max_iterations is None:
        max_iterations = DEFAULT_MAX_ITERATIONS[method]
    checks.integer("max_iterations", max_iterations, "an integer >= 1", 1, 2**53)
    state, tolerance = _set_up(scene, method, tolerance, initial, threads, planning, backend)
    problem = state.problem
    ready = time.perf_counter()
    lead = [] if initial is not None else _lead_in(scene, state, max_iterations, progress)
    led = sum(iterations for _, iterations, _ in lead)
    interrupted = bool(lead) and lead[-1][0] is Status.INTERRUPTED
    status = Status.INTERRUPTED if interrupted else relax(state, max_iterations - led, progress)
    relaxed = time.perf_counter()
    certificate, pressure, contact = certify(problem, state.displacement)
    certified = certificate.free_residual <= tolerance and math.isfinite(certificate.energy_error_bound)
    if status is Status.CONVERGED and not certified:
        status = Status.STAGNATED  # the method's own precision cannot see the difference
    displacement = np.where(contact, scene.profile, state.displacement * problem.length_unit)
    pressure *= scene.pressure
    observables = observe(scene, displacement, pressure, contact)
    end = time.perf_counter()
    return Solution(
        scene=scene,
        method=method,
        tolerance=tolerance,
        status=status,
        displacement=displacement,
        contact_pressure=pressure,
        contact=contact,
        observables=observables,
        certificate=certificate,
        iterations=state.iteration + led,
        transform_pairs=state.transform_pairs + sum(pairs for _, _, pairs in lead),
        seconds={"setup": ready - begin, "solve": relaxed - ready, "certificate": end - relaxed, "total": end - begin},
        threads=threads,
        planning=planning,
        backend=backend,
    )


def _set_up(
    scene: Scene,
    method: str,
    tolerance: float | None,
    initial: Array64 | None,
    threads: int,
    planning: str,
    backend: str,
) -> tuple[Fire, float]:
    """The checked problem, its transforms and kernels, ready to step; and the tolerance."""
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is {scene!r}; allowed: a Scene")
    checks.choice("backend", backend, kernels.BACKENDS)
    _check_memory(scene)
    problem = Problem.from_scene(scene)
    _check_range(scene, problem)
    if tolerance is None:
        tolerance = default_tolerance(scene, problem)
    checks.real("tolerance", tolerance, "1e-14 < tolerance <= 0.5", 1e-14, 0.5)
    transforms = Transforms(scene.num_points, scene.precision, threads, planning)
    # the certificate's own rounding must not turn a solution away
    state = _METHODS[method](problem, transforms, 0.95 * tolerance, backend)
    if planning != "estimate":
        save_wisdom()
    if initial is not None:
        state.start(_check_initial(initial, scene.num_points) / problem.length_unit)
    return state, tolerance


def _lead_in(
    scene: Scene, state: Fire, max_iterations: int, progress: Progress | None
) -> list[tuple[Status, int, int]]:
    """Bring `state` near the solution of a thin, nearly incompressible layer by way of more compressible ones.

    Such a layer's softest and longest modes differ by (L/d)^3 in stiffness; from u = 0 mass-weighted FIRE bounces off
    the wall and may never settle. Measured for nu = 1/2, d = 1e-3 to 1e-5, n = 1.5 to 8: with this ladder, each rung
    solved to 1e-2, every solve converged. Returns each rung's status, iterations and transform pairs.
    """
    k, layer = state.problem.stiffness[1:], scene.layer
    rungs: list[tuple[Status, int, int]] = []
    if not isinstance(state, MassWeightedFire) or k[0] < 1e3 * k.min():
        return rungs
    for poisson_ratio in (0.4, 0.48, 0.498):
        if poisson_ratio < layer.poisson_ratio:
            softer = stiffness(scene.num_points, layer.thickness / scene.period, poisson_ratio)
            rung = MassWeightedFire(replace(state.problem, stiffness=softer), state.transforms, 1e-2, state.backend)
            rung.start(state.displacement)
            left = max_iterations - sum(iterations for _, iterations, _ in rungs)
            status = relax(rung, min(500, left), progress)
            rungs.append((status, rung.iteration, rung.transform_pairs))
            if status is not Status.DIVERGED:
                state.start(rung.displacement)
            if status is Status.INTERRUPTED:
                break
    return rungs


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
