"""Where a contact ends: by the pressures at its ends, the loads of its patches or the gaps between them, whichever
knows it better.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import Array64, Indices, Mask
from ..calibration import FITTED
from .cached import MOST_POINTS
from .edges import UNRESOLVED_BELOW, UNRESOLVED_ERROR, Edges, find_edges
from .few_nodes import MOST_NODES
from .narrow import Surface, from_loads, gap_ends
from .patches import Patches
from .problem import Problem
from .shares import shared_loads
from .unseen import unseen_gaps, unseen_patches

_JAGGED = 1.9
"""Fourth over second difference of given heights, or at a gap, from which they do not tell the heights between them; 2
for a wave of four grid spacings, and at a kink."""
_LOADS_KNOW_BEST = 10
"""Nodes of patches up to which loads tell the ends better than pressures do, whatever their estimated errors."""


class Contact(NamedTuple):
    """The contact on a grid."""

    problem: Problem
    pressure: Array64
    """Contact pressure, 0 off the contact, shape (N,) [any unit]."""
    patches: Patches
    ends: Edges


def contact_edges(problem: Problem, pressure: Array64, displacement: Array64 | None = None) -> Contact:
    """Patches and their sub-grid edges, from the contact pressure [any unit], 0 off the contact, shape (N,).

    displacement: u, shape (N,) [length], with which loads and gaps tell where narrow patches end; None: pressures alone
    tell the ends, in half of the time.
    """
    n, indenter, layer = problem.num_points, problem.indenter, problem.layer
    scale = problem.scene.reduced_load / (float(pressure.mean()) or 1.0)
    patches = Patches.of(pressure > 0)
    inside = pressure[patches.nodes] * scale
    edges, unseen = _apart(find_edges(patches, inside, layer, indenter.of.steepness), n), 0.0
    if displacement is not None and patches.count and not patches.full:
        surface = Surface(problem.profile, displacement, pressure, n / problem.scene.period, scale)
        edges = _by_loads(problem, surface, patches, edges)
        edges = edges if indenter.exponent else _by_gaps(problem, surface, patches, edges)  # kinks of power profiles
        unseen = unseen_patches(patches, problem.profile, displacement, layer.thickness > 0)
    unseen += unseen_gaps(patches, inside, kinks=indenter.of.kinked or not indenter.shortest_wave)
    # all ends, those of other patches by the share of the load
    at_tip = np.flatnonzero((patches.first <= n // 2) & (n // 2 <= patches.last) | (patches.count == 1))
    tip = indenter.of.end_error(float(edges.width[at_tip[0]])) if at_tip.size else 0.0
    error = np.where(edges.by_load & (indenter.of.steepness > 1), edges.end_errors, np.maximum(edges.end_errors, tip))
    if patches.count > 1:  # loads have errors of all ends
        error = error + np.where(edges.by_load, error.mean(), 0.0)
    return Contact(problem, pressure, patches, replace(edges, end_errors=error, unseen=unseen))


def _by_loads(problem: Problem, surface: Surface, patches: Patches, edges: Edges) -> Edges:
    """Edges with those ends of narrow patches that their loads tell better than their pressures."""
    n, layer, resolved = patches.num_points, problem.layer, problem.layer.thickness > 0
    chosen = np.flatnonzero(patches.size <= min(MOST_NODES if resolved else UNRESOLVED_BELOW - 1, n / 2))
    if not chosen.size:
        return edges
    pressure = surface.pressure[patches.nodes] * surface.scale
    first, size, loads = patches.first[chosen], patches.size[chosen], patches.sums(pressure)[chosen]
    gap = patches.gap.min(axis=0)[chosen]
    begin = (edges.left + edges.right)[chosen] / 2, np.minimum(edges.width[chosen], size) / 2
    found = from_loads(surface, first, size, gap, loads, begin, layer)
    error = np.full(size.size, UNRESOLVED_ERROR)  # unless resolved not known better than by counting, but narrower
    if resolved:
        error = FITTED.of_heights * (found.uneven[1] + 1 / gap**2) + FITTED.of_layer * size**3 / layer.thickness**4
        if patches.count > 1 and n <= MOST_POINTS and found.solved.any():
            shared = shared_loads(patches, chosen, pressure, found, layer.around_node)[chosen]
            error = np.where(shared > 0, error, UNRESOLVED_ERROR)
            loads = np.where(shared > 0, shared, loads)
            found = from_loads(surface, first, size, gap, loads, (found.middle, found.half_width), layer)
    at = np.stack([chosen, patches.count + chosen])
    given = problem.indenter.of.given_points is not None  # heights are known at nodes only
    solved = found.solved & ~(given & (found.uneven[0] > _JAGGED))
    edges, better = _bettered(edges, patches, at, found.both, error, solved, best=size <= _LOADS_KNOW_BEST)
    unresolved, by_load = edges.unresolved.copy(), edges.by_load.copy()
    unresolved[chosen[better]], by_load[chosen[better]] = False, resolved
    return replace(edges, unresolved=unresolved, by_load=by_load)


def _by_gaps(problem: Problem, surface: Surface, patches: Patches, edges: Edges) -> Edges:
    """Edges with those ends of patches on both sides of a narrow gap that the gap tells better than they do."""
    n, gap, narrower = patches.num_points, patches.gap[1], np.minimum(patches.size, np.roll(patches.size, -1))
    before = np.flatnonzero((gap <= np.minimum(narrower, MOST_NODES)) & (narrower >= UNRESOLVED_BELOW))
    thickness = problem.layer.thickness
    if not before.size or not thickness:
        return edges
    behind = (before + 1) % patches.count
    beyond = np.where(behind == 0, n, 0)
    first, size = patches.last[before] + 1, gap[before]
    found = gap_ends(surface, first, size, narrower[before], edges.right[before], edges.left[behind] + beyond)
    error = FITTED.of_heights_at_gaps * found.uneven[0] + FITTED.of_layer * size / thickness**2
    left, right = found.both
    at, ends = np.stack([patches.count + before, behind]), np.stack([left, right - beyond])
    edges, better = _bettered(edges, patches, at, ends, error, found.solved & (found.uneven[0] <= _JAGGED))
    by_gap = edges.by_gap.copy()
    by_gap[before[better]] = True
    return replace(edges, by_gap=by_gap)


def _bettered(
    edges: Edges, patches: Patches, at: Indices, ends: Array64, error: Array64, solved: Mask, best: Mask | bool = False
) -> tuple[Edges, Mask]:
    """Edges with those pairs of ends that are the best ones, or known better, and lie less than half a spacing inside
    the last nodes of their patches, or less than one outside, where the next nodes do not touch; and which pairs.

    at: their places among all left and all right ends, shape (2, pairs); ends: new ones, of that shape; error: of
    both, without the least, shape (pairs,) [grid spacings]; solved: which there are; best: which to take whatever the
    errors.
    """
    error = np.minimum(FITTED.always + error, UNRESOLVED_ERROR)
    places, errors = np.append(edges.left, edges.right), edges.end_errors.ravel().copy()
    inside = (ends - np.append(patches.first, patches.last)[at]) * np.where(at < patches.count, 1, -1)
    better = solved & (best | (2 * error <= errors[at].sum(axis=0)))
    better &= ((inside > -1) & (inside < 0.5)).all(axis=0)
    at = at[:, better]
    places[at] = ends[:, better]
    errors[at] = error[better]
    left, right = places.reshape(2, -1)
    return _apart(replace(edges, left=left, right=right, end_errors=errors.reshape(2, -1)), patches.num_points), better


def _apart(edges: Edges, num_points: int) -> Edges:
    """Edges in a period of `num_points` spacings, those of neighbours not beyond each other."""
    left, right = edges.left, edges.right
    overlap = np.maximum(right - np.append(left[1:], left[:1] + num_points), 0.0) / 2
    return replace(edges, left=left + np.append(overlap[-1:], overlap[:-1]), right=right - overlap)
