"""Gaps between two contact nodes, and patches between two open ones: neither has a node, and no pressure and no opening
is theirs.
"""

import numpy as np

from ..arrays import Array64, parts
from .patches import Patches

_TURNS = 5  # until the width of a patch agrees with its depth


def unseen_gaps(patches: Patches, pressure: Array64) -> float:
    """Widths of gaps that lie between two contact nodes, their sum [grid spacings].

    pressure: as for `edges.find_edges`. In full contact the pressure beside the middle of a narrow gap of the width g
    would be proportional to y^2 - g^2/8, with y the distance from it (H. M. Westergaard, J. Appl. Mech. 6, 49 (1939)),
    and a grid on which no node lies in the gap has just that. So there is a gap where the parabola through four
    pressures (least squares) is negative somewhere between the middle ones. On thin compressible layers the widths come
    out up to 1.4 times too large, on thin incompressible ones many times. Where the pressure is no parabola, a gap near
    a node may be missed.
    """
    four = np.flatnonzero(patches.label[3:] == patches.label[:-3])
    if patches.full:
        four = np.arange(pressure.size)
    a, b, c, d = (pressure[(four + k) % pressure.size] for k in range(4))
    slope, bend, inner = 3 * (a - d) + b - c, a + d - b - c, b + c
    inside = np.abs(slope) < 2.5 * bend  # the middle of the gap lies between the middle nodes
    slope, bend, inner = slope[inside], bend[inside], inner[inside]
    beside = slope / (5 * bend)  # [grid spacings] from halfway between them
    squared = 2 - 16 * inner / bend + 8 * beside**2
    return float(np.sqrt(np.maximum(squared, 0.0)).sum())


def unseen_patches(profile: Array64, displacement: Array64, half_space: bool) -> float:
    """Widths of patches that lie between two open nodes, their sum [grid spacings].

    profile, displacement: h and u, shape (N,) [any unit], equal at contact nodes. half_space: whether the grid's
    shortest waves find one. There is such a patch where the parabola through an open node, which no neighbour
    undercuts, and both of its open neighbours is below 0. A summit of the curvature k that stands out by D is pressed
    flat over the width 2a with D = k a^2 [1/4 + ln(2/a)/2] on the half-space (`loads` has both equations), and with D =
    k a^2/2 on a Winkler foundation.
    """
    found = [_lowest(profile, displacement, part) for part in parts(profile.size)]
    left, node, right = np.concatenate(found, axis=1)
    bend = left - 2 * node + right
    depth = (left - right) ** 2 / 8 - bend * node  # times the curvature
    stand_out = depth > 0
    ratio = depth[stand_out] / bend[stand_out] ** 2
    a = np.sqrt(2 * ratio)
    for _ in range(_TURNS if half_space else 0):
        a = np.sqrt(ratio / (0.25 + np.log(2 / a) / 2))
    return 2 * float(a.sum())


def _lowest(profile: Array64, displacement: Array64, part: slice) -> Array64:
    """Gaps at open nodes that no neighbour undercuts, with those of their neighbours to the left and right, shape (3,
    nodes), in a part of the grid.
    """
    before, after = part.start - 1, part.stop + 1
    if before >= 0 and after <= profile.size:
        gap = profile[before:after] - displacement[before:after]
    else:  # the period goes on
        nodes = np.arange(before, min(after, profile.size + 1)) % profile.size
        gap = profile[nodes] - displacement[nodes]
    left, node, right = gap[:-2], gap[1:-1], gap[2:]
    lowest = np.flatnonzero((node > 0) & (node <= left) & (node <= right))
    return np.stack([left[lowest], node[lowest], right[lowest]])
