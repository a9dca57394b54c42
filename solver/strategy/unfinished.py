"""What an iteration that was ended at a residual leaves of the errors, and these with it."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import Array64
from ..calibration import FITTED
from ..grid.certificate import Certificate
from ..grid.observables import Observables
from ..grid.patches import Patches
from ..scene import Scene
from ..solution import MEANINGLESS, Level
from .errors import QUANTITIES, estimated, sensitivity


def iteration_share(free_residual: float, area: float = 0.0) -> float:
    """Estimated relative error of a_r that a free residual leaves; `inf` where the area may be anything.

    Measured: up to 0.12 of residuals below 1e-3, 0.3 below blunt indenters on thin layers, 0.8 of one of 0.03. area:
    a_r. If that is nearly the whole period, a load that is off by the residual moves the ends of the last gaps, as
    under H. M. Westergaard's wave: p = p_full [1 - cos^2(pi a_r/2)].
    """
    open_part = math.cos(math.pi / 2 * area)
    of_gaps = 2 / math.pi * (math.hypot(open_part, math.sqrt(free_residual)) - open_part) if area < 1 else 0.0
    return max(free_residual, of_gaps) if free_residual < MEANINGLESS else math.inf


def left_at_ends(free_residual: float, patches: Patches, pressure: Array64, largest: float | None = None) -> float:
    """Estimated error of a_r that a residual leaves at the ends of patches (dimensionless).

    An end is anywhere among the nodes whose pressure is below what the residual leaves of it, and the next node tells
    it the better the more it carries. That matters on thin incompressible layers, where the pressure rises like a
    parabola, and below blunt profiles. The part that all ends have in common follows from the rms residual; what is
    left near single ends, which may be a hundred times as much, differs from end to end and adds up in squares.

    free_residual, largest: rms and largest force on the free nodes, over the mean pressure; None where the largest one
    is not known, and then all of the residual may be at one node; pressure: of all nodes, shape (N,) [any unit].
    """
    if not patches.count or patches.full or not math.isfinite(free_residual):
        return 0.0
    if largest is None:
        largest = free_residual * math.sqrt(pressure.size - patches.nodes.size)
    unit = float(pressure.mean())
    common = _off_at_ends(FITTED.of_residual * free_residual * unit, patches, pressure)
    single = _off_at_ends(FITTED.of_largest_residual * largest * unit, patches, pressure)
    return max(float(common.sum()), float(np.linalg.norm(single))) / pressure.size


def _off_at_ends(error: float, patches: Patches, pressure: Array64) -> Array64:
    """How far off the ends of patches are where the pressures of their nodes are off by `error`, shape (2, patches)
    [grid spacings].
    """
    inside = pressure[patches.nodes]
    above, begin = np.flatnonzero(inside > error), patches.offset
    behind = begin + patches.size
    first, last = np.searchsorted(above, begin), np.searchsorted(above, behind) - 1
    some = first <= last
    off = np.zeros((2, patches.count))
    off[0] = patches.size  # without a node above, all of the patch
    first, last = above[first[some]], above[last[some]]
    off[0, some] = first - begin[some] + error / inside[first]
    off[1, some] = behind[some] - 1 - last + error / inside[last]
    return off


def with_errors(
    scene: Scene,
    observables: Observables,
    levels: Sequence[Level],
    certificate: Certificate,
    patches: Patches,
    pressure: Array64,
) -> Observables:
    """Observables on the scene's grid with the estimated errors: what the grid leaves, and an unfinished iteration.

    levels: the coarser grids, from coarse to fine; patches, pressure: of the contact, see `left_at_ends`.
    """
    errors: dict[str, Any] = {}
    area = observables.contact_area_subgrid
    residual = certificate.free_residual
    share = iteration_share(residual, area)
    at_ends = left_at_ends(residual, patches, pressure, certificate.largest_residual)
    for quantity in QUANTITIES.values():
        value = abs(getattr(observables, quantity.value))
        left = share + at_ends / area if quantity.of_area and area else share
        unfinished = sensitivity(quantity, scene) * left * value if math.isfinite(left) else math.inf
        errors[quantity.error] = estimated(quantity, scene, scene.num_points, observables, levels) + unfinished
    return replace(observables, **errors)
