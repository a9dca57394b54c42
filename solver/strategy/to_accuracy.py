"""A solve to a given accuracy of something measured: the smallest model, or the coarsest grid, that is good enough."""

import math
import time
from dataclasses import replace

from .. import checks, display
from ..endings import Cause, Reason, Status
from ..grid.errors import FACTOR, MOST_ACCURACY, QUANTITIES, estimated, iteration_share
from ..grid.problem import Problem
from ..methods import Method
from ..solution import Choice, Solution
from .finish import finish
from .grids import check_memory, coarser, grids, solve_on_grid
from .run import Run
from .small_models import by_small_model


def solve_to_accuracy(run: Run, accuracy: float, of: str) -> Solution:
    """Solve the run's scene to an accuracy, the relative error of one of `QUANTITIES`. Raises `ValueError`.

    A smaller model that is good enough gives the answer; the grid always does, or says that it is not good enough.
    """
    scene = run.scene
    if not scene.indenter.power_law:  # that most likely needs no grid
        check_memory(scene.num_points)
    if scene.precision != "float64":
        raise ValueError(f"precision is {scene.precision!r}; allowed: float64, with an accuracy")
    run.tolerance = accuracy / 2
    solution = by_small_model(run, accuracy, of)
    return _judged(solution, accuracy, of) if solution else _on_grids(run, accuracy, of)


def _judged(solution: Solution, accuracy: float, of: str) -> Solution:
    """The solution, which says whether it reaches the accuracy."""
    status, reason, quantity = solution.status, solution.reason, QUANTITIES[of]
    value, error = (abs(getattr(solution.observables, name)) for name in (quantity.value, quantity.error))
    if status is Status.CONVERGED and not error <= accuracy * value:
        status = Status.INACCURATE
        known = error / value if value else math.inf
        above = f"above {display.rounded_up(known)}, or " if known < MOST_ACCURACY else ""
        heights = ", with heights given there, as by a denser scan" if solution.scene.indenter.given_points else ""
        allowed = f"{above}a finer grid: num_points above {solution.scene.num_points}{heights}"
        reason = Reason(Cause.GRID, "accuracy", f"{accuracy:g}", allowed)
    elif reason and status is not Status.INTERRUPTED and solution.certificate:
        got = solution.certificate.equilibrium_residual
        takes = f"{accuracy:g}, which takes a residual of {solution.tolerance:.2g} and got {got:.2g}"
        reason = Reason(reason.cause, "accuracy", takes, "a larger one")
    return replace(solution, status=status, reason=reason, accuracy=accuracy, accuracy_of=of)


def _on_grids(run: Run, accuracy: float, of: str) -> Solution:
    """The default method, from coarse to fine, until the estimated error is small enough.

    Should the certified solution be less accurate than estimated, it goes on from there on the next grid. An
    interruption returns the result of the grid at hand.
    """
    scene, quantity, run.memory = run.scene, QUANTITIES[of], checks.available_memory()
    tolerance, before = min(0.2 * accuracy, 1e-8), tuple(run.choices)
    run.times[1] = time.perf_counter()

    def begin(size: int) -> Method:
        run.allow(run.kind.max_iterations)  # on each grid
        run.tolerance, run.handed_over = tolerance, False
        return run.begin(Problem.from_scene(scene, size), tolerance)

    sizes = grids(scene.num_points)
    if len(sizes) == 1 and sizes[0] >= FACTOR**3:  # without a coarser one there is no telling the error
        sizes.insert(0, coarser(sizes[0]))
    for next_size in sizes:
        solve_on_grid(run, next_size, begin)
        size, found = run.state.problem.num_points, run.levels
        settled = found and found[-1].num_points == size
        error = math.inf  # on the first grid, and where the quantity is 0
        if settled and len(found) > 1 and (value := abs(getattr(found[-1], quantity.value))):
            error = estimated(quantity, scene, size, found[-1], found[:-1]) / value
        last = size == scene.num_points or run.status is Status.INTERRUPTED
        if last or (error <= accuracy and scene.indenter.omitted(size) <= accuracy / 2):
            why = "the coarsest that is good enough" if error <= accuracy else "the finest allowed, and not fine enough"
            run.choices = [
                *before,
                Choice("model", "grid", "no smaller model will do"),
                Choice("grid", f"{size} points", why, error),
                Choice("method", run.kind.name, "the fastest on every scene measured"),
                Choice("tolerance", f"{tolerance:g}", "small beside the accuracy", iteration_share(tolerance)),
            ]
            try:
                of_grid = scene.on_grid(size)
            except ValueError:
                if run.status is Status.INTERRUPTED:  # on a grid that does not resolve the surface
                    raise KeyboardInterrupt from None
                raise
            solution = finish(run, of_grid, run.state.problem)
            if not solution.levels:  # without a coarser grid nothing is known, and edges alone are not believed
                unknown = replace(solution.observables, contact_area_error=1.0, kappa_error=math.inf)
                solution = replace(solution, observables=unknown)
            solution = _judged(solution, accuracy, of)
            if last or solution.status is not Status.INACCURATE:
                return solution
    raise AssertionError("the last grid returns")
