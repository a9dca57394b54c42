"""Where a contact ends: by the pressures at its ends, the loads of its patches or the gaps between them, whichever
knows it better.
"""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..arrays import Array64, Indices
from ..calibration import FITTED
from ..layers import ElasticLayer
from ..scene import Scene
from .edges import COUNTED_BELOW, COUNTED_ERROR, Edges, apart, find_edges
from .few_nodes import MOST_NODES
from .gaps import gap_ends
from .heights import Heights
from .layer_on_grid import Modulus, modulus_on_grid
from .loads import first_centre, from_loads, level_error
from .patches import Patches
from .shares import MOST_POINTS, layer_response, shared_loads
from .surroundings import Field, Surroundings
from .unseen import unseen_gaps, unseen_patches

_RESOLVED, _THINNEST = 0.2, 0.5
"""Logarithm of the shortest wave's modulus over the half-space's, up to which a grid resolves a layer, and the layer's
thickness from which on it does [grid spacings]."""
_JAGGED = 1.9
"""Fourth over second difference of the heights from which the nodes do not tell what lies between them; 2 for a wave of
four grid spacings."""
_FARTHEST = 0.5
"""By how much the ends may differ from those by pressures to be believed [grid spacings]."""

_LEAST = 0.25
"""Share of the nodes of a patch on a layer that the grid does not resolve, below which its width is not believed."""

_DIFFERENCES = np.array([[0, 0, 1, -2, 1, 0, 0], [0, 1, -4, 6, -4, 1, 0], [1, -6, 15, -20, 15, -6, 1]]).T
_SHORT = 8  # nodes
_SHORT_OF_FIT = 0.1
"""Width of patches that served for no fit [grid spacings]: under rough surfaces nothing is known of it, because another
valley may be lower between the nodes."""
_FEW, _MANY = (np.polynomial.legendre.leggauss(points) for points in (8, 32))
"""Places and weights of the integral of h'^2 over patches of up to so many nodes, and over others."""


def contact_edges(
    scene: Scene,
    pressure: Array64,
    profile: Array64 | None = None,
    displacement: Array64 | None = None,
) -> tuple[Patches, Edges]:
    """Patches and their sub-grid edges, from the contact pressure [any unit], 0 off the contact, shape (N,), any N.

    profile: h, shape (N,) [length], if it is at hand. displacement: u, shape (N,) [length], with which loads and gaps
    tell where narrow patches end; None: pressures alone tell the ends, in half of the time.
    """
    if profile is None:
        profile = scene.period * scene.indenter.profile(pressure.size, scene.period)
    scale = scene.reduced_load / (float(pressure.mean()) or 1.0)
    kinks = scene.indenter.kinked or not scene.indenter.shortest_wave(pressure.size)
    patches, edges = ends(scene.layer, scene.period, profile, pressure, scale, kinks, displacement)
    # all ends, the same way, those of other patches by the share of the load
    middle = pressure.size // 2
    at_tip = np.flatnonzero((patches.first <= middle) & (middle <= patches.last) | (patches.count == 1))
    tip = scene.indenter.end_error(float(edges.width[at_tip[0]])) if at_tip.size else 0.0
    error = np.maximum(edges.end_errors, tip)
    if scene.indenter.effective_wave(pressure.size):
        error = np.maximum(error, np.where(edges.width < _SHORT_OF_FIT, edges.width / 2, 0.0))
    return patches, replace(edges, end_errors=error)


def ends(
    layer: ElasticLayer,
    period: float,
    profile: Array64,
    pressure: Array64,
    scale: float,
    kinks: bool,
    displacement: Array64 | None = None,
) -> tuple[Patches, Edges]:
    """Patches and their sub-grid edges. profile: h [length], pressure: 0 off the contact, both shape (N,); scale: what
    makes of that pressure the one over E*; kinks: whether the profile may have some; displacement: as in
    `contact_edges`.
    """
    patches = Patches.of(pressure > 0)
    inside = pressure[patches.nodes] * scale
    edges = replace(find_edges(patches, inside, layer, period), unseen=unseen_gaps(patches, inside, kinks))
    if displacement is None or patches.full or not patches.count:
        return patches, edges
    n, spacings = pressure.size, pressure.size / period
    surface = _Surface(
        layer=layer,
        period=period,
        heights=Heights(profile, spacings),
        pressure=lambda nodes: pressure[nodes % n] * scale,
        displacement=lambda nodes: displacement[nodes % n] * spacings,
    )
    edges = _by_loads(surface, patches, edges, inside)
    edges = _by_gaps(surface, patches, edges)
    unseen = edges.unseen + unseen_patches(profile, displacement, surface.resolved)
    return patches, _with_slopes(patches, replace(edges, unseen=unseen), surface.heights)


