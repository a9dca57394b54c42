"""The multilevel Monte Carlo estimator.

After M. B. Giles, Multilevel Monte Carlo path simulation, Operations Research 56, 607 (2008), and Multilevel Monte
Carlo methods, Acta Numerica 24, 259 (2015). The mean on the finest grid is that on a coarse grid plus the means of the
changes from grid to grid. One seed is one surface on every grid, so that the changes scatter little. A term takes every
surface that is solved on its grids; the common part of two terms through their surfaces is counted by their
covariance. Where few surfaces tell a variance it is made larger, as Student's distribution has it. Below the coarsest
grid there may be a foundation, see `Samples`: grids then mean that, too, where nothing else is said.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from .samples import FOUNDATION, Samples, name_of, unit_of

FEWEST_SURFACES = 32
"""Of the mean on the coarsest grid, or of its change from the foundation: their variances count most."""

_CHANGES = 3  # from grid to grid, that tell how the error falls


@dataclass(frozen=True)
class Term:
    """One term of the sum: the mean on the coarsest grid, or that of the change from one grid to a finer one."""

    num_points: int
    """Points of the (finer) grid; 0 for the foundation."""
    coarser: int | None
    """Points of the coarser grid, 0 for the foundation; None for the first term."""
    count: int
    """Surfaces."""
    mean: float
    """Of the observable, or of its change."""
    variance: float
    """Of the same for one surface."""
    seconds: float
    """Time of one surface, on both grids [s]."""

    @property
    def fewest(self) -> int:
        """Surfaces that it needs at least; 0 where those that are solved first are enough."""
        return FEWEST_SURFACES if self.coarser in (None, FOUNDATION) else 0

    @property
    def believed(self) -> float:
        """The variance that the standard error is made of: (n-1)/(n-3) of the n surfaces' own."""
        return self.variance * (self.count - 1) / (self.count - 3)


@dataclass(frozen=True)
class Estimate:
    """A mean over random surfaces, and how wrong it can be; in the unit of the observable."""

    observable: str
    """The quantity that it is the mean of."""
    mean: float
    """The mean on the finest grid."""
    standard_error: float
    """Of that mean, by the number of surfaces."""
    bias: float
    """Estimate of the error of the finest grid; NaN where one grid is all there is."""
    terms: tuple[Term, ...]
    """From coarse to fine."""
    plain_variance: float
    """Of a single surface on the finest grid."""
    plain_seconds: float
    """Time of a single surface on the finest grid [s]."""
    warnings: str = ""
    """The kinds of `Solution.warnings` on the finest grid, each with the number of surfaces that have it."""

    def __repr__(self) -> str:
        numbers = "".join(f", {name} {getattr(self, name):.3g}" for name in ("standard_error", "bias"))
        grids = ", ".join(f"{term.count} on {name_of(term.num_points)}" for term in self.terms)
        mean = f"mean of {self.observable} {self.mean:.6g}{numbers} [{unit_of(self.observable)}]"
        told = f"{type(self).__name__}: {mean}; surfaces: {grids} points"
        return f"{told}; warnings: {self.warnings}" if self.warnings else told

    def plain_cost(self, standard_error: float) -> float:
        """Time that sampling on the finest grid alone would take for a standard error > 0 [s]."""
        return self.plain_variance / standard_error**2 * self.plain_seconds


def differences(samples: Samples, size: int, coarser: int | None) -> dict[int, float]:
    """The observable on a grid, or its change from a coarser one, by seed."""
    fine = samples.values[size]
    if coarser is None:
        return dict(fine)
    return {seed: fine[seed] - samples.values[coarser][seed] for seed in samples.seeds(size, coarser)}


def term(samples: Samples, size: int, coarser: int | None) -> Term:
    """The estimates of one term."""
    values = np.array(list(differences(samples, size, coarser).values()))
    variance = float(values.var(ddof=1))
    seconds = samples.seconds(size) + (samples.seconds(coarser) if coarser is not None else 0.0)
    return Term(size, coarser, values.size, float(values.mean()), variance, seconds)


