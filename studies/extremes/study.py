"""A map of what can be asked: thousands of random scenes, each certified, refused for a reason, or a defect.

linecontact study extremes [--quick] [--folder FOLDER]

Thickness, Poisson's ratio, pressure, shape, amplitude, number of points, precision, method, units and start all at
their extremes (`cells`), every answer looked at twice (`verdicts`). A cell that asks for a tolerance or an accuracy of
its own may ask for more than can be had; all others are counted as physically meaningful.
"""

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from linecontact.solver import PowerIndenter
from linecontact.solver.relaxation import Progress
from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from ..runner import ensemble
from ..runner.tasks import Record
from ..terminal import console
from . import cells
from .verdicts import CERTIFIED, DEFECT, REFUSED, judge

KIND = "extremes"


@dataclass(frozen=True)
class Configuration:
    """small, middle, large: numbers of cells of each of `cells.SIZES`; seed: of all of them."""

    small: int = 20_000
    middle: int = 400
    large: int = 20
    seed: int = 1

    def study(self) -> ensemble.Study:
        """The tasks, spread over the map's places."""
        counts = {"small": self.small, "middle": self.middle, "large": self.large}
        numbers = [(size, number) for size, count in counts.items() for number in range(count)]
        return ensemble.Study(KIND, asdict(self), [Task(self.seed, number, size) for size, number in numbers])


QUICK = Configuration(small=490, middle=10, large=0)


@dataclass(frozen=True)
class Options(ensemble.Options):
    """Scenes at the extremes, each certified, refused for a reason, or a defect: data, figure, table."""

    quick: bool = False
    """500 cells on up to 2^18 points instead of 20 420 on up to 2^24."""


@dataclass(frozen=True)
class Task:
    """One cell."""

    seed: int
    number: int
    size: str

    def cell(self) -> cells.Cell:
        """The cell, at a place that goes through the whole map as the number grows."""
        place = self.number * 7 % (cells.COLUMNS * cells.ROWS)  # 7 divides neither 25 nor 12
        stream = list(cells.SIZES).index(self.size) + 10 * self.number
        return cells.draw(self.seed, stream, place % cells.COLUMNS, place // cells.COLUMNS, self.size)

    def run(self, report: Progress | None) -> Record:
        """The cell's record: what was asked, the verdict, and what was found."""
        cell = self.cell()
        return describe(cell) | judge(cell)


def describe(cell: cells.Cell) -> Record:
    """What a cell asks for, in units L = E* = 1."""
    scene, options = cell.scene, cell.options
    indenter = scene.indenter
    steepness = {"scene.exponent": indenter.exponent} if isinstance(indenter, PowerIndenter) else {}
    return {
        "shape": cell.shape,
        "highest": float(indenter.profile(scene.num_points, 1.0).max()),
        **steepness,
        "scene.thickness": scene.layer.thickness,
        "scene.poisson_ratio": scene.layer.poisson_ratio,
        "scene.pressure": scene.pressure,
        "scene.num_points": scene.num_points,
        "full_load": cell.full_load,
        "unit_length": cell.length,
        "unit_pressure": cell.stress,
        "precision": scene.precision,
        "method": str(options.get("method", "to an accuracy")),
        "asked_for": float(options.get("tolerance", options.get("accuracy", 0.0))),
        "elsewhere": int(cell.initial is not None),
    }


def command(options: Options) -> int:
    """Run the study as asked, or what is left of it; returns the exit status, 4 if there is a defect."""
    folder = Path("results/extremes-quick" if options.quick else "results/extremes")
    study = (QUICK if options.quick else Configuration()).study()
    return ensemble.command([study], options, folder, closing, defects)


def closing(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """Tables of verdicts and of reasons, and what is known of the areas."""
    parts: list[RenderableType] = []
    for file in files.values():
        parts += [summary(file.runs), reasons(file.runs), areas(file.runs)] if file.runs else []
    return parts


def summary(runs: Sequence[Record]) -> Table:
    """Verdicts by what was asked, and how far the areas are off."""
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
    """What was refused, by the parameter that the reason names."""
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
    """How far the areas are off where they are known, and how often the claimed error holds."""
    known = [run for run in runs if math.isfinite(run.get("off.known", math.nan)) and run["method"] != "to an accuracy"]
    if not known:
        return "No area is known from elsewhere."
    subgrid, counted, claimed, error = (
        np.array([run[f"off.{name}"] for run in known]) for name in ("subgrid", "counted", "claimed", "known")
    )
    share, passed = 100 * float(np.mean(subgrid <= claimed + error)), float(((subgrid - error) / claimed).max())
    return (
        f"In {len(known)} cells solved on a grid to a tolerance the area is known from elsewhere. An edge is off by "
        f"{np.median(subgrid):.2g} grid spacings between nodes, by {np.median(counted):.2g} where nodes are counted "
        f"(medians); at most by {subgrid.max():.2g} and {counted.max():.2g}, and nowhere by more than "
        f"{(subgrid - counted).max():.2g} above counting. The error claimed holds in {share:.1f} % and is passed by a "
        f"factor of {passed:.1f} at most."
    )


def defects(file: StudyFile) -> list[str]:
    """A line on each."""
    return [
        f"{run['shape']}, N {run['scene.num_points']}, d/L {float(run['scene.thickness']):.3g}: {run['why']}"
        for run in file.runs
        if run["verdict"] == DEFECT
    ]
