"""The next solves for a standard error, and whether it can be reached. Everything follows from the samples so far,
so that a run that was killed goes on as if it had not been.
"""

import itertools
import math
from collections.abc import Iterable, Sequence, Set
from dataclasses import dataclass

import numpy as np
from linecontact.solver import Scene
from linecontact.solver.display import rounded_up

from . import foundation
from .estimator import Estimate, best_ladder, counts, estimate
from .samples import FOUNDATION, Batch, Row, Samples, fewest_points, on_grids

PILOT, FINER_PILOT = 16, 8
"""Surfaces that are solved first, on the coarsest grids and on finer ones; they tell variances and times."""
FIRST_GRIDS = 3
"""Grids with which to begin."""

_BIAS = 1 / 3  # of the standard error that the finest grid may be off
_LEAST = 4  # surfaces that tell a variance
_GROWTH = 4  # factor by which a number of surfaces grows at once: variances become known better on the way
_SECONDS = 1.0  # of a task
_LESS = 0.97  # factor of the error aimed at, as long as the common part of the surfaces keeps the error too large
_APART = 2**32  # seeds that belong to one term at the most


@dataclass(frozen=True)
class Wanted:
    """The request of the user."""

    observables: tuple[str, ...]
    """Whose means are wanted."""
    standard_error: float
    """Of each mean, in the observable's unit or over the mean."""
    relative: bool
    """Whether it is over the mean."""
    max_seconds: float
    """Time of solving that may be planned, of all processes together [s]."""
    max_samples: int
    """Solves that may be planned."""

    def error(self, found: Estimate) -> float:
        """The standard error wanted of a mean, in its own unit."""
        return self.standard_error * (abs(found.mean) if self.relative else 1.0)

    def biased(self, found: Estimate) -> bool:
        """Whether the finest grid is off by more than may be."""
        return found.bias > _BIAS * self.error(found)


@dataclass(frozen=True)
class State:
    """How far an ensemble is."""

    estimates: dict[str, Estimate]
    """By observable; empty before the first surfaces are solved on all grids."""
    batches: tuple[Batch, ...]
    """The next solves; none when it is done, or out of reach."""
    seconds_left: float
    """Time of solving that all that is left takes, as far as it is known [s]."""
    solves_left: int = 0
    """Solves that are left, as far as they are known."""
    out_of_reach: str = ""
    """Why it goes no further, with the allowed values."""

    @property
    def done(self) -> bool:
        """Whether nothing is left to solve, because every mean is as it was asked for."""
        return bool(self.estimates) and not (self.batches or self.out_of_reach)