def terms(samples: Samples, ladder: Sequence[int]) -> tuple[Term, ...]:
    """The terms of the sum over some grids, from coarse to fine."""
    return tuple(term(samples, size, coarser) for size, coarser in _steps(ladder))


def _steps(ladder: Sequence[int]) -> list[tuple[int, int | None]]:
    return list(zip(ladder, (None, *ladder), strict=False))


def estimate(samples: Samples, ladder: Sequence[int], sizes: Sequence[int]) -> Estimate:
    """The mean and its errors, from all surfaces that serve the grids of a ladder; sizes: all grids up to its finest,
    whose changes tell the bias.
    """
    found = terms(samples, ladder)
    variance = sum(t.believed / t.count for t in found)
    for one, other in itertools.combinations(_steps(ladder), 2):
        first, second = differences(samples, *one), differences(samples, *other)
        shared = sorted(first.keys() & second.keys())
        if len(shared) > 1:
            covariance = float(np.cov([first[s] for s in shared], [second[s] for s in shared])[0, 1])
            variance += 2 * len(shared) * covariance / len(first) / len(second)
    alone = term(samples, ladder[-1], None)
    return Estimate(
        observable=samples.observable,
        mean=sum(t.mean for t in found),
        standard_error=math.sqrt(max(variance, 0.0)),
        bias=bias(samples, sizes),
        terms=found,
        plain_variance=alone.variance,
        plain_seconds=samples.seconds(ladder[-1]),
    )


def bias(samples: Samples, sizes: Sequence[int]) -> float:
    """The error of the finest of these grids, each twice as fine as the one before, from the last changes of the mean.

    For an error that falls like N^-alpha; alpha follows from the last three changes, between 1 and 2. A change that is
    small by chance does not count: the one before, as alpha would have it go on, is the least that is believed (Giles
    2015, eq. 2.10). NaN where there is no change.
    """
    grids = [size for size in sizes if size != FOUNDATION]
    steps = list(itertools.pairwise(grids))[-_CHANGES:]
    changes = [abs(term(samples, size, coarser).mean) for coarser, size in steps]
    if not changes:
        return math.nan
    falls = len(changes) > 1 and min(changes) > 0
    alpha = math.log2(changes[0] / changes[-1]) / (len(changes) - 1) if falls else 1.0
    factor = 2 ** min(max(alpha, 1.0), 2.0)
    return max([changes[-1], *(change / factor for change in changes[-2:-1])]) / (factor - 1)


def best_ladder(asked: Sequence[tuple[Samples, float]], sizes: Sequence[int]) -> tuple[int, ...]:
    """Of these grids the ones whose sums take the least further time; the finest is always there. Surfaces that are
    solved already count, so that variances which become known better on the way seldom lead to other grids.

    asked: samples of each observable, of the same surfaces, with the standard error > 0 that its mean is to have.
    """
    known = cache(lambda which, size, coarser: term(asked[which][0], size, coarser))

    def seconds(ladder: tuple[int, ...]) -> tuple[float, float]:
        """Time that is left, and that it takes from the beginning [s]."""
        each = []
        for which, (_, standard_error) in enumerate(asked):
            found = [known(which, *step) for step in _steps(ladder)]
            each.append(counts(found, standard_error))
        numbers = [max(column) for column in zip(*each, strict=True)]
        pairs = [(max(number, t.fewest), t) for number, t in zip(numbers, found, strict=True)]
        left = sum(max(0, number - t.count) * t.seconds for number, t in pairs)
        return left, sum(number * t.seconds for number, t in pairs)

    chosen = (itertools.compress(sizes[:-1], kept) for kept in itertools.product((False, True), repeat=len(sizes) - 1))
    return min(((*coarser, sizes[-1]) for coarser in chosen), key=seconds)


def counts(found: Sequence[Term], standard_error: float) -> list[int]:
    """Surfaces for each term that bring the standard error in the least time (Giles 2008, eq. 12)."""
    effort = sum(math.sqrt(t.believed * t.seconds) for t in found)
    return [math.ceil(math.sqrt(t.believed / t.seconds) * effort / standard_error**2) for t in found]
