"""Estimates of the error that a grid leaves in the observables of a solution, by one rule:

    sqrt((a c)^2 + [b V/M (s/m)^2]^2 + e^2) + g.

c is the change from a grid with a quarter of the points to the present one, a the share of it that is left, and V the
value in M patches of m nodes, at least 1, with b fitted (`calibration`). In area and kappa a and b are 0, because the
ends of the patches tell more. In peak pressure and approach c is at least 1/16 of the change before, because it may be
small by chance. s is `Indenter.steepness`. Below the tip of a power profile with n < 2 the peak pressure is of the
order n - 1, and a = 1/(4^(n-1) - 1).

e is told by the present grid alone: for area and kappa the errors of the patches' ends (`edges`), for peak
pressure and approach the possible extremes between the nodes. g is the largest width of gaps and patches between two
nodes (`unseen`), in area and kappa. The share that an iteration leaves at its residual is added.

Under heights with a few kinks, and where a power profile's contact has split, all of c is taken. Nothing is known
(`inf`) of peak pressure and approach without a coarser grid; of peak pressure and kappa under heights with a few kinks,
where they may have no limit; of the peak pressure where its changes under a profile without a shortest wave do not
fall, as at a step, and under a stiff coating thinner than a grid spacing, where the nodes may miss anything; and of all
but the approach where a sharp tip (n < 2) presses a coating of a few spacings on a softer base down, which may split
the contact between the nodes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from .. import checks
from ..arrays import Array64
from ..calibration import FITTED
from ..scene import Scene
from .certificate import MEANINGLESS, Certificate
from .contact import Contact
from .layer_on_grid import modulus_on_grid
from .observables import Measured, Observables
from .patches import Patches

FACTOR = 4
"""Points of a grid over those of the next coarser one."""


@dataclass(frozen=True)
class Quantity:
    """Something that is measured, and how its error is estimated; names are those in `Observables`."""

    value: str
    """Its name."""
    error: str
    """The name of its error, in `Observables` only."""
    alone: str
    """The name of the part of its error that a grid tells alone."""
    of_nodes: str | None = None
    """The name in `Calibration` of the error that few nodes leave; None where this grid tells more than changes do."""
    of_lowest: bool = False
    """Whether it counts from the profile's lowest point, and does not depend on the largest pressure."""
    of_slopes: bool = False
    """Whether slopes matter, too."""

    @property
    def of_area(self) -> bool:
        """Whether its error follows from that of the contact area."""
        return self.of_nodes is None


QUANTITIES = {
    "contact-area": Quantity("contact_area_subgrid", "contact_area_error", "contact_area_edges_error"),
    "kappa": Quantity("kappa_subgrid", "kappa_error", "kappa_edges_error", of_slopes=True),
    "peak-pressure": Quantity("peak_pressure", "peak_pressure_error", "peak_pressure_sampling", "of_nodes_in_peak"),
    "approach": Quantity("approach", "approach_error", "approach_sampling", "of_nodes_in_approach", of_lowest=True),
}
"""By the name under which an accuracy of it is asked for."""

DEFAULT_QUANTITY = "contact-area"

MOST_ACCURACY = 0.1
"""Coarsest relative error that may be asked for (dimensionless)."""

_LEFT = 0.2
"""Share of the last change from grid to grid that is left in peak pressure and approach; the first order leaves 1/3,
the order 3/2 of pressures at ends 1/7."""
_STIFF = 0.9
"""2K/(E* q) of a wave, below which shorter ones find the layer stiffer."""


def check_accuracy(accuracy: float | None, of: str) -> float | None:
    """The accuracy, if it is one that may be asked for, of one of `QUANTITIES`; None for none. Raises `ValueError`."""
    checks.choice("accuracy_of", of, tuple(QUANTITIES))
    if accuracy is not None:
        allowed = "1e-9 <= accuracy <= 0.1"
        return checks.real("accuracy", accuracy, allowed, math.nextafter(1e-9, 0), MOST_ACCURACY)
    if of != DEFAULT_QUANTITY:
        raise ValueError(f"accuracy_of is {of!r}; allowed: together with an accuracy")
    return None


def estimated(quantity: Quantity, scene: Scene, num_points: int, found: Measured, coarser: Sequence[Measured]) -> float:
    """Estimated error that a grid leaves in a quantity, in its unit.

    found: on this grid; coarser: the grids before it, from coarse to fine. Without any, the estimate by this grid
    alone, and `inf` for a quantity that does not depend on edges.
    """
    values = [abs(float(getattr(level, quantity.value))) for level in (*coarser[-2:], found)]
    alone, area, unseen = float(getattr(found, quantity.alone)), found.contact_area_subgrid, 0.0
    if quantity.of_area and area:
        unseen = sensitivity(quantity, scene) * found.unseen_gap_area / area * values[-1]
    left = _left(quantity, scene, num_points, found, values) if coarser else 0.0
    if not (quantity.of_area or coarser) or (area and _unknown(quantity, scene, num_points, area)):
        return math.inf
    return math.hypot(left, alone) + unseen


