"""The report of the map of extremes: tables of verdicts and of reasons, and comparisons of the areas."""

import math
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from ..runner.tasks import Record
from ..terminal import console
from .verdicts import CERTIFIED, DEFECT, REFUSED


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """Tables of verdicts and of reasons, and comparisons of the areas."""
    parts: list[RenderableType] = []
    for file in files.values():
        parts += [summary(file.runs), reasons(file.runs), areas(file.runs)] if file.runs else []
    return parts


def summary(runs: Sequence[Record]) -> Table:
    """Verdicts by request, and how far the areas are off."""
    table = console.table(
        title=f"{len(runs)} cells",
        caption="solved: share certified [%]; worst: largest tolerance certified at, over p; 1e-8: share of these at "
        "1e-8 or less [%]; own request: of a tolerance or an accuracy, maybe too much. All else dimensionless.",
    )
    for heading in ("", "cells", "certified", "refused", "defects", "solved", "worst", "1e-8"):
        table.add_column(heading, justify="left" if not heading else "right", no_wrap=True)
    groups = {"default": [run for run in runs if not run["asked"]]}
    groups |= {
        f"  {p}": [run for run in groups["default"] if run["precision"] == p] for p in _distinct(runs, "precision")
    }
    groups |= {"own request": [run for run in runs if run["asked"]], "all": list(runs)}
    for name, group in groups.items():
        count = Counter(run["verdict"] for run in group)
        levels = [float(run["tolerance"]) for run in group if run["verdict"] == CERTIFIED]
        fine = sum(level <= 1e-8 for level in levels)
        table.add_row(
            name,
            str(len(group)),
            *(str(count[verdict]) for verdict in (CERTIFIED, REFUSED, DEFECT)),
            f"{100 * count[CERTIFIED] / max(1, len(group)):.2f}",
            f"{max(levels, default=0.0):.1g}",
            f"{100 * fine / max(1, len(levels)):.1f}",
        )
    return table


def _distinct(runs: Sequence[Record], name: str) -> list[str]:
    return list(dict.fromkeys(str(run[name]) for run in runs))


def reasons(runs: Sequence[Record]) -> Table:
    """The refused requests, by the parameter that the reason names."""
    table = console.table(title="Refused, by the parameter named")
    for heading in ("parameter", "cells", "own request", "one of them"):
        table.add_column(heading, justify="left" if heading in ("parameter", "one of them") else "right")
    refused = [run for run in runs if run["verdict"] == REFUSED]
    named = Counter(_parameter(run) for run in refused)
    for name, count in named.most_common():
        group = [run for run in refused if _parameter(run) == name]
        table.add_row(name, str(count), str(sum(run["asked"] for run in group)), group[0]["why"])
    return table


def _parameter(run: Record) -> str:
    return re.split(r" is ", run["why"], maxsplit=1)[0]


def areas(runs: Sequence[Record]) -> str:
    """How far the areas are off where they are known, and how often the estimated error holds."""
    known = [run for run in runs if math.isfinite(run.get("off.known", math.nan)) and run["method"] != "to an accuracy"]
    if not known:
        return "No area is known from elsewhere."
    subgrid, counted, estimated, error = (
        np.array([run[f"off.{name}"] for run in known]) for name in ("subgrid", "counted", "claimed", "known")
    )
    share, passed = 100 * float(np.mean(subgrid <= estimated + error)), float(((subgrid - error) / estimated).max())
    return (
        f"In {len(known)} cells solved on a grid to a tolerance the area is known from elsewhere. An edge is off by "
        f"{np.median(subgrid):.2g} grid spacings between nodes, by {np.median(counted):.2g} where nodes are counted "
        f"(medians); at most by {subgrid.max():.2g} and {counted.max():.2g}, and nowhere by more than "
        f"{(subgrid - counted).max():.2g} above counting. The estimated error holds in {share:.1f} % and is passed by "
        f"a factor of {passed:.1f} at most."
    )
