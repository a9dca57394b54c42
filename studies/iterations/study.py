"""The cost of a solution over N: transform pairs and time of every method, Hertz and one rough surface, half-space.

linecontact study iterations [--quick] [--folder FOLDER]

The rough surface has its shortest wave at L/1024, so that every grid from 2^12 on holds it whole.
"""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from linecontact.solver import PowerIndenter, RoughIndenter, Scene, solve
from linecontact.solver.grid.cached import forget
from linecontact.solver.methods import DEFAULT, METHODS, Progress
from linecontact.solver.reference import closed_forms
from linecontact.solver.transforms.planned import plan_transforms
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

NAME = "iterations"
LOADS = {"Hertz": 2e-3, "rough": 1e-2}


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the study."""

    default: tuple[int, ...] = (12, 14, 16, 18, 20, 22)
    """log2 of the numbers of points of the default method, on both scenes."""
    others: tuple[int, ...] = (12, 14, 16, 18, 20)
    """log2 of the numbers of points of the other methods, on the Hertz scene."""
    growing: tuple[int, ...] = (12, 14, 16, 18)
    """The same for methods whose iterations grow with the number of points."""
    tolerance: float = 1e-8
    """Of the solves: rms equilibrium residual over p (dimensionless)."""

    def plan(self) -> Plan:
        """The tasks."""
        sizes = {(scene, DEFAULT.name): self.default for scene in LOADS}
        for kind in METHODS.values():
            if kind is not DEFAULT:
                sizes["Hertz", kind.name] = self.growing if kind.grows else self.others
        runs = [Task(scene, method, k, self.tolerance) for (scene, method), ks in sizes.items() for k in ks]
        return Plan(NAME, asdict(self), runs)


QUICK = Configuration((12, 14), (12, 14), (12, 14))


@dataclass(frozen=True)
class Options(study.Options):
    """Transform pairs and seconds to a residual of 1e-8 over N, for every method: data, figure, table."""

    workers: int = 1
    """More than one disturb each other's times."""
    quick: bool = False
    """Up to 2^14 points only."""


def make_scene(name: str, log2_num_points: int) -> Scene:
    """One of the study's scenes."""
    indenter = PowerIndenter() if name == "Hertz" else RoughIndenter(0.8, 0, 1 / 8, 1 / 128)
    return Scene(indenter=indenter, pressure=LOADS[name], num_points=2**log2_num_points)


def pair_seconds(num_points: int) -> float:
    """Median time of one real forward-inverse pair in float64, plans by estimate [s]."""
    transforms = plan_transforms(num_points, "float64", way="real")
    buffer = transforms.buffer()
    forward, inverse = transforms.forward(buffer), transforms.inverse(buffer)
    times = []
    for _ in range(7):
        buffer[:num_points] = 1.0
        begin = time.perf_counter()
        forward()
        inverse()
        times.append(time.perf_counter() - begin)
    return float(np.median(times))


@dataclass(frozen=True)
class Task:
    """One solve, timed."""

    kind: ClassVar[str] = "linecontact.studies.iterations.Task"

    name: str
    """Of the scene, see `make_scene`."""
    method: str
    """Of the solve."""
    log2_num_points: int
    """log2 of the number of grid points."""
    tolerance: float
    """Rms equilibrium residual over p to stop at (dimensionless)."""

    def run(self, report: Progress | None) -> Record:
        """The solution's record, with the time of a transform pair taken before and after."""
        scene = make_scene(self.name, self.log2_num_points)
        if self.method == DEFAULT.name:
            solve(make_scene(self.name, min(self.log2_num_points, 14)))  # kernels, tables and short plans are there
        pair = pair_seconds(scene.num_points)
        forget()
        solution = solve(scene, method=self.method, tolerance=self.tolerance, progress=report)
        pair = (pair + pair_seconds(scene.num_points)) / 2
        return records.run_record(solution) | {"name": self.name, "seconds.pair": pair}


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The table, and the comparison in one sentence."""
    return [part for file in files.values() if file.complete for part in (summary(file), one_line(file))]


def exact_areas(file: StudyFile) -> dict[str, float]:
    """a_r of each scene: Hertz in closed form, rough from the finest grid's sub-grid edges."""
    rough = file.select("name", "rough")
    finest = int(np.argmax(rough.column("scene.num_points")))
    return {
        "Hertz": closed_forms.periodic_half_space_area(2.0, 1.0, LOADS["Hertz"]),
        "rough": rough.runs[finest]["contact_area_subgrid"],
    }


def summary(file: StudyFile) -> Table:
    """One row per run, with the error it reached."""
    exact = exact_areas(file)
    table = console.table(
        title="Pairs and seconds to a residual of 1e-8 on the half-space",
        caption="pairs: transform pairs in units of one at that N; count, sub-grid: errors of a_r in grid spacings, of "
        "counted nodes and between sub-grid edges, against the closed form (Hertz) or the finest grid (rough); solve: "
        "solving time, over the points beside it. All but the times dimensionless.",
    )
    headings = ("scene", "method", "N", "pairs", "count", "sub-\ngrid", "solve\n(s)", "/N\n(us)")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    for run in file.runs:
        n, area = run["scene.num_points"], exact[run["name"]]
        table.add_row(
            run["name"],
            run["method"],
            f"2^{int(n).bit_length() - 1}",
            f"{run['transform_pairs']:.1f}",
            f"{(run['contact_area'] - area) * n:+.2f}",
            f"{(run['contact_area_subgrid'] - area) * n:+.0e}",
            f"{run['seconds.solve']:.2g}",
            f"{run['seconds.solve'] / n * 1e6:.3g}",
        )
    return table


def one_line(file: StudyFile) -> str:
    """The smallest grid with sub-grid edges beside counting on the largest common one."""
    hertz = file.select("name", "Hertz").select("method", DEFAULT.name)
    exact, n = exact_areas(file)["Hertz"], hertz.column("scene.num_points")
    small = hertz.runs[int(np.argmin(n))]
    large = min(hertz.runs, key=lambda run: abs(run["scene.num_points"] - 2**18))
    return (
        f"Hertz: a_r at N = {small['scene.num_points']} with sub-grid edges is off by "
        f"{abs(small['contact_area_subgrid'] - exact):.1e} after {1e3 * small['seconds.solve']:.1f} ms; counted at "
        f"N = {large['scene.num_points']}, by {abs(large['contact_area'] - exact):.1e}, and four transform pairs alone "
        f"take {4e3 * large['seconds.pair']:.1f} ms there."
    )


def plans(options: Options) -> Sequence[Plan]:
    """The tasks at full size, or those of the quick study."""
    return [(QUICK if options.quick else Configuration()).plan()]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw)


def command(options: Options) -> int:
    """Run the study as asked, or the rest of it; returns the exit status."""
    return run_study(STUDY, options)
