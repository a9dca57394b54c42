"""Where a contact ends between the nodes, by the pressures there: the ends of its patches, and how well they are known.

Near its edge the pressure of a contact is one of the curves of `edge_curves`, so the last two or three nodal pressures
tell where between two nodes the edge lies. That is right to the first order in 1/w, one over the width w of a patch in
grid spacings.

In a patch that is narrow beside the layer's thickness the pressure has a square root at each end, and beside a narrow
gap it rises like y (y^2 - c^2)^1/2, with c half the gap and y the distance from its middle. Both are in H. M.
Westergaard's row of patches of the width w = 2A that follow each other at the distance P = w + g under a wave of that
length, g being the gap next to the end:

    p(x) ~ cos(pi x/P) [sin^2(pi A/P) - sin^2(pi x/P)]^1/2, x from the middle of a patch.

The last pressures are divided by p over the root of the distance from the end: the quotient looks like an edge. The
distance is taken as the grid has it (`edge_curves.edge_distance`).

For an edge theta = beta - s spacings inside the last node the curve goes over into a [(j - theta)^1/2 + e (j -
theta)^-3/2], e = (beta^2 - beta + 1/6)/8, and not into the root alone. In a patch of half-width A with a given load the
ends then lie 3/2 e/A further inside than the pressures say, in a row pi/P (3 cot(pi A/P) + tan(pi A/P)) e/2 (derived in
docs/edges.md). As it is the load of all patches together that is given, e is the mean over all ends of this kind.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import Array64, Mask
from ..calibration import FITTED
from .edge_curves import UNKNOWN, EdgeCurve, edge_distance, edge_function, half_space_curve
from .layer_on_grid import LayerOnGrid
from .patches import Patches

UNRESOLVED_BELOW = 3
"""Nodes; smaller patches have no pressures that tell their ends."""

_NARROW = 2.0
"""Layer thicknesses; narrower patches have the half-space's edge if their pressures look like it, on layers of so many
grid spacings and more. Their load tells the second order, which the pressures leave."""

UNRESOLVED_ERROR = math.sqrt(0.5)
"""Error of an end halfway between two nodes, as counting has it, at most [grid spacings]."""

_FEWEST = 8  # nodes of a full contact whose gaps `unseen` finds
_NARROWEST = 0.5  # gap between two patches that is believed [grid spacings]
TURNS = 3
"""Until ends agree with pressures, or with the modulus that a layer has for their width."""

_ALIKE = 0.15
"""Grid spacings by which two estimates of an edge may differ to be of an edge at all."""


def edge_offset(curve: EdgeCurve, pressures: Array64) -> tuple[Array64, Array64, Array64]:
    """theta from the last three nodal pressures, (..., 3), last node first; and from the last two. [grid spacings]

    The edge lies theta inside the last contact node (outside for theta < 0); -s <= theta <= 1 - s. The third result is
    how little the pressures look like an edge: by how far the estimates differ, before they are put into these bounds.
    """
    least, most = -curve.shift, 1 - curve.shift
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = pressures[..., 0] / pressures[..., 1]
        two = curve.table[0] - ratio * curve.table[1]
        two = two / (two + ratio * curve.table[0]) - curve.shift
        low, middle, high = np.moveaxis(pressures @ curve.rows.T, -1, 0)
        theta = -2 * low / middle
        for _ in range(TURNS):  # -theta middle/2 - 3/8 theta^2 high = low
            theta = -2 * low / (middle + 0.75 * theta * high)
        theta += curve.delta
    two[~np.isfinite(two)] = 0.5 - curve.shift
    bounded = np.minimum(np.maximum(two, least), most)
    differ = np.abs(theta - bounded)
    unknown = ~np.isfinite(theta)
    differ[unknown], theta[unknown] = 1.0, bounded[unknown]
    spread = np.maximum(np.abs(two - bounded), differ)
    theta = np.minimum(np.maximum(theta, least), most)
    # two estimates far apart: the patch is too small for a third family
    return np.where(np.abs(theta - bounded) < _ALIKE, theta, bounded), bounded, spread


@dataclass(frozen=True, eq=False)
class Edges:
    """The ends of M patches."""

    left: Array64
    """Left ends, shape (M,) [grid spacings]."""
    right: Array64
    """Right ends, shape (M,) [grid spacings]."""
    end_errors: Array64
    """Estimated errors of left and right ends, shape (2, M) [grid spacings]."""
    unresolved: Mask
    """Which patches have as many spacings as nodes because nothing better is known, shape (M,)."""
    by_load: Mask
    """Which narrow patches have ends that their loads have told, see `narrow`, shape (M,); without those on a layer
    that the grid does not resolve."""
    by_gap: Mask
    """Behind which patches there is a narrow gap that has told its ends, see `narrow`, shape (M,)."""
    unseen: float = 0.0
    """Widths of gaps between two contact nodes and of patches between two open ones, see `unseen`, their sum [grid
    spacings]."""

    @property
    def width(self) -> Array64:
        """Widths, shape (M,) [grid spacings]."""
        return self.right - self.left

    def total_error(self, weights: Array64 | float = 1.0) -> float:
        """Estimated error of the sum of the widths, without `unseen` [grid spacings]: the root of the sum of squares,
        because the signs of most vary from patch to patch, and a share of the sum, for those that do not.

        weights: of left and right ends in that sum, shape (2, M).
        """
        error = (self.end_errors * weights).sum(axis=0)
        return float(np.linalg.norm(error) + FITTED.in_common * error.sum())


def find_edges(patches: Patches, pressure: Array64, layer: LayerOnGrid, steepness: float = 1.0) -> Edges:
    """Sub-grid edges of patches from the pressure, shape (contact nodes,) in compact order [any unit]; each end by
    itself, so that neighbours may overlap. steepness: see `Indenter`; it makes the errors larger.

    Patches of fewer than three nodes end half a spacing outside their last nodes, as counting has it, and a full
    contact has no edge at all.

    The error is an estimate, see `calibration`; it is a spacing where the pressures do not look like an edge, because
    the profile bends within a few spacings.
    """
    none = np.zeros(patches.count, dtype=bool)
    if patches.full:
        unknown = np.full((2, 1), 0.5 if patches.num_points < _FEWEST else 0.0)
        return Edges(np.subtract(patches.first, 0.5), np.add(patches.last, 0.5), unknown, none, none, none)
    thickness, curve = layer.thickness, half_space_curve()
    theta, _, spread = edge_offset(curve, lone_ends(curve, patches, pressure, _in_row))
    on_thick = (patches.size < _NARROW * thickness) & (thickness > _NARROW)
    narrow = on_thick & (spread < _ALIKE)
    by_curve = if_wide = 0.0
    if thickness < math.inf and not narrow.all():
        curve = layer.edge_curve
        wide, _, spread_of_wide = edge_offset(curve, lone_ends(curve, patches, pressure))
        theta, spread = np.where(narrow, theta, wide), np.where(narrow, spread, spread_of_wide)
        by_curve, if_wide = curve.error, FITTED.of_size_if_wide * curve.power
    unresolved = patches.size < UNRESOLVED_BELOW
    theta = theta + _by_load(patches, theta, narrow & ~unresolved)
    outside = np.where(unresolved, 0.5, -theta)
    left, right = patches.first - outside[0], patches.last + outside[1]
    size = patches.size / steepness
    by_size = FITTED.of_size / size**2 + np.where(on_thick, 0.0, if_wide / patches.size)
    by_gap = FITTED.beside_gap / patches.gap**2
    resolved = max(thickness, _NARROW)
    by_layer = FITTED.of_layer * (patches.size / resolved) ** 3 / resolved
    by_spread = FITTED.of_difference * spread.max(axis=0) ** 1.5 / np.sqrt(np.minimum(size, resolved))
    error = np.minimum(by_spread + by_size + by_gap, UNRESOLVED_ERROR)
    error += np.where(narrow, by_layer, by_curve)
    error = np.where(spread < _ALIKE, error, UNKNOWN)
    return Edges(left, right, np.where(unresolved, UNRESOLVED_ERROR, error), unresolved, none, none)


def _ends(patches: Patches, pressure: Array64) -> Array64:
    """The last three pressures of left and right ends, last node first, shape (2, M, 3)."""
    steps = np.minimum(np.arange(3), patches.size[:, None] - 1)
    left = pressure[patches.offset[:, None] + steps]
    right = pressure[(patches.offset + patches.size - 1)[:, None] - steps]
    return np.stack([left, right])


def _in_row(curve: EdgeCurve, patches: Patches, theta: Array64) -> Array64:
    """What the last three pressures of each end have from all others, shape (2, M, 3), as if patches like its own, with
    gaps like the one next to it, followed each other on the half-space.
    """
    width, gap = (of[..., None] for of in _around(patches, theta))
    wave, away = np.pi / (width + gap), np.minimum(edge_distance(curve, theta), width)
    beyond = np.sin(wave * np.maximum(width - away, _NARROWEST)) * np.sinc(wave / np.pi * away)
    return np.asarray(np.sin(wave * (gap / 2 + away)) * np.sqrt(beyond))


def _by_load(patches: Patches, theta: Array64, known: Mask) -> Array64:
    """What is left to the second order if the load is given, shape (2, M) [grid spacings].

    known: which ends the half-space's curve tells, shape (2, M); the others are left where they are.
    """
    width, gap = _around(patches, theta)
    tangent = np.tan(np.pi / 2 * width / (width + gap))
    beta = theta + half_space_curve().shift
    e = float(np.sum(beta**2 - beta + 1 / 6, where=known)) / 8 / max(int(known.sum()), 1)
    return np.where(known, np.pi / (width + gap) * (3 / tangent + tangent) / 2 * e, 0.0)


def _around(patches: Patches, theta: Array64) -> tuple[Array64, Array64]:
    """Widths of patches, and of the gaps to their left and right, shape (2, M) each [grid spacings]; widths not below
    two, the least that three nodes can have, and gaps not below `_NARROWEST`.
    """
    width = np.maximum(patches.size - 1 - theta.sum(axis=0), 2.0)
    left, right = theta
    facing = np.concatenate((right[-1:], right[:-1], left[1:], left[:1])).reshape(theta.shape)  # of the neighbours
    gap = np.maximum(patches.gap + 1 + theta + facing, _NARROWEST)
    return np.broadcast_to(width, gap.shape), gap


def _in_patch(curve: EdgeCurve, patches: Patches, theta: Array64) -> Array64:
    """As `_in_row`, from the edge function of the patch's other end alone."""
    away = patches.size[:, None] - 1 - np.arange(3)
    return np.maximum(edge_function(curve, (theta + curve.shift)[::-1, :, None], away), 1e-3)


def lone_ends(
    curve: EdgeCurve,
    patches: Patches,
    pressure: Array64,
    others: Callable[[EdgeCurve, Patches, Array64], Array64] = _in_patch,
) -> Array64:
    """The last three pressures of left and right ends, last node first, divided by the factors of `others`, shape
    (2, M, 3).
    """
    alone = ends = _ends(patches, pressure)
    theta = np.full((2, patches.count), 0.5 - curve.shift)
    for turn in range(TURNS):
        if turn:
            theta = edge_offset(curve, alone)[0]
        alone = ends / others(curve, patches, theta)
    return alone
