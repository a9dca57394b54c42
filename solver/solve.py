"""From a scene to a certified solution."""

import math
import time
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import checks
from .certificate import Certificate
from .nested import Level, discretisation_error, iteration_error
from .observables import Observables, observe
from .provenance import package_version, provenance
from .relaxation import Progress, Status
from .run import METHODS, Run
from .scene import Scene

Array64 = NDArray[np.float64]


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
        """Everything but the fields, JSON-ready: numbers, text and flat objects; not finite: 'inf', 'nan'."""
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
    run = Run(scene, method, tolerance, initial, threads, planning, backend, max_iterations, progress)
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
