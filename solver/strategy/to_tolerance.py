"""A solve to a given residual by a method of one's choice, and the residuals that its precision can reach."""

import math
import time

import numpy as np

from .. import checks, display
from ..arrays import Array64
from ..endings import Status
from ..grid.problem import Problem, rounding_floor
from ..methods import DEFAULT, ExecutionConfig, Method, relax
from ..scene import Scene
from ..solution import MEANINGLESS, Solution
from .grids import COARSEST, grids, over_grids, start_from_contact
from .report import finish
from .run import Run, check_memory

DEFAULT_TOLERANCE, COARSE_TOLERANCE = 1e-8, 1e-4
"""Equilibrium residual over p to stop at in float64 and mixed precision; on coarse grids or in float32, at least."""
_OVER_FLOOR = 4.0  # times the residual of rounding: the default tolerance in float32, at least


def solve_to_tolerance(run: Run, nested: bool | None, tolerance: float | None, initial: Array64 | None) -> Solution:
    """Solve the run's scene by its method to a tolerance; arguments as in `solve`. Raises `ValueError`."""
    scene, kind = run.scene, run.kind
    nested = kind.nested if nested is None else nested
    sizes = grids(scene.num_points) if nested and initial is None else [scene.num_points]
    memory = checks.available_memory()
    # without a coarser grid there is no telling how much will be in contact
    check_memory(scene.num_points, kind, 0.0 if len(sizes) > 1 else 1.0, memory)
    if scene.precision not in kind.precisions:
        raise ValueError(f"precision is {scene.precision!r}; allowed: {', '.join(kind.precisions)}, for {kind.name}")
    if tolerance is not None:
        tolerance = checks.real("tolerance", tolerance, "1e-14 to 0.5", math.nextafter(1e-14, 0), 0.5)
    problem = Problem.from_scene(scene)
    run.tolerance, run.own_tolerance = _reachable(scene, problem, tolerance), tolerance is not None
    start = None if initial is None else _displacement(initial, scene, problem)
    run.times[1] = time.perf_counter()

    def begin(num_points: int) -> Method:
        if num_points < scene.num_points:
            least = 0.0 if scene.precision == "float32" else run.tolerance
            return run.begin(Problem.from_scene(scene, num_points), max(COARSE_TOLERANCE, least))
        if run.contact:
            check_memory(num_points, kind, run.contact_share, memory)
        finest = run.begin(problem, run.tolerance)
        if start is not None:
            finest.start(start)
        return finest

    for _ in over_grids(run, sizes, begin):
        pass
    if run.state.problem.num_points < scene.num_points:  # interrupted: the last contact, on the finest grid
        run.state = begin(scene.num_points)
        start_from_contact(run, run.state)
    return finish(run, scene, problem)


def _displacement(initial: Array64, scene: Scene, problem: Problem) -> Array64:
    """A displacement to start from, shape (N,) [length], in the problem's unit; see `solve`. Raises `ValueError`."""
    allowed = f"allowed: an array of {scene.num_points} finite real numbers"
    displacement = checks.array(initial)
    if displacement is None:
        raise ValueError(f"initial is masked or not an array of real numbers; {allowed}")
    if displacement.shape != (scene.num_points,):
        raise ValueError(f"initial has shape {displacement.shape}; {allowed}")
    if not np.isfinite(displacement).all():
        raise ValueError(f"initial holds a value that is not finite; {allowed}")
    # on the wall exactly, whatever the units' rounding; and not beyond where any solution is
    reach = problem.reach * problem.length_unit
    inside = np.clip(displacement, -reach, reach) / problem.length_unit
    return np.where(displacement >= scene.profile, problem.height, inside)


def float32_floor(scene: Scene, problem: Problem) -> float:
    """The rms equilibrium residual over p that rounding in float32 leaves, see `rounding_floor` (dimensionless).

    problem: of the scene; the size of u, which hardly depends on the grid, is that on a coarse one. Ctrl-C meanwhile is
    passed on.
    """
    coarse = Problem.from_scene(scene, min(scene.num_points, 2 * COARSEST))
    state = DEFAULT.begin(coarse, ExecutionConfig(COARSE_TOLERANCE, backend="numpy"))
    if relax(state, DEFAULT.max_iterations) is Status.INTERRUPTED:
        raise KeyboardInterrupt
    displacement = state.displacement * (coarse.length_unit / problem.length_unit)
    return rounding_floor(problem.stiffness, displacement, "float32")


def default_tolerance(scene: Scene) -> float:
    """1e-8; in float32 the larger of 1e-4 and four times the residual of rounding (dimensionless).

    Where rounding turns out to leave more, `Solution.tolerance` says how much, up to `MEANINGLESS`, as long as
    `MOST_ENERGY` bounds the energy's error.

    Raises `ValueError` where rounding in float32 leaves no meaning in the residual.
    """
    return _reachable(scene, Problem.from_scene(scene), None)


def _reachable(scene: Scene, problem: Problem, tolerance: float | None) -> float:
    """A tolerance, by default as `default_tolerance` has it; `ValueError` if the scene's precision cannot reach it."""
    if scene.precision != "float32":
        return DEFAULT_TOLERANCE if tolerance is None else tolerance
    floor = float32_floor(scene, problem)
    if tolerance is not None and tolerance >= floor:
        return tolerance
    if floor > MEANINGLESS or (tolerance is None and _OVER_FLOOR * floor > MEANINGLESS):
        own = "a tolerance of your own, " if floor < MEANINGLESS else ""
        raise ValueError(
            f"num_points is {scene.num_points}, where float32 leaves a residual of about {floor:.1g}; allowed: "
            f"fewer points, {own}or precision mixed or float64"
        )
    if tolerance is None:
        return max(COARSE_TOLERANCE, _OVER_FLOOR * floor)
    raise ValueError(
        f"tolerance is {tolerance!r}; allowed: at least {display.rounded_up(floor)}, which is what rounding in float32 "
        "leaves of the residual, or precision mixed or float64"
    )