@dataclass(frozen=True)
class _Surface:
    """What is known of the surface on a grid."""

    layer: ElasticLayer
    """Below it."""
    period: float
    """L [length]."""
    heights: Heights
    """Of the indenter."""
    pressure: Field
    """Over E*."""
    displacement: Field
    """u [grid spacings]."""

    @property
    def num_points(self) -> int:
        """N."""
        return self.heights.profile.size

    @property
    def thickness(self) -> float:
        """Of the layer [grid spacings]."""
        return self.layer.thickness / self.period * self.num_points

    @property
    def modulus(self) -> Modulus:
        """2K(q)/q over E*."""
        return partial(modulus_on_grid, self.layer, num_points=self.num_points, period=self.period)

    @property
    def resolved(self) -> bool:
        """Whether the layer is at least half a spacing thick, and the shortest wave finds a half-space's stiffness."""
        return self.thickness >= _THINNEST and abs(math.log(self.modulus(np.array([np.pi]))[0])) < _RESOLVED


def _by_loads(surface: _Surface, patches: Patches, edges: Edges, pressure: Array64) -> Edges:
    """Edges with those ends of narrow patches that their loads tell better than their pressures.

    pressure: over E*, on the contact nodes in compact order.
    """
    n, heights, resolved = surface.num_points, surface.heights, surface.resolved
    chosen = np.flatnonzero(patches.size <= min(MOST_NODES if resolved else COUNTED_BELOW - 1, n / 2))
    if not chosen.size:
        return edges
    gap = patches.to_neighbours[:, chosen].min(axis=0).astype(np.int64) - 1
    runs = patches.first[chosen], patches.size[chosen], gap
    around = Surroundings.of_patches(*runs, surface.pressure, surface.displacement)
    loads, half_width = patches.sums(pressure), _start(patches, edges, pressure, heights)[chosen]
    begin = first_centre(around, heights, resolved), half_width
    found = from_loads(around, heights, loads[chosen], *begin, None if resolved else surface.modulus)
    chosen, around, found = chosen[found.solved], around.part(found.solved), found.part(found.solved)
    if resolved and chosen.size and patches.count > 1 and n <= MOST_POINTS:
        level = level_error(found, around, heights, loads[chosen])
        green = layer_response(surface.layer, n, surface.period)
        loads = shared_loads(patches, chosen, pressure, found, level, green)
        found = from_loads(around, heights, loads[chosen], found.centre, found.half_width)
    left, right = found.centre - found.half_width, found.centre + found.half_width
    size = patches.size[chosen]
    fourth, sixth = _differences(heights.profile, patches.first[chosen], size)
    gap = patches.to_neighbours[:, chosen].min(axis=0) - 1
    uneven = FITTED.of_heights * sixth.max(axis=1) + FITTED.beside_gap / gap**2
    error = _known(uneven, size, surface.thickness)
    if not resolved:  # not known better than by counting, but narrower
        error = np.where(2 * found.half_width < _LEAST * size, math.inf, COUNTED_ERROR)
    differ = np.maximum(np.abs(left - edges.left[chosen]), np.abs(right - edges.right[chosen]))
    better = found.solved & (2 * error <= edges.error[chosen])
    better &= differ < np.where(edges.counted[chosen], size, _FARTHEST)
    better &= ~(fourth.min(axis=1) > _JAGGED)
    lefts, rights, errors = edges.left.copy(), edges.right.copy(), edges.end_errors.copy()
    counted, by_load, which = edges.counted.copy(), edges.by_load.copy(), chosen[better]
    lefts[which], rights[which], errors[:, which] = left[better], right[better], error[better]
    counted[which], by_load[which] = False, resolved
    lefts, rights = apart(lefts, rights, n)
    return replace(edges, left=lefts, right=rights, end_errors=errors, counted=counted, by_load=by_load)


