"""From a scene to a certified solution: the checks of the arguments, and the way to a residual.

The ways to an accuracy and to an approach, and all that they share with this one, are in `strategy`.
"""

import math
import time
from collections.abc import Mapping

import numpy as np

from ..kernels import BACKENDS
from . import checks, display
from .arrays import Array64, on_one_thread
from .endings import Status
from .grid.certificate import MEANINGLESS
from .grid.errors import DEFAULT_QUANTITY, check_accuracy
from .grid.problem import Problem, rounding_floor
from .methods import DEFAULT, METHODS, ExecutionConfig, Method, MethodKind, Progress, relax
from .scene import Scene
from .solution import Solution
from .strategy.finish import finish
from .strategy.grids import (
    COARSE_TOLERANCE,
    COARSEST,
    DEFAULT_TOLERANCE,
    check_memory,
    grids,
    solve_on_grid,
    start_from_contact,
)
from .strategy.run import Run
from .strategy.small_models import without_contact
from .strategy.to_accuracy import solve_to_accuracy
from .strategy.to_approach import solve_to_approach
from .transforms.device import DEVICES, borrowed, check_device, check_settings

_OVER_FLOOR = 4.0  # times the residual of rounding: the default tolerance in float32, at least


@on_one_thread()
def solve(
    scene: Scene,
    *,
    accuracy: float | None = None,
    accuracy_of: str = DEFAULT_QUANTITY,
    method: str | None = None,
    nested: bool | None = None,
    tolerance: float | None = None,
    max_iterations: int | None = None,
    initial: Array64 | None = None,
    threads: int = 1,
    planning: str = "estimate",
    backend: str = "warp",
    device: str = "cpu",
    progress: Progress | None = None,
) -> Solution:
    """Solve a scene; returns a `Solution`.

    accuracy: the relative error wanted, 1e-9 to 0.1 (dimensionless). Model, method, grid and tolerance are then chosen
        for it and must not be given; the scene's grid is the finest allowed, its precision must be the default. See
        `Solution.choices` and `Status.INACCURATE`. A scene whose approach is given takes neither this nor an initial
        displacement.
    accuracy_of: the quantity it is wanted of, one of `QUANTITIES`: 'contact-area', 'kappa' (both between sub-grid
        edges), 'peak-pressure' or 'approach'. It concerns that alone.
    method: one of `METHODS`, by default `DEFAULT`.
    nested: start from the solution on coarser grids; by default for the active set only; never with `initial`.
    tolerance: rms net force on free nodes over the mean pressure at which to stop, 1e-14 to 0.5 (dimensionless); by
        default 1e-8, in float32 the larger of 1e-4 and four times the residual of rounding. Where rounding turns out to
        leave more, `Solution.tolerance` says how much.
    max_iterations: at least 1, all grids, hand-over included; default by method. Where an approach is given, of each
        of the solves that it takes.
    initial: displacement to start from, shape (N,) [length], for instance a neighbour's solution.
    threads: of the transforms; where other programs keep the cores busy, two take many times as long as one.
    planning: FFTW's effort, 'estimate', 'measure' or 'patient'; its plans are kept at once.
    backend: 'warp', or 'numpy' for the method's reference kernels.
    device: where the method works: 'cpu', or 'cuda' for a GPU, with a method whose `MethodKind.devices` names it. There
        threads and planning, which are FFTW's, concern the certificate alone, which is computed on the CPU.
    progress: called about ten times a second with (iteration, residual).

    A solve that fails to converge returns, too: see `Solution.status` and `Solution.reason`. So does one that Ctrl-C
    interrupts while it iterates; before the first iteration `KeyboardInterrupt` is passed on. Raises `ValueError`.
    """
    config = _config(nested, initial, threads, planning, backend, device, progress)
    chosen = {"method": method, "nested": nested, "tolerance": tolerance, "initial": initial}
    accuracy = _check_goal(scene, accuracy, accuracy_of, chosen | {"max_iterations": max_iterations}, device)
    kind = DEFAULT if accuracy else _kind(method, config)
    if max_iterations is not None:
        max_iterations = checks.integer("max_iterations", max_iterations, "an integer from 1 to 2^53", 1, 2**53)
    run = Run(scene, kind, config)
    touches = scene.pressure > 0 if scene.approach is None else scene.approach > scene.first_node
    if not touches:
        return without_contact(run)
    if accuracy:
        return solve_to_accuracy(run, accuracy, accuracy_of)

    def under_load(scene: Scene) -> Solution:
        return solve_to_tolerance(Run(scene, kind, config, limit=max_iterations), nested, tolerance, initial)

    with borrowed(device):
        return under_load(scene) if scene.approach is None else solve_to_approach(scene, under_load)


