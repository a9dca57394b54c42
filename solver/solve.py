"""From a scene to a certified solution."""

import time

import numpy as np
from numpy.typing import NDArray

from . import checks
from .accurate import Accurate
from .relaxation import Progress, Status
from .run import BELOW_FLOOR, METHODS, Run
from .scene import Scene
from .solution import Solution

Array64 = NDArray[np.float64]


def solve(
    scene: Scene,
    *,
    accuracy: float | None = None,
    method: str | None = None,
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

    accuracy: the relative error wanted of `contact_area_subgrid`, 1e-9 to 0.1 (dimensionless). Model, method, grid and
        tolerance are then chosen for it and must not be given; the scene's grid is the finest allowed, its precision
        must be the default. It concerns a_r alone. See `Solution.choices` and `Status.INACCURATE`.
    method: one of `METHODS`, by default the first.
    nested: start from the solution on coarser grids; by default for the active set only, and not with `initial`.
    tolerance: rms net force on free nodes over the mean pressure at which to stop, 1e-14 to 0.5 (dimensionless); by
        default `default_tolerance`, or what rounding leaves if that is more.
    max_iterations: at least 1, all grids, hand-over included; default by method.
    initial: displacement to start from, shape (N,) [length], for instance a neighbour's solution.
    threads: of FFTW. planning: FFTW's effort, 'estimate', 'measure' or 'patient'; what it finds is kept.
    backend: 'warp', or 'numpy' for the twins.
    below_floor: a tolerance that float32 cannot reach is refused ('refuse'), or met in mixed precision ('mixed').
    progress: called about ten times a second with (iteration, residual).

    A solve that fails to converge, or is interrupted, returns too: see `Solution.status`; to an accuracy, one that is
    interrupted raises `KeyboardInterrupt`. Raises `ValueError`.
    """
    begin = time.perf_counter()
    if not (nested is None or isinstance(nested, bool | np.bool_)):
        raise ValueError(f"nested is {nested!r}; allowed: True, False or None")
    if not (progress is None or callable(progress)):
        raise ValueError(f"progress is {progress!r}; allowed: a function of an iteration and a residual, or None")
    if accuracy is not None:
        checks.choice("below_floor", below_floor, BELOW_FLOOR)
        if below_floor != "refuse":
            raise ValueError(f"below_floor is {below_floor!r}; allowed: without accuracy only, which chooses precision")
        chosen = {"method": method, "nested": nested, "tolerance": tolerance, "initial": initial}
        for name, value in (chosen | {"max_iterations": max_iterations}).items():
            if value is not None:
                raise ValueError(f"{name} is {value!r}; allowed: without accuracy only, which chooses it")
        return Accurate(scene, accuracy, threads, planning, backend, progress).solve()
    method = checks.choice("method", METHODS[0] if method is None else method, METHODS)
    if max_iterations is not None:
        max_iterations = checks.integer("max_iterations", max_iterations, "an integer from 1 to 2^53", 1, 2**53)
    if nested is None:
        nested = method == METHODS[0] and initial is None
    run = Run(scene, method, tolerance, initial, threads, planning, backend, max_iterations, below_floor, progress)
    ready = time.perf_counter()
    try:
        status = run.drive(nested)
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    return run.solution(run.scene, method, status, (begin, ready))
