"""Gaps between two contact nodes, and patches between two open ones: neither has a node, and no pressure and no opening
is theirs.
"""

import math

import numpy as np
from numpy.polynomial.polynomial import polyval

from ...kernels import layout
from ..arrays import Array64
from .few_nodes import node_compliance
from .patches import Patches

_THROUGH_SIX = np.linalg.inv(np.vander(np.arange(-2.5, 3), increasing=True))  # to coefficients of the polynomial


def unseen_gaps(patches: Patches, pressure: Array64, kinks: bool) -> float:
    """How wide gaps between two contact nodes may be, their sum [grid spacings].

    pressure: as for `edges.find_edges`; kinks: whether the heights may have some. A gap may hide where the pressure
    falls from both sides towards the two nodes at a minimum, in two ways:

    - In full contact the pressure beside the middle of a narrow gap of the width g would be proportional to y^2 -
      g^2/8, with y the distance from it (H. M. Westergaard, J. Appl. Mech. 6, 49 (1939)), and a grid on which no node
      lies in the gap has just that, up to g = sqrt(2). The least pressure is that of the parabola through four nodes
      (least squares), or of the polynomial through six there, and may be less by as much as the two differ.
    - The pressure falls the faster the nearer. Beside a gap at a kink of the heights, which no load closes, it goes
      like arcosh(2 y/g), far away ln(4 y/g). For a kink anywhere between the two nodes the grid has that logarithm, in
      the mean of both nodes and of the next ones, at the y of `few_nodes.node_compliance`, 0.407 and 1.379.
    """
    size, label = pressure.size, patches.label
    four = np.arange(size) if patches.full else np.flatnonzero(label[3:] == label[:-3])
    a, b, c, d = (pressure[(four + k) % size] for k in range(4))
    four = four[(a > b) & (d > c) & np.where(b <= c, c <= a, b < d)]  # of two pairs beside one node the lower one
    nodes = (four + np.arange(-1, 5)[:, None]) % size
    six = np.where(label[nodes] == label[nodes[1]], pressure[nodes], 0.0)
    steps = -np.diff(six, axis=0)
    before, falls, across = steps[[0, 4]], steps[[1, 3]], steps[[2, 2]]  # towards the pair, and within it
    before[1], falls[1], across[1] = -before[1], -falls[1], -across[1]
    kinked = kinks & ((falls > before) | (across > falls)).all(axis=0)
    bend, inner = falls.sum(axis=0), six[2] + six[3]
    near, far = np.exp(-np.pi / 4 * (node_compliance()[:2] + node_compliance()[1:3]))
    at_kink = 4 * near * (far / near) ** (-inner / bend)
    middle = np.clip((3 * (six[1] - six[4]) + six[2] - six[3]) / (5 * bend), -0.5, 0.5)
    by_four = inner / 2 - bend * (1 + 4 * middle**2) / 16
    by_six = polyval(middle, _THROUGH_SIX @ six, tensor=False)
    least = np.minimum(by_four, by_six) - np.abs(by_four - by_six)
    smooth = np.minimum(np.sqrt(32 * np.maximum(-least, 0.0) / bend), math.sqrt(2))
    return float(np.where(kinked, at_kink, smooth).sum())


def unseen_patches(patches: Patches, profile: Array64, displacement: Array64, half_space: bool) -> float:
    """Widths of patches that lie between two open nodes, their sum [grid spacings].

    profile, displacement: h and u, shape (N,) [any unit]; half_space: whether the grid's shortest waves find one. There
    is such a patch where the parabola through an open node, which no neighbour undercuts, and both of its neighbours is
    below 0. A summit of the curvature k that stands out by D is pressed flat over the width 2a with D = k a^2 [1/4 +
    ln(2/a)/2] on the half-space (see `narrow`), and with D = k a^2/2 on a Winkler foundation.
    """
    gap = profile - displacement
    gap[patches.nodes] = 0  # a profile computed again may differ in its last digits
    gap = np.concatenate((gap[-1:], gap, gap[:1]))
    lowest = 1 + np.flatnonzero((gap[1:-1] > 0) & (gap[1:-1] <= gap[:-2]) & (gap[1:-1] <= gap[2:]))
    left, node, right = (gap[lowest + step] for step in (-1, 0, 1))
    bend = left - 2 * node + right
    depth = (left - right) ** 2 / 8 - bend * node  # times the curvature
    stand_out = depth > 0
    ratio = depth[stand_out] / bend[stand_out] ** 2
    a = np.sqrt(2 * ratio)
    for _ in range(2 * layout.TURNS if half_space else 0):
        a = np.sqrt(ratio / (0.25 + np.log(2 / a) / 2))
    return 2 * float(a.sum())
