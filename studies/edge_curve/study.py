"""The curves of contact edges, measured: where a contact ends, from the ratio of its last two nodal pressures.

linecontact study edge-curve [--folder FOLDER]

Loads are chosen so that the edge, known from collocation, takes every place between two nodes. The curves in
`linecontact.solver.grid.edge_curves` are closed forms; this is the check, and their error.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from linecontact.solver import PowerIndenter, Scene, solve
from linecontact.solver.grid import edges
from linecontact.solver.grid.layer_on_grid import layer_on_grid
from linecontact.solver.grid.patches import Patches
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
from . import few_nodes
from .scenes import SCENE, by_scene, from_two, layer_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "edge-curve"
_STEP = 1.01  # factor of the load, to find how the contact grows with it


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the study."""

    scenes: tuple[tuple[int, float, float, str, float, float, float], ...] = (
        (2**15, 2e-3, 2.0, "bonded", math.inf, 0.25, 0.0),
        (2**15, 2e-3, 1.5, "bonded", math.inf, 0.25, 0.0),
        (2**15, 2e-3, 4.0, "bonded", math.inf, 0.25, 0.0),
        (2**15, 2e-3, 2.0, "bonded", 800.0, 0.45, 0.0),
        (2**13, 2e-3, 2.0, "bonded", 5.0, 0.3, 0.0),
        (2**13, 1e-5, 4.0, "bonded", 1.0, 0.3, 0.0),
        (2**13, 2e-3, 2.0, "bonded", 1.0, 0.5, 0.0),
        (2**13, 2e-3, 1.5, "sliding", 2.0, 0.0, 0.0),
        (2**13, 2e-4, 2.0, "coated", 2.0, 0.3, 100.0),
        (2**13, 1e-5, 2.0, "coated", 2.0, 0.3, 0.05),
    )
    """Points, mean pressure over E*, exponent of the profile, and the layer: kind, thickness [grid spacings], Poisson's
    ratio, base modulus over E* (the rest dimensionless)."""
    places: int = 12
    """Places of the edge between two nodes, for each scene."""
    tolerance: float = 1e-9
    """Of the solves: rms equilibrium residual over p (dimensionless)."""

    def plan(self) -> Plan:
        """The tasks."""
        places = [place / self.places for place in range(self.places)]
        runs = [Task(*scene, place, self.tolerance) for scene in self.scenes for place in places]
        return Plan(NAME, asdict(self), runs)


@dataclass(frozen=True)
class Options(study.Options):
    """Measure the curves of contact edges on the half-space and on thin layers, and areas of rough surfaces on coarse
    grids: data, figure, tables."""


@dataclass(frozen=True)
class Task:
    """One load, with the edge about `place` between two nodes [grid spacings]."""

    kind: ClassVar[str] = "linecontact.studies.edge_curve.Task"

    num_points: int
    """Grid points."""
    pressure: float
    """Mean pressure over E* (dimensionless)."""
    exponent: float
    """n of the profile h = (R/n) |x/R|^n."""
    layer: str
    """Kind of layer: 'bonded', 'sliding' or 'coated'."""
    spacings: float
    """Its thickness [grid spacings]."""
    poisson_ratio: float
    """Of the layer, where it matters (dimensionless)."""
    base_modulus: float
    """Of a coating's base over E* (dimensionless)."""
    place: float
    """About where the edge is between two nodes [grid spacings]."""
    tolerance: float
    """Rms equilibrium residual over p to stop at (dimensionless)."""

    def run(self, report: Progress | None) -> Record:
        """The record with the pressures' ratio, the edge's true offset and the closed form's value of it."""
        n = self.num_points
        layer = layer_of(self.layer, self.spacings / n, self.poisson_ratio, self.base_modulus)

        def asperity(load: float) -> collocation.Asperity:
            return collocation.solve_layer(layer, load, self.exponent, 1.0)

        # a grid spacing more of half-width, in steps; near enough, as long as the places differ
        first, more = (asperity(load).half_width for load in (self.pressure, _STEP * self.pressure))
        load = self.pressure * (1 + self.place / (first * n)) ** (math.log(_STEP) / math.log(more / first))
        scene = Scene(layer, PowerIndenter(self.exponent), load, num_points=n)
        solution = solve(scene, tolerance=self.tolerance, progress=report)
        patches = Patches.of(solution.contact_pressure > 0)
        curve = layer_on_grid(layer, n, 1.0).edge_curve
        three, _, alone = edges.pressed_ends(curve, patches, solution.contact_pressure[patches.nodes])
        ratio = alone[0, 0] / alone[1, 0]
        return records.run_record(solution) | {
            **{name: getattr(self, name) for name in SCENE},
            "place": self.place,
            "ratio": float(ratio),
            "offset": float(n / 2 - asperity(load).half_width * n - patches.first[0]),
            "offset.two_nodes": float(from_two(curve, ratio)),
            "offset.three_nodes": float(three[0, 0]),
        }


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """A table for each file."""
    tables = {NAME: summary, few_nodes.KIND: few_nodes.summary}
    return [tables[kind](file) for kind, file in files.items()]


def summary(file: StudyFile) -> Table:
    """A table of the largest deviations from the closed form, one row for each scene."""
    table = console.table(
        title="Places of edges against collocation",
        caption="d: thickness in grid spacings; nodes: in contact. Largest |error| of the edge's place by the closed "
        "form, from the last two and the last three nodal pressures, in grid spacings. The rest dimensionless.",
    )
    for heading in ("n", "layer", "d", "nu", "base", "nodes", "places", "two nodes", "three nodes"):
        table.add_column(heading, justify="right", no_wrap=True)
    for scene, runs in by_scene(file).items():
        exponent, kind, spacings, nu, base = scene
        worst = [max(abs(run[f"offset.{k}_nodes"] - run["offset"]) for run in runs) for k in ("two", "three")]
        nodes = min(round(run["contact_area"] * run["scene.num_points"]) for run in runs)
        table.add_row(
            f"{exponent:g}",
            kind,
            f"{float(spacings):g}",
            "-" if kind == "sliding" else f"{nu:g}",
            f"{base:g}" if kind == "coated" else "-",
            str(nodes),
            str(len(runs)),
            *(f"{w:.1e}" for w in worst),
        )
    return table


def plans(_: Options) -> Sequence[Plan]:
    """The tasks."""
    return [Configuration().plan(), few_nodes.Configuration().plan()]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw)


def command(options: Options) -> int:
    """Run the study as asked, or the rest of it; returns the exit status."""
    return run_study(STUDY, options)
