"""The universal edge curve, measured: where a contact ends, from the ratio of its last two nodal pressures.

linecontact study edge-curve [--folder FOLDER]

Loads are chosen so that the edge, known from the collocation oracle, takes every place between two nodes. The curve in
`linecontact.solver.grid.edge_curves` is a closed form; this is the check, on high-resolution solutions, and its error.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from linecontact.solver import Layer, PowerIndenter, Scene, solve
from linecontact.solver.grid import edges
from linecontact.solver.grid.edge_curves import half_space_curve
from linecontact.solver.methods import Progress
from linecontact.solver.reference import collocation
from rich.console import RenderableType
from rich.table import Table

from ..files import records
from ..files.study_files import StudyFile
from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Record
from ..terminal import console

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "edge-curve"


@dataclass(frozen=True)
class Configuration:
    """What identifies the study."""

    num_points: int = 2**15
    """Grid points of every solve."""
    scenes: tuple[tuple[float, float, float], ...] = (
        (2.0, math.inf, 0.25),
        (1.5, math.inf, 0.25),
        (4.0, math.inf, 0.25),
        (2.0, 0.05, 0.0),
        (2.0, 0.02, 0.45),
    )
    """Exponent of the profile, thickness over the period and Poisson's ratio (dimensionless)."""
    places: int = 12
    """Places of the edge between two nodes, for each scene."""
    tolerance: float = 1e-9
    """Of the solves: rms free residual over p (dimensionless)."""

    def plan(self) -> Plan:
        """The tasks."""
        places = [place / self.places for place in range(self.places)]
        runs = [Task(self.num_points, *scene, place, self.tolerance) for scene in self.scenes for place in places]
        return Plan(NAME, asdict(self), runs)


@dataclass(frozen=True)
class Options(study.Options):
    """Measure the universal edge curve on high-resolution solutions: data, figure, table."""


@dataclass(frozen=True)
class Task:
    """One load, with the edge about `place` between two nodes [grid spacings]."""

    kind: ClassVar[str] = "linecontact.studies.edge_curve.Task"

    num_points: int
    """Grid points."""
    exponent: float
    """n of the profile h = (R/n) |x/R|^n."""
    thickness: float
    """Of the layer over the period (dimensionless)."""
    poisson_ratio: float
    """Of the layer (dimensionless)."""
    place: float
    """About where the edge is between two nodes [grid spacings]."""
    tolerance: float
    """Rms free residual over p to stop at (dimensionless)."""

    def run(self, report: Progress | None) -> Record:
        """The record with the pressures' ratio, the edge's true offset and what the closed form makes of the ratio."""
        n, layer = self.num_points, (self.thickness, self.poisson_ratio)
        guess = collocation.solve_load(2e-3, self.exponent, 1.0, *layer)
        # a grid spacing more of half-width, in steps; near enough, what matters is that the places differ
        stretch = 1 + self.place / (guess.half_width * n)
        load = 2e-3 * stretch ** (self.exponent if math.isinf(self.thickness) else self.exponent + 1)
        exact = collocation.solve_load(load, self.exponent, 1.0, *layer)
        scene = Scene(Layer(*layer), PowerIndenter(self.exponent), load, num_points=n)
        solution = solve(scene, tolerance=self.tolerance, progress=report)
        nodes = np.flatnonzero(solution.contact)[:3]
        last = solution.contact_pressure[nodes]
        three, two, _ = edges.edge_offset(half_space_curve(), last[None, :])
        return records.run_record(solution) | {
            "place": self.place,
            "ratio": float(last[0] / last[1]),
            "offset": float(n / 2 - exact.half_width * n - nodes[0]),
            "offset.two_nodes": float(two[0]),
            "offset.three_nodes": float(three[0]),
        }


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The table of deviations."""
    return [summary(file) for file in files.values()]


def summary(file: StudyFile) -> Table:
    """A table of the largest deviations from the closed form, one row for each scene."""
    table = console.table(
        title=f"Edge offsets against the oracle, {file.configuration['num_points']} points",
        caption="Largest |error| of the edge's place by the closed form, from the last two and the last three nodal "
        "pressures, in grid spacings. All dimensionless.",
    )
    for heading in ("n", "d/L", "nu", "places", "two nodes", "three nodes"):
        table.add_column(heading, justify="right", no_wrap=True)
    names = ("scene.exponent", "scene.thickness", "scene.poisson_ratio")
    for scene in dict.fromkeys(tuple(run[name] for name in names) for run in file.runs):
        runs = [run for run in file.runs if tuple(run[name] for name in names) == scene]
        worst = [max(abs(run[f"offset.{k}_nodes"] - run["offset"]) for run in runs) for k in ("two", "three")]
        table.add_row(*(f"{float(value):g}" for value in scene), str(len(runs)), *(f"{w:.1e}" for w in worst))
    return table


def plans(_: Options) -> Sequence[Plan]:
    """The tasks."""
    return [Configuration().plan()]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw)


def command(options: Options) -> int:
    """Run the study as asked, or what is left of it; returns the exit status."""
    return run_study(STUDY, options)
