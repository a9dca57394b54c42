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
distance is taken as the grid has it: the pressure of a far field x^(3/2) over that of x^(1/2).

For an edge theta = beta - s spacings inside the last node the curve goes over into a [(j - theta)^1/2 + e (j -
theta)^-3/2], e = (beta^2 - beta + 1/6)/8, and not into the root alone. In a patch of half-width A with a given load the
ends then lie 3/2 e/A further inside than the pressures say, in a row pi/P (3 cot(pi A/P) + tan(pi A/P)) e/2 (derived in
docs/edges.md). As it is the load of all patches together that is given, e is the mean over all ends of this kind.
"""

import math
from dataclasses import dataclass

import numpy as np

from ...kernels import launch, layout
from ..arrays import Array64, Mask
from ..calibration import FITTED
from .edge_curves import UNKNOWN, EdgeCurve, half_space_curve
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
    thickness = layer.thickness
    unresolved = patches.size < UNRESOLVED_BELOW
    on_thick = (patches.size < _NARROW * thickness) & (thickness > _NARROW)
    theta, spread, _ = pressed_ends(half_space_curve(), patches, pressure, on_thick & ~unresolved)
    narrow = on_thick & (spread < layout.ALIKE)
    by_curve = if_wide = 0.0
    if thickness < math.inf and not narrow.all():
        curve = layer.edge_curve
        wide, spread_of_wide, _ = pressed_ends(curve, patches, pressure)
        theta, spread = np.where(narrow, theta, wide), np.where(narrow, spread, spread_of_wide)
        by_curve, if_wide = curve.error, FITTED.of_size_if_wide * curve.power
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
    error = np.where(spread < layout.ALIKE, error, UNKNOWN)
    return Edges(left, right, np.where(unresolved, UNRESOLVED_ERROR, error), unresolved, none, none)


def pressed_ends(
    curve: EdgeCurve, patches: Patches, pressure: Array64, known: Mask | None = None
) -> tuple[Array64, Array64, Array64]:
    """How far edges lie inside the last nodes, shape (2, M) [grid spacings], by the kernel of this name, see there; by
    how far two estimates of that differ, of that shape; the pressures without the effect of other ends, shape (6, M).

    known: patches that may have the half-space's edge, shape (M,); with it other ends act as those of a row of patches.
    """
    count, size = patches.count, patches.size
    given, ends = np.zeros((layout.PRESSED + 6, count)), np.zeros((layout.ALONE + 6, count))
    given[layout.NODES], given[layout.GAPS : layout.KNOWN] = size, patches.gap
    if known is not None:
        given[layout.KNOWN] = known
    steps = np.minimum(np.arange(3)[:, None], size - 1)
    given[layout.PRESSED : layout.PRESSED + 3] = pressure[patches.offset + steps]
    given[layout.PRESSED + 3 :] = pressure[patches.offset + size - 1 - steps]
    launch("pressed_ends", 1, (curve.packed, given.ravel(), known is not None), (ends.ravel(),))
    return ends[layout.OFFSET : layout.SPREAD], ends[layout.SPREAD : layout.BEFORE], ends[layout.ALONE :]
