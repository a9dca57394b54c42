"""Nested grids: a coarse solution, carried over to the next finer grid, is where any method starts best.

What is carried over is the contact pressure, patch by patch. At its edges it goes like a square root, which no
interpolation follows; divided by the universal edge functions of both ends (`edges.edge_function`, at the ends'
sub-grid positions) it is smooth. So the smooth part is interpolated (cubic) and multiplied by the edge functions of the
fine grid. The fine contact set comes out right but for a few nodes, and the error of the pressure is that of the coarse
grid, not of the interpolation.
"""

from dataclasses import asdict, dataclass, replace

import numpy as np

from .edges import EdgeCurve, Edges, edge_curve, edge_function, layer_curve
from .observables import Observables, subgrid_measures
from .patches import Array64, Indices, Patches
from .relaxation import Method
from .scene import Scene

FACTOR = 4
COARSEST = 512  # at least


def grids(num_points: int) -> list[int]:
    """Grid sizes from coarse to fine, each about four times the one before; the coarser ones are even."""
    sizes = [num_points]
    while sizes[0] // FACTOR >= COARSEST:
        sizes.insert(0, 2 * round(sizes[0] / FACTOR / 2))
    return sizes


def prolong(scene: Scene, pressure: Array64, patches: Patches, ends: Edges, num_points: int) -> Array64:
    """A contact pressure, shape (N,), on a grid of `num_points`, shape (num_points,); both 0 off the contact [p].

    patches, ends: of that pressure, see `observables.contact_edges`.
    """
    factor, nu = num_points / pressure.size, scene.layer.poisson_ratio
    thickness = scene.layer.thickness / scene.period * num_points
    fine_curve = edge_curve(thickness, nu)
    coarse_curve = layer_curve(thickness / factor, nu) if fine_curve.rows is None else fine_curve  # of one kind
    if patches.full:
        x = np.arange(num_points) / factor
        return np.asarray(np.interp(x, np.arange(pressure.size + 1), np.append(pressure, pressure[0])))
    # the nodes whose distance beyond the edge lies between -s and 1 - s
    first = np.ceil(factor * ends.left - (1 - fine_curve.shift)).astype(np.int64)
    last = np.maximum(first, np.floor(factor * ends.right + (1 - fine_curve.shift)).astype(np.int64))
    fine = Patches(num_points, first, last)
    nodes = np.arange(int(fine.size.sum())) - np.repeat(fine.offset - first, fine.size)
    p = fine.label

    def edges_at(at: Patches, inside: Indices, scale: float, curve: EdgeCurve) -> Array64:
        left = np.clip(scale * ends.left - at.first + curve.shift, 0, 1)[at.label]
        right = np.clip(at.last - scale * ends.right + curve.shift, 0, 1)[at.label]
        return edge_function(curve, left, inside) * edge_function(curve, right, at.size[at.label] - 1 - inside)

    steps = np.arange(patches.nodes.size) - np.repeat(patches.offset, patches.size)
    smooth = pressure[patches.nodes] / np.maximum(edges_at(patches, steps, 1.0, coarse_curve), 1e-3)
    # Lagrange's polynomial through up to four nodes of the patch
    x = nodes / factor - patches.first[p]
    count = np.minimum(patches.size, 4)[p]
    base = np.clip(np.floor(x).astype(np.int64) - 1, 0, patches.size[p] - count)
    x -= base
    base += patches.offset[p]
    values = np.zeros(x.size)
    for k in range(4):
        basis = (k < count).astype(np.float64)
        for m in range(4):
            if m != k:
                basis *= np.where(m < count, (x - m) / (k - m), 1.0)
        values += basis * smooth[np.minimum(base + k, smooth.size - 1)]
    values *= edges_at(fine, nodes - first[p], factor, fine_curve)
    values *= factor * pressure.sum() / values.sum()
    fine_pressure = np.zeros(num_points)
    # never 0: the node belongs to the contact
    fine_pressure[nodes % num_points] = np.maximum(values, 1e-12 * pressure.max())
    return fine_pressure


@dataclass(frozen=True)
class Level:
    """What a coarser grid gave: sub-grid contact area and kappa (dimensionless), and what it took there."""

    num_points: int
    contact_area_subgrid: float
    kappa_subgrid: float
    iterations: int
    transform_pairs: float

    def to_dict(self) -> dict[str, float]:
        """JSON-ready, without the number of points."""
        return {name: value for name, value in asdict(self).items() if name != "num_points"}


def measure_level(scene: Scene, patches: Patches, ends: Edges, state: Method) -> Level:
    """The level of a state that has been relaxed on a coarser grid; patches, ends: of its contact pressure."""
    n = state.problem.num_points
    area, _, kappa, _ = subgrid_measures(scene, patches, ends, scene.indenter.slope(n, scene.period) ** 2)
    return Level(n, area, kappa, state.iteration, round(state.transform_pairs, 3))


def discretisation_error(observables: Observables, levels: list[Level]) -> Observables:
    """Add what the last coarser grid says about the error of the finest one.

    The sub-grid area converges faster than dx; if it were dx only, a third of the change would be left.
    """
    if not levels:
        return observables
    last, o = levels[-1], observables
    area = abs(o.contact_area_subgrid - last.contact_area_subgrid) / (FACTOR - 1)
    kappa = abs(o.kappa_subgrid - last.kappa_subgrid) / (FACTOR - 1)
    return replace(
        o,
        contact_area_discretisation_error=area,
        kappa_discretisation_error=kappa,
        contact_area_error=o.contact_area_error + area,
        kappa_error=o.kappa_error + kappa,
    )


def iteration_share(free_residual: float) -> float:
    """Estimated relative error of a_r that a free residual leaves.

    Measured: up to 0.12 of residuals below 1e-3; 0.8 of one of 0.03, and of no meaning beyond.
    """
    return min(1.0, (0.25 + 30 * free_residual) * free_residual)


def iteration_error(observables: Observables, free_residual: float) -> Observables:
    """Add what an unfinished iteration leaves."""
    area = iteration_share(free_residual) * observables.contact_area_subgrid
    sensitivity = observables.kappa_subgrid / observables.contact_area_subgrid if area else 0.0
    return replace(
        observables,
        contact_area_error=observables.contact_area_error + area,
        kappa_error=observables.kappa_error + 2 * sensitivity * area,
    )
