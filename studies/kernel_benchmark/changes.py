"""Changes from one measurement to another, judged on ratios that were taken in the same round.

A time changes with whatever else the machine does; its ratio to C's in the same round much less. The rest scatters
from repetition to repetition (`cells.Scatter`), and between two processes, whose memory lies elsewhere, a little more,
which is seen in the changes themselves (`between`). Transforms are listed and not judged.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .cells import Cell, Key, Scatter, quantile

JUDGED = "warp"
"""The variant that the program runs, which decides on the exit status."""
BOTH = "both"
"""Stands for a precision where both are judged together, which finds changes that neither shows alone."""
ROWS, BENCHMARKS_ = 0.002, 0.002
"""Probability that a row which did not change is marked, and that any benchmark of a comparison is."""


@dataclass(frozen=True)
class Change:
    """One benchmark, precision, size and variant in both measurements."""

    key: Key
    """The measurement."""
    variant: str
    """The way in which it was done."""
    old: float
    """Ratio to the yardstick in the earlier measurement (dimensionless)."""
    new: float
    """In the later one."""
    error: float
    """Standard error of the logarithm of the change, from the repetitions."""
    freedom: int
    """Degrees of freedom of that."""

    @property
    def log(self) -> float:
        """Logarithm of the later ratio over the earlier one."""
        return math.log(self.new / self.old)


@dataclass(frozen=True)
class Measurement:
    """A stored measurement."""

    identity: dict[str, str]
    """Source, compiler and machine of the times."""
    commit: str
    """Of the checkout, with '+dirty'."""
    cells: dict[Key, Cell]
    """Repetitions by measurement."""


def changes(old: Measurement, new: Measurement) -> list[Change]:
    """The measurements that both have, against the same yardstick."""
    found = []
    variants = dict.fromkeys(v for cell in new.cells.values() for v in cell.variants)
    for variant in variants:
        scatters = [Scatter(one.cells.values(), variant) for one in (old, new)]
        for key, cell in new.cells.items():
            before = old.cells.get(key)
            yardsticks = {one.runs[0]["yardstick"] for one in (cell, before) if one}
            if before is None or len(yardsticks) > 1 or variant in yardsticks:
                continue
            ratios = before.ratio(variant), cell.ratio(variant)
            errors = [s.error(one, variant) for s, one in zip(scatters, (before, cell), strict=True)]
            if all(ratio > 0 for ratio in ratios) and not math.isnan(sum(errors)):
                freedom = sum(s.freedom(one) for s, one in zip(scatters, (before, cell), strict=True))
                found.append(Change(key, variant, *ratios, math.hypot(*errors), freedom))
    return found


def between(found: list[Change]) -> tuple[float, float]:
    """Standard deviations of logarithms of changes that nobody made, beyond the scatter of the repetitions.

    The first is of single sizes, seen in how far they are from the mean of their benchmark; the second of these means,
    for a process's common part for all sizes, seen in how they scatter. Where there are too few to see it, both
    are those of identical runs.
    """
    groups: dict[tuple[str, str], list[Change]] = {}
    for change in found:
        groups.setdefault((change.key.benchmark, change.key.precision), []).append(change)
    several = [np.array([change.log for change in own]) for own in groups.values() if len(own) > 1]
    apart = [(logs - logs.mean()) * math.sqrt(logs.size / (logs.size - 1)) for logs in several]
    single = _beyond(np.concatenate(apart), [c.error for c in found]) if len(apart) >= _ENOUGH else _USUAL
    means, errors = zip(*(_mean(own, single) for own in groups.values()), strict=True) if groups else ((), ())
    from_median = np.array(means) - np.median(means) if groups else np.zeros(0)
    return single, _beyond(from_median, list(errors)) if len(means) >= _ENOUGH else _USUAL


def _mean(own: list[Change], single: float) -> tuple[float, float]:
    """Mean logarithm of some changes, the surer ones counting more, and its standard error.

    Where the changes differ by more than their errors tell, the error is their difference: a change at one size only
    may come from other work of the machine just then.
    """
    logs, weights = np.array([c.log for c in own]), np.array([1 / (c.error**2 + single**2) for c in own])
    mean = float(weights @ logs / weights.sum())
    differ = float(weights @ (logs - mean) ** 2 / weights.sum()) / max(1, logs.size - 1)
    return mean, math.sqrt(max(1 / float(weights.sum()), differ))


_ENOUGH, _USUAL = 8, 0.02


def _beyond(deviations: NDArray[np.float64], explained: list[float]) -> float:
    """Standard deviation of the changes seen (from the median of the magnitudes) beyond the explained one."""
    seen = 1.4826 * float(np.median(np.abs(deviations)))
    return math.sqrt(max(0.0, seen**2 - float(np.median(explained)) ** 2))


def verdict(log: float, error: float, freedom: int, threshold: float, chance: float) -> str:
    """'slower' or 'faster' for a change beyond the threshold that chance makes rarely; empty for any other."""
    limit = max(math.log(threshold), quantile(1 - chance / 2, freedom) * error)
    return "" if abs(log) <= limit else "slower" if log > 0 else "faster"


def judge(found: list[Change], threshold: float) -> dict[tuple[str, str], tuple[float, float, str]]:
    """Benchmarks over all their sizes, by name and precision or `BOTH`: mean change, its standard error, verdict."""
    own = [change for change in found if change.variant == JUDGED]
    groups: dict[tuple[str, str], list[Change]] = {}
    for change in own:
        for precision in (change.key.precision, BOTH):
            groups.setdefault((change.key.benchmark, precision), []).append(change)
    groups = {
        name: rows for name, rows in groups.items() if name[1] != BOTH or len({r.key.precision for r in rows}) > 1
    }
    judged, (single, common) = {}, between(own)
    for name, rows in groups.items():
        mean, error = _mean(rows, single)
        error = math.hypot(error, common)
        freedom = sum(change.freedom for change in rows)
        judged[name] = math.exp(mean), error, verdict(mean, error, freedom, threshold, BENCHMARKS_ / len(groups))
    return judged
