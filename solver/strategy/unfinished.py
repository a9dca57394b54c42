"""What an iteration that was ended at a residual leaves of the errors, and these with it."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import Array64
from ..grid.observables import Observables
from ..grid.patches import Patches
from ..scene import Scene
from ..solution import Level
from .errors import QUANTITIES, estimated, sensitivity

_OF_PRESSURE = 5.0  # error of a node's pressure over the free residual


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
    """Estimated error of a_r that a free residual leaves at the ends of patches (dimensionless).

    An end is anywhere among the nodes whose pressure is below what the residual leaves of it, and the next node tells
    it the better the more it carries. That matters on thin incompressible layers, where the pressure rises like a
    parabola. pressure: of all nodes, shape (N,) [any unit]; free_residual: over its mean.
    """
    if not patches.count or patches.full or not math.isfinite(free_residual):
        return 0.0
    inside = pressure[patches.nodes]
    error = _OF_PRESSURE * free_residual * float(pressure.mean())
    above, begin = np.flatnonzero(inside > error), patches.offset
    first, behind = np.searchsorted(above, begin), np.searchsorted(above, begin + patches.size)
    some = behind > first
    first, last = above[first[some]], above[behind[some] - 1]
    beyond = patches.size[~some].sum() + (patches.size[some] - (last - first + 1)).sum()
    return float(beyond + (error / inside[first]).sum() + (error / inside[last]).sum()) / pressure.size


def with_errors(
    scene: Scene,
    observables: Observables,
    levels: Sequence[Level],
    free_residual: float,
    patches: Patches,
    pressure: Array64,
) -> Observables:
    """Observables on the scene's grid with the estimated errors: what the grid leaves, and an unfinished iteration.

    levels: the coarser grids, from coarse to fine; free_residual: over p; patches, pressure: of the contact, see
    `left_at_ends`.
    """
    errors: dict[str, Any] = {}
    area = observables.contact_area_subgrid
    share = iteration_share(free_residual, area, rounded=scene.precision == "float32")
    at_ends = left_at_ends(free_residual, patches, pressure)
    for quantity in QUANTITIES.values():
        value = abs(getattr(observables, quantity.value))
        left = share + at_ends / area if quantity.of_area and area else share
        unfinished = sensitivity(quantity, scene) * left * value if math.isfinite(left) else math.inf
        errors[quantity.error] = estimated(quantity, scene, scene.num_points, observables, levels) + unfinished
    return replace(observables, **errors)
