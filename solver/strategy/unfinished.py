"""What an iteration that was ended at a residual leaves of the contact area's error."""

import math

import numpy as np

from ..arrays import Array64
from ..grid.patches import Patches

_FLAT = 1e-4  # pressure of the last node but one, over that of its patch in the mean, at an end that it hardly tells
_OF_PRESSURE = 10.0  # error of that pressure over the free residual; measured up to 6


def iteration_share(free_residual: float, area: float = 0.0, rounded: bool = False) -> float:
    """Estimated relative error of a_r that a free residual leaves; `inf` where the area may be anything.

    Measured: up to 0.12 of residuals below 1e-3, 0.3 below blunt indenters on thin layers; 0.8 of one of 0.03, and of
    no meaning beyond. rounded: whether the residual may be rounding to float32, which acts at the edges; measured up to
    1.2 of it. area: a_r. If that is nearly the whole period, a load that is off by the residual moves the ends of the
    last gaps, as under H. M. Westergaard's wave: p = p_full [1 - cos^2(pi a_r/2)].
    """
    open_part = math.cos(math.pi / 2 * area)
    of_gaps = 2 / math.pi * (math.hypot(open_part, math.sqrt(free_residual)) - open_part) if area < 1 else 0.0
    share = max((1.5 if rounded else 0.4) * free_residual, of_gaps) + 30 * free_residual**2
    return share if share < 1 else math.inf


def near_full_contact(area: float) -> float:
    """How many times more of a small residual is left in an area that is nearly the whole period, see
    `iteration_share`; at least 1.
    """
    return max(1.0, math.tan(math.pi / 2 * area) / (0.4 * math.pi)) if area < 1 else 1.0


def left_at_ends(free_residual: float, patches: Patches, pressure: Array64) -> float:
    """Estimated error of a_r that a free residual leaves at ends where the pressure rises from 0 so slowly that it
    hardly tells where they are, as on thin incompressible layers: up to a grid spacing at each (dimensionless).

    pressure: of all nodes, shape (N,) [any unit]; free_residual: over its mean.
    """
    if not patches.count or patches.full:
        return 0.0
    n, mean = pressure.size, float(pressure.mean())
    of_patches = patches.sums(pressure[patches.nodes]) / patches.size
    inner = np.minimum(1, patches.size - 1)  # of a patch of one node that node
    last = pressure[np.concatenate((patches.first + inner, patches.last - inner)) % n]
    flat = last < _FLAT * np.tile(of_patches, 2)
    error = _OF_PRESSURE * free_residual * mean
    return float(np.minimum(1.0, error / last[flat]).sum()) / n
