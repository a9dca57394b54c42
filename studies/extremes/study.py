"""A map of possible requests: thousands of random scenes, each certified, refused for a reason, or a defect.

linecontact study extremes [--quick] [--folder FOLDER]

Thickness, Poisson's ratio, pressure, shape, amplitude, number of points, precision, method, units and start all at
their extremes (`cells`), every answer looked at twice (`verdicts`). A cell that asks for a tolerance or an accuracy of
its own may ask for more than can be had; all others are counted as physically meaningful.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from linecontact.solver.methods import Progress

from ..files.study_files import StudyFile
from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Record
from . import cells
from .report import report
from .verdicts import DEFECT, judge

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "extremes"


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the study."""

    small: int = 20_000
    """Number of small cells, see `cells.SIZES`."""
    middle: int = 400
    """Number of cells of middle size."""
    large: int = 20
    """Number of large cells."""
    seed: int = 1
    """Of the random numbers that all cells are drawn from."""

    def plan(self) -> Plan:
        """The tasks, spread over the map's places."""
        counts = {"small": self.small, "middle": self.middle, "large": self.large}
        numbers = [(size, number) for size, count in counts.items() for number in range(count)]
        return Plan(NAME, asdict(self), [Task(self.seed, number, size) for size, number in numbers])


QUICK = Configuration(small=290, middle=10, large=0)


@dataclass(frozen=True)
class Options(study.Options):
    """Scenes at the extremes, each certified, refused for a reason, or a defect: data, figure, table."""

    quick: bool = False
    """300 cells on up to 2^18 points instead of 20 420 on up to 2^24."""


@dataclass(frozen=True)
class Task:
    """One cell of the map."""

    kind: ClassVar[str] = "linecontact.studies.extremes.Task"

    seed: int
    """Of all cells."""
    number: int
    """Which of the cells of its size."""
    size: str
    """One of `cells.SIZES`."""

    def cell(self) -> cells.Cell:
        """The cell, at a place that goes through the whole map as the number grows."""
        place = self.number * 7 % (cells.COLUMNS * cells.ROWS)  # 7 divides neither 25 nor 12
        stream = list(cells.SIZES).index(self.size) + 10 * self.number
        return cells.draw(self.seed, stream, place % cells.COLUMNS, place // cells.COLUMNS, self.size)

    def run(self, report: Progress | None) -> Record:
        """The cell's record: the request, the verdict, and the results."""
        cell = self.cell()
        return describe(cell) | judge(cell)


def describe(cell: cells.Cell) -> Record:
    """The request of a cell, in units L = E* = 1."""
    scene, options = cell.scene, cell.options
    indenter = scene.indenter
    layer = scene.layer.to_dict()
    steepness = {"scene.exponent": indenter.power_law[0]} if indenter.power_law else {}
    return {
        "shape": cell.shape,
        "highest": float(indenter.profile(scene.num_points, 1.0).max()),
        **steepness,
        "scene.thickness": layer["thickness"],
        "scene.poisson_ratio": layer["poisson_ratio"],
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


def defects(file: StudyFile) -> list[str]:
    """A line on each cell that is a defect."""
    return [
        f"{run['shape']}, N {run['scene.num_points']}, d/L {float(run['scene.thickness']):.3g}: {run['why']}"
        for run in file.runs
        if run["verdict"] == DEFECT
    ]


def plans(options: Options) -> Sequence[Plan]:
    """The tasks at full size, or those of the quick study."""
    return [(QUICK if options.quick else Configuration()).plan()]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw, defects=defects)


def command(options: Options) -> int:
    """Run the study as asked, or the rest of it; returns the exit status, 4 if there is a defect."""
    return run_study(STUDY, options)
