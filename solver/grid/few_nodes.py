"""What the grid of a half-space makes of patches of a few nodes: it has no waves shorter than two spacings.

Units: E* = 1 and the grid spacing.
"""

import functools

import numpy as np

from ..arrays import Array64


@functools.cache
def response(most: int) -> Array64:
    """Displacement g_j beside a node of unit load, j = 0, 1, ..., most nodes away, shape (most + 1,).

    g_j = 2/pi (gamma + ln pi - int (1 - cos j t)/t dt over 0 < t < pi): far away -2/pi ln j, as without a grid.
    """
    nodes, weights = np.polynomial.legendre.leggauss(64 + 4 * most)
    t = np.pi / 2 * (1 + nodes)
    rest = (1 - np.cos(np.arange(most + 1)[:, None] * t)) / t @ weights * (np.pi / 2)
    found = 2 / np.pi * (np.euler_gamma + np.log(np.pi) - rest)
    found.flags.writeable = False
    return np.asarray(found)


@functools.cache
def punch_half_widths(most: int) -> Array64:
    """Half-widths of the flat punches that are as compliant without a grid as 1, 2, ..., most nodes are with it, shape
    (most,).

    A punch of the half-width a under the load P is displaced by -2/pi P ln(a/2) (K. L. Johnson, Contact Mechanics
    (1985), section 2.8).
    """
    near = response(most - 1)
    found = np.empty(most)
    for size in range(1, most + 1):
        steps = np.arange(size)
        pressure = np.linalg.solve(near[np.abs(steps[:, None] - steps)], np.ones(size))
        found[size - 1] = 2 * np.exp(-np.pi / 2 / pressure.sum())
    found.flags.writeable = False
    return found
