"""Where a contact ends: by the pressures at its ends or by the loads of its patches, whichever knows it better."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from ..arrays import Array64, Indices
from ..layers import ElasticLayer
from ..scene import Scene
from .edges import COUNTED_BELOW, Edges, apart, find_edges, unseen_gaps
from .few_nodes import MOST_NODES
from .gaps import gap_ends
from .heights import Heights
from .layer_on_grid import modulus_on_grid
from .loads import from_loads, level_error
from .patches import Patches
from .shares import MOST_PATCHES, layer_response, shared_loads
from .surroundings import Surroundings

_RESOLVED = 0.2  # logarithm of the shortest wave's modulus over the half-space's, up to which a grid resolves a layer
_JAGGED = 1.9  # fourth over second difference of the heights; 2 for a wave of four grid spacings
_FARTHEST = 0.5  # grid spacings by which the two may differ for the load to be believed

# The estimated error of a width by the load [grid spacings]: fitted so that it holds in 97 of 100 patches of rough
# surfaces with 4 to 32 points to the shortest wave, on half-spaces, layers of one spacing and more, and coatings.
_ALWAYS = 0.0013
_OF_SIXTH, _MOST_SIXTH = 0.045, 2.0  # of the sixth over the second difference of the heights, up to so much of that
_OVER_GAP_SQUARED = 0.1  # over the square of the nodes between neighbouring patches
_OF_THICKNESS = 1.0  # of s/(1 + s), s = r^2/(1 + r) d^-1.5, d the thickness [grid spacings] and r the nodes over that
_ESTIMATED = 0.3  # of the nodes of a patch on a layer that the grid does not resolve; half of how far from them it ends
# The same of a gap, of 95 of 100 under loads of 0.1 to 0.95 of full contact.
_ALWAYS_OF_GAP = 0.0005
_OF_FOURTH, _MOST_FOURTH = 0.15, 2.0  # of the fourth over the second difference of the heights, up to so much of
# that; twice as much of a gap of one node, half more of one of two, and so on
_OVER_THICKNESS_SQUARED = 0.8  # [grid spacings]

_SECOND_FOURTH_SIXTH = np.array([[0, 0, 1, -2, 1, 0, 0], [0, 1, -4, 6, -4, 1, 0], [1, -6, 15, -20, 15, -6, 1]]).T
_SHORT = 8  # nodes
_FEW, _MANY = (np.polynomial.legendre.leggauss(points) for points in (8, 32))
"""Places and weights of the integral of h'^2 over patches of up to so many nodes, and over others."""


def contact_edges(
    scene: Scene,
    pressure: Array64,
    profile: Array64 | None = None,
    displacement: Array64 | None = None,
) -> tuple[Patches, Edges]:
    """Patches and their sub-grid edges, from the contact pressure [any unit], 0 off the contact, shape (N,), any N.

    profile: h, shape (N,) [length], if it is at hand. displacement: u, shape (N,) [length], with which loads tell where
    narrow patches end; None: pressures alone tell the ends, in half of the time.
    """
    if profile is None:
        profile = scene.period * scene.indenter.profile(pressure.size, scene.period)
    scale = scene.reduced_load / (float(pressure.mean()) or 1.0)
    patches, edges = ends(scene.layer, scene.period, profile, pressure, scale, displacement)
    # both ends, the same way; no width is known worse than by counting; patches beside each other have left the tip
    tip = min(2 * scene.indenter.tip_error(float(edges.width[0])), 1.0) if patches.count == 1 else 0.0
    unseen = unseen_gaps(patches, pressure[patches.nodes])
    return patches, replace(edges, end_errors=np.hypot(edges.end_errors, tip * math.sqrt(0.5)), unseen=unseen)


def ends(
    layer: ElasticLayer,
    period: float,
    profile: Array64,
    pressure: Array64,
    scale: float,
    displacement: Array64 | None = None,
) -> tuple[Patches, Edges]:
    """Patches and their sub-grid edges. profile: h [length], pressure: 0 off the contact, both shape (N,); scale: what
    makes of that pressure the one over E*; displacement: as in `contact_edges`.
    """
    patches = Patches.of(pressure > 0)
    inside = pressure[patches.nodes] * scale
    edges = find_edges(patches, inside, layer, period)
    if displacement is None or patches.full or not patches.count:
        return patches, edges
    spacings = pressure.size / period
    heights, surface = Heights(profile, spacings), displacement * spacings
    edges = _by_loads(layer, period, patches, edges, inside, surface, heights)
    edges = _by_gaps(layer, period, patches, edges, pressure * scale, surface, heights)
    return patches, _with_slopes(edges, heights)


