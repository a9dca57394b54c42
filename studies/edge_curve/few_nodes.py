"""Areas of rough surfaces that a grid sees with few points to the shortest wave, with and without the patches' loads.

The second file of `linecontact study edge-curve`. The area that counts as true is that on a grid with 64 times as many
points as the coarsest one.
"""

import math
from dataclasses import asdict, dataclass
from typing import ClassVar

import numpy as np
from linecontact.solver import Layer, RoughIndenter, Scene, solve
from linecontact.solver.grid.contact import contact_edges
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods import Progress
from rich.table import Table

from ..files.study_files import StudyFile
from ..runner.study import Plan
from ..runner.tasks import ROWS, Record
from ..terminal import console

KIND = "few-nodes"

_WAYS = {"by_pressures": "pressures", "by_loads": "loads or pressures"}
"""Columns with areas, and how the ends of the patches were found."""


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the file."""

    hursts: tuple[float, ...] = (0.3, 0.8)
    """H (dimensionless)."""
    thicknesses: tuple[float, ...] = (math.inf, 1e-3)
    """Of the layer over the period (dimensionless)."""
    seeds: tuple[int, ...] = tuple(range(40, 56))
    """Of the surfaces."""
    points_to_wave: tuple[int, ...] = (4, 8, 16, 32, 64)
    """Grid points to the shortest wave."""
    true: int = 256
    """The same on the grid whose area counts as true."""
    pressure: float = 0.01
    """Mean pressure over E* (dimensionless)."""
    poisson_ratio: float = 0.25
    """Of the layer (dimensionless)."""

    def plan(self) -> Plan:
        """The tasks."""
        common = self.points_to_wave, self.true, self.pressure, self.poisson_ratio
        runs = [Surface(h, d, seed, *common) for h in self.hursts for d in self.thicknesses for seed in self.seeds]
        return Plan(KIND, asdict(self), runs, figures=())


@dataclass(frozen=True)
class Surface:
    """A surface on all grids."""

    kind: ClassVar[str] = "linecontact.studies.edge_curve.Surface"

    hurst: float
    """H (dimensionless)."""
    thickness: float
    """Of the layer over the period (dimensionless)."""
    seed: int
    """Of the surface."""
    points_to_wave: tuple[int, ...]
    """Grid points to the shortest wave."""
    true: int
    """The same on the grid whose area counts as true."""
    pressure: float
    """Mean pressure over E* (dimensionless)."""
    poisson_ratio: float
    """Of the layer (dimensionless)."""

    def run(self, report: Progress | None) -> Record:
        """A row for each grid: a_r with the ends of patches by pressures alone, and as the program has it."""
        indenter = RoughIndenter(self.hurst, self.seed)
        waves = indenter.shortest_wave(self.true)  # the same on every grid
        layer = Layer(self.thickness, self.poisson_ratio)

        def solved(points: int) -> dict[str, float | str]:
            scene = Scene(layer, indenter, self.pressure, num_points=points * waves)
            solution = solve(scene, progress=report)
            alone = contact_edges(Problem.from_scene(scene), solution.contact_pressure).ends
            return {
                "num_points": scene.num_points,
                "points_to_wave": points,
                "by_pressures": float(alone.width.sum()) / scene.num_points,
                "by_loads": solution.observables.contact_area_subgrid,
                "seconds.total": solution.seconds["total"],
                "status": str(solution.status),
            }

        true = solved(self.true)
        own = {"hurst": self.hurst, "thickness": self.thickness, "seed": self.seed, "true": true["by_loads"]}
        rows = [own | solved(points) for points in self.points_to_wave]
        if true["status"] != "converged":  # and then no row is worth anything
            rows = [row | {"status": true["status"]} for row in rows]
        return {ROWS: rows}


def summary(file: StudyFile) -> Table:
    """Rms relative errors of the area, by surface, layer and way, over the points to a wave."""
    points = file.configuration["points_to_wave"]
    table = console.table(
        title="Areas on rough surfaces with few points to the shortest wave",
        caption=f"Relative error of a_r in thousandths, root mean square over {len(file.configuration['seeds'])} "
        f"surfaces, with {points[0]} to {points[-1]} points to the shortest wave; true is the area of "
        f"{file.configuration['true']} points. Ends of patches by pressures alone, and by loads where those know "
        f"them better. p = {file.configuration['pressure']:g} E*, nu = {file.configuration['poisson_ratio']:g}. All "
        "dimensionless.",
    )
    for heading in ("H", "d/L", "ends by", *map(str, points)):
        table.add_column(heading, justify="left" if heading == "ends by" else "right", no_wrap=True)
    for hurst in file.configuration["hursts"]:
        for thickness in map(float, file.configuration["thicknesses"]):
            own = [run for run in file.runs if (run["hurst"], float(run["thickness"])) == (hurst, thickness)]
            for column, label in _WAYS.items():
                errors = [
                    math.sqrt(np.mean([(r[column] / r["true"] - 1) ** 2 for r in own if r["points_to_wave"] == w]))
                    for w in points
                ]
                shown = (f"{1e3 * error:.{3 if error > 0.1 else 2}g}" for error in errors)
                table.add_row(f"{hurst:g}", f"{thickness:g}", label, *shown)
    return table
