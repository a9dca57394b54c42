"""The grids of one solve, from coarse to fine: how many, whether they fit, and the contact that the next begins from.

A finer grid begins from the coarse one's contact pressure (`grid.prolong`).
"""

from collections.abc import Callable

from .. import checks
from ..endings import Status
from ..grid.contact import Contact, contact_edges
from ..grid.errors import FACTOR
from ..grid.observables import measure
from ..grid.prolong import prolong
from ..methods import DEFAULT, Method, MethodKind
from ..solution import Level
from .run import Run

COARSEST = 512
"""Points of the coarsest grid, at least."""

DEFAULT_TOLERANCE, COARSE_TOLERANCE = 1e-8, 1e-5
"""Equilibrium residual over p to stop at in float64 and mixed precision; on coarse grids, at least."""


def solve_on_grid(
    run: Run, num_points: int, begin: Callable[[int], Method], measured: bool = True, by_loads: bool = True
) -> None:
    """Solve on the next finer grid, from the contact of the last one that was measured.

    begin: the method on a grid of so many points. measured: whether the level is wanted; by_loads: see `_measured`. An
    interruption before the first grid is reached is passed on; a later one leaves the last grid that was reached, as
    interrupted. Raises `ValueError` like `check_memory`.
    """
    try:
        if run.contact:
            run.state.rest()
        check_memory(num_points, run.kind, run.contact_share, run.memory)
        state = begin(num_points)
        start_from_contact(run, state)
        status, contact = run.relax(state), run.contact
        if measured:
            level, contact = _measured(state, by_loads)
            if status in (Status.CONVERGED, Status.STAGNATED):  # another says nothing of errors
                run.levels.append(level)
        run.state, run.status, run.contact = state, status, contact
    except KeyboardInterrupt:  # while a grid is prepared or measured
        if not run.contact:
            raise
        run.status = Status.INTERRUPTED


def start_from_contact(run: Run, finer: Method) -> None:
    """Begin on a finer grid from the contact of the last one that was measured, if there is one."""
    if run.contact and run.contact.pressure.any():
        finer.start_from_pressure(prolong(*run.contact, finer.problem))


def grids(num_points: int) -> list[int]:
    """Grid sizes from coarse to fine, each about four times the one before; the coarser ones are even."""
    sizes = [num_points]
    while sizes[0] // FACTOR >= COARSEST:
        sizes.insert(0, coarser(sizes[0]))
    return sizes


def coarser(num_points: int) -> int:
    """The next coarser grid."""
    return 2 * round(num_points / FACTOR / 2)


def check_memory(
    num_points: int, kind: MethodKind = DEFAULT, contact_share: float = 0.0, available: int | None = None
) -> None:
    """Raise `ValueError` for a grid that the free memory cannot hold.

    kind: the method; contact_share: of the nodes, where a coarser grid tells it (dimensionless). available: memory
    that was free before the solve began [bytes]; by default the memory that is free now.
    """
    available = checks.available_memory() if available is None else available
    needed = kind.bytes_per_point(contact_share) * num_points
    if available is not None and needed > available:
        fits = f"as many as fit into the {available / 2**30:.1f} GiB that are free"
        raise ValueError(f"num_points is {num_points}, needing about {needed / 2**30:.1f} GiB; allowed: {fits}")


def _measured(state: Method, by_loads: bool) -> tuple[Level, Contact]:
    """Level and contact of a grid; by_loads: whether loads may tell the ends of patches, for the errors."""
    pressure, problem, pairs = state.contact_pressure, state.problem, round(state.transform_pairs, 3)
    displacement = problem.to_length(state.displacement.copy(), pressure > 0)
    contact = contact_edges(problem, pressure, displacement if by_loads else None)
    measured = measure(contact, displacement, problem.scene.pressure)
    level = Level(**measured, num_points=problem.num_points, iterations=state.iteration, transform_pairs=pairs)
    problem.indenter.rest()
    return level, contact
