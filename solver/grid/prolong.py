"""A contact pressure of a coarse grid on a finer one.

At the ends of its patches it goes like a square root, which no interpolation follows. Divided by the edge functions of
both ends (`edge_curves`) it is smooth: that is interpolated, and multiplied by the edge functions of the fine grid.
"""

import numpy as np

from ..arrays import Array64, Indices
from .edge_curves import EdgeCurve, half_space_curve
from .edges import UNRESOLVED_BELOW, Edges
from .patches import Patches
from .problem import Problem


def prolong(coarse: Problem, pressure: Array64, patches: Patches, ends: Edges, finer: Problem) -> Array64:
    """A contact pressure of a coarse grid on a finer one, shape (N,) of each; both 0 off the contact [p].

    patches, ends: of that pressure, see `contact.contact_edges`.
    """
    fine_pressure, n = np.zeros(finer.num_points), coarse.num_points
    if not patches.count:  # none that rounding leaves
        return fine_pressure
    # on layers thicker than the nodes that tell an edge the half-space's is right near it, and the rest is smooth
    thick = coarse.layer.thickness >= UNRESOLVED_BELOW
    coarse_curve, curve = (half_space_curve() if thick else one.layer.edge_curve for one in (coarse, finer))
    factor, beyond = finer.num_points / n, 1 - curve.shift
    if patches.full:
        return np.asarray(np.interp(np.arange(finer.num_points) / factor, np.arange(n), pressure, period=n))
    left, right = factor * np.stack([ends.left, ends.right])
    first = np.ceil(left - beyond).astype(np.int64)
    fine = Patches(finer.num_points, first, np.maximum(first, np.floor(right + beyond).astype(np.int64)))
    smooth = pressure[patches.nodes] / _edge_functions(coarse_curve, patches, ends.left, ends.right)
    places = fine.step + first[fine.label]
    values = np.interp(places / factor, patches.step + patches.first[patches.label], smooth)
    values *= _edge_functions(curve, fine, left, right)
    values *= (factor * patches.sums(pressure[patches.nodes]) / fine.sums(values))[fine.label]  # each keeps its load
    fine_pressure[places % finer.num_points] = values
    return fine_pressure


def _edge_functions(curve: EdgeCurve, patches: Patches, left: Array64, right: Array64) -> Array64:
    """Of both ends of each patch, left and right [grid spacings], multiplied, at its contact nodes, 1e-3 at least."""
    known = curve.at(np.arange(-1, int(patches.size.max())))  # of every step once, from -1 on

    def edge(theta: Array64, j: Indices) -> Array64:
        beta = np.clip(theta + curve.shift, 0, 1)[patches.label]
        return np.asarray((1 - beta) * known[j + 1] + beta * known[j])

    from_last = patches.size[patches.label] - 1 - patches.step
    return np.maximum(edge(left - patches.first, patches.step) * edge(patches.last - right, from_last), 1e-3)