def grid_sizes(scene: Scene) -> tuple[int, ...]:
    """The grids that hold the surface, from coarse to fine, each twice the one before; the scene's is the finest."""
    sizes, least = [scene.num_points], fewest_points(scene)
    while sizes[0] % 2 == 0 and sizes[0] // 2 >= least:
        sizes.insert(0, sizes[0] // 2)
    return tuple(sizes)


def levels(scene: Scene) -> tuple[int, ...]:
    """The same, after the foundation where the layer is one for long waves and there is more than one grid."""
    sizes = grid_sizes(scene)
    return (FOUNDATION, *sizes) if len(sizes) > 1 and foundation.is_one(scene) else sizes


def stored_levels(rows: Sequence[Row], sizes: Sequence[int]) -> tuple[int, ...]:
    """The grids of stored rows, after the foundation where they have it. sizes: points of the grids."""
    return (FOUNDATION,) * (len(on_grids(rows)) < len(rows)) + tuple(sizes)


def first_seed(seed: int, term: int) -> int:
    """The first seed of the surfaces of a term, 0 for those that are solved first; far from all others."""
    return int(np.random.SeedSequence([seed, term]).generate_state(1, np.uint64)[0]) >> 2


def state(rows: Sequence[Row], sizes: Sequence[int], wanted: Wanted, seed: int) -> State:
    """From the solves so far to the estimates and the next solves. seed: tells one ensemble from another."""
    known = {name: Samples(rows, name) for name in wanted.observables}
    main = known[wanted.observables[0]]
    tried = {(int(row["seed"]), int(row["num_points"])) for row in rows}
    begin = first_seed(seed, 0)
    first = sizes[: FIRST_GRIDS + (FOUNDATION in sizes)]
    pilots = [PILOT if size in first else FINER_PILOT for size in sizes]
    reached = [
        size for size, count in zip(sizes, pilots, strict=True) if all((begin + i, size) in tried for i in range(count))
    ]
    if len(reached) < len(first):
        return State({}, _batches(begin, PILOT, tuple(first), math.inf), math.nan)
    least = min(len(main.seeds(*pair)) for pair in itertools.product(reached, reached))
    if least < _LEAST:
        why = f"of the surfaces solved first no more than {least} converge; allowed: a scene whose solves do"
        return State({}, (), math.nan, out_of_reach=why)
    plain = [(samples, estimate(samples, reached[-1:], reached)) for samples in known.values()]
    asked = [(samples, wanted.error(found)) for samples, found in plain]
    ladder = best_ladder(asked, reached) if all(error > 0 for _, error in asked) else reached
    estimates = {name: estimate(samples, ladder, reached) for name, samples in known.items()}
    if not all(wanted.error(found) > 0 for found in estimates.values()):
        why = "a mean is 0; allowed: a standard error that is not relative"
        return State(estimates, (), math.nan, out_of_reach=why)
    then = _more_surfaces(estimates, wanted, tried, seed, sizes)
    if any(map(wanted.biased, estimates.values())) and len(reached) < len(sizes):
        finer, count = sizes[len(reached)], pilots[len(reached)]
        seconds = main.seconds(reached[-1]) * finer / reached[-1]
        batches = _batches(begin, count, (finer,), seconds)
        seconds, solves = count * seconds + then.seconds_left, count + then.solves_left
        return _within(State(estimates, batches, seconds, solves), rows, wanted, more_grids=True)
    return _within(then, rows, wanted, more_grids=False)


def share_done(ensembles: Iterable[tuple[Sequence[Row], State]]) -> float:
    """Share of the time of solving that is spent, 0 to 1, of the rows and states of some ensembles.

    One whose time is not known is taken to be like the mean of the others, and to have at least as much
    left as it has taken; 0 as long as it is known of none. Nothing is left of one that is out of reach.
    """
    spent, left, unknown = 0.0, 0.0, []
    known: list[float] = []
    for rows, now in ensembles:
        seconds = _seconds(rows)
        spent += seconds
        if now.out_of_reach:
            continue
        if math.isfinite(now.seconds_left):
            left += now.seconds_left
            known.append(seconds + now.seconds_left)
        else:
            unknown.append(seconds)
    if unknown and not known:
        return 0.0
    left += sum(max(before, sum(known) / len(known) - before) for before in unknown)
    return spent / (spent + left) if spent > 0 else 0.0


def _seconds(rows: Sequence[Row]) -> float:
    return sum(float(row["seconds.total"]) for row in rows)


def _more_surfaces(
    estimates: dict[str, Estimate], wanted: Wanted, tried: Set[tuple[int, int]], seed: int, sizes: Sequence[int]
) -> State:
    """The solves for the standard errors, on the grids that are chosen; first the fewest surfaces that are needed."""
    few = any(one.count < one.fewest for one in estimates[wanted.observables[0]].terms)
    each = [_numbers(found, wanted.error(found)) for found in estimates.values()]
    planned: list[Batch] = []
    seconds, solves = 0.0, 0
    for one, *numbers in zip(estimates[wanted.observables[0]].terms, *each, strict=True):
        missing = max(numbers) - one.count
        if missing > 0:
            grids = tuple(size for size in (one.coarser, one.num_points) if size is not None)
            seconds, solves = seconds + missing * one.seconds, solves + missing * len(set(grids) - {FOUNDATION})
            start = first_seed(seed, 1 + sizes.index(one.num_points))
            own = (number + 1 for number, size in tried if size == one.num_points and 0 <= number - start < _APART)
            more = max(0, one.fewest - one.count) if few else min(missing, _GROWTH * one.count)
            planned += _batches(max(own, default=start), more, grids, one.seconds)
    return State(estimates, tuple(planned), seconds, solves)


def _numbers(found: Estimate, error: float) -> list[int]:
    """Surfaces for each term; as many as there are where the standard error is small enough, and else more of one."""
    have = [one.count for one in found.terms]
    numbers, aim = have, error
    if found.standard_error > error:
        numbers = counts(found.terms, error)
        while all(number <= count for number, count in zip(numbers, have, strict=True)):
            aim *= _LESS  # the common part of surfaces that serve several terms counts as well
            numbers = counts(found.terms, aim)
    return [max(number, one.fewest) for number, one in zip(numbers, found.terms, strict=True)]


def _batches(first: int, count: int, sizes: tuple[int, ...], seconds: float) -> tuple[Batch, ...]:
    """Surfaces in batches of about `_SECONDS`, from the time of one of them [s]."""
    size = max(1, math.floor(_SECONDS / seconds))
    return tuple(Batch(first + done, min(size, count - done), sizes) for done in range(0, count, size))


def _within(found: State, rows: Sequence[Row], wanted: Wanted, more_grids: bool) -> State:
    """The same, without anything left to do if that would go beyond the limit.

    more_grids: whether finer grids are needed, on which not all is known that they take.
    """
    if not found.batches:
        return found
    seconds = _seconds(rows) + found.seconds_left
    solves = len(on_grids(rows)) + found.solves_left
    known, allowed = "at least about" if more_grids else "about", "of that or more, or a larger standard error"
    if seconds > wanted.max_seconds:
        more = f"it takes {known} {rounded_up(seconds)} s of solving, max_seconds is {wanted.max_seconds:g}"
        why = f"{more}; allowed: max_seconds {allowed}"
    elif solves > wanted.max_samples:
        more = f"it takes {known} {math.ceil(float(rounded_up(solves)))} solves, max_samples is {wanted.max_samples}"
        why = f"{more}; allowed: max_samples {allowed}"
    else:
        return found
    return State(found.estimates, (), found.seconds_left, found.solves_left, why)
