"""Estimates of the error that grid and iteration leave in what is measured on a solution.

From a grid with a quarter of the points to the present one a quantity changes by c; what is claimed for it from the
edges of the patches alone is e. On a surface with w points to its shortest wave its error is estimated as

    contact area               sqrt(s^2 ((0.6 e)^2 + (c/48)^2) + b^2), s = max(0.6, 6/sqrt(w))
    kappa                      sqrt(s^2 ((0.4 e)^2 + (c/48)^2) + b^2)
    peak pressure, approach    max(1, (128/w)^1.5) sqrt((m c)^2 + (c'/16)^2)

On smooth profiles s = 1, b = 0, the shares of area and kappa are 0.36 and 0.5 of e, c/13 and c/8, and the factor of the
others is 1.

The area between sub-grid edges converges with the second or third power of the spacing, which would leave c/15 or c/63,
and e alone is careful: it has to hold without a coarser grid. (Not so under smooth profiles for patches of fewer than
20 nodes, and where a table ends with the grid's shortest wave: there e is taken whole.) The errors of many patches are
independent but for a part that they have in common: patches that a grid sees with few points to a wave are too narrow,
if their pressures tell where they end, by up to 0.08 (1 + 4 a_r) (16/w)^(4/3) grid spacings each for the area (0.1
for kappa), and by up to 0.015 (1 + 4 a_r) (16/w)^(4/3) if their loads do. Their sum is b.

At tips sharper than |x|^1.5 kappa's sum over the slope converges more slowly, with the power 2n - 1, and more of c is
taken.

The order of pressure and approach is measured, and at best the first is believed: m = 1/(c'/c - 1), between 1/3 and 4,
with the change c' before c, which also keeps a change that is small by accident from being believed. With one coarser
grid alone the whole change is taken. To the peak pressure's error comes what the nodes may miss of the peak; under a
stiff coating thinner than a grid spacing that may be anything (`inf`).

The numbers were fitted to random scenes (power profiles on layers and half-spaces against collocation; 700 rough
surfaces, up to five grids of each, against grids of 8 times as many points and more), so that each estimate holds in 97
of 100. On scenes that nothing was fitted to, see `linecontact study tradeoff`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

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
    of_edges: tuple[float, float] = (0.0, 0.0)
    """Share of that which is left beside a coarser grid, under smooth and rough profiles (dimensionless)."""
    of_change: tuple[float, float] = (0.0, 0.0)
    """Share of the last change between grids that is left, likewise (dimensionless)."""
    per_patch: tuple[float, float] = (0.0, 0.0)
    """Error that patches have in common at 16 points to the shortest wave and small areas, in the width of each, where
    pressures and where loads tell their ends [grid spacings]."""
    of_slope: bool = False
    """Whether it is made of the slope, too, whose mean square converges slowly at a sharp tip."""
    sampling: str | None = None
    """The name, in both, of what nodes may miss of it; None where that is no matter."""
    sensitivity: float = 1.0
    """Its relative error over that of a_r where a model or an unfinished iteration causes both (dimensionless)."""

    @property
    def of_area(self) -> bool:
        """Whether its error follows from that of the contact area."""
        return self.edges is not None


QUANTITIES = {
    "contact-area": Quantity(
        "contact_area_subgrid",
        "contact_area_error",
        "contact_area_edges_error",
        of_edges=(0.36, 0.6),
        of_change=(1 / 13, 1 / 48),
        per_patch=(0.08, 0.015),
    ),
    "kappa": Quantity(
        "kappa_subgrid",
        "kappa_error",
        "kappa_edges_error",
        of_edges=(0.5, 0.4),
        of_change=(1 / 8, 1 / 48),
        per_patch=(0.1, 0.015),
        of_slope=True,
        sensitivity=2.0,
    ),
    "peak-pressure": Quantity("peak_pressure", "peak_pressure_error", sampling="peak_pressure_sampling"),
    "approach": Quantity("approach", "approach_error"),
}
"""By the name under which an accuracy of it is asked for."""

DEFAULT_QUANTITY = "contact-area"

_CAREFUL_FROM_IF_SMOOTH = 20.0
"""Nodes of a patch under a smooth profile, on the average, from which on the claim of its edges is careful."""
_KNOWN = 0.001  # error of a layer's edge up to which the claim is careful [grid spacings]
_INDEPENDENT = 0.6  # s of many well resolved patches, whose errors are independent; the two edges of one err alike
_FEW, _FEW_OF_OTHERS, _COMMON = 36.0, 128.0, 16.0  # points to the shortest wave
_COMMON_POWER = 4 / 3  # the mean falls like 1/w from 8 to 16, and like 1/w^2 from 32 to 64
_OF_AREA = 4.0  # growth of what patches have in common with the contact area: the gaps between them become narrow
_LEAST, _MOST = 1.25, 4.0  # factor by which changes fall from grid to grid, as far as that is believed
_STIFF = 0.9  # 2K/(E* q) of the shortest wave, below which shorter ones find the layer stiffer
_EARLIER = 1 / 16  # share of the change before the last
_OVER_ORDER = 1.25  # share of the change over what a known order would leave of it


def estimated(
    quantity: Quantity, scene: Scene, num_points: int, found: Observables | Level, coarser: Sequence[Level]
) -> float:
    """Estimated error that a grid leaves in a quantity, in its unit.

    found: on this grid; coarser: the grids before it, from coarse to fine. Without any, what is claimed for the edges
    alone, and `inf` for what does not depend on edges.
    """
    waves = scene.indenter.effective_wave(num_points) / num_points  # 1/w
    values = [float(getattr(level, quantity.value)) for level in (*coarser[-2:], found)]
    if not quantity.edges:
        if quantity.sampling and _hides_peaks(scene, num_points):
            return math.inf
        sampling = float(getattr(found, quantity.sampling)) if quantity.sampling else 0.0
        return math.hypot(math.pow(max(1.0, _FEW_OF_OTHERS * waves), 1.5) * _by_order(values), sampling)
    edges, area = float(getattr(found, quantity.edges)), found.contact_area_subgrid
    if not area:
        return edges
    by_load = found.num_patches_by_load
    each = [share * of for share, of in zip(quantity.per_patch, (found.num_patches - by_load, by_load), strict=True)]
    spacings = sum(each) * (1 + _OF_AREA * area) * math.pow(_COMMON * waves, _COMMON_POWER)
    common = spacings / num_points / area * abs(values[-1])
    if not coarser:
        return math.hypot(edges, common)
    rough = waves > 0
    careful = rough or area * num_points >= _CAREFUL_FROM_IF_SMOOTH * found.num_patches
    careful &= edge_curve(scene.layer, num_points, scene.period).error < _KNOWN
    several = max(_INDEPENDENT, math.sqrt(_FEW * waves)) if rough else 1.0
    of_edges = quantity.of_edges[1 if rough else 0] if careful else 1.0
    change = _of_change(quantity, scene, rough) * abs(values[-1] - values[-2])
    return math.hypot(several * of_edges * edges, several * change, common)


def _hides_peaks(scene: Scene, num_points: int) -> bool:
    """Whether waves that the grid has not find the layer stiffer, as on a coating thinner than a spacing on a softer
    base: then the pressure may have peaks between the nodes, at edges and tips.
    """
    return bool(modulus_on_grid(scene.layer, np.array([np.pi]), num_points, scene.period)[0] < _STIFF)


def _of_change(quantity: Quantity, scene: Scene, rough: bool) -> float:
    """Share of the last change between grids that is left (dimensionless)."""
    power = scene.indenter.power_law
    share = quantity.of_change[1 if rough else 0]
    if not (power and quantity.of_slope):
        return share
    order = min(2 * power[0] - 1, 2.0)  # of the mean square slope's sum
    return max(share, _OVER_ORDER / (4**order - 1))


def _by_order(values: Sequence[float]) -> float:
    """What the changes of a quantity from grid to grid leave by the order that they have.

    values: on up to three grids, from coarse to fine; of one grid nothing is known (`inf`).
    """
    if len(values) == 1:
        return math.inf
    change = abs(values[-1] - values[-2])
    if len(values) == 2:
        return change
    before = abs(values[-2] - values[-3])
    ratio = min(max(before / change, _LEAST), _MOST) if change else _MOST
    return math.hypot(change / (ratio - 1), _EARLIER * before)


def grid_error(quantity: Quantity, scene: Scene, level: Level, coarser: Sequence[Level]) -> float:
    """As `estimated`, relative; `inf` on the first grid, and where the quantity is 0."""
    value = abs(getattr(level, quantity.value))
    return estimated(quantity, scene, level.num_points, level, coarser) / value if coarser and value else math.inf


def with_errors(scene: Scene, observables: Observables, levels: Sequence[Level], free_residual: float) -> Observables:
    """Observables on the scene's grid with the estimated errors: what the grid leaves, and an unfinished iteration.

    levels: the coarser grids, from coarse to fine; free_residual: over p.
    """
    errors = {}
    for quantity in QUANTITIES.values():
        unfinished = quantity.sensitivity * iteration_share(free_residual) * abs(getattr(observables, quantity.value))
        errors[quantity.error] = estimated(quantity, scene, scene.num_points, observables, levels) + unfinished
    return replace(observables, **errors)


def iteration_share(free_residual: float) -> float:
    """Estimated relative error of a_r that a free residual leaves.

    Measured: up to 0.12 of residuals below 1e-3; 0.8 of one of 0.03, and of no meaning beyond.
    """
    return min(1.0, (0.25 + 30 * free_residual) * free_residual)