def _config(
    nested: object, initial: object, threads: int, planning: str, backend: str, device: str, progress: Progress | None
) -> ExecutionConfig:
    """The configuration that was asked for. Raises `ValueError`, also for a bad `nested`."""
    if not (nested is None or isinstance(nested, bool | np.bool_)):
        raise checks.refusal("nested", nested, "True, False or None")
    if nested and initial is not None:
        raise checks.refusal("nested", nested, "False or None with an initial displacement")
    if not (progress is None or callable(progress)):
        raise checks.refusal("progress", progress, "a function of an iteration and a residual, or None")
    threads, planning = check_settings(threads, planning)
    backend, device = checks.choice("backend", backend, BACKENDS), checks.choice("device", device, DEVICES)
    return ExecutionConfig(threads=threads, planning=planning, backend=backend, device=device, progress=progress)


def _check_goal(
    scene: Scene, accuracy: float | None, of: str, chosen: Mapping[str, object], device: str
) -> float | None:
    """The accuracy, if one is asked for. Raises `ValueError`, also for no scene, and where a choice is given, too."""
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is of type {type(scene).__name__}; allowed: a Scene")
    if scene.approach is not None and not (accuracy is None and chosen["initial"] is None):
        name, value = ("accuracy", accuracy) if chosen["initial"] is None else ("initial", chosen["initial"])
        raise checks.refusal(name, value, "none for a scene with an approach")
    accuracy = check_accuracy(accuracy, of)
    if accuracy is not None:
        for name, value in chosen.items():
            if value is not None:
                raise checks.refusal(name, value, "without accuracy only, which chooses it")
        if device != "cpu":
            raise ValueError(f"device is {device!r}; allowed with an accuracy: cpu alone, for the active set")
    return accuracy


def _kind(method: str | None, config: ExecutionConfig) -> MethodKind:
    """The method of that name. Raises `ValueError`, also for a device that it cannot work on, or that is not there."""
    kind = METHODS[checks.choice("method", DEFAULT.name if method is None else method, tuple(METHODS))]
    if not isinstance(kind, MethodKind):
        raise checks.refusal(f"method {method} in METHODS", kind, "a MethodKind")
    if config.device not in kind.devices:
        able = ", ".join(other.name for other in METHODS.values() if config.device in other.devices)
        allowed = f"{', '.join(kind.devices)} for method {kind.name}, or one of the methods {able}"
        raise ValueError(f"device is {config.device!r}; allowed: {allowed}")
    if config.device != "cpu" and config.backend != "warp":
        raise ValueError(f"backend is {config.backend!r}; allowed: warp, on device {config.device}")
    check_device(config.device)
    return kind


