"""The numbers of `solver.calibration`, fitted so that nearly all estimates hold and are as small as they can be."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields, replace

import numpy as np
from linecontact.solver import QUANTITIES, Solution
from linecontact.solver.arrays import Array64
from linecontact.solver.calibration import FITTED, Calibration
from linecontact.solver.grid.observables import observe
from linecontact.solver.grid.patches import Patches
from linecontact.solver.strategy.unfinished import with_errors

FLOOR = 1e-8
"""Relative error that the references have themselves."""

_HELD = 0.985
"""Share of the estimates that are to hold in the scenes of a fit, so that 97 of 100 do in others."""
_FACTORS = (4.0, 2.0, 1.3)
_LARGEST = 12.0
"""Logarithm of estimate over error beyond which it makes no difference."""


@dataclass(frozen=True)
class Fitted:
    """A scene of the fit."""

    family: str
    """Of the scene."""
    solution: Solution
    """On the grid whose errors are estimated."""
    errors: Array64
    """True errors of the quantities, relative, shape (4,)."""
    unfinished: bool
    """Whether what the iteration left is all that counts."""

    def claims(self) -> Array64:
        """Estimated errors by the present numbers, relative, shape (4,)."""
        one = self.solution
        assert one.certificate
        found, _ = observe(one.scene, one.scene.profile, one.displacement, one.contact_pressure, one.contact)
        shape = Patches.of(one.contact), one.contact_pressure
        known = with_errors(one.scene, found, one.levels, one.certificate, *shape)
        estimates = relative(known)
        if self.unfinished:
            done = replace(one.certificate, free_residual=0.0, largest_residual=0.0)
            by_grid = relative(with_errors(one.scene, found, one.levels, done, *shape))
            estimates = estimates - np.where(np.isfinite(by_grid), by_grid, 0.0)
        return np.maximum(estimates, FLOOR)


def relative(found: object) -> Array64:
    """Estimated errors of the four quantities over their values, shape (4,); found: `Observables`."""
    names = [(quantity.error, quantity.value) for quantity in QUANTITIES.values()]
    return np.array([getattr(found, error) / max(abs(getattr(found, value)), 1e-300) for error, value in names])


def numbers(scenes: Sequence[Fitted]) -> Calibration:
    """The best numbers, from those in use on by multiplying one at a time; those in use are not changed."""
    begin, weights = asdict(FITTED), _weights(scenes)
    best = _loss(scenes, weights)
    for factor in _FACTORS:
        for name in (field.name for field in fields(FITTED)):
            for times in (factor, 1 / factor):
                while True:
                    before = getattr(FITTED, name)
                    setattr(FITTED, name, before * times)
                    loss = _loss(scenes, weights)
                    if loss > best - 1e-4:
                        setattr(FITTED, name, before)
                        break
                    best = loss
    found = replace(FITTED)
    _set(begin.items())
    return found


def held(scenes: Sequence[Fitted], by: Calibration) -> dict[str, dict[str, list[float]]]:
    """Of each family and quantity the share of estimates by some numbers that hold, and the median of estimate over
    error.
    """
    begin = asdict(FITTED)
    _set(asdict(by).items())
    found: dict[str, dict[str, list[float]]] = {}
    for family in dict.fromkeys(one.family for one in scenes):
        some = [one for one in scenes if one.family == family]
        ratios = np.array([one.claims() for one in some]) / np.maximum([one.errors for one in some], FLOOR)
        found[family] = {
            name: [round(float(np.mean(ratio >= 1)), 4), float(f"{np.median(ratio):.3g}")]
            for name, ratio in zip(QUANTITIES, ratios.T, strict=True)
        }
    _set(begin.items())
    return found


def _set(values: Iterable[tuple[str, float]]) -> None:
    for name, value in values:
        setattr(FITTED, name, value)


def _weights(scenes: Sequence[Fitted]) -> Array64:
    """All families count the same, shape (scenes,)."""
    families = [one.family for one in scenes]
    return np.array([1 / families.count(family) for family in families]) / len(set(families))


def _loss(scenes: Sequence[Fitted], weights: Array64) -> float:
    """How far the estimates are off the quantile of the errors that they are meant to be (quantile regression)."""
    errors = np.maximum([one.errors for one in scenes], FLOOR)
    above = np.minimum(np.log(np.array([one.claims() for one in scenes])) - np.log(errors), _LARGEST)
    return float(weights @ np.where(above > 0, (1 - _HELD) * above, -_HELD * above).sum(axis=1))
