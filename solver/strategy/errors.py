"""Estimates of the error that grid and iteration leave in the contact area and in kappa.

The sub-grid area converges faster than the grid spacing; if it were as slow, a third of the change from a grid with a
quarter of the points would be left.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

from ..grid.observables import Observables
from ..solution import Level
from .grids import FACTOR


def _remaining_change(value: float, coarser: float) -> float:
    """Estimated error of a value: a third of its change from the next coarser grid."""
    return abs(value - coarser) / (FACTOR - 1)


def claimed_error(level: Level, coarser: Sequence[Level]) -> float:
    """Estimated error of a_r on a grid, of its edges and of the discretisation (dimensionless); `inf` on the first one.

    coarser: the grids before it, from coarse to fine.
    """
    if not coarser:
        return math.inf
    return _remaining_change(level.contact_area_subgrid, coarser[-1].contact_area_subgrid) + level.edges_error


def grid_error(level: Level, coarser: Sequence[Level]) -> float:
    """As `claimed_error`, relative; `inf` without a contact."""
    area = level.contact_area_subgrid
    return claimed_error(level, coarser) / area if area else math.inf


def discretisation_error(observables: Observables, levels: Sequence[Level]) -> Observables:
    """Add what the last coarser grid says about the error of the finest one."""
    if not levels:
        return observables
    last, o = levels[-1], observables
    area = _remaining_change(o.contact_area_subgrid, last.contact_area_subgrid)
    kappa = _remaining_change(o.kappa_subgrid, last.kappa_subgrid)
    return replace(
        o,
        contact_area_discretisation_error=area,
        kappa_discretisation_error=kappa,
        contact_area_error=o.contact_area_error + area,
        kappa_error=o.kappa_error + kappa,
    )


def iteration_share(free_residual: float) -> float:
    """Estimated relative error of a_r that a free residual leaves.

    Measured: up to 0.12 of residuals below 1e-3; 0.8 of one of 0.03, and of no meaning beyond.
    """
    return min(1.0, (0.25 + 30 * free_residual) * free_residual)


def iteration_error(observables: Observables, free_residual: float) -> Observables:
    """Add what an unfinished iteration leaves."""
    area = iteration_share(free_residual) * observables.contact_area_subgrid
    sensitivity = observables.kappa_subgrid / observables.contact_area_subgrid if area else 0.0
    return replace(
        observables,
        contact_area_error=observables.contact_area_error + area,
        kappa_error=observables.kappa_error + 2 * sensitivity * area,
    )