def _by_loads(
    layer: ElasticLayer,
    period: float,
    patches: Patches,
    edges: Edges,
    pressure: Array64,
    displacement: Array64,
    heights: Heights,
) -> Edges:
    """Edges with those ends of narrow patches that their loads tell better than their pressures.

    pressure: over E*, on the contact nodes in compact order; displacement: shape (N,) [grid spacings].
    """
    n = displacement.size
    unlike = _unlike(layer, n, period)
    resolved = unlike < _RESOLVED
    chosen = np.flatnonzero(patches.size <= min(MOST_NODES if resolved else COUNTED_BELOW - 1, n / 2))
    if not chosen.size:
        return edges
    around = Surroundings.of_patches(patches, chosen, pressure, displacement)
    loads, start = patches.sums(pressure), _start(patches, edges, pressure, heights)[chosen]
    modulus = None if resolved else partial(modulus_on_grid, layer, num_points=n, period=period)
    found = from_loads(around, heights, loads[chosen], start, modulus)
    if resolved and found.solved.any() and 1 < patches.count <= MOST_PATCHES:
        level = level_error(found, around, heights, loads[chosen])
        loads = shared_loads(patches, chosen, pressure, found, level, layer_response(layer, n, period))
        found = from_loads(around, heights, loads[chosen], found.half_width, None)
    left, right = found.centre - found.half_width, found.centre + found.half_width
    fourth, sixth = _differences(heights.profile, _middles(patches, chosen))
    if resolved:
        error = _estimated(patches, chosen, sixth.max(axis=0), layer.thickness / period * n)
    else:
        nodes = patches.size[chosen]
        error = np.asarray(np.maximum(_ESTIMATED * nodes, np.abs(nodes - 2 * found.half_width) / 2), np.float64)
    differ = np.maximum(np.abs(left - edges.left[chosen]), np.abs(right - edges.right[chosen]))
    better = found.solved & (error < edges.error[chosen])
    better &= differ < np.where(edges.counted[chosen], patches.size[chosen], _FARTHEST)
    better &= ~(fourth.min(axis=0) > _JAGGED)
    lefts, rights, errors = edges.left.copy(), edges.right.copy(), edges.end_errors.copy()
    counted, by_load, which = edges.counted.copy(), np.zeros(patches.count, dtype=bool), chosen[better]
    lefts[which], rights[which], errors[:, which] = left[better], right[better], error[better] * math.sqrt(0.5)
    counted[which], by_load[which] = False, True
    lefts, rights = apart(lefts, rights, n)
    return Edges(lefts, rights, errors, counted, by_load)


def _by_gaps(
    layer: ElasticLayer,
    period: float,
    patches: Patches,
    edges: Edges,
    pressure: Array64,
    displacement: Array64,
    heights: Heights,
) -> Edges:
    """Edges with those ends of patches on both sides of a narrow gap that the gap tells better than they do.

    pressure: over E*; displacement: [grid spacings]; both of shape (N,).
    """
    n = pressure.size
    after = (np.arange(patches.count) + 1) % patches.count
    size = patches.to_neighbours[1] - 1
    narrow = size <= np.minimum(np.minimum(patches.size, patches.size[after]), MOST_NODES)
    narrow &= np.minimum(patches.size, patches.size[after]) >= COUNTED_BELOW
    if not narrow.any() or _unlike(layer, n, period) >= _RESOLVED:
        return edges
    before = np.flatnonzero(narrow)
    gaps = Patches.of(pressure == 0)
    chosen = np.searchsorted(gaps.first, (patches.last[before] + 1) % n)
    opening = heights.profile[gaps.nodes] * heights.scale - displacement[gaps.nodes]
    closed = Surroundings.of_gaps(gaps, chosen, opening, pressure)
    behind = after[before]
    moved = (patches.last[before] + 1) - gaps.first[chosen]  # whole periods
    left, right = edges.right[before], edges.left[behind]
    right = right + np.where(right < left, n, 0)
    found = gap_ends(closed, left - moved, right - moved)
    fourth, _ = _differences(heights.profile, _middles(gaps, chosen))
    error = _ALWAYS_OF_GAP + _OF_FOURTH * np.minimum(fourth.max(axis=0), _MOST_FOURTH) * (1 + 1 / size[before])
    error += _OVER_THICKNESS_SQUARED / (layer.thickness / period * n) ** 2
    known = np.hypot(edges.end_errors[1, before], edges.end_errors[0, behind])
    differ = np.maximum(np.abs(found.left + moved - left), np.abs(found.right + moved - right))
    better = found.solved & (error < known) & (differ < _FARTHEST)
    lefts, rights, errors = edges.left.copy(), edges.right.copy(), edges.end_errors.copy()
    one, other = before[better], behind[better]
    rights[one] += (found.left + moved - left)[better]
    lefts[other] += (found.right + moved - right)[better]
    errors[1, one] = errors[0, other] = error[better] * math.sqrt(0.5)
    return replace(edges, left=lefts, right=rights, end_errors=errors)


