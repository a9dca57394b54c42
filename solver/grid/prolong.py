"""A contact pressure of a coarse grid on a finer one.

At the edges of its patches it goes like a square root, which no interpolation follows; divided by the edge functions of
both ends (`edge_curves.edge_functions`, at the ends' sub-grid positions) it is smooth. So the smooth part is
interpolated and multiplied by the edge functions of the fine grid. The fine contact set comes out right except for a
few nodes, and the error of the pressure is that of the coarse grid.
"""

import numpy as np

from ..arrays import Array64
from .edge_curves import edge_functions, half_space_curve
from .edges import UNRESOLVED_BELOW, Edges
from .patches import Patches
from .problem import Problem


def prolong(coarse: Problem, pressure: Array64, patches: Patches, ends: Edges, finer: Problem) -> Array64:
    """A contact pressure of a coarse grid on a finer one, shape (N,) of each; both 0 off the contact [p].

    patches, ends: of that pressure, see `contact.contact_edges`.
    """
    num_points = finer.num_points
    if not patches.count:  # none that rounding leaves
        return np.zeros(num_points)
    factor = num_points / pressure.size
    coarse_curve = fine_curve = half_space_curve()
    # on layers thicker than the nodes that tell an edge the half-space's is right near it, and the rest is smooth
    if coarse.layer.thickness < UNRESOLVED_BELOW:
        coarse_curve, fine_curve = coarse.layer.edge_curve, finer.layer.edge_curve
    if patches.full:
        x = np.arange(num_points) / factor
        return np.asarray(np.interp(x, np.arange(pressure.size), pressure, period=pressure.size))
    # the nodes whose distance beyond the edge lies between -s and 1 - s
    beyond = 1 - fine_curve.shift
    first = np.ceil(factor * ends.left - beyond).astype(np.int64)
    fine = Patches(num_points, first, np.maximum(first, np.floor(factor * ends.right + beyond).astype(np.int64)))
    nodes = np.arange(int(fine.size.sum())) - np.repeat(fine.offset - first, fine.size)
    p = fine.label
    smooth = pressure[patches.nodes] / np.maximum(edge_functions(coarse_curve, patches, ends.left, ends.right), 1e-3)
    coarse_nodes = np.arange(smooth.size) - np.repeat(patches.offset - patches.first, patches.size)
    values = np.interp(nodes / factor, coarse_nodes, smooth)
    values *= edge_functions(fine_curve, fine, factor * ends.left, factor * ends.right)
    # every patch keeps its load, also where its nodes lie beyond its ends
    values = np.maximum(values, 0.0)
    lost = fine.sums(values) <= 0
    values[lost[p]] = 1.0
    values *= (factor * patches.sums(pressure[patches.nodes]) / fine.sums(values))[p]
    fine_pressure = np.zeros(num_points)
    # never 0: the node belongs to the contact
    fine_pressure[nodes % num_points] = np.maximum(values, 1e-12 * pressure.max())
    return fine_pressure
