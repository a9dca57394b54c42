"""What to solve next for a standard error, and whether it can be reached. Everything follows from the samples so far,
so that a run that was killed goes on as if it had not been.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from linecontact.solver import Scene

from .estimator import Estimate, best_ladder, counts, estimate
from .samples import Batch, Row, Samples

PILOT, FINER_PILOT = 16, 8
"""Surfaces that are solved first, on the coarsest grids and on finer ones; they tell variances and times."""

_WAVE_POINTS = 4  # of the coarsest grid to the shortest wave
_FEWEST = 2**8  # points of the coarsest grid
_FIRST_GRIDS = 3  # with which to begin
_BIAS = 1 / 3  # of the standard error that the finest grid may be off
_GROWTH = 4  # factor by which a number of surfaces grows at once: variances become known better on the way
_SECONDS = 1.0  # of a task
_LESS = 0.97  # of an error, to be sure of it
_APART = 2**40  # seeds between the surfaces of two terms


@dataclass(frozen=True)
class Wanted:
    """What the user asked for."""

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


@dataclass(frozen=True)
class State:
    """How far an ensemble is."""

    estimates: dict[str, Estimate]
    """By observable; empty before the first surfaces are solved on all grids."""
    batches: tuple[Batch, ...]
    """What to solve next; none when it is done, or out of reach."""
    seconds_left: float
    """Time of solving that all that is left takes, as far as it is known [s]."""
    out_of_reach: str = ""
    """Why it goes no further, with what is allowed instead."""


def grid_sizes(scene: Scene) -> tuple[int, ...]:
    """The grids that hold the surface, from coarse to fine, each twice the one before; the scene's is the finest."""
    sizes = [scene.num_points]
    least = max(_FEWEST, _WAVE_POINTS * scene.indenter.shortest_wave(scene.num_points))
    while sizes[0] % 2 == 0 and sizes[0] // 2 >= least:
        sizes.insert(0, sizes[0] // 2)
    return tuple(sizes)


def state(rows: Sequence[Row], sizes: Sequence[int], wanted: Wanted, first_seed: int) -> State:
    """From the solves so far to what is known, and what to do next."""
    known = {name: Samples(rows, name) for name in wanted.observables}
    main = known[wanted.observables[0]]
    tried = {(int(row["seed"]), int(row["num_points"])) for row in rows}
    pilots = [PILOT if i < _FIRST_GRIDS else FINER_PILOT for i in range(len(sizes))]
    reached = [
        size
        for size, count in zip(sizes, pilots, strict=True)
        if all((seed, size) in tried for seed in range(first_seed, first_seed + count))
    ]
    if len(reached) < min(_FIRST_GRIDS, len(sizes)):
        return State({}, _batches(first_seed, PILOT, tuple(sizes[:_FIRST_GRIDS]), math.inf), math.nan)
    ladder = best_ladder(main, reached)
    estimates = {name: estimate(samples, ladder, reached) for name, samples in known.items()}
    if any(not found.bias <= _BIAS * wanted.error(found) for found in estimates.values()) and len(reached) < len(sizes):
        finer = sizes[len(reached)]
        seconds = main.seconds(reached[-1]) * finer / reached[-1]
        count = pilots[len(reached)]
        batches = _batches(first_seed, count, (finer,), seconds)
        return _within(State(estimates, batches, count * seconds), main, rows, wanted)
    planned: list[Batch] = []
    left = 0.0
    each = [_numbers(found, wanted.error(found)) for found in estimates.values()]
    for i, one in enumerate(estimates[wanted.observables[0]].terms):
        missing = max(numbers[i] for numbers in each) - one.count
        if missing <= 0:
            continue
        left += missing * one.seconds
        own = first_seed + PILOT + (1 + sizes.index(one.num_points)) * _APART
        here = tuple(size for size in (one.coarser, one.num_points) if size)
        while (own, here[-1]) in tried:  # of this term or, with another coarser grid, of an earlier one
            own += 1
        more = min(missing, _GROWTH * one.count)
        planned += _batches(own, more, here, one.seconds)
    return _within(State(estimates, tuple(planned), left), main, rows, wanted)


def _numbers(found: Estimate, error: float) -> list[int]:
    """Surfaces for each term; as many as there are where the standard error is small enough."""
    if found.standard_error <= error:
        return [one.count for one in found.terms]
    numbers = counts(found.terms, error)
    enough = all(number <= one.count for number, one in zip(numbers, found.terms, strict=True))
    # what the surfaces solved first have in common counts as well
    return counts(found.terms, error**2 / found.standard_error * _LESS) if enough else numbers


def _batches(first: int, count: int, sizes: tuple[int, ...], seconds: float) -> tuple[Batch, ...]:
    """Surfaces in batches of about `_SECONDS`, from the time of one of them [s]."""
    size = max(1, math.floor(_SECONDS / seconds))
    return tuple(Batch(first + done, min(size, count - done), sizes) for done in range(0, count, size))


def _within(found: State, samples: Samples, rows: Sequence[Row], wanted: Wanted) -> State:
    """The same, without anything left to do if that would go beyond what may be planned."""
    if not found.batches:
        return found
    seconds = samples.spent + found.seconds_left
    planned = len(rows) + sum(batch.count * len(batch.sizes) for batch in found.batches)
    why = ""
    if seconds > wanted.max_seconds:
        why = f"it takes about {seconds:.2g} s of solving; allowed: max_seconds of that, or a larger standard error"
    elif planned > wanted.max_samples:
        why = f"it takes {planned} solves and more; allowed: max_samples of that, or a larger standard error"
    return State(found.estimates, () if why else found.batches, found.seconds_left, why)
