"""A contact pressure carried over to a finer grid, where any method starts best.

At the edges of its patches the pressure goes like a square root, which no interpolation follows; divided by the edge
functions of both ends (`edge_curves.edge_function`, at the ends' sub-grid positions) it is smooth. So the smooth part
is interpolated (cubic) and multiplied by the edge functions of the fine grid. The fine contact set comes out right but
for a few nodes, and the error of the pressure is that of the coarse grid, not of the interpolation.
"""

import numpy as np

from ..arrays import Array64, Indices
from ..grid.edge_curves import EdgeCurve, edge_curve, half_space_curve
from ..grid.edges import Edges
from ..grid.layer_on_grid import thickness_on_grid
from ..grid.patches import Patches
from ..scene import Scene

_THIN = 8.0  # grid spacings; on thicker layers the half-space's edge is right near the edge, and the rest is smooth


def prolong(scene: Scene, pressure: Array64, patches: Patches, ends: Edges, num_points: int) -> Array64:
    """A contact pressure, shape (N,), on a grid of `num_points`, shape (num_points,); both 0 off the contact [p].

    patches, ends: of that pressure, see `grid.contact.contact_edges`.
    """
    if not patches.count:  # none that rounding leaves
        return np.zeros(num_points)
    factor = num_points / pressure.size
    coarse_curve = fine_curve = half_space_curve()
    if thickness_on_grid(scene.layer, num_points, scene.period) <= _THIN:
        coarse_curve, fine_curve = (edge_curve(scene.layer, n, scene.period) for n in (pressure.size, num_points))
    if patches.full:
        x = np.arange(num_points) / factor
        return np.asarray(np.interp(x, np.arange(pressure.size + 1), np.append(pressure, pressure[0])))
    # the nodes whose distance beyond the edge lies between -s and 1 - s
    first = np.ceil(factor * ends.left - (1 - fine_curve.shift)).astype(np.int64)
    last = np.maximum(first, np.floor(factor * ends.right + (1 - fine_curve.shift)).astype(np.int64))
    fine = Patches(num_points, first, last)
    nodes = np.arange(int(fine.size.sum())) - np.repeat(fine.offset - first, fine.size)
    p = fine.label
    smooth = pressure[patches.nodes] / np.maximum(_edge_functions(coarse_curve, patches, ends, 1.0), 1e-3)
    # Newton's polynomial through up to four nodes of the patch
    x = nodes / factor - patches.first[p]
    base = np.clip(np.floor(x).astype(np.int64) - 1, 0, np.maximum(patches.size - 4, 0)[p])
    x -= base
    base += patches.offset[p]
    first_nodes, *differences = _differences(smooth, patches)
    values = np.zeros(x.size)
    for k, difference in reversed([*enumerate(differences)]):
        values = (values + difference[base]) * (x - k) / (k + 1)
    values += first_nodes[base]
    values *= _edge_functions(fine_curve, fine, ends, factor)
    # every patch keeps its load; nodes may lie outside of where that says that the patch ends
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


def _differences(values: Array64, patches: Patches) -> list[Array64]:
    """Values on contact nodes, and their first three forward differences; 0 for those that no patch of its size has."""
    found = [values]
    for k in range(1, 4):
        found.append(np.where(patches.size[patches.label] > k, np.diff(found[-1], append=0.0), 0.0))
    return found
