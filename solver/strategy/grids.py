"""Nested grids: the one loop from coarse to fine. A solution on a coarse grid is where the next finer one starts.

The loop leaves to others which method works on a grid and when a grid is fine enough.
"""

from collections.abc import Callable, Iterator, Sequence

from ..endings import Status
from ..grid.contact import contact_edges
from ..grid.observables import approach, approach_sampling, peak_sampling, subgrid_measures
from ..grid.problem import squared_slope
from ..methods import Method
from ..scene import Scene
from ..solution import Level
from .prolongation import prolong
from .run import Contact, Run

FACTOR = 4
COARSEST = 512
"""Points of the coarsest grid, at least."""


def grids(num_points: int) -> list[int]:
    """Grid sizes from coarse to fine, each about four times the one before; the coarser ones are even."""
    sizes = [num_points]
    while sizes[0] // FACTOR >= COARSEST:
        sizes.insert(0, coarser(sizes[0]))
    return sizes


def coarser(num_points: int) -> int:
    """The next coarser grid."""
    return 2 * round(num_points / FACTOR / 2)


def over_grids(
    run: Run, sizes: Sequence[int], begin: Callable[[int], Method], measure_last: bool = False
) -> Iterator[None]:
    """From coarse to fine: `run` as every grid is reached. One that is interrupted is the last one.

    sizes: numbers of points. begin: the method on a grid of so many. measure_last: whether the level of the finest grid
    is wanted, too, as any may be the last.

    An interruption before the first grid is reached is passed on; a later one leaves the last grid that was reached, as
    interrupted.
    """
    for size in sizes:
        try:
            if run.contact:
                run.state.rest()
            state = begin(size)
            start_from_contact(run, state)
            status = run.relax(state)
            if measure_last or size < sizes[-1]:
                # of an area, errors follow from the last two grids
                level, contact = _measured(run.scene, state, by_loads=measure_last or size in sizes[-2:])
                if status in (Status.CONVERGED, Status.STAGNATED):  # how far another is off says nothing of the rest
                    run.levels.append(level)
                run.contact = contact
            run.state, run.status = state, status
        except KeyboardInterrupt:  # while a grid is prepared or measured
            if not run.contact:
                raise
            run.status = Status.INTERRUPTED
        yield
        if run.status is Status.INTERRUPTED:
            return


def start_from_contact(run: Run, finer: Method) -> None:
    """Begin on a finer grid from the contact of the last one that was measured; without one where the method does."""
    if run.contact:
        finer.start_from_pressure(prolong(*run.contact, finer.problem.num_points))


def _measured(scene: Scene, state: Method, by_loads: bool) -> tuple[Level, Contact]:
    """What a grid gives; by_loads: whether loads may tell where patches end, which a finer grid does not need."""
    pressure, problem = state.contact_pressure, state.problem
    unit, num_points = problem.length_unit, problem.num_points
    profile, displacement = problem.height * unit, state.displacement * unit
    patches, edges = contact_edges(scene, pressure, profile, displacement if by_loads else None)
    squared = squared_slope(scene.indenter, num_points, scene.period)
    area, _, kappa, kappa_error = subgrid_measures(scene, patches, edges, squared)
    level = Level(
        num_points=num_points,
        contact_area_subgrid=area,
        kappa_subgrid=kappa,
        peak_pressure=scene.pressure * float(pressure.max(initial=0.0)),
        peak_pressure_sampling=scene.pressure * peak_sampling(scene.indenter, pressure, patches, edges),
        approach=approach(scene, displacement, profile),
        approach_sampling=approach_sampling(scene.indenter, profile, patches),
        num_patches=patches.count,
        num_patches_by_load=edges.num_by_load,
        contact_area_edges_error=edges.total_error / num_points,
        kappa_edges_error=kappa_error,
        unseen_gap_area=edges.unseen / num_points,
        iterations=state.iteration,
        transform_pairs=round(state.transform_pairs, 3),
    )
    return level, (pressure, patches, edges)
