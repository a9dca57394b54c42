"""Where a contact ends between the nodes, by the pressures there: the ends of its patches, and how well they are known.

Near its edge the pressure of a contact is one of the curves of `edge_curves`, so the last two or three nodal pressures
tell where between two nodes the edge lies. That is right to the first order in 1/w, one over the width w of a patch in
grid spacings.

To the second order, for patches that are narrow beside the layer's thickness. For an edge theta = beta - s spacings
inside the last node the curve goes over into a [(j - theta)^1/2 + e (j - theta)^-3/2], e = (beta^2 - beta + 1/6)/8, and
not into the root alone. In a patch of half-width A that is the pressure F(x; A) under a smooth indenter plus
-4 e F'', with F'' the second derivative with respect to A. F'' carries load, so the half-width with that load is
4 e/A less; and F'' goes like (j - theta)^-1/2 to the next order, which the three pressures take for 5/2 e/A of that
already. What is left, 3/2 e/A = 3 e/w, the edge lies further inside than they say. If such patches follow each other
at the distance P, end to end with the gaps, F' = f(A) cos(pi x/P) (sin^2(pi A/P) - sin^2(pi x/P))^-1/2, and the same
steps leave pi/P (3 cot(pi A/P) + tan(pi A/P)) e/2: next to a narrow gap of g spacings e/g.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import Array64, Mask
from ..layers import ElasticLayer
from .edge_curves import EdgeCurve, edge_curve, edge_function, half_space_curve
from .layer_on_grid import thickness_on_grid
from .patches import Patches

COUNTED_BELOW = 3
"""Nodes; smaller patches have no pressures that tell their ends."""

_NARROW, _THINNEST = 8.0, 2.5
"""Layer thicknesses; narrower patches have the half-space's edge if their pressures look like it, on layers of so many
grid spacings and more."""

# What is claimed for an edge [grid spacings]. The constants were fitted so that the claim holds where the collocation
# oracle knows the edge (Hertz, sharp and blunt profiles, nu = -0.9 to 1/2, layers of 0.03 spacings to the half-space).
_OVER_SIZE = 0.3  # over the nodes of the patch; measured 0.1 to 0.25
_OVER_SIZE_SQUARED = 10.0  # over their square: patches of a few nodes, whose two ends disturb each other
_OVER_THICKNESS, _OVER_THICKNESS_SQUARED = 0.05, 0.25  # over the thickness [grid spacings], of narrow patches
_OF_LAYER, _OF_LAYER_OVER_SIZE = 0.003, 0.3  # more for patches that are wide beside the layer
_OVER_GAP_SQUARED = 3.0  # over the square of the nodes between neighbouring patches, whose edges disturb each other
_OF_SPREAD = 0.3  # of the difference between two estimates of one edge, where it is below `_CLOSE`

_SECOND_ORDER_WIDTH = 2.0  # layer thicknesses; narrower patches have the half-space's edges to the second order
_SECOND_ORDER_NODES = 7  # at least, of such a patch
_SECOND_ORDER_CLAIM = 3.0  # over the square of its nodes, instead of `_OVER_SIZE` and `_OVER_SIZE_SQUARED`

_CLOSE, _ALIKE = 0.05, 0.15
"""Grid spacings by which two estimates of an edge may differ to be as good as equal, and to be of an edge at all."""


def edge_offset(curve: EdgeCurve, pressures: Array64) -> tuple[Array64, Array64, Array64]:
    """theta from the last three nodal pressures, shape (M, 3), last node first; and from the last two. [grid spacings]

    The edge lies theta inside the last contact node (outside for theta < 0); -s <= theta <= 1 - s. The third result is
    how little the pressures look like an edge: by how far the estimates differ, before they are put into these bounds.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = pressures[:, 0] / pressures[:, 1]
        two = curve.table[0] - ratio * curve.table[1]
        two = two / (two + ratio * curve.table[0]) - curve.shift
    two = np.where(np.isfinite(two), two, 0.5 - curve.shift)
    bounded = np.clip(two, -curve.shift, 1 - curve.shift)
    spread = np.abs(two - bounded)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        low, middle, high = curve.rows @ pressures.T
        theta = -2 * low / middle
        for _ in range(3):  # -theta middle/2 - 3/8 theta^2 high = low
            theta = -2 * low / (middle + 0.75 * theta * high)
        theta += curve.delta
        spread = np.maximum(spread, np.where(np.isfinite(theta), np.abs(theta - bounded), 1.0))
    theta = np.clip(np.where(np.isfinite(theta), theta, bounded), -curve.shift, 1 - curve.shift)
    # two estimates far apart: the patch is too small for a third family
    return np.where(np.abs(theta - bounded) < _ALIKE, theta, bounded), bounded, spread


