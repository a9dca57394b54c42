"""The numbers of `solver.calibration`, fitted so that nearly all estimates hold and are as small as they can be."""

import itertools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import cached_property

import numpy as np
from linecontact.solver import QUANTITIES, Observables, Solution
from linecontact.solver.arrays import Array64
from linecontact.solver.calibration import FITTED
from linecontact.solver.grid.contact import contact_edges
from linecontact.solver.grid.errors import with_errors
from linecontact.solver.grid.observables import observe
from linecontact.solver.grid.problem import Problem

Numbers = dict[str, float]

_HELD, _LEAST = 0.9865, 0.9765  # shares of estimates that are to hold in a fit, of all scenes and of each family
_PRICE = 60.0  # of the share that is missing, in means of the logarithm of estimate over error
_FACTOR, _GAIN = 1.2, 1e-4  # by which one number after the other is changed, and the least gain of a change
_FLOOR, _LARGEST = 1e-8, 12.0  # relative error of references, and logarithm of estimate over error that is enough


@dataclass(frozen=True)
class Known:
    """A scene whose errors are known."""

    family: str
    """Of the scene."""
    found: Solution
    """On the grid whose errors are estimated."""
    true: Array64
    """Values of the quantities, shape (4,) [units of each]."""
    unfinished: bool
    """Whether the error of the iteration alone counts."""

    @cached_property
    def _problem(self) -> Problem:
        return Problem.from_scene(self.found.scene)

    def ratios(self) -> Array64:
        """Estimated errors by the present numbers over true errors, shape (4,)."""
        one, certificate = self.found, self.found.certificate
        assert certificate
        contact = contact_edges(self._problem, one.contact_pressure, one.displacement)
        found, _ = observe(contact, one.displacement)

        def estimates(**left: float) -> Array64:
            errors = with_errors(one.scene, found, one.levels, replace(certificate, **left), contact)
            return np.array([getattr(errors, quantity.error) for quantity in QUANTITIES.values()])

        estimated, value, true = estimates(), values(found), self.true
        if self.unfinished:
            by_grid = estimates(equilibrium_residual=0.0, largest_residual=0.0)
            estimated = estimated - np.where(np.isfinite(by_grid), by_grid, 0.0)
        floor = _FLOOR * np.abs(true)
        return np.asarray(np.maximum(estimated, floor) / np.maximum(np.abs(value - true), floor))


def values(found: Observables) -> Array64:
    """Of the quantities, shape (4,) [units of each]."""
    return np.array([getattr(found, quantity.value) for quantity in QUANTITIES.values()])


def fitted(scenes: Sequence[Known]) -> Numbers:
    """The best numbers, from those in use on by multiplying one at a time."""
    families = np.array([one.family for one in scenes])

    def loss() -> float:
        """Mean logarithms of estimate over error, and the price of estimates that do not hold."""
        above = np.minimum(np.log([one.ratios() for one in scenes]), _LARGEST)
        of_each = [(above[families == family] >= 0).mean(axis=0) for family in np.unique(families)]
        missing = (_HELD - (above >= 0).mean(axis=0)).clip(0) + np.mean((_LEAST - np.array(of_each)).clip(0), axis=0)
        return float((above.mean(axis=0) + _PRICE * missing).sum())

    with _in_use(asdict(FITTED)):
        best = loss()
        for name, times in itertools.product(asdict(FITTED), (_FACTOR, 1 / _FACTOR)):
            better = True
            while better:
                before = getattr(FITTED, name)
                setattr(FITTED, name, before * times)
                now = loss()
                if better := now < best - _GAIN:
                    best = now
                else:
                    setattr(FITTED, name, before)
        return {name: float(f"{value:.2g}") for name, value in asdict(FITTED).items()}


def held(scenes: Sequence[Known], numbers: Numbers) -> dict[str, dict[str, str]]:
    """Of each family and quantity how many estimates by some numbers hold, and the median of estimate over error."""
    found: dict[str, dict[str, str]] = {}
    with _in_use(numbers):
        for family in dict.fromkeys(one.family for one in scenes):
            ratios = np.array([one.ratios() for one in scenes if one.family == family]).T
            told = [f"{sum(ratio >= 1)} of {ratio.size}, median {np.median(ratio):.3g}" for ratio in ratios]
            found[family] = dict(zip(QUANTITIES, told, strict=True))
    return found


@contextmanager
def _in_use(numbers: Numbers) -> Iterator[None]:
    """The solver takes these numbers, and those before afterwards."""
    before = asdict(FITTED)
    try:
        vars(FITTED).update(numbers)
        yield
    finally:
        vars(FITTED).update(before)
