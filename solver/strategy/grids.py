"""Nested grids: the one loop from coarse to fine. A solution on a coarse grid is where the next finer one starts.

The loop leaves to others which method works on a grid and when a grid is fine enough.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from ..arrays import Array64
from ..endings import Status
from ..grid.contact import contact_edges
from ..grid.edges import Edges
from ..grid.observables import approach, approach_sampling, peak_sampling, subgrid_measures
from ..grid.patches import Patches
from ..grid.problem import squared_slope
from ..methods import Method
from ..scene import Scene
from ..solution import Level
from .prolongation import prolong

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


@dataclass(frozen=True, eq=False)
class Reached:
    """A method that has been relaxed on one of the grids, and what is measured there, computed on first use."""

    scene: Scene
    """The scene that is solved; its own grid is the finest."""
    state: Method
    """The method on this grid."""
    status: Status
    """How the relaxation ended."""
    by_loads: bool = True
    """Whether loads may tell where its patches end; not needed to start on a finer grid."""

    @property
    def num_points(self) -> int:
        """Points of this grid."""
        return self.state.problem.num_points

    @cached_property
    def pressure(self) -> Array64:
        """Contact pressure, shape (num_points,) [p]."""
        return self.state.contact_pressure

    @cached_property
    def displacement(self) -> Array64:
        """u, shape (num_points,) [u]."""
        return self.state.displacement

    @cached_property
    def contact(self) -> tuple[Patches, Edges]:
        """Its patches and their ends."""
        problem = self.state.problem
        unit = problem.length_unit
        displacement = self.displacement * unit if self.by_loads else None
        return contact_edges(self.scene, self.pressure, problem.height * unit, displacement)

    @property
    def contact_share(self) -> float:
        """Share of the nodes that are in contact (dimensionless)."""
        return int(self.contact[0].size.sum()) / self.num_points

    @cached_property
    def level(self) -> Level:
        """What this grid gives."""
        scene, state, edges, unit = self.scene, self.state, self.contact[1], self.state.problem.length_unit
        profile = state.problem.height * unit
        squared = squared_slope(scene.indenter, self.num_points, scene.period)
        area, _, kappa, kappa_error = subgrid_measures(scene, *self.contact, squared)
        error = edges.total_error / self.num_points
        return Level(
            num_points=self.num_points,
            contact_area_subgrid=area,
            kappa_subgrid=kappa,
            peak_pressure=scene.pressure * float(self.pressure.max(initial=0.0)),
            peak_pressure_sampling=scene.pressure * peak_sampling(scene.indenter, self.pressure, *self.contact),
            approach=approach(scene, self.displacement * unit, profile),
            approach_sampling=approach_sampling(scene.indenter, profile, self.contact[0]),
            num_patches=self.contact[0].count,
            contact_area_edges_error=error,
            kappa_edges_error=kappa_error,
            unseen_gap_area=edges.unseen / self.num_points,
            iterations=state.iteration,
            transform_pairs=round(state.transform_pairs, 3),
        )

    def start(self, finer: Method) -> None:
        """Begin on a finer grid from this solution."""
        finer.start_from_pressure(prolong(self.scene, self.pressure, *self.contact, finer.problem.num_points))


def over_grids(
    scene: Scene,
    sizes: Sequence[int],
    begin: Callable[[int, float], Method],
    relax: Callable[[Method], tuple[Method, Status]],
    measure_last: bool = False,
) -> Iterator[Reached]:
    """From coarse to fine: every grid as it is reached. One that is interrupted is the last one.

    sizes: numbers of points. begin: the method on a grid of so many, given the share of the nodes that are in contact
    on the grid before, 0 on the first one. relax: returns the relaxed state, which may be another one than it got.
    measure_last: whether the level of the finest grid is wanted, too, as any may be the last.

    An interruption before the first grid is reached is passed on; a later one yields the last grid that was reached
    once more, as interrupted.
    """
    reached: Reached | None = None
    for size in sizes:
        try:
            if reached:
                reached.state.rest()
            state = begin(size, reached.contact_share if reached else 0.0)
            if reached:
                reached.start(state)
            # of an area, errors follow from the last two grids
            relaxed = Reached(scene, *relax(state), by_loads=measure_last or size in sizes[-2:])
            if measure_last or size != sizes[-1]:
                _ = relaxed.level  # computed here, where an interruption is noticed
            reached = relaxed
        except KeyboardInterrupt:  # while a grid is prepared or measured
            if not reached:
                raise
            reached = Reached(scene, reached.state, Status.INTERRUPTED)
        yield reached
        if reached.status is Status.INTERRUPTED:
            return
