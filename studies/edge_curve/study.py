"""The universal edge curve, measured: where a contact ends, from the ratio of its last two nodal pressures.

linecontact study edge-curve [--folder FOLDER]

Loads are chosen so that the edge, known from the collocation oracle, takes every place between two nodes. The curve in
`linecontact.solver.edges` is a closed form; this is the check, on high-resolution solutions, and its error.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from linecontact.solver import Layer, PowerIndenter, Scene, collocation, edges, solve
from linecontact.solver.relaxation import Progress
from rich.console import RenderableType
from rich.table import Table

from ..files import records
from ..files.study_files import StudyFile
from ..runner import ensemble
from ..runner.tasks import Record
from ..terminal import console

KIND = "edge-curve"


@dataclass(frozen=True)
class Configuration:
    """scenes: (exponent, thickness over the period, Poisson's ratio); places: of the edge between nodes, per scene."""

    num_points: int = 2**15
    scenes: tuple[tuple[float, float, float], ...] = (
        (2.0, math.inf, 0.25),
        (1.5, math.inf, 0.25),
        (4.0, math.inf, 0.25),
        (2.0, 0.05, 0.0),
        (2.0, 0.02, 0.45),
    )
    places: int = 12
    tolerance: float = 1e-9

    def study(self) -> ensemble.Study:
        """The tasks."""
        places = [place / self.places for place in range(self.places)]
        runs = [Task(self.num_points, *scene, place, self.tolerance) for scene in self.scenes for place in places]
        return ensemble.Study(KIND, asdict(self), runs)


@dataclass(frozen=True)
class Options(ensemble.Options):
    """Measure the universal edge curve on high-resolution solutions: data, figure, table."""


@dataclass(frozen=True)
class Task:
    """One load, with the edge about `place` between two nodes [grid spacings]."""

    num_points: int
    exponent: float
    thickness: float
    poisson_ratio: float
    place: float
    tolerance: float

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
        three, two, _ = edges.edge_offset(edges.edge_curve(), last[None, :])
        return records.run_record(solution) | {
            "place": self.place,
            "ratio": float(last[0] / last[1]),
            "offset": float(n / 2 - exact.half_width * n - nodes[0]),
            "offset.two_nodes": float(two[0]),
            "offset.three_nodes": float(three[0]),
        }


def command(options: Options) -> int:
    """Run what is left of the study; returns the exit status."""
    return ensemble.command([Configuration().study()], options, Path("results/edge-curve"), closing)


def closing(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The table."""
    return [summary(file) for file in files.values()]


def summary(study: StudyFile) -> Table:
    """Largest deviations from the closed form, per scene."""
    table = console.table(
        title=f"Edge offsets against the oracle, {study.configuration['num_points']} points",
        caption="Largest |error| of the edge's place by the closed form, from the last two and the last three nodal "
        "pressures, in grid spacings. All dimensionless.",
    )
    for heading in ("n", "d/L", "nu", "places", "two nodes", "three nodes"):
        table.add_column(heading, justify="right", no_wrap=True)
    names = ("scene.exponent", "scene.thickness", "scene.poisson_ratio")
    for scene in dict.fromkeys(tuple(run[name] for name in names) for run in study.runs):
        runs = [run for run in study.runs if tuple(run[name] for name in names) == scene]
        worst = [max(abs(run[f"offset.{k}_nodes"] - run["offset"]) for run in runs) for k in ("two", "three")]
        table.add_row(*(f"{float(value):g}" for value in scene), str(len(runs)), *(f"{w:.1e}" for w in worst))
    return table