@dataclass(frozen=True, eq=False)
class Edges:
    """The ends of M patches."""

    left: Array64
    """Left ends, shape (M,) [grid spacings]."""
    right: Array64
    """Right ends, shape (M,) [grid spacings]."""
    error: Array64
    """Estimated errors of the patches' widths, shape (M,) [grid spacings]."""
    counted: Mask
    """Which patches have as many spacings as nodes because nothing better is known, shape (M,)."""
    by_load: Mask | None = None
    """Which narrow patches have ends that their loads have told, see `loads`, shape (M,); None for none."""
    squared_slope: Array64 | None = None
    """Integral of h'^2 over each patch, shape (M,) [grid spacings]; NaN, or None for all, where it is to be had from
    the nodes."""

    @property
    def width(self) -> Array64:
        """Widths, shape (M,) [grid spacings]."""
        return self.right - self.left

    @property
    def num_by_load(self) -> int:
        """Number of narrow patches whose ends their loads have told."""
        return 0 if self.by_load is None else int(self.by_load.sum())

    @property
    def total_error(self) -> float:
        """Estimated error of the sum of the widths [grid spacings]."""
        return math.sqrt(float(self.error @ self.error))


def find_edges(patches: Patches, pressure: Array64, layer: ElasticLayer, period: float) -> Edges:
    """Sub-grid edges of patches from the pressure, shape (contact nodes,) in compact order [any unit].

    The pressure is first divided by the edge function of the patch's other end; that is not needed where the edge is
    found to the second order, see the beginning of this file. Patches of fewer than three nodes end half a spacing
    outside their last nodes, as counting has it, and a full contact has no edge at all.

    period: L [length]. The error is an estimate, see the constants of this module; where the pressures do not look like
    an edge, because the profile bends within a few spacings, it is as large as two estimates of the edge differ; for
    patches that are counted it is one spacing.
    """
    if patches.full:
        half = np.array([0.5])  # error: a gap between two nodes would not be seen
        return Edges(patches.first - half, patches.last + half, np.ones(1), np.zeros(1, dtype=bool))
    thickness = thickness_on_grid(layer, patches.num_points, period)
    half_space = half_space_curve()
    theta, spread = _offsets(half_space, patches, pressure)
    narrow = (patches.size < _NARROW * thickness) & (thickness > _THINNEST) & (spread < _ALIKE)
    by_layer = np.full(narrow.shape, _OVER_THICKNESS / thickness + _OVER_THICKNESS_SQUARED / thickness**2)
    if thickness < math.inf and not narrow.all():
        curve = edge_curve(layer, patches.num_points, period)
        theta, spread = np.where(narrow, (theta, spread), _offsets(curve, patches, pressure))
        by_layer = np.where(narrow, by_layer, _OF_LAYER + _OF_LAYER_OVER_SIZE / patches.size + curve.error)
    better = _to_second_order(half_space, patches, pressure)
    second_order = (patches.size >= _SECOND_ORDER_NODES) & (patches.size < _SECOND_ORDER_WIDTH * thickness)
    second_order = second_order & (np.abs(better - theta) < _ALIKE) & (spread < _ALIKE)
    theta = np.where(second_order, better, theta)
    counted = patches.size < COUNTED_BELOW
    outside = np.where(counted, 0.5, -theta)
    left, right = apart(patches.first - outside[0], patches.last + outside[1], patches.num_points)
    error = np.where(counted, math.sqrt(0.5), _claimed(patches, spread, by_layer, second_order))
    return Edges(left, right, np.hypot(*error), counted)


