"""The report of a curve: a table with a row for each value, and means where the seed is what varies."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver import Status
from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from ..terminal import console
from .tasks import column, unit_in

_MEANS = {"contact_area_subgrid": "a_r", "kappa_subgrid": "kappa"}
"""What is averaged over seeds, and its symbol."""


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The table, and the means over seeds."""
    (file,) = files.values()
    return [summary(file), *means(file), *short(file), *warned(file)]


def short(file: StudyFile) -> list[str]:
    """A sentence on the values that are less accurate than asked; none where all are."""
    count = sum(run["status"] == str(Status.INACCURATE) for run in file.runs)
    c = file.configuration
    what = f"{c.get('accuracy')} of the {str(c.get('accuracy_of', '')).replace('-', ' ')}"
    return [f"{count} values are less accurate than asked ({what}); allowed: more num_points."] if count else []


def warned(file: StudyFile) -> list[str]:
    """A sentence on the values whose solutions have warnings; none where there are none."""
    found = [kind for run in file.runs for kind in str(run.get("warnings", "")).split(", ") if kind]
    told = ", ".join(f"{kind} ({found.count(kind)})" for kind in dict.fromkeys(found))
    return [f"Warnings, and the number of values: {told}; `linecontact solve` says why."] if told else []


def summary(file: StudyFile) -> Table:
    """A row for each value."""
    over = file.configuration["over"]
    table = console.table(
        title=f"{len(file.runs)} values of {over}",
        caption="a_r and kappa between sub-grid edges, +-: the estimated error of a_r; stiffness: dp/d(approach); M: "
        "contact patches; *: not converged, or less accurate than asked. All other quantities: `linecontact export`.",
    )
    columns = {over: over, "a_r": "1", "+-": "1"} | ({"pressure": "pressure"} if over == "approach" else {})
    columns |= {"kappa": "1"} | ({"approach": "approach"} if over != "approach" else {})
    columns |= {"stiffness": "contact_stiffness", "M": "1"}
    for name, quantity in columns.items():
        table.add_column(f"{name}\n[{unit_in(file, quantity)}]".replace("/", "/\n"), justify="right", no_wrap=True)
    for run in file.runs:
        table.add_row(*_row(run, over))
    return table


def _row(run: dict[str, Any], over: str) -> list[str]:
    mark = "" if run["status"] == "converged" else "*"
    load = float(run["scene.pressure" if over == "approach" else "approach"])
    cells = [f"{float(run['kappa_subgrid']):.5g}", f"{load:.4g}"]
    return [
        f"{float(run[column(over)]):.4g}{mark}",
        f"{run['contact_area_subgrid']:.6g}",
        f"{run['contact_area_error']:.0e}",
        *(reversed(cells) if over == "approach" else cells),
        f"{float(run['contact_stiffness']):.4g}",
        f"{run['num_patches']}",
    ]


def means(file: StudyFile) -> list[str]:
    """Sentences with mean and standard error over the seeds; none where something else varies."""
    runs = [run for run in file.runs if run["status"] == "converged"]
    if file.configuration["over"] != "seed" or len(runs) < 2:
        return []
    found = []
    for name, symbol in _MEANS.items():
        values = np.array([float(run[name]) for run in runs])
        error = float(values.std(ddof=1)) / math.sqrt(values.size)
        found.append(f"{symbol} = {values.mean():.6g} +- {error:.2g}")
    return [f"Mean over {len(runs)} surfaces, with its standard error (dimensionless): {', '.join(found)}."]
