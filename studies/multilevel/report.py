"""The report of an ensemble: the means with their errors, the surfaces of each grid, and the cost of plain sampling."""

import math
from collections.abc import Sequence
from pathlib import Path

from linecontact.solver.display import counted, rounded_up
from rich.console import RenderableType
from rich.table import Table

from ..files.records import warnings_in
from ..files.study_files import StudyFile
from ..terminal import console
from .allocation import State, Wanted
from .estimator import Estimate, Term
from .samples import FOUNDATION, Row, name_of, on_finest, on_grids, unit_of
from .tasks import found

_ABOUT = 1.05  # ratio of times that are about equal
_ROUNDING = 1e-9  # of the mean: scatter that rounding and the tolerance of the solves leave


def reached(wanted: Wanted, state: State) -> bool:
    """Whether every mean has the standard error that was asked for, and the finest grid is fine enough for it."""
    found = state.estimates.values()
    small = all(e.standard_error <= wanted.error(e) and not wanted.biased(e) for e in found)
    return bool(found) and small and not state.out_of_reach


def grid(term: Term) -> str:
    """The grids of a term."""
    name = name_of(term.num_points)
    return name if term.coarser is None else f"{name_of(term.coarser)} to {name}"


def summary(observable: str, estimate: Estimate) -> Table:
    """A row for each term of the sum."""
    on_foundation = estimate.terms[0].num_points == FOUNDATION
    first = "A mean on a foundation, times a factor," if on_foundation else "A mean on a coarse grid,"
    table = console.table(
        title=f"{observable}: {estimate.mean:.6g} +- {rounded_up(estimate.standard_error)} [{unit_of(observable)}]",
        caption=f"{first} and means of the change to finer ones; std: of one surface; s: time of one surface, and of "
        "all of them [s].",
    )
    for heading in ("grid points", "surfaces", "mean", "std", "s", "s, all"):
        table.add_column(heading, justify="right", no_wrap=True)
    for term in estimate.terms:
        table.add_row(
            grid(term),
            str(term.count),
            f"{term.mean:.5g}",
            f"{math.sqrt(term.variance):.2g}",
            f"{term.seconds:.2g}",
            f"{term.seconds * term.count:.3g}",
        )
    return table


def _sentences(observable: str, estimate: Estimate, wanted: Wanted, spent: float) -> str:
    bias, number = estimate.bias, unit_of(observable)
    finest = estimate.terms[-1].num_points
    off = f"The finest grid, {finest} points, is off by about {rounded_up(bias)} [{number}]"
    if math.isnan(bias):
        off = f"Only {finest} points hold the surfaces: this is plain sampling, whose bias is not known"
    elif wanted.biased(estimate):
        off += f", more than a third of the standard error of {wanted.error(estimate):.2g} that was asked for"
    error = rounded_up(estimate.standard_error)
    said = f"{observable} = {estimate.mean:.6g} +- {error} (standard error) [{number}]. {off}. "
    said += f"Solving took {spent:.3g} s in all processes, with the first surfaces on other grids"
    if not estimate.standard_error > _ROUNDING * abs(estimate.mean):
        return f"{said}; all surfaces have the same value, so the standard error says nothing of how far it is off."
    if math.isnan(bias):
        return f"{said}."
    plain = estimate.plain_cost(estimate.standard_error)
    said += f". Plain sampling on {finest} points takes about {plain:.3g} s to a standard error of {error}, "
    if 1 / _ABOUT < plain / spent < _ABOUT:
        return f"{said}about as long, but does not tell the bias."
    if plain > spent:
        return f"{said}{plain / spent:.2g} times as long."
    return f"{said}and is the cheaper way here, by a factor of {spent / plain:.2g}, but does not tell the bias."


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """For each observable a table, its meaning, and a note on omissions."""
    parts: list[RenderableType] = []
    for file in files.values():
        wanted, state = found(file)
        spent = float(sum(float(run["seconds.total"]) for run in file.runs))
        for observable, estimate in state.estimates.items():
            parts += [summary(observable, estimate), _sentences(observable, estimate, wanted, spent)]
        solves = on_grids(file.runs)
        parts += _warned(solves)
        lost = sum(run["status"] != "converged" for run in solves)
        if lost:
            parts.append(f"Left out: {lost} of {len(solves)} solves that did not converge.")
    return parts


def _warned(solves: Sequence[Row]) -> list[str]:
    """A sentence on the warnings of the surfaces on the finest grid; none where there are none."""
    there = on_finest(solves)
    told = warnings_in(there)
    if not told:
        return []
    surfaces = f"the {counted(len(there), 'surface')} on {there[0]['num_points']} points"
    why = "`linecontact solve --seed N` with one of them says why"
    return [f"Warnings of {surfaces}, and how many have them: {told}; {why}."]


def missed(file: StudyFile) -> list[str]:
    """Why a stored ensemble is less than was asked for, and the allowed values; nothing where it is not."""
    wanted, state = found(file)
    if reached(wanted, state):
        return []
    biased = any(map(wanted.biased, state.estimates.values()))
    finer = "a finer grid is needed; allowed: more num_points, or a larger standard error"
    return [state.out_of_reach or (finer if biased else "it is not finished; allowed: to run it again")]