def _left(quantity: Quantity, scene: Scene, num_points: int, found: Measured, values: Sequence[float]) -> float:
    power = scene.indenter.power_law
    changes = [abs(after - before) for before, after in pairwise(values)]
    last, share = changes[-1], _LEFT if quantity.of_nodes else 0.0
    if power and power[0] < 2 and not (quantity.of_area or quantity.of_lowest):
        share = 1 / (FACTOR ** (power[0] - 1) - 1)
    if scene.indenter.kinked or (power and found.num_patches > 1):
        share = max(share, 1.0)
    if not quantity.of_nodes:
        return share * last
    if len(changes) == 2:
        limited = scene.indenter.shortest_wave(num_points) or power or quantity.of_lowest
        if not limited and last > max(changes[0], float(getattr(found, quantity.alone))):
            return math.inf
        last = max(last, changes[0] / FACTOR**2)
    patches = max(found.num_patches, 1)
    nodes = max(found.contact_area_subgrid * num_points / patches, 1.0)
    of_nodes = values[-1] * (scene.indenter.steepness / nodes) ** 2 / patches
    return math.hypot(share * last, getattr(FITTED, quantity.of_nodes) * of_nodes)


def _unknown(quantity: Quantity, scene: Scene, num_points: int, area: float) -> bool:
    """Whether nothing is known of a quantity because of a kink, or because shorter waves find the layer stiffer."""
    if quantity.of_lowest:
        return False
    if scene.indenter.kinked and (quantity.of_slopes or not quantity.of_area):
        return True
    sharp = scene.indenter.power_law and scene.indenter.power_law[0] < 2 and area < 1
    if quantity.of_area and not sharp:
        return False
    waves = np.array([np.pi / FACTOR, np.pi])  # a sharp tip brings waves of eight spacings with it
    of_tip, shortest = modulus_on_grid(scene.layer, waves, num_points, scene.period)
    splits = sharp and of_tip < min(_STIFF, shortest)
    return bool(splits or (not quantity.of_area and shortest < _STIFF))


def sensitivity(quantity: Quantity, scene: Scene) -> float:
    """The relative error of a quantity over that of a_r where both have the same cause.

    Kappa of a power profile goes like a_r^n, and other kappas are taken to go like a_r^2.
    """
    power = scene.indenter.power_law
    return max(2.0, power[0] if power else 2.0) if quantity.of_slopes else 1.0


def iteration_share(equilibrium_residual: float, area: float = 0.0) -> float:
    """Estimated relative error of a_r that an equilibrium residual leaves; `inf` where the area may be anything.

    area: a_r. If that is nearly the whole period, a load that is off by the residual moves the ends of the last gaps,
    as under H. M. Westergaard's wave: p = p_full [1 - cos^2(pi a_r/2)].
    """
    open_part = math.cos(math.pi / 2 * area)
    of_gaps = 2 / math.pi * (math.hypot(open_part, math.sqrt(equilibrium_residual)) - open_part) if area < 1 else 0.0
    return max(equilibrium_residual, of_gaps) if equilibrium_residual < MEANINGLESS else math.inf


def left_at_ends(largest: float, patches: Patches, pressure: Array64) -> float:
    """Estimated error of a_r that a residual leaves at the ends of patches (dimensionless).

    An end is anywhere among the nodes whose pressure is below the error that the residual leaves, and the
    next node tells it the better the more it carries. Residuals near single ends, up to a hundred times the rms, add up
    at the two ends of a patch; those of different patches add up in squares.

    largest: the largest force on a free node over the mean pressure; pressure: of all nodes, shape (N,) [any unit].
    """
    if not patches.count or patches.full or not math.isfinite(largest):
        return 0.0
    error, inside = largest * float(pressure.mean()), pressure[patches.nodes]
    above, begin = np.flatnonzero(inside > error), patches.offset
    behind = begin + patches.size
    first, last = np.searchsorted(above, begin), np.searchsorted(above, behind) - 1
    some = first <= last
    off = np.zeros((2, patches.count))  # [grid spacings]
    off[0] = patches.size  # without a node above, all of the patch
    first, last = above[first[some]], above[last[some]]
    off[0, some] = first - begin[some] + error / inside[first]
    off[1, some] = behind[some] - 1 - last + error / inside[last]
    return float(np.linalg.norm(off.sum(axis=0))) / pressure.size


def with_errors(
    scene: Scene,
    observables: Observables,
    levels: Sequence[Measured],
    certificate: Certificate,
    contact: Contact,
) -> Observables:
    """Observables on the scene's grid with the estimated errors, of the grid and of the unfinished iteration.

    levels: the coarser grids, from coarse to fine.
    """
    errors: dict[str, Any] = {}
    area = observables.contact_area_subgrid
    residual = certificate.equilibrium_residual
    share = iteration_share(residual, area)
    at_ends = left_at_ends(certificate.largest_residual, contact.patches, contact.pressure)
    for quantity in QUANTITIES.values():
        value = abs(getattr(observables, quantity.value))
        left = share + at_ends / area if quantity.of_area and area else share
        unfinished = sensitivity(quantity, scene) * left * value if math.isfinite(left) else math.inf
        errors[quantity.error] = estimated(quantity, scene, scene.num_points, observables, levels) + unfinished
    return replace(observables, **errors)
