"""A solve to a given residual, by a method of one's choice."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import checks
from ..arrays import Array64
from ..endings import Status
from ..grid.problem import Problem
from ..methods import Method
from ..scene import Scene
from ..solution import Level, Solution
from .certification import certify_or_fall_back
from .effort import CAUTION, COARSE_REDUCTION, COARSE_TOLERANCE, COARSE_WRONG_NODES, Effort
from .grids import Reached, grids, over_grids
from .memory import check_memory
from .precision import problems, reachable
from .report import make_solution, stages


@dataclass(frozen=True)
class Prepared:
    """Everything that a solve needs before its first iteration."""

    effort: Effort
    """The method and its means."""
    problem: Problem
    """On the scene's grid."""
    tolerance: float
    """Tolerance on the free residual over p (dimensionless)."""
    start: Array64 | None
    """A displacement to start from, shape (N,) [u]."""
    sizes: Sequence[int]
    """The grids to go over, from coarse to fine."""
    memory: int | None
    """What was free before anything was made [bytes], if that is known."""

    def begin(self, num_points: int, contact_share: float) -> Method:
        """The method on one of the grids; contact_share: of the nodes, as the grid before has it."""
        scene = self.effort.scene
        if num_points == scene.num_points:
            if len(self.sizes) > 1:
                check_memory(num_points, self.effort.kind, contact_share, self.memory)
            finest = self.effort.begin(self.problem, CAUTION * self.tolerance, contact_share=contact_share)
            if self.start is not None:
                finest.start(self.start)
            return finest
        tolerance = max(COARSE_TOLERANCE, 0.0 if scene.precision == "float32" else self.tolerance)
        problem = Problem.from_scene(scene, num_points)
        few, reduction = COARSE_WRONG_NODES, COARSE_REDUCTION
        return self.effort.begin(
            problem, tolerance, wrong_nodes_per_patch=few, reduction=reduction, contact_share=contact_share
        )


def solve_to_tolerance(
    effort: Effort, nested: bool | None, tolerance: float | None, initial: Array64 | None
) -> Solution:
    """Solve the effort's scene by its method to a tolerance; arguments as in `solve`. Raises `ValueError`."""
    begin = time.perf_counter()
    prepared = _prepare(effort, nested, tolerance, initial)
    problem, asked, own = prepared.problem, prepared.tolerance, tolerance is not None
    ready = time.perf_counter()
    reached, levels = _iterate(prepared)
    relaxed = time.perf_counter()
    certified = certify_or_fall_back(effort, problem, reached.state, reached.status, asked, own)
    del prepared, reached  # and with them the method's fields, which are most of the memory
    solution = make_solution(effort.scene, problem, certified, levels, effort)
    times = stages(begin, ready, relaxed + certified.seconds, time.perf_counter())
    return replace(solution, seconds=times)


def _prepare(effort: Effort, nested: bool | None, tolerance: float | None, initial: Array64 | None) -> Prepared:
    """Check what was asked for, and discretise the scene."""
    scene, kind = effort.scene, effort.kind
    nested = kind.nested if nested is None else nested
    sizes = grids(scene.num_points) if nested and initial is None else [scene.num_points]
    memory = checks.available_memory()
    # without a coarser grid there is no telling how much will be in contact
    check_memory(scene.num_points, kind, 0.0 if len(sizes) > 1 else 1.0, memory)
    if scene.precision not in kind.precisions:
        raise ValueError(f"precision is {scene.precision!r}; allowed: {', '.join(kind.precisions)}, for {kind.name}")
    if tolerance is not None:
        tolerance = checks.real("tolerance", tolerance, "1e-14 to 0.5", math.nextafter(1e-14, 0), 0.5)
    problem, coarse = problems(scene)
    tolerance = reachable(scene, problem, coarse, tolerance)
    start = None if initial is None else _displacement(initial, scene, problem)
    return Prepared(effort, problem, tolerance, start, sizes, memory)


def _displacement(initial: Array64, scene: Scene, problem: Problem) -> Array64:
    """A displacement to start from, shape (N,) [length], in the problem's unit; see `solve`. Raises `ValueError`."""
    displacement = _check_initial(initial, scene.num_points)
    # on the wall exactly, whatever the units' rounding; and not beyond where any solution is
    on_wall, reach = displacement >= scene.profile, problem.reach
    reach *= problem.length_unit
    inside = np.clip(displacement, -reach, reach) / problem.length_unit
    return np.where(on_wall, problem.height, inside)


def _check_initial(initial: Array64, num_points: int) -> Array64:
    allowed = f"allowed: an array of {num_points} finite real numbers"
    real = checks.array(initial)
    if real is None:
        raise ValueError(f"initial is masked or not an array of real numbers; {allowed}")
    if real.shape != (num_points,):
        raise ValueError(f"initial has shape {real.shape}; {allowed}")
    if not np.isfinite(real).all():
        raise ValueError(f"initial holds a value that is not finite; {allowed}")
    return real


def _iterate(prepared: Prepared) -> tuple[Reached, list[Level]]:
    """Go over the grids; the finest one as it is reached, and what the coarser ones gave.

    An interruption on a coarse grid leaves what is known by then on the finest one.
    """
    effort, levels = prepared.effort, list[Level]()
    for reached in over_grids(effort.scene, prepared.sizes, prepared.begin, effort.settle):
        # how far a grid is off that was not solved says nothing of the others
        if reached.num_points < effort.scene.num_points and reached.status in (Status.CONVERGED, Status.STAGNATED):
            levels.append(reached.level)
    if reached.num_points < effort.scene.num_points:
        finest = prepared.begin(effort.scene.num_points, 0.0)
        if reached.pressure.any():
            reached.start(finest)
        reached = Reached(effort.scene, finest, reached.status)
    return reached, levels
