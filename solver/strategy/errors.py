"""Estimates of the error that grid and iteration leave in what is measured on a solution.

From a grid with a quarter of the points to the present one a quantity changes by c; what is claimed for it from the
edges of the patches alone is e. Then its error is estimated as

    contact area               s sqrt((0.4 e)^2 + (c/12)^2)
    kappa                      s sqrt((0.5 e)^2 + (c/8)^2)
    peak pressure, approach    s sqrt((m c)^2 + (b/16)^2), m = 1/(b/c - 1) between 1/3 and 4, b the change before c

The area between sub-grid edges converges with the square of the spacing, which would leave c/15, and e alone is
careful: it has to hold without a coarser grid. Pressure and approach converge between the first and the second order,
so their order is measured; b keeps a change that is small by accident from being believed.

s is 1 for smooth profiles. On a surface with w points to its shortest wave s = (f/w)^1.5, f = 64 for area and kappa and
128 for the others: where they are few, convergence has not yet begun, and the next grid finds asperities that this one
does not see. It is at least 0.75 for area and kappa, because the errors of many patches are independent of each other
while the two edges of one err alike, and at least 1 for the others.

The numbers were fitted to 600 random scenes (power profiles on layers and half-spaces against collocation, rough
surfaces against grids of at least 16 times as many points, four grids of each), so that each estimate holds in 97 of
100. On scenes that nothing was fitted to, see `linecontact study trade-off`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

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
    """Share of that which is left beside a coarser grid (dimensionless)."""
    of_change: float | None = None
    """Share of the last change between grids that is left (dimensionless); None: as the order measured says."""
    fine: float = 128.0
    """f, points to the shortest wave (dimensionless)."""
    least: float = 1.0
    """Smallest s on surfaces that have a shortest wave (dimensionless)."""
    sensitivity: float = 1.0
    """Its relative error over that of a_r where a model or an unfinished iteration causes both (dimensionless)."""

    @property
    def of_area(self) -> bool:
        """Whether its error follows from that of the contact area."""
        return self.edges is not None


QUANTITIES = {
    "contact-area": Quantity(
        "contact_area_subgrid", "contact_area_error", "contact_area_edges_error", 0.4, 1 / 12, 64.0, 0.75
    ),
    "kappa": Quantity("kappa_subgrid", "kappa_error", "kappa_edges_error", 0.5, 1 / 8, 64.0, 0.75, sensitivity=2.0),
    "peak-pressure": Quantity("peak_pressure", "peak_pressure_error"),
    "approach": Quantity("approach", "approach_error"),
}
"""By the name under which an accuracy of it is asked for."""

_LEAST, _MOST = 1.25, 4.0  # factor by which changes fall from grid to grid, as far as that is believed
_EARLIER = 1 / 16  # share of the change before the last


def estimated(
    quantity: Quantity, scene: Scene, num_points: int, found: Observables | Level, coarser: Sequence[Level]
) -> float:
    """Estimated error that a grid leaves in a quantity, in its unit.

    found: on this grid; coarser: the grids before it, from coarse to fine. Without any, what is claimed for the edges
    alone, and `inf` for what does not depend on edges.
    """
    waves = scene.indenter.effective_wave(num_points)
    few = float(max(quantity.least, (quantity.fine * waves / num_points) ** 1.5)) if waves else 1.0
    edges = float(getattr(found, quantity.edges)) if quantity.edges else math.inf
    if not coarser:
        return few * edges
    values = [float(getattr(level, quantity.value)) for level in (*coarser[-2:], found)]
    change = abs(values[-1] - values[-2])
    if quantity.of_change is not None:
        return few * math.hypot(quantity.of_edges * edges, quantity.of_change * change)
    if len(values) < 3:
        return few * change
    before = abs(values[-2] - values[-3])
    ratio = min(max(before / change, _LEAST), _MOST) if change else _MOST
    return few * math.hypot(change / (ratio - 1), _EARLIER * before)


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
