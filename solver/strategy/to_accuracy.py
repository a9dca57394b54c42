"""A solve to a given accuracy of something measured: the plan carried out, the smallest model first."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from .. import checks, display
from ..endings import Cause, Reason, Status
from ..grid.certificate import certify
from ..grid.problem import Problem
from ..methods import DEFAULT, Method
from ..scene import Scene
from ..solution import Choice, Level, Solution
from .certification import certify_or_fall_back
from .effort import CAUTION, COARSE_WRONG_NODES, Effort, Means
from .errors import DEFAULT_QUANTITY, QUANTITIES, Quantity, grid_error, sensitivity
from .grids import FACTOR, Reached, coarser, grids, over_grids
from .memory import check_memory
from .plan import Plan, decide, residual
from .report import make_solution, stages
from .small_models import Modelled, asperity, winkler
from .unfinished import iteration_share, left_at_ends, near_full_contact

MOST_ACCURACY = 0.1
"""Coarsest relative error that may be asked for (dimensionless)."""

_FEWEST_POINTS = 16
"""Points of the smallest coarser grid."""
_SMALLEST = 1e-12
"""Tolerance to which a nearly full contact, or one with flat ends, may be solved (dimensionless)."""
_SHARE_OF_ENDS = 0.25  # of the accuracy, that the residual may leave at the ends of patches


def check_accuracy(accuracy: float | None, of: str) -> float | None:
    """The accuracy, if it is one that may be asked for, of one of `QUANTITIES`; None for none. Raises `ValueError`."""
    checks.choice("accuracy_of", of, tuple(QUANTITIES))
    if accuracy is not None:
        allowed = "1e-9 <= accuracy <= 0.1"
        return checks.real("accuracy", accuracy, allowed, math.nextafter(1e-9, 0), MOST_ACCURACY)
    if of != DEFAULT_QUANTITY:
        raise ValueError(f"accuracy_of is {of!r}; allowed: together with an accuracy")
    return None


def solve_to_accuracy(scene: Scene, accuracy: float, of: str, means: Means) -> Solution:
    """Solve a scene to an accuracy, the relative error of one of `QUANTITIES` (dimensionless). Raises `ValueError`.

    The first model that is good enough gives the answer; the grid always does, or says that it is not good enough.
    """
    begin = time.perf_counter()
    check_memory(_FEWEST_POINTS if scene.indenter.power_law else scene.num_points)  # most likely needs no grid
    if scene.precision != "float64":
        raise ValueError(f"precision is {scene.precision!r}; allowed: float64, accuracy chooses the precision")
    task = _Task(scene, accuracy, of, means, begin, decide(scene, accuracy, of))
    for model in task.plan.models:
        solution = _MODELS[model](task)
        if solution:
            return solution
    return _on_grids(task)


@dataclass
class _Task:
    """What was asked for, and what has been chosen for it so far."""

    scene: Scene
    """As the user gave it; its grid is the finest allowed."""
    accuracy: float
    """Relative error asked for (dimensionless)."""
    of: str
    """Of which of `QUANTITIES`."""
    means: Means
    """What to compute with."""
    begin: float
    """When the solve began [s]."""
    plan: Plan
    """What to try."""
    choices: list[Choice] = field(default_factory=list)
    """What has been chosen so far, and why."""

    def __post_init__(self) -> None:
        self.choices += self.plan.choices

    def chose(self, what: str, chosen: str, reason: str, error: float = 0.0) -> None:
        """Keep a choice, see `Choice`."""
        self.choices.append(Choice(what, chosen, reason, error))

    @property
    def quantity(self) -> Quantity:
        """What the accuracy is asked of."""
        return QUANTITIES[self.of]

    @property
    def model_error(self) -> float:
        """Relative error of the contact area by the choices made."""
        return sum(choice.error for choice in self.choices)

    @property
    def sensitivity(self) -> float:
        """Of the quantity, see the function of that name."""
        return sensitivity(self.quantity, self.scene)

    def judged(self, solution: Solution, model_error: float) -> Solution:
        """With the model's share in the errors, and whether they are what was asked for.

        model_error: of a_r, relative.
        """
        o, status, reason = solution.observables, solution.status, solution.reason
        area = min(o.contact_area_error + model_error * o.contact_area_subgrid, 1.0)
        kappa = o.kappa_error + sensitivity(QUANTITIES["kappa"], self.scene) * model_error * o.kappa_subgrid
        o = replace(o, contact_area_error=area, kappa_error=kappa)
        if self.plan.layer is not self.scene.layer:  # what that leaves out of them is not known
            o = replace(o, peak_pressure_error=math.inf, approach_error=math.inf)
        value, error = abs(getattr(o, self.quantity.value)), getattr(o, self.quantity.error)
        if status is Status.CONVERGED and not error <= self.accuracy * value:
            status = Status.INACCURATE
            known = error / value if value else math.inf
            above = f"above {display.rounded_up(known)}, or " if known < MOST_ACCURACY else ""
            heights = ", with heights given there" if self.scene.indenter.given_points else ""
            allowed = f"{above}a finer grid: num_points above {solution.scene.num_points}{heights}"
            reason = Reason(Cause.GRID, "accuracy", f"{self.accuracy:g}", allowed)
        elif reason and status is not Status.INTERRUPTED and solution.certificate:
            got = solution.certificate.free_residual
            takes = f"{self.accuracy:g}, which takes a residual of {solution.tolerance:.2g} and got {got:.2g}"
            reason = Reason(reason.cause, "accuracy", takes, "a larger one")
        solution = replace(solution, observables=o, status=status, reason=reason)
        return replace(solution, choices=tuple(self.choices), accuracy=self.accuracy, accuracy_of=self.of)


def _asperity(task: _Task) -> Solution | None:
    """One asperity by collocation; None where that does not get there."""
    try:
        found = asperity(task.scene, task.plan.layer, task.accuracy / 2, task.of.replace("-", "_"))
    except ValueError as error:
        task.chose("collocation", "no", str(error))
        return None
    reason = "a power profile is one asperity; error: from the change by the last doubling of the nodes"
    task.chose("model", "collocation", reason, found.error)
    task.chose("grid", f"{found.scene.num_points} points", "for the fields only, which are sampled")
    power = task.scene.indenter.power_law
    if power and power[0] < 2:
        task.chose("peak pressure", "by collocation", "rough: too low at a tip sharper than a parabola")
    return _modelled(task, "collocation", found)


def _winkler(task: _Task) -> Solution | None:
    """The Winkler foundation; None where that is not accurate enough."""
    found = winkler(task.scene)
    value, error = (getattr(found.observables, name) for name in (task.quantity.value, task.quantity.error))
    if not error <= task.accuracy * value:
        what = task.of.replace("-", " ")
        share = error / value if value else math.inf
        task.chose("Winkler foundation", "no", f"its {what} would be off by a share of {share:.1g}")
        return None
    task.chose("model", "Winkler foundation", "the layer's edges are narrow", task.sensitivity * found.error)
    task.chose("grid", f"{found.scene.num_points} points", "no transform is needed")
    return _modelled(task, "winkler-foundation", found)


_MODELS: dict[str, Callable[[_Task], Solution | None]] = {"winkler": _winkler, "asperity": _asperity}


def _modelled(task: _Task, name: str, found: Modelled) -> Solution:
    """A model's solution; a foundation's on the grid is certified with its own stiffness."""
    others = sum(choice.error for choice in task.choices if choice.what != "model")
    certificate, ready = None, time.perf_counter()
    if found.problem:
        # on the wall exactly, whatever the units' rounding
        on_wall = np.where(found.contact, found.problem.height, found.displacement / found.problem.length_unit)
        certificate = certify(found.problem, on_wall)[0]
    solution = Solution(
        scene=found.scene,
        method=name,
        tolerance=task.accuracy / 2,
        status=Status.CONVERGED,
        displacement=found.displacement,
        contact_pressure=found.contact_pressure,
        contact=found.contact,
        observables=found.observables,
        patches=found.patches,
        certificate=certificate,
        iterations=0,
        transform_pairs=0.0,
        seconds=stages(task.begin, task.begin, ready, time.perf_counter()),
        threads=task.means.threads,
        planning=task.means.planning,
        backend=task.means.backend,
    )
    return task.judged(solution, others)


def _on_grids(task: _Task) -> Solution:
    """The default method, from coarse to fine, until the estimated error is small enough.

    Should the certified solution be less accurate than estimated, it goes on from there on the next grid. An
    interruption returns what the grid at hand has given.
    """
    scene, tolerance, ready = replace(task.scene, layer=task.plan.layer), residual(task.accuracy), time.perf_counter()
    effort = Effort(scene, DEFAULT, task.means)
    model_error = task.model_error
    memory = checks.available_memory()
    budget = task.accuracy - task.sensitivity * (model_error + iteration_share(tolerance))

    def begin(size: int, contact_share: float) -> Method:
        check_memory(size, effort.kind, contact_share, memory)
        problem, few = Problem.from_scene(scene, size), COARSE_WRONG_NODES
        return effort.begin(problem, CAUTION * tolerance, wrong_nodes_per_patch=few, contact_share=contact_share)

    def relax(state: Method) -> tuple[Method, Status]:
        effort.add_start(state)
        effort.allow(effort.kind.max_iterations)  # on each grid
        return state, effort.relax(state)

    sizes, levels = grids(scene.num_points), list[Level]()
    if len(sizes) == 1 and sizes[0] >= FACTOR * _FEWEST_POINTS:  # without a coarser one there is no telling the error
        sizes.insert(0, coarser(sizes[0]))
    chosen_before = tuple(task.choices)
    for reached in over_grids(scene, sizes, begin, relax, measure_last=True):
        if levels and levels[-1].num_points == reached.num_points:
            levels.pop()  # interrupted after it was reached
        error = grid_error(task.quantity, scene, reached.level, levels)
        last = reached.num_points == scene.num_points or reached.status is Status.INTERRUPTED
        fine = error <= budget and scene.indenter.omitted(reached.num_points) <= budget / 2
        if last or fine:
            task.choices = list(chosen_before)
            task.chose("model", "grid", "no smaller model will do")
            why = "the coarsest that is good enough" if error <= budget else "the finest allowed, and not fine enough"
            task.chose("grid", f"{reached.num_points} points", why, error)
            smaller = _small_enough(task, tolerance, reached)
            solution = task.judged(_finish(task, effort, reached, levels, smaller, ready), model_error)
            if last or solution.status is not Status.INACCURATE:
                return solution
        levels.append(reached.level)
    raise AssertionError("the last grid returns")


def _small_enough(task: _Task, tolerance: float, reached: Reached) -> float:
    """A tolerance that leaves little of the accuracy asked for, also nearly in full contact and at flat ends."""
    area = reached.level.contact_area_subgrid
    smaller = tolerance / near_full_contact(area)
    allowed = _SHARE_OF_ENDS * task.accuracy / task.sensitivity * area
    while smaller > _SMALLEST and left_at_ends(smaller, reached.contact[0], reached.pressure) > allowed:
        smaller /= 10
    return max(smaller, _SMALLEST)


def _finish(
    task: _Task, effort: Effort, reached: Reached, levels: list[Level], tolerance: float, ready: float
) -> Solution:
    """Relax until no node is wrong any more, certify, and say what was chosen."""
    scene, state, status = task.scene.on_grid(reached.num_points), reached.state, reached.status
    if status is not Status.INTERRUPTED:
        if CAUTION * tolerance < state.tolerance:
            state, before = effort.begin(state.problem, CAUTION * tolerance), state
            state.start_from_pressure(before.contact_pressure)
        state.demand_every_node()
        status = effort.relax(state)
    relaxed = time.perf_counter()
    # the certificate is for the scene's own layer; contact is where u = h exactly
    problem = replace(Problem.from_scene(scene), height=state.problem.height)
    certified = certify_or_fall_back(effort, problem, state, status, tolerance, own_tolerance=False)
    task.chose("method", effort.kind.name, "the fastest on every scene measured")
    task.chose("precision", "float64", "mixed saves next to nothing where transforms are few")
    area = reached.level.contact_area_subgrid
    left, largest = certified.certificate.free_residual, certified.certificate.largest_residual
    share = iteration_share(left, area)
    if area and task.quantity.of_area:
        share += left_at_ends(left, reached.contact[0], reached.pressure, largest) / area
    share *= task.sensitivity
    task.chose("tolerance", f"{tolerance:g}", "small beside the accuracy", share)
    solution = make_solution(scene, problem, certified, levels, effort)
    if not levels:  # without a coarser grid nothing is known, and edges alone are not believed
        unknown = replace(solution.observables, contact_area_error=1.0, kappa_error=math.inf)
        solution = replace(solution, observables=unknown)
    return replace(solution, seconds=stages(task.begin, ready, relaxed + certified.seconds, time.perf_counter()))
