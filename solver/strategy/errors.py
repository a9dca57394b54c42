"""Estimates of the error that grid and iteration leave in what is measured on a solution.

From a grid with a quarter of the points to the present one a quantity changes by c; its error estimated from the edges
of the patches alone is e. On a surface with w points to its shortest wave its error is estimated as

    contact area     sqrt(e^2 + b^2) + g
    kappa            sqrt(e^2 + b^2) + g
    peak pressure    sqrt((c/3)^2 + (c'/32)^2 + s^2)
    approach         sqrt((c/4)^2 + (c'/32)^2 + s^2)

with c' the change before c and s what the nodes may miss of a peak, or of the lowest point, between them, which grids
that share a node do not tell by their changes; with one coarser grid alone they are c and 2 c. Of scans and own
indenters, which do not tell what lies between the nodes, area and kappa have a further c/48 under the root.

On smooth profiles b = 0, and area and kappa have 0.36 and 0.5 of e, and c/13 and c/8 beside it. The order of pressure
and approach is measured there, and at best the first is believed: sqrt((m c)^2 + (c'/16)^2), m = 1/(c'/c - 1) between
1/3 and 4, which also keeps a change that is small by accident from being believed; with one coarser grid the whole
change. Below the tip of a power profile with n < 2 the pressure is known to be of the order n - 1: m = 1/(4^(n-1) - 1).
Where the changes of another profile's peak fall by less than a factor of 1.25, and are above 1e-3 of it, the pressure
may have no limit, as below a kink or at a step: `inf`.

Under smooth profiles e is taken whole for patches of fewer than 20 nodes, and where a table ends with the grid's
shortest wave. b is what the errors of many patches have in common: up to 0.02 (16/w)^2.5 grid spacings for the area of
each patch whose pressures tell where it ends (0.03 for kappa), and 0.002 (16/w)^2.5 (0.003) if its load does. g is the
most that gaps and patches between two nodes may be wide, over the period, see `unseen`; in kappa it is the same share.
Under a power profile with n > 2 the width has a further 2/s^3 spacings, up to 2, with s those in which the slope at its
ends becomes e times as large. Under heights with a few kinks, and where a power profile's contact has split, c counts
in full. What these numbers stand for is said in docs/accuracy.md.

Under a stiff coating thinner than a grid spacing the nodes may miss anything of the peak pressure (`inf`), and under
one of a few spacings the contact of a sharp tip (n < 2) may split between them: then nothing but the approach has an
error that is known. With one coarser grid alone the estimated errors of peak pressure and approach are at least 1/m^2
of the value, with m nodes to a patch, because the only change may be small by chance.

The numbers were fitted to random scenes (power profiles on layers and half-spaces against collocation; 1900 rough
surfaces with 4 to 128 points to the shortest wave against grids of 8 times as many points and more), so that each
estimate holds in 97 of 100. On scenes that nothing was fitted to, see `linecontact study tradeoff`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..grid.edge_curves import edge_curve
from ..grid.layer_on_grid import modulus_on_grid
from ..grid.observables import Observables
from ..scene import Scene
from ..solution import Level


@dataclass(frozen=True)
class Quantity:
    """Something that is measured, and how its error is estimated."""

    value: str
    """Its name in `Observables` and `Level`."""
    error: str
    """The name of its error in `Observables`."""
    edges: str | None = None
    """The name, in both, of what its error would be by the edges alone; None where they do not matter."""
    of_edges: float = 0.0
    """Share of that which is left beside a coarser grid under smooth profiles (dimensionless)."""
    of_change: tuple[float, float] = (0.0, 0.0)
    """Share of the last change between grids that is left under smooth profiles, and under rough ones that are not
    known between the nodes (dimensionless)."""
    per_patch: tuple[float, float] = (0.0, 0.0)
    """Error that patches have in common at 16 points to the shortest wave, in the width of each, where pressures and
    where loads tell their ends [grid spacings]."""
    of_changes: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of what does not depend on edges, the shares of the last change and the one before that are left under rough
    profiles, and of the only one where there is no other (dimensionless)."""
    of_lowest: bool = False
    """Whether it counts from the profile's lowest point, and does not depend on the largest pressure."""
    sampling: str | None = None
    """The name, in both, of what nodes may miss of it; None where it depends on edges."""
    of_slopes: bool = False
    """Whether slopes matter, too."""
    sensitivity: float = 1.0
    """See the function `sensitivity` (dimensionless)."""

    @property
    def of_area(self) -> bool:
        """Whether its error follows from that of the contact area."""
        return self.edges is not None


