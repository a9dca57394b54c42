"""The tolerance that a precision can reach, known before anything is solved."""

from .. import display
from ..endings import Status
from ..grid.problem import Problem, rounding_floor
from ..methods import DEFAULT, Setting, relax
from ..scene import Scene
from ..solution import MEANINGLESS

_FLOOR_POINTS = 1024  # of the solution that tells the size of u
_DEFAULT, _DEFAULT_FLOAT32 = 1e-8, 1e-4  # tolerances in float64 and mixed precision, and the least in float32
_OVER_FLOOR = 4.0  # times what rounding leaves: how far the default tolerance in float32 stays above


def problems(scene: Scene) -> tuple[Problem, Problem]:
    """The discrete problem of a scene, and for float32 the same on a coarse grid."""
    coarser = scene.precision == "float32" and scene.num_points > _FLOOR_POINTS
    made = [Problem.from_scene(scene, n) for n in (scene.num_points, _FLOOR_POINTS)[: 1 + coarser]]
    return made[0], made[-1]


def float32_floor(problem: Problem, coarse: Problem) -> float:
    """The rms free residual over p that rounding in float32 leaves, see `rounding_floor` (dimensionless).

    problem, coarse: see `problems`; the size of u, which hardly depends on the grid, is taken from the solution of the
    coarse one. Ctrl-C meanwhile is passed on.
    """
    state = DEFAULT.begin(coarse, Setting(1e-3, backend="numpy"))
    if relax(state, 300) is Status.INTERRUPTED:
        raise KeyboardInterrupt
    displacement = state.displacement * (coarse.length_unit / problem.length_unit)
    return rounding_floor(problem.stiffness, displacement, "float32")


def default_tolerance(scene: Scene) -> float:
    """1e-8; in float32 the larger of 1e-4 and four times what rounding leaves (dimensionless).

    Where rounding turns out to leave more, `Solution.tolerance` says how much, up to `MEANINGLESS`, as long as
    `MOST_ENERGY` bounds the energy's error.

    Raises `ValueError` where rounding in float32 leaves no meaning in the residual.
    """
    problem, coarse = problems(scene)
    return reachable(scene, problem, coarse, None)


def reachable(scene: Scene, problem: Problem, coarse: Problem, tolerance: float | None) -> float:
    """A tolerance, by default as `default_tolerance` has it; `ValueError` if the scene's precision cannot reach it.

    problem, coarse: see `problems`.
    """
    if scene.precision != "float32":
        return _DEFAULT if tolerance is None else tolerance
    floor = float32_floor(problem, coarse)
    if tolerance is not None and tolerance >= floor:
        return tolerance
    if floor > MEANINGLESS or (tolerance is None and _OVER_FLOOR * floor > MEANINGLESS):
        own = "a tolerance of your own, " if floor < MEANINGLESS else ""
        raise ValueError(
            f"num_points is {scene.num_points}, where float32 leaves a residual of about {floor:.1g}; allowed: "
            f"fewer points, {own}or precision mixed or float64"
        )
    if tolerance is None:
        return max(_DEFAULT_FLOAT32, _OVER_FLOOR * floor)
    raise ValueError(
        f"tolerance is {tolerance!r}; allowed: at least {display.rounded_up(floor)}, which is what rounding in float32 "
        "leaves of the residual, or precision mixed or float64"
    )
