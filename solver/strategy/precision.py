"""The tolerance that a precision can reach, known before anything is solved."""

from ..endings import Status
from ..grid.problem import Problem, rounding_floor
from ..methods import METHODS, Setting, relax
from ..scene import Scene
from ..solution import MEANINGLESS

_FLOOR_POINTS = 1024  # of the solution that tells the size of u
_DEFAULT, _DEFAULT_FLOAT32, _OVER_FLOOR = 1e-8, 1e-4, 4.0


def float32_floor(scene: Scene, problem: Problem) -> float:
    """The rms free residual over p that rounding in float32 leaves, see `rounding_floor` (dimensionless).

    The size of u hardly depends on the grid and is taken from a coarse one. Ctrl-C meanwhile is passed on.
    """
    method = next(iter(METHODS.values()))
    coarse_problem = Problem.from_scene(scene, min(_FLOOR_POINTS, scene.num_points))
    coarse = method.begin(coarse_problem, Setting(1e-3, backend="numpy"))
    if relax(coarse, 300) is Status.INTERRUPTED:
        raise KeyboardInterrupt
    displacement = coarse.displacement * (coarse_problem.length_unit / problem.length_unit)
    return rounding_floor(problem.stiffness, displacement, "float32")


def default_tolerance(scene: Scene, problem: Problem | None = None) -> float:
    """1e-8; in float32 the larger of 1e-4 and four times what rounding leaves (dimensionless).

    Where rounding turns out to leave more, `Solution.tolerance` says how much, up to `MEANINGLESS`, as long as
    `MOST_ENERGY` bounds the energy's error. problem: of the scene, if there is one already.

    Raises `ValueError` where rounding in float32 leaves no meaning in the residual.
    """
    if scene.precision != "float32":
        return _DEFAULT
    floor = float32_floor(scene, problem or Problem.from_scene(scene))
    if _OVER_FLOOR * floor > MEANINGLESS:
        raise ValueError(_too_many_points(scene, floor))
    return max(_DEFAULT_FLOAT32, _OVER_FLOOR * floor)


def check_tolerance(scene: Scene, problem: Problem, tolerance: float) -> None:
    """Raise `ValueError` if the scene's precision cannot reach a tolerance."""
    if scene.precision != "float32" or tolerance >= (floor := float32_floor(scene, problem)):
        return
    if floor > MEANINGLESS:
        raise ValueError(_too_many_points(scene, floor))
    raise ValueError(
        f"tolerance is {tolerance!r}; allowed: at least {floor:.1g}, which is what rounding in float32 leaves of the "
        "residual, or precision mixed or float64"
    )


def _too_many_points(scene: Scene, floor: float) -> str:
    own = "a tolerance of your own, " if floor < MEANINGLESS else ""
    return (
        f"num_points is {scene.num_points}, where float32 leaves a residual of about {floor:.1g}; allowed: "
        f"fewer points, {own}or precision mixed or float64"
    )