def _unlike(layer: ElasticLayer, num_points: int, period: float) -> float:
    """Logarithm of the stiffness for the grid's shortest wave over the half-space's, taken positive (dimensionless)."""
    return abs(math.log(modulus_on_grid(layer, np.array([np.pi]), num_points, period)[0]))


def _start(patches: Patches, edges: Edges, pressure: Array64, heights: Heights) -> Array64:
    """Half-widths to begin with, shape (M,) [grid spacings]; patches whose nodes are counted begin with Hertz' law."""
    _, curvature = heights.slope_in_the_middle((patches.first + patches.last) / 2)
    hertz = np.sqrt(4 / math.pi * patches.sums(pressure)) / np.sqrt(np.maximum(curvature, 1e-300))  # no overflow
    return np.where(edges.counted, np.clip(hertz, 0.05, patches.size), edges.width / 2)


def _estimated(patches: Patches, chosen: Indices, sixth: Array64, thickness: float) -> Array64:
    """Estimated errors of the widths of the chosen patches, shape (patches,) [grid spacings].

    sixth: over the second difference of the heights, of their shape; thickness: of the layer [grid spacings].
    """
    before, after = patches.to_neighbours[:, chosen] - 1
    wide = patches.size[chosen] / thickness
    of_layer = wide**2 / (1 + wide) / thickness**1.5
    error = _ALWAYS + _OF_SIXTH * np.minimum(sixth, _MOST_SIXTH) + _OF_THICKNESS * of_layer / (1 + of_layer)
    return np.asarray(error + _OVER_GAP_SQUARED * (1 / before**2 + 1 / after**2))


def _middles(runs: Patches, chosen: Indices) -> Indices:
    """The middle nodes of runs of nodes, twice the same where their number is odd, shape (2, runs)."""
    twice = (runs.first + runs.last)[chosen]
    return np.stack([twice // 2, (twice + 1) // 2])


def _differences(profile: Array64, nodes: Indices) -> tuple[Array64, Array64]:
    """Fourth and sixth over second differences of the profile at nodes, taken positive, of their shape: how little the
    nodes tell of the heights between them.
    """
    at = profile[(nodes[..., None] + np.arange(-3, 4)) % profile.size]
    second, fourth, sixth = np.abs(at @ _SECOND_FOURTH_SIXTH).T
    with np.errstate(divide="ignore", invalid="ignore"):
        return fourth.T / second.T, sixth.T / second.T


def _with_slopes(edges: Edges, heights: Heights) -> Edges:
    """Edges with the integral of h'^2 over the patches whose ends their loads tell."""
    if edges.by_load is None or not edges.by_load.any():
        return edges
    squared = np.full(edges.left.size, np.nan)
    for (places, weights), wide in ((_FEW, edges.width <= _SHORT), (_MANY, edges.width > _SHORT)):
        which = edges.by_load & wide
        half = edges.width[which, None] / 2
        slope = heights.slope((edges.left + edges.right)[which, None] / 2 + half * places)[0]
        squared[which] = (slope**2 * half) @ weights
    return replace(edges, squared_slope=squared)