def apart(left: Array64, right: Array64, num_points: int) -> tuple[Array64, Array64]:
    """Ends of patches in a period of `num_points` spacings, those of neighbours not beyond each other."""
    overlap = np.maximum(right - np.append(left[1:], left[:1] + num_points), 0.0) / 2
    return left + np.roll(overlap, 1), right - overlap


def _claimed(patches: Patches, spread: Array64, layer: Array64, second_order: Mask) -> Array64:
    """Estimated errors of the left and the right ends, shape (2, M) [grid spacings].

    spread: how little the pressures look like an edge, shape (2, M); layer: the layer's share, of the same shape;
    second_order: which ends are known to it, shape (2, M).
    """
    beyond = np.append(patches.first[1:], patches.first[:1] + patches.num_points) - patches.last - 1
    narrow_gap = _OVER_GAP_SQUARED / np.stack([np.roll(beyond, 1), beyond]) ** 2
    fitted = np.where(spread < _CLOSE, _OF_SPREAD * spread, spread)
    first_order = _OVER_SIZE / patches.size + _OVER_SIZE_SQUARED / patches.size**2
    fitted = fitted + np.where(second_order, _SECOND_ORDER_CLAIM / patches.size**2, first_order)
    fitted += layer + narrow_gap
    counting = np.maximum(layer, 0.5)  # an edge is known as well as by counting, unless the layer spoils it
    return np.where(spread < _ALIKE, np.minimum(fitted, counting), np.clip(spread, counting, np.maximum(counting, 1.0)))


def _ends(patches: Patches, pressure: Array64) -> Array64:
    """The last three pressures of left and right ends, last node first, shape (2, M, 3)."""
    steps = np.minimum(np.arange(3), patches.size[:, None] - 1)
    left = pressure[patches.offset[:, None] + steps]
    right = pressure[(patches.offset + patches.size - 1)[:, None] - steps]
    return np.stack([left, right])


def _to_second_order(curve: EdgeCurve, patches: Patches, pressure: Array64) -> Array64:
    """theta of left and right ends to the second order in one over the width, shape (2, M); each end as if patches like
    its own, with gaps like the one next to it, followed each other.
    """
    theta = edge_offset(curve, _ends(patches, pressure).reshape(-1, 3))[0].reshape(2, -1)
    left, right = patches.first + theta[0], patches.last - theta[1]
    beyond = np.append(left[1:], left[:1] + patches.num_points) - right
    period = right - left + np.stack([np.roll(beyond, 1), beyond])
    tangent = np.tan(np.pi / 2 * (right - left) / period)
    beta = theta + curve.shift
    left_over = np.pi / period * (3 / tangent + tangent) / 2  # of e
    return np.asarray(theta + left_over * (beta**2 - beta + 1 / 6) / 8)


def _offsets(curve: EdgeCurve, patches: Patches, pressure: Array64) -> tuple[Array64, Array64]:
    """theta of left and right ends, and how little they look like edges, shape (2, M) each; see `edge_offset`."""
    theta, _, spread = edge_offset(curve, lone_ends(curve, patches, pressure).reshape(-1, 3))
    return theta.reshape(2, -1), spread.reshape(2, -1)


def lone_ends(curve: EdgeCurve, patches: Patches, pressure: Array64) -> Array64:
    """The last three pressures of left and right ends, last node first, divided by the edge function of the patch's
    other end, shape (2, M, 3).
    """
    ends, away = _ends(patches, pressure), patches.size[:, None] - 1 - np.arange(3)
    theta, alone = np.full((2, patches.count), 0.5 - curve.shift), ends
    for turn in range(3):
        if turn:
            theta = edge_offset(curve, alone.reshape(-1, 3))[0].reshape(2, -1)
        alone = ends / np.maximum(edge_function(curve, (theta + curve.shift)[::-1, :, None], away), 1e-3)
    return np.asarray(alone)
