"""The formulas of `solver/grid/edges.py` in NumPy, as the kernel `pressed_ends` has them: its reference."""

import numpy as np
from linecontact.kernels.layout import ALIKE, TURNS

NARROWEST = 0.5


def edge_offset(curve, pressures):
    """theta from the last three pressures, (..., 3), and from the last two, within bounds; how far they differ."""
    least, most = -curve.shift, 1 - curve.shift
    with np.errstate(all="ignore"):
        ratio = pressures[..., 0] / pressures[..., 1]
        two = curve.table[0] - ratio * curve.table[1]
        two = two / (two + ratio * curve.table[0]) - curve.shift
        low, middle, high = np.moveaxis(pressures @ curve.rows.T, -1, 0)
        theta = -2 * low / middle
        for _ in range(TURNS):
            theta = -2 * low / (middle + 0.75 * theta * high)
        theta += curve.delta
    two[~np.isfinite(two)] = 0.5 - curve.shift
    bounded = np.clip(two, least, most)
    differ, unknown = np.abs(theta - bounded), ~np.isfinite(theta)
    differ[unknown], theta[unknown] = 1.0, bounded[unknown]
    theta = np.clip(theta, least, most)
    theta = np.where(np.abs(theta - bounded) < ALIKE, theta, bounded)
    return theta, bounded, np.maximum(np.abs(two - bounded), differ)


def edge_function(curve, beta, j):
    """The edge pressure at the nodes j from the last contact node inwards; on the half-space ~ sqrt(j - theta)."""
    return (1 - beta) * curve.at(j) + beta * curve.at(j - 1)


def edge_distance(curve, theta):
    """Pressures of the last three nodes under a far field x^(3/2) over those under x^(1/2), shape (..., 3)."""
    theta = np.asarray(theta)[..., None] - curve.delta
    high, middle, low = np.linalg.inv(curve.rows).T[::-1]
    edge = middle - theta / 2 * low
    bent = high - 1.5 * theta * middle + 0.375 * theta**2 * low
    return np.where(edge > 2.0**-26, bent / np.maximum(edge, 2.0**-26), 0.0)


def ends(patches, pressure):
    """The last three pressures of left and right ends, last node first, shape (2, M, 3)."""
    steps = np.minimum(np.arange(3), patches.size[:, None] - 1)
    left = pressure[patches.offset[:, None] + steps]
    return np.stack([left, pressure[(patches.offset + patches.size - 1)[:, None] - steps]])


def around(patches, theta):
    """Widths of patches, and of the gaps to their left and right, shape (2, M)."""
    width = np.maximum(patches.size - 1 - theta.sum(axis=0), 2.0)
    facing = np.stack([np.roll(theta[1], 1), np.roll(theta[0], -1)])
    return width, np.maximum(patches.gap + 1 + theta + facing, NARROWEST)


def in_row(curve, patches, theta):
    """The factor that all other ends of a row of such patches and gaps give to the last three pressures."""
    width, gap = (of[..., None] for of in np.broadcast_arrays(*around(patches, theta)))
    wave, away = np.pi / (width + gap), np.minimum(edge_distance(curve, theta), width)
    beyond = np.sin(wave * np.maximum(width - away, NARROWEST)) * np.sinc(wave / np.pi * away)
    return np.sin(wave * (gap / 2 + away)) * np.sqrt(beyond)


def in_patch(curve, patches, theta):
    """The factor that the patch's other end gives to them."""
    away = patches.size[:, None] - 1 - np.arange(3)
    return np.maximum(edge_function(curve, (theta + curve.shift)[::-1, :, None], away), 1e-3)


def offsets(curve, patches, pressure, others):
    """theta and how little the pressures look like an edge, shape (2, M) each, by turns; the latter alone, (6, M)."""
    theta = np.full((2, patches.count), 0.5 - curve.shift)
    for _ in range(TURNS):
        alone = ends(patches, pressure) / others(curve, patches, theta)
        theta, _, spread = edge_offset(curve, alone)
    return theta, spread, np.moveaxis(alone, -1, 1).reshape(6, -1)


def by_load(curve, patches, theta, known):
    """The rest of the second order if the load is given, shape (2, M); 0 where ends are not known."""
    width, gap = around(patches, theta)
    tangent, beta = np.tan(np.pi / 2 * width / (width + gap)), theta + curve.shift
    mean = np.sum(beta**2 - beta + 1 / 6, where=known) / 8 / max(known.sum(), 1)
    return np.where(known, np.pi / (width + gap) * (3 / tangent + tangent) / 2 * mean, 0.0)
