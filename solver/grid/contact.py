"""Where a contact ends: by the pressures at its ends or by the loads of its patches, whichever knows it better."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from ..arrays import Array64, Indices, Mask
from ..layers import ElasticLayer
from ..scene import Scene
from .edges import COUNTED_BELOW, Edges, apart, find_edges, unseen_gaps
from .few_nodes import MOST_NODES, response
from .heights import Heights
from .kept import kept
from .layer_on_grid import modulus_on_grid, thickness_on_grid
from .layer_slope import LayerSlope, loads_tell
from .loads import FromLoads, from_loads
from .patches import Patches

_NARROW = 0.2  # layer thicknesses; wider patches can only be estimated by their load
_THINNEST = 1e-9  # grid spacings; as if a thinner layer were so thick
_JAGGED = 1.9  # fourth over second difference of the heights; 2 for a wave of four grid spacings
_FARTHEST = 0.5  # grid spacings by which the two may differ for the load to be believed

# The estimated error of a width by the load [grid spacings]: fitted so that it holds in 95 of 100 patches of rough
# surfaces with 4 to 32 points to the shortest wave, on half-spaces and layers.
_OVER_SIZE_SQUARED, _OF_SKEW, _OF_BEND = 0.14, 0.5, 0.2  # over the squared nodes; of the squared skew; of the bend
_OF_THICKNESS = 2.0  # of the fourth power of the width over the thickness, and of the width
_OF_OTHERS = 0.05  # of the nodes, and of the share of the slope's change by other patches, taken as Hertz contacts
_OVER_GAP_SQUARED = 0.2  # over the square of the nodes between neighbouring patches
_ESTIMATED = 0.2  # of the nodes of a patch that is not narrow
_ON_SOFT = 2.0  # times all that on a base much softer than the layer

_AT, _WEIGHTS = np.polynomial.legendre.leggauss(6)  # of the integral of h'^2


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
    return patches, replace(edges, error=np.hypot(edges.error, tip), unseen=unseen)


@kept
def _layer_slope(layer: ElasticLayer, num_points: int, period: float) -> LayerSlope:
    """The layer's part of the response, on a grid of that many points."""
    thickness = max(thickness_on_grid(layer, num_points, period), _THINNEST)
    return LayerSlope.of(partial(modulus_on_grid, layer, num_points=num_points, period=period), thickness, num_points)


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
    n = pressure.size
    patches, layer_thickness = Patches.of(pressure > 0), thickness_on_grid(layer, n, period)
    inside = pressure[patches.nodes] * scale
    edges = find_edges(patches, inside, layer, period)
    largest = min(MOST_NODES, max(_NARROW * layer_thickness, COUNTED_BELOW - 1))
    chosen = np.flatnonzero(patches.size <= min(largest, n / 2))
    modulus = partial(modulus_on_grid, layer, num_points=n, period=period)
    tell = chosen.size and loads_tell(modulus, layer.thickness / period * n, n)
    if displacement is None or not tell:
        return patches, edges
    heights, thickness = Heights(profile, n / period), max(layer_thickness, _THINNEST)
    wide = patches.size[chosen] / thickness
    narrow = wide < _NARROW

    # patches without ends begin with Hertz' law
    _, curvature = heights.slope_in_the_middle((patches.first + patches.last) / 2)
    hertz = np.sqrt(4 / math.pi * patches.sums(inside)) / np.sqrt(np.maximum(curvature, 1e-300))  # no overflow
    start = np.where(edges.counted, np.clip(hertz, 0.05, patches.size), edges.width / 2)
    layer_slope = _layer_slope(layer, n, period)
    slope = _slope_by_others(patches, chosen, inside, displacement, n / period)
    found = from_loads(patches, chosen, narrow, inside, heights, modulus, layer_slope, start, slope)
    left, right = found.centre - found.half_width, found.centre + found.half_width
    error = _estimated(patches, chosen, found, wide) * (_ON_SOFT if layer_slope.is_soft else 1.0)
    differ = np.maximum(np.abs(left - edges.left[chosen]), np.abs(right - edges.right[chosen]))
    better = found.solved & (error < edges.error[chosen])
    better &= differ < np.where(edges.counted[chosen], patches.size[chosen], _FARTHEST)
    twice_middle = (patches.first + patches.last)[chosen]
    better &= ~(_jagged(profile, twice_middle // 2) & _jagged(profile, (twice_middle + 1) // 2))
    by_load = np.zeros(patches.count, dtype=bool)
    by_load[chosen[better & narrow]] = True
    return patches, _with(edges, chosen[better], left[better], right[better], error[better], by_load, heights)


def _slope_by_others(
    patches: Patches, chosen: Indices, pressure: Array64, displacement: Array64, scale: float
) -> Array64:
    """Mean slope that all other patches add to the displacement into the layer, from the node before each chosen patch
    to that behind it, shape (patches,) (dimensionless).

    scale: what makes grid spacings of the displacement's unit. What the patch's own pressure adds on a half-space's
    grid is taken off.
    """
    first, last, size = patches.first[chosen], patches.last[chosen], patches.size[chosen, None]
    before, after = displacement[first - 1], displacement[(last + 1) % displacement.size]
    steps = np.arange(int(size.max()))
    node = np.minimum(patches.offset[chosen, None] + steps, pressure.size - 1)
    own, near = np.where(steps < size, pressure[node], 0.0), response()[1:]
    rise = (own * (near[np.abs(size - 1 - steps)] - near[steps])).sum(axis=1)
    return np.asarray(-((after - before) * scale + rise) / (size[:, 0] + 1))


def _estimated(patches: Patches, chosen: Indices, found: FromLoads, wide: Array64) -> Array64:
    """Estimated errors of the widths of the chosen patches, shape (patches,) [grid spacings]. wide: their nodes over
    the layer's thickness.
    """
    size = patches.size[chosen]
    error = _OVER_SIZE_SQUARED / size**2 + _OF_SKEW * found.skew**2 + _OF_BEND * found.bend
    error += _OF_OTHERS * size * found.by_others
    error += np.where(wide < _NARROW, _OF_THICKNESS * size * wide**4, _ESTIMATED * size)
    before, after = patches.to_neighbours[:, chosen] - 1
    return np.asarray(error + _OVER_GAP_SQUARED * (1 / before**2 + 1 / after**2))


def _jagged(profile: Array64, nodes: Indices) -> Mask:
    """Where the profile has steps or noise from node to node, so that no polynomial tells it between them."""
    at = profile[(nodes[:, None] + np.arange(-2, 3)) % profile.size]
    second, fourth = at @ np.array([0, 1, -2, 1, 0]), at @ np.array([1, -4, 6, -4, 1])
    return np.asarray(np.abs(fourth) > _JAGGED * np.abs(second))


def _with(
    edges: Edges, which: Indices, left: Array64, right: Array64, error: Array64, by_load: Mask, heights: Heights
) -> Edges:
    """Edges with other ends of some patches. error: of their widths; by_load: as in `Edges`."""
    lefts, rights, errors = (values.copy() for values in (edges.left, edges.right, edges.error))
    counted = edges.counted.copy()
    lefts[which], rights[which], errors[which], counted[which] = left, right, error, False
    lefts, rights = apart(lefts, rights, heights.profile.size)
    half = (rights - lefts)[which, None] / 2
    slope = heights.slope((lefts + rights)[which, None] / 2 + half * _AT)[0]
    squared = np.full(lefts.size, np.nan)
    squared[which] = (slope**2 * half) @ _WEIGHTS
    return Edges(lefts, rights, errors, counted, by_load, squared)
