"""Nested grids: the one loop from coarse to fine. The next finer grid starts at a coarse grid's solution.

The loop leaves to others which method works on a grid and when a grid is fine enough.

A finer grid begins from the coarse one's contact pressure. At the edges of its patches that goes like a square root,
which no interpolation follows; divided by the edge functions of both ends (`edge_curves.edge_function`, at the ends'
sub-grid positions) it is smooth. So the smooth part is interpolated and multiplied by the edge functions of the
fine grid. The fine contact set comes out right except for a few nodes, and the error of the pressure is that of the
coarse grid, not of the interpolation.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ..arrays import Array64, Indices
from ..endings import Status
from ..grid.edge_curves import EdgeCurve, half_space_curve
from ..grid.edges import UNRESOLVED_BELOW, Edges
from ..grid.observables import measure
from ..grid.patches import Patches
from ..grid.problem import Problem
from ..methods import Method
from ..solution import Level
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
            status, contact = run.relax(state), run.contact
            if measure_last or size < sizes[-1]:
                # of an area, errors follow from the last two grids
                level, contact = _measured(state, by_loads=measure_last or size in sizes[-2:])
                if status in (Status.CONVERGED, Status.STAGNATED):  # how far another is off says nothing of the rest
                    run.levels.append(level)
            run.state, run.status, run.contact = state, status, contact
        except KeyboardInterrupt:  # while a grid is prepared or measured
            if not run.contact:
                raise
            run.status = Status.INTERRUPTED
        yield
        if run.status is Status.INTERRUPTED:
            return


def start_from_contact(run: Run, finer: Method) -> None:
    """Begin on a finer grid from the contact of the last one that was measured; without one where the method does."""
    if run.contact and run.contact[1].any():
        finer.start_from_pressure(prolong(*run.contact, finer.problem))


def _measured(state: Method, by_loads: bool) -> tuple[Level, Contact]:
    """Level and contact of a grid; by_loads: whether loads may tell the ends of patches, for the errors."""
    pressure, problem = state.contact_pressure, state.problem
    displacement = problem.to_length(state.displacement.copy(), pressure > 0)
    measured, patches, edges = measure(problem, displacement, pressure, problem.scene.pressure, by_loads)
    pairs = round(state.transform_pairs, 3)
    level = Level(**measured, num_points=problem.num_points, iterations=state.iteration, transform_pairs=pairs)
    return level, (problem, pressure, patches, edges)


def prolong(coarse: Problem, pressure: Array64, patches: Patches, ends: Edges, finer: Problem) -> Array64:
    """A contact pressure of a coarse grid on a finer one, shape (N,) of each; both 0 off the contact [p].

    patches, ends: of that pressure, see `grid.contact.contact_edges`.
    """
    num_points = finer.num_points
    if not patches.count:  # none that rounding leaves
        return np.zeros(num_points)
    factor = num_points / pressure.size
    coarse_curve = fine_curve = half_space_curve()
    # on layers thicker than the nodes that tell an edge the half-space's is right near it, and the rest is smooth
    if coarse.rigidity.thickness < UNRESOLVED_BELOW:
        coarse_curve, fine_curve = coarse.rigidity.edge_curve, finer.rigidity.edge_curve
    if patches.full:
        x = np.arange(num_points) / factor
        return np.asarray(np.interp(x, np.arange(pressure.size), pressure, period=pressure.size))
    # the nodes whose distance beyond the edge lies between -s and 1 - s
    beyond = 1 - fine_curve.shift
    first = np.ceil(factor * ends.left - beyond).astype(np.int64)
    fine = Patches(num_points, first, np.maximum(first, np.floor(factor * ends.right + beyond).astype(np.int64)))
    nodes = np.arange(int(fine.size.sum())) - np.repeat(fine.offset - first, fine.size)
    p = fine.label
    smooth = pressure[patches.nodes] / np.maximum(_edge_functions(coarse_curve, patches, ends, 1.0), 1e-3)
    coarse_nodes = np.arange(smooth.size) - np.repeat(patches.offset - patches.first, patches.size)
    values = np.interp(nodes / factor, coarse_nodes, smooth)
    values *= _edge_functions(fine_curve, fine, ends, factor)
    # every patch keeps its load, also where its nodes lie beyond its ends
    values = np.maximum(values, 0.0)
    lost = fine.sums(values) <= 0
    values[lost[p]] = 1.0
    values *= (factor * patches.sums(pressure[patches.nodes]) / fine.sums(values))[p]
    fine_pressure = np.zeros(num_points)
    # never 0: the node belongs to the contact
    fine_pressure[nodes % num_points] = np.maximum(values, 1e-12 * pressure.max())
    return fine_pressure


def _edge_functions(curve: EdgeCurve, patches: Patches, ends: Edges, factor: float) -> Array64:
    """The edge functions of both ends of the patches, multiplied, at their contact nodes; see `edge_function`.

    factor: grid spacings of the patches in one of the ends.
    """
    steps = np.arange(int(patches.size.max()))
    known, before = curve.at(steps), curve.at(steps - 1)  # of every step once, for all ends
    inside, p = np.arange(patches.label.size) - np.repeat(patches.offset, patches.size), patches.label

    def edge(beyond: Array64, j: Indices) -> Array64:
        beta = np.clip(beyond + curve.shift, 0, 1)[p]
        return np.asarray((1 - beta) * known[j] + beta * before[j])

    left, right = factor * ends.left - patches.first, patches.last - factor * ends.right
    return edge(left, inside) * edge(right, patches.size[p] - 1 - inside)