QUANTITIES = {
    "contact-area": Quantity(
        "contact_area_subgrid",
        "contact_area_error",
        "contact_area_edges_error",
        of_edges=0.36,
        of_change=(1 / 13, 1 / 48),
        per_patch=(0.02, 0.002),
    ),
    "kappa": Quantity(
        "kappa_subgrid",
        "kappa_error",
        "kappa_edges_error",
        of_edges=0.5,
        of_change=(1 / 8, 1 / 48),
        per_patch=(0.03, 0.003),
        of_slopes=True,
        sensitivity=2.0,
    ),
    "peak-pressure": Quantity(
        "peak_pressure", "peak_pressure_error", of_changes=(1 / 3, 1 / 32, 1.0), sampling="peak_pressure_sampling"
    ),
    "approach": Quantity(
        "approach", "approach_error", of_changes=(1 / 4, 1 / 32, 2.0), of_lowest=True, sampling="approach_sampling"
    ),
}
"""By the name under which an accuracy of it is asked for."""

DEFAULT_QUANTITY = "contact-area"

_CAREFUL_FROM_IF_SMOOTH = 20.0
"""Nodes of a patch under a smooth profile, on the average, from which on its edges are known better than estimated."""
_KNOWN = 0.001  # error of a layer's edge up to which that is so [grid spacings]
_COMMON, _COMMON_POWER = 16.0, 2.5  # points to the shortest wave, and the power with which their share falls
_LEAST, _MOST = 1.25, 4.0  # factor by which changes fall from grid to grid, as far as that is believed
_WAVE_OF_TIP = 8.0  # that a sharp tip brings with it [grid spacings]
_STIFF = 0.9  # 2K/(E* q) of the shortest wave, below which shorter ones find the layer stiffer
_STEEP, _MOST_STEEP = 2.0, 2.0  # errors of a contact's width below a steep side [grid spacings]
_HARDLY = 1e-3  # relative change that is no matter of the tolerance, or of chance
_EARLIER = 1 / 16  # share of the change before the last


def estimated(
    quantity: Quantity,
    scene: Scene,
    num_points: int,
    found: Observables | Level,
    coarser: Sequence[Observables | Level],
) -> float:
    """Estimated error that a grid leaves in a quantity, in its unit.

    found: on this grid; coarser: the grids before it, from coarse to fine. Without any, the estimate from the
    edges alone, and `inf` for what does not depend on edges.
    """
    waves = scene.indenter.effective_wave(num_points) / num_points  # 1/w
    values = [float(getattr(level, quantity.value)) for level in (*coarser[-2:], found)]
    if not quantity.edges:
        return _of_nodes(quantity, scene, num_points, found, values, bool(waves))
    edges, area = float(getattr(found, quantity.edges)), found.contact_area_subgrid
    if not area:
        return edges
    if area < 1 and _splits(scene, num_points):
        return math.inf
    by_load = found.num_patches_by_load
    gaps = found.unseen_gap_area / area * abs(values[-1])
    each = [share * of for share, of in zip(quantity.per_patch, (found.num_patches - by_load, by_load), strict=True)]
    spacings = sum(each) * math.pow(_COMMON * waves, _COMMON_POWER)
    spacings += sensitivity(quantity, scene) * _of_steep_sides(scene, found.contact_area_subgrid * num_points)
    common = spacings / num_points / area * abs(values[-1])
    if not coarser:
        return math.hypot(edges, common) + gaps
    rough = waves > 0
    careful = not rough and area * num_points >= _CAREFUL_FROM_IF_SMOOTH * found.num_patches
    careful &= edge_curve(scene.layer, num_points, scene.period).error < _KNOWN
    of_edges = quantity.of_edges if careful else 1.0
    if scene.indenter.kinked or (scene.indenter.power_law and found.num_patches > 1):
        of_change = 1.0
    elif rough:
        of_change = 0.0 if scene.indenter.knows_lowest else quantity.of_change[1]
    else:
        of_change = quantity.of_change[0]
    change = of_change * abs(values[-1] - values[-2])
    return math.hypot(of_edges * edges, change, common) + gaps


def _of_steep_sides(scene: Scene, width: float) -> float:
    """What a contact of this width may be off by because the profile rises between two nodes at its ends, where its
    slope goes like |x|^(n-1) [grid spacings].
    """
    power = scene.indenter.power_law
    if power is None or power[0] <= 2 or not width:
        return 0.0
    nodes = width / 2 / (power[0] - 1)  # in which the slope becomes e times as large
    return min(_STEEP / nodes**3, _MOST_STEEP)


