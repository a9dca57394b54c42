"""Patches and gaps of a few nodes on the grid of a half-space, which has no waves shorter than two spacings: what they
do around them, and the punches and gaps that do the same without a grid.

Units: E* = 1 and the grid spacing.
"""

import functools

import numpy as np

from ..arrays import Array64

MOST_NODES = 32
"""Nodes of patches and gaps whose ends are found from all of these; the last pressures know the ends of wider ones as
well."""
MARGIN = 3
"""Nodes to each side of such a patch or gap that are looked at, too."""


@functools.cache
def node_compliance() -> Array64:
    """Displacement g_j by a unit load on one node, j = 0, 1, ... nodes away, shape (MOST_NODES + MARGIN,).

    g_j = 2/pi (gamma + ln pi - int (1 - cos j t)/t dt over 0 < t < pi): far away -2/pi ln j, as without a grid.
    """
    nodes, weights = np.polynomial.legendre.leggauss(128)
    t = np.pi / 2 * (1 + nodes)
    rest = (1 - np.cos(np.arange(MOST_NODES + MARGIN)[:, None] * t)) / t @ weights * (np.pi / 2)
    found = 2 / np.pi * (np.euler_gamma + np.log(np.pi) - rest)
    found.flags.writeable = False
    return np.asarray(found)


@functools.cache
def node_stiffness() -> Array64:
    """Pressure K_j where the surface is displaced by 1 at one node, j = 0, 1, ... nodes away, shape (MOST_NODES +
    MARGIN,): 1/(2 pi) int t cos j t dt over 0 < t < pi.
    """
    nodes = np.arange(1, MOST_NODES + MARGIN)
    found = np.append(np.pi / 4, np.where(nodes % 2, -1 / (np.pi * nodes**2), 0.0))
    found.flags.writeable = False
    return found


@functools.cache
def equivalent_gaps() -> Array64:
    """Half-widths of the gaps that open as far without a grid as 1, 2, ... nodes do with it, shape (MOST_NODES,).

    A gap of the half-width b opens over the area pi b^2 p where the pressure p is taken away (H. Tada, P. C. Paris and
    G. R. Irwin, The Stress Analysis of Cracks Handbook (1973), of one side of the crack).
    """
    return np.asarray(np.sqrt(_sums(node_stiffness()) / np.pi))


@functools.cache
def equivalent_half_widths() -> Array64:
    """Half-widths of the flat punches that are as compliant without a grid as 1, 2, ... nodes are with it, shape
    (MOST_NODES,).

    A punch of the half-width a under the load P is displaced by -2/pi P ln(a/2) (K. L. Johnson, Contact Mechanics
    (1985), section 2.8).
    """
    return np.asarray(2 * np.exp(-np.pi / 2 / _sums(node_compliance())))


def _sums(kernel: Array64) -> Array64:
    """Sums over 1, 2, ... nodes of the values that cause 1 at each of these nodes, shape (MOST_NODES,)."""
    found = np.empty(MOST_NODES)
    for size in range(1, MOST_NODES + 1):
        steps = np.arange(size)
        found[size - 1] = np.linalg.solve(kernel[np.abs(steps[:, None] - steps)], np.ones(size)).sum()
    return found
