"""A contact pressure carried over to a finer grid, where any method starts best.

At the edges of its patches the pressure goes like a square root, which no interpolation follows; divided by the edge
functions of both ends (`edge_curves.edge_function`, at the ends' sub-grid positions) it is smooth. So the smooth part
is interpolated (cubic) and multiplied by the edge functions of the fine grid. The fine contact set comes out right
except for a few nodes, and the error of the pressure is that of the coarse grid, not of the interpolation. On thin
layers, too, the edge functions are the half-space's: their own save no iteration.
"""

import numpy as np

from ..arrays import Array64, Indices
from ..grid.edge_curves import half_space_curve
from ..grid.edges import Edges
from ..grid.patches import Patches


def prolong(pressure: Array64, patches: Patches, ends: Edges, num_points: int) -> Array64:
    """A contact pressure, shape (N,), on a grid of `num_points`, shape (num_points,); both 0 off the contact [p].

    patches, ends: of that pressure, see `grid.contact.contact_edges`.
    """
    if not patches.count:  # none that rounding leaves
        return np.zeros(num_points)
    factor = num_points / pressure.size
    if patches.full:
        x = np.arange(num_points) / factor
        return np.asarray(np.interp(x, np.arange(pressure.size + 1), np.append(pressure, pressure[0])))
    # the nodes whose distance beyond the edge lies between -s and 1 - s
    beyond = 1 - half_space_curve().shift
    first = np.ceil(factor * ends.left - beyond).astype(np.int64)
    fine = Patches(num_points, first, np.maximum(first, np.floor(factor * ends.right + beyond).astype(np.int64)))
    nodes = np.arange(int(fine.size.sum())) - np.repeat(fine.offset - first, fine.size)
    p = fine.label
    smooth = pressure[patches.nodes] / np.maximum(_edge_functions(patches, ends, 1.0), 1e-3)
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
    values *= _edge_functions(fine, ends, factor)
    # every patch keeps its load; nodes may lie outside of where that says that the patch ends
    values = np.maximum(values, 0.0)
    lost = fine.sums(values) <= 0
    values[lost[p]] = 1.0
    values *= (factor * patches.sums(pressure[patches.nodes]) / fine.sums(values))[p]
    fine_pressure = np.zeros(num_points)
    # never 0: the node belongs to the contact
    fine_pressure[nodes % num_points] = np.maximum(values, 1e-12 * pressure.max())
    return fine_pressure


def _edge_functions(patches: Patches, ends: Edges, factor: float) -> Array64:
    """The edge functions of both ends of the patches, multiplied, at their contact nodes; see `edge_function`.

    factor: grid spacings of the patches in one of the ends.
    """
    curve, steps = half_space_curve(), np.arange(int(patches.size.max()))
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
