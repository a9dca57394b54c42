"""From a scene to a certified solution."""

import time

import numpy as np
from numpy.typing import NDArray

from . import checks
from .nested import discretisation_error, iteration_error
from .observables import observe
from .relaxation import Progress, Status
from .run import METHODS, Run
from .scene import Scene
from .solution import Choice, Solution

Array64 = NDArray[np.float64]


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
    below_floor: str = "refuse",
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
    below_floor: a tolerance that float32 cannot reach is refused ('refuse'), or met in mixed precision ('mixed').
    progress: called about ten times a second with (iteration, residual).

    A solve that fails to converge, or is interrupted, returns too: see `Solution.status`. Raises `ValueError`.
    """
    begin = time.perf_counter()
    checks.choice("method", method, METHODS)
    if max_iterations is not None:
        max_iterations = checks.integer("max_iterations", max_iterations, "an integer >= 1", 1, 2**53)
    if nested is None:
        nested = method == METHODS[0] and initial is None
    run = Run(scene, method, tolerance, initial, threads, planning, backend, max_iterations, below_floor, progress)
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
        scene=run.scene,
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
        choices=(Choice("precision", "mixed", run.precision_changed),) if run.precision_changed else (),
    )