def _by_gaps(surface: _Surface, patches: Patches, edges: Edges) -> Edges:
    """Edges with those ends of patches on both sides of a narrow gap that the gap tells better than they do."""
    n = surface.num_points
    gap, narrower = patches.to_neighbours[1].astype(np.int64) - 1, np.minimum(patches.size, np.roll(patches.size, -1))
    before = np.flatnonzero((gap <= np.minimum(narrower, MOST_NODES)) & (narrower >= COUNTED_BELOW))
    if not before.size or not surface.resolved:
        return edges
    behind, heights = (before + 1) % patches.count, surface.heights
    first, size = patches.last[before] + 1, gap[before]

    def opening(nodes: Indices) -> Array64:
        height: Array64 = heights.profile[nodes % n] * heights.scale
        return height - surface.displacement(nodes)

    closed = Surroundings.of_gaps(first, size, narrower[before], opening, surface.pressure)
    left, right = edges.right[before], edges.left[behind]
    right = right + np.where(behind == 0, n, 0)
    found = gap_ends(closed, left, right)
    fourth, _ = _differences(heights.profile, first, size)
    error = _known(FITTED.of_heights_at_gaps * fourth.max(axis=1), size, surface.thickness)
    known = edges.end_errors[1, before] + edges.end_errors[0, behind]
    inwards, outwards = found.left - left, found.right - right
    better = found.solved & (2 * error < known) & (np.maximum(np.abs(inwards), np.abs(outwards)) < _FARTHEST)
    better &= ~(fourth.min(axis=1) > _JAGGED)
    lefts, rights, errors = edges.left.copy(), edges.right.copy(), edges.end_errors.copy()
    one, other, by_gap = before[better], behind[better], edges.by_gap.copy()
    by_gap[one] = True
    rights[one] += inwards[better]
    lefts[other] += outwards[better]
    errors[1, one] = errors[0, other] = error[better]
    return replace(edges, left=lefts, right=rights, end_errors=errors, by_gap=by_gap)


def _start(patches: Patches, edges: Edges, pressure: Array64, heights: Heights) -> Array64:
    """Half-widths to begin with, shape (M,) [grid spacings]; patches whose nodes are counted begin with Hertz' law."""
    _, curvature = heights.slope_in_the_middle((patches.first + patches.last) / 2)
    hertz = np.sqrt(4 / math.pi * patches.sums(pressure)) / np.sqrt(np.maximum(curvature, 1e-300))  # no overflow
    return np.where(edges.counted, np.clip(hertz, 0.05, patches.size), edges.width / 2)


def _known(uneven: Array64, size: Indices, thickness: float) -> Array64:
    """Estimated errors of the ends of some patches by their loads, or of some gaps, shape (runs,) [grid spacings].

    uneven: what heights and neighbours leave, of their shape [grid spacings]; size: their nodes; thickness: of the
    layer [grid spacings].
    """
    error = FITTED.always + uneven + FITTED.of_layer * size / thickness**2
    return np.minimum(error, COUNTED_ERROR)


def _differences(profile: Array64, first: Indices, size: Indices) -> tuple[Array64, Array64]:
    """Fourth and sixth over second differences of the profile, taken positive, at the two nodes in the middle of each
    run of nodes, or twice at one, shape (runs, 2): how little the nodes tell of the heights between them.
    """
    twice = 2 * first + size - 1
    nodes = np.stack([twice // 2, (twice + 1) // 2])
    second, fourth, sixth = np.abs(profile[(nodes[..., None] + np.arange(-3, 4)) % profile.size] @ _DIFFERENCES).T
    with np.errstate(divide="ignore", invalid="ignore"):
        return fourth / second, sixth / second


def _with_slopes(patches: Patches, edges: Edges, heights: Heights) -> Edges:
    """Edges with the integral of h'^2 over the patches whose ends their loads tell, or let estimate."""
    known = edges.by_load | (patches.size < COUNTED_BELOW) & ~edges.counted
    squared = np.full(patches.count, np.nan)
    for (places, weights), wide in ((_FEW, edges.width <= _SHORT), (_MANY, edges.width > _SHORT)):
        which = known & wide
        half = edges.width[which, None] / 2
        slope = heights.slope((edges.left + edges.right)[which, None] / 2 + half * places)[0]
        squared[which] = (slope**2 * half) @ weights
    return replace(edges, squared_slope=squared)