def _of_nodes(
    quantity: Quantity, scene: Scene, num_points: int, found: Observables | Level, values: Sequence[float], rough: bool
) -> float:
    """`estimated` for what does not depend on edges. values: as in `_by_order`; rough: whether there is a shortest
    wave.
    """
    assert quantity.sampling
    power = scene.indenter.power_law
    splits = found.contact_area_subgrid < 1 and _splits(scene, num_points)
    if not quantity.of_lowest and (splits or _hides_peaks(scene, num_points)):
        return math.inf
    if rough:
        left = _by_shares(values, quantity.of_changes)
    elif quantity.of_lowest:
        left = _by_order(values)
    elif power:
        left = _by_order(values, _MOST ** (power[0] - 1) if power[0] < 2 else None)
    else:
        left = _with_limit(values, _by_order(values))
    if len(values) == 2 and not rough:
        left = math.hypot(left, _least_error(values[-1], num_points, found))
    return math.hypot(left, float(getattr(found, quantity.sampling)))


def _least_error(value: float, num_points: int, found: Observables | Level) -> float:
    """What is left of a second-order error at least, however small the only change between grids is by chance."""
    nodes = found.contact_area_subgrid * num_points / max(found.num_patches, 1)
    return abs(value) / nodes**2 if nodes else 0.0


def _with_limit(values: Sequence[float], left: float) -> float:
    """What is left, `inf` where the changes hardly fall."""
    changes = [abs(after - before) for before, after in pairwise(values)]
    grows = len(changes) == 2 and changes[1] > max(changes[0] / _LEAST, _HARDLY * abs(values[-1]))
    return math.inf if grows else left


def _hides_peaks(scene: Scene, num_points: int) -> bool:
    """Whether waves that the grid has not find the layer stiffer, as on a coating thinner than a spacing on a softer
    base: then the pressure may have peaks between the nodes, at edges and tips.
    """
    return bool(modulus_on_grid(scene.layer, np.array([np.pi]), num_points, scene.period)[0] < _STIFF)


def _splits(scene: Scene, num_points: int) -> bool:
    """Whether the contact may split between the nodes: a sharp tip (n < 2) presses a coating of a few spacings on a
    softer base down beside itself.
    """
    power = scene.indenter.power_law
    if power is None or power[0] >= 2:
        return False
    waves = np.array([2 * np.pi / _WAVE_OF_TIP, np.pi])
    of_tip, shortest = modulus_on_grid(scene.layer, waves, num_points, scene.period)
    return bool(of_tip < min(_STIFF, shortest))


def _by_shares(values: Sequence[float], shares: tuple[float, float, float]) -> float:
    """What the changes of a quantity from grid to grid leave by shares of them, see `Quantity`. values: as in
    `_by_order`.
    """
    changes = [abs(after - before) for before, after in pairwise(values)]
    if len(changes) < 2:
        return shares[2] * changes[0] if changes else math.inf
    return math.hypot(shares[0] * changes[1], shares[1] * changes[0])


def _by_order(values: Sequence[float], falls: float | None = None) -> float:
    """What the changes of a quantity from grid to grid leave by the order that they have.

    values: on up to three grids, from coarse to fine; of one grid nothing is known (`inf`). falls: the factor by which
    changes fall, if it is known.
    """
    if len(values) == 1:
        return math.inf
    change = abs(values[-1] - values[-2])
    if falls:
        return change / (falls - 1)
    if len(values) == 2:
        return change
    before = abs(values[-2] - values[-3])
    ratio = min(max(before / change, _LEAST), _MOST) if change else _MOST
    return math.hypot(change / (ratio - 1), _EARLIER * before)


def grid_error(quantity: Quantity, scene: Scene, level: Level, coarser: Sequence[Level]) -> float:
    """As `estimated`, relative; `inf` on the first grid, and where the quantity is 0."""
    value = abs(getattr(level, quantity.value))
    return estimated(quantity, scene, level.num_points, level, coarser) / value if coarser and value else math.inf


def sensitivity(quantity: Quantity, scene: Scene) -> float:
    """The relative error of a quantity over that of a_r where a model or an unfinished iteration causes both.

    Kappa of a power profile goes like a_r^n.
    """
    power = scene.indenter.power_law if quantity.of_slopes else None
    return max(quantity.sensitivity, power[0]) if power else quantity.sensitivity
