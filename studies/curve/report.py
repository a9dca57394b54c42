"""The report of a curve: a table with a row for each value, and means where the seed varies."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver import Status
from linecontact.solver.display import counted, rounded_up
from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.table import Table

from ..files.records import warnings_in
from ..files.study_files import StudyFile
from ..scans.preparation import mirrored
from ..terminal import console
from .tasks import column, unit_in

_MEANS = {"contact_area_subgrid": "a_r", "kappa_subgrid": "kappa"}
"""The quantities that are averaged over seeds, and their symbols."""


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The table, and the means over seeds."""
    (file,) = files.values()
    return [Summary(file), *means(file), *short(file), *warned(file)]


def short(file: StudyFile) -> list[str]:
    """A sentence on the values that are less accurate than asked; none where all are."""
    count = sum(run["status"] == str(Status.INACCURATE) for run in file.runs)
    c = file.configuration
    what = f"{c.get('accuracy')} of the {str(c.get('accuracy_of', '')).replace('-', ' ')}"
    values = f"{counted(count, 'value')} {'is' if count == 1 else 'are'}"
    told = f"{values} less accurate than asked ({what}); allowed: more num_points."
    return [told] if count else []


def warned(file: StudyFile) -> list[str]:
    """A sentence on the values whose solutions have warnings; none where there are none."""
    told = warnings_in(file.runs)
    return [f"Warnings, and the number of values: {told}; `linecontact solve` says why."] if told else []


@dataclass(frozen=True)
class Summary:
    """A row for each value, with as many columns as the screen has room for."""

    file: StudyFile
    """The stored curve."""

    @property
    def title(self) -> str:
        """Its heading."""
        return f"{counted(len(self.file.runs), 'value')} of {self.file.configuration['over']}"

    def __rich_console__(self, screen: Console, options: ConsoleOptions) -> RenderResult:
        table = self._table(_WIDE, "All other quantities")
        if screen.measure(table, options=options.update(width=_MOST)).maximum > options.max_width:
            table = self._table(_NARROW, "p*, mean gap and peak pressure on wider terminals; everything")
        yield table

    def _table(self, headings: Sequence[str], more: str) -> Table:
        over = self.file.configuration["over"]
        caption = "a_r, kappa and p* between sub-grid edges, +-: estimated numerical error; stiffness: dp/d(approach);"
        steps = next((run.get("scene.profile_steps") for run in self.file.runs), "")
        image = ", mirror image too" * mirrored({"profile_steps": steps})
        if any(math.isinf(float(run["contact_stiffness"])) for run in self.file.runs):
            caption += " inf: in full contact no load moves the indenter further;"
        if {math.isinf(float(run.get("scene.thickness", 0))) for run in self.file.runs} == {True, False}:
            caption += " approach and stiffness of the half-space have another reference, and compare with no other;"
        caption += f" M: contact patches{image}; *: not converged, or less accurate than asked."
        table = console.table(title=self.title, caption=f"{caption} {more}: `linecontact export`.")
        shown = [name for name in headings if name != _NOT_SHOWN.get(over, "p")]
        for name, quantity in ((over, over), *((name, _COLUMNS[name][0]) for name in shown)):
            unit = unit_in(self.file, quantity)
            table.add_column(f"{name}\n[{unit}]".replace("/", "/\n"), justify="right", no_wrap=True)
        for run in self.file.runs:
            mark = "" if run["status"] == "converged" else "*"
            cells = (_COLUMNS[name][1](run) for name in shown)
            table.add_row(f"{float(run[column(over)]):.4g}{mark}", *cells)
        return table


_COLUMNS: dict[str, tuple[str, Callable[[Mapping[str, Any]], str]]] = {
    "p": ("pressure", lambda run: f"{float(run['scene.pressure']):.4g}"),
    "p*": ("reduced_pressure", lambda run: f"{_reduced_pressure(run):.4g}"),
    "a_r": ("contact_area_subgrid", lambda run: f"{run['contact_area_subgrid']:.6g}"),
    "+-": ("contact_area_error", lambda run: rounded_up(run["contact_area_error"])),
    "kappa": ("kappa_subgrid", lambda run: f"{float(run['kappa_subgrid']):.5g}"),
    "approach": ("approach", lambda run: f"{float(run['approach']):.4g}"),
    "mean gap": ("mean_gap", lambda run: f"{float(run['mean_gap']):.4g}"),
    "stiffness": ("contact_stiffness", lambda run: f"{float(run['contact_stiffness']):.4g}"),
    "M": ("num_patches", lambda run: f"{run['num_patches']}"),
    "peak": ("peak_pressure", lambda run: f"{float(run['peak_pressure']):.4g}"),
}
"""The name whose unit a column has, and its contents, by its heading."""

_WIDE = tuple(_COLUMNS)
_NARROW = tuple(name for name in _COLUMNS if name not in ("p*", "mean gap", "peak"))
_NOT_SHOWN = {"approach": "approach"}
"""The column that is the number itself, or the same in every row, by the varied number; of others the pressure's."""
_MOST = 1000  # columns of a terminal


def _reduced_pressure(run: Mapping[str, Any]) -> float:
    """p*, of the contact that a_r and kappa are of; NaN where nothing touches."""
    kappa = float(run["kappa_subgrid"])
    return float(run["contact_area_subgrid"]) / kappa if kappa else math.nan


def means(file: StudyFile) -> list[str]:
    """Sentences with mean and standard error over the seeds; none where something else varies."""
    runs = [run for run in file.runs if run["status"] == "converged"]
    if file.configuration["over"] != "seed" or len(runs) < 2:
        return []
    found = []
    for name, symbol in _MEANS.items():
        values = np.array([float(run[name]) for run in runs])
        error = float(values.std(ddof=1)) / math.sqrt(values.size)
        found.append(f"{symbol} = {values.mean():.6g} +- {rounded_up(error)}")
    return [f"Mean over {len(runs)} surfaces, with its standard error (dimensionless): {', '.join(found)}."]
