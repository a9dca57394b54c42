"""Loads at which the contact area is evenly spaced, found by solves on a coarse grid."""

import numpy as np
from linecontact.solver import Scene, Status, solve
from linecontact.solver.grid.problem import Problem

from . import number

_POINTS = 2**12  # of the coarse grid, if it holds the indenter
_LOADS = 40  # solved there
_DIGITS = 4  # of a load: it need not be known better, and is the same on every machine


def loads(scene: Scene, first: float, last: float, count: int) -> tuple[float, ...]:
    """Pressures from the first to the last, at which a_r between sub-grid edges rises evenly, but for about a percent.

    Raises `ValueError`.
    """
    if not 0 < first < last:
        raise ValueError(f"from is {first:g}, and to {last:g}; allowed: 0 < from < to, with --spacing area")
    coarse = _coarse(scene)
    known = np.geomspace(first, last, _LOADS)
    full = Problem.from_scene(coarse).full_contact_pressure
    areas = [_area(coarse, pressure) if pressure < full else 1.0 for pressure in known]
    wanted = np.linspace(areas[0], areas[-1], count)
    between = np.exp(np.interp(wanted, np.maximum.accumulate(areas), np.log(known)))
    rounded = (float(f"{pressure:.{_DIGITS}g}") for pressure in between[1:-1])
    return tuple(dict.fromkeys((first, *rounded, last)))


def _coarse(scene: Scene) -> Scene:
    size = _POINTS
    while size < scene.num_points:
        try:
            return scene.on_grid(size)
        except ValueError:  # it does not hold the indenter
            size *= 4
    return scene


def _area(scene: Scene, pressure: float) -> float:
    solution = solve(number.put(scene, "pressure", pressure), tolerance=1e-4)
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return solution.observables.contact_area_subgrid