def solve_to_tolerance(run: Run, nested: bool | None, tolerance: float | None, initial: Array64 | None) -> Solution:
    """Solve the run's scene by its method to a tolerance; arguments as in `solve`. Raises `ValueError`."""
    scene, kind = run.scene, run.kind
    nested = kind.nested if nested is None else nested
    sizes = grids(scene.num_points) if nested and initial is None else [scene.num_points]
    run.memory = checks.available_memory()
    # without a coarser grid there is no telling how much will be in contact
    check_memory(scene.num_points, kind, 0.0 if len(sizes) > 1 else 1.0, run.memory)
    if scene.precision not in kind.precisions:
        raise ValueError(f"precision is {scene.precision!r}; allowed: {', '.join(kind.precisions)}, for {kind.name}")
    if tolerance is not None:
        tolerance = checks.real("tolerance", tolerance, "1e-14 to 0.5", math.nextafter(1e-14, 0), 0.5)
    problem = Problem.from_scene(scene)
    run.tolerance, run.own_tolerance = _reachable(problem, tolerance), tolerance is not None
    start = None if initial is None else _displacement(initial, problem)
    run.times[1] = time.perf_counter()

    def begin(num_points: int) -> Method:
        if num_points < scene.num_points:
            coarse = Problem.from_scene(scene, num_points)
            aim = math.sqrt(DEFAULT_TOLERANCE) if scene.precision == "float32" else run.tolerance
            return run.begin(coarse, max(COARSE_TOLERANCE, aim))
        finest = run.begin(problem, run.tolerance)
        if start is not None:
            finest.start(start)
        return finest

    for size in sizes:  # of an area, errors follow from the last two grids
        solve_on_grid(run, size, begin, measured=size < scene.num_points, by_loads=size in sizes[-2:])
        if run.status is Status.INTERRUPTED:
            break
    if run.state.problem.num_points < scene.num_points:  # interrupted: the last contact, on the finest grid
        check_memory(scene.num_points, kind, run.contact_share, run.memory)
        run.state = begin(scene.num_points)
        start_from_contact(run, run.state)
    return finish(run, scene, problem)


def _displacement(initial: Array64, problem: Problem) -> Array64:
    """A displacement to start from, shape (N,) [length], in the problem's unit; see `solve`. Raises `ValueError`."""
    n, allowed = problem.num_points, f"an array of {problem.num_points} finite real numbers"
    displacement = checks.array("initial", initial, allowed, n, n)
    if not np.isfinite(displacement).all():
        raise ValueError(f"initial holds a value that is not finite; allowed: {allowed}")
    # on the wall exactly, whatever the units' rounding; and not beyond where any solution is
    reach = problem.layer.reach * problem.length_unit
    inside = np.clip(displacement, -reach, reach) / problem.length_unit
    return np.where(displacement >= problem.profile, problem.height, inside)


def float32_floor(problem: Problem) -> float:
    """The rms equilibrium residual over p that rounding in float32 leaves, see `rounding_floor` (dimensionless).

    The size of u, which hardly depends on the grid, is that on a coarse one. Ctrl-C meanwhile is passed on.
    """
    coarse = Problem.from_scene(problem.scene, min(problem.num_points, 2 * COARSEST))
    state = DEFAULT.begin(coarse, ExecutionConfig(COARSE_TOLERANCE))
    if relax(state, DEFAULT.max_iterations) is Status.INTERRUPTED:
        raise KeyboardInterrupt
    displacement = state.displacement * (coarse.length_unit / problem.length_unit)
    return rounding_floor(problem.stiffness, displacement, "float32")


def _reachable(problem: Problem, tolerance: float | None) -> float:
    """A tolerance, by default as `solve` has it; `ValueError` if the scene's precision cannot reach it."""
    if problem.scene.precision != "float32":
        return DEFAULT_TOLERANCE if tolerance is None else tolerance
    floor = float32_floor(problem)
    if tolerance is not None and tolerance >= floor:
        return tolerance
    if floor > MEANINGLESS or (tolerance is None and _OVER_FLOOR * floor > MEANINGLESS):
        own = "a tolerance of your own, " if floor < MEANINGLESS else ""
        raise ValueError(
            f"num_points is {problem.num_points}, where float32 leaves a residual of about {floor:.1g}; allowed: "
            f"fewer points, {own}or precision mixed or float64"
        )
    if tolerance is None:
        return max(math.sqrt(DEFAULT_TOLERANCE), _OVER_FLOOR * floor)  # of half of the digits
    least = f"at least {display.rounded_up(floor)}, which is what rounding in float32 leaves of the residual"
    raise checks.refusal("tolerance", tolerance, f"{least}, or precision mixed or float64")
