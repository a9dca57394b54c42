"""The numbers in estimated errors: fitted to random scenes, and what they hold on others.

linecontact study calibration [--quick] [--folder FOLDER]

Scenes with even seeds are for the fit, those with odd ones for what it holds. The numbers go to calibration.json in the
folder; the solver takes those of solver/calibration.json.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from linecontact.solver import QUANTITIES, Solution, Status, solve
from linecontact.solver.methods import Progress
from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile, load_study
from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Record
from ..terminal import console
from . import fit
from .scenes import FAMILIES, UNFINISHED, draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "calibration"
_REFERENCE = 1e-9  # tolerance of the references
_TOLERANCES = (-6.0, -2.0)  # log10 of those of unfinished iterations


@dataclass(frozen=True)
class Options(study.Options):
    """Fit the numbers in estimated errors to random scenes: data, table, and the numbers."""

    quick: bool = False
    """A few scenes only."""


def solved(family: str, seed: int, report: Progress | None = None) -> Solution:
    """The scene of this family, solved on its own grid. Raises `ValueError`."""
    scene = draw(family, seed)[0]
    if family == UNFINISHED:  # FIRE leaves as much as it may
        tolerance = float(10 ** np.random.default_rng(seed).uniform(*_TOLERANCES))
        return solve(scene, method="fire", tolerance=tolerance, progress=report)
    return solve(scene, progress=report)


@dataclass(frozen=True)
class Task:
    """A scene and its reference."""

    kind: ClassVar[str] = "linecontact.studies.calibration.Task"

    family: str
    """One of `FAMILIES`."""
    seed: int
    """Of everything that is drawn."""

    def run(self, report: Progress | None) -> Record:
        """Estimated and true errors, relative; no errors of scenes that cannot be solved, or have no reference."""
        own: Record = {"family": self.family, "seed": self.seed, "status": "refused"}
        try:
            found = solved(self.family, self.seed, report)
            true = solve(draw(self.family, self.seed)[1], tolerance=_REFERENCE, progress=report)
        except ValueError:
            return own
        if {found.status, true.status} != {Status.CONVERGED} or not (found.certificate and true.certificate):
            return own | {"status": "no reference"}
        claims = fit.relative(found.observables)
        for (name, quantity), claim in zip(QUANTITIES.items(), claims, strict=True):
            value, truth = (getattr(one.observables, quantity.value) for one in (found, true))
            own |= {f"error.{name}": abs(truth - value) / max(abs(value), 1e-300), f"estimate.{name}": claim}
        return own | {"status": "converged"}


def plans(options: Options) -> Sequence[Plan]:
    """The tasks."""
    count = 4 if options.quick else 200
    runs = [Task(family, seed) for family in FAMILIES for seed in range(count)]
    return [Plan(NAME, {"count": count}, runs, figures=())]


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """What the numbers that the solver takes hold."""
    return [summary(file) for file in files.values()]


def summary(file: StudyFile) -> Table:
    """One row per family."""
    table = console.table(
        title="Estimated errors that hold, and how large they are",
        caption="%: estimates that hold, by the numbers that the solver took; over: median of estimate over error. "
        "Half of these scenes served for a fit. Unfinished: with what the grid leaves.",
    )
    for heading in ("family", "scenes", *(f"{name}\n% over" for name in QUANTITIES)):
        table.add_column(heading, justify="right", no_wrap=True)
    done = file.select("status", "converged")
    for family in FAMILIES:
        some = done.select("family", family)
        if some.runs:
            cells = []
            for name in QUANTITIES:
                ratio = some.column(f"estimate.{name}") / np.maximum(some.column(f"error.{name}"), fit.FLOOR)
                cells.append(f"{100 * np.mean(ratio >= 1):.1f} {np.median(ratio):.3g}")
            table.add_row(family, str(len(some.runs)), *cells)
    return table


def scenes_of_fit(file: StudyFile, odd: int) -> list[fit.Fitted]:
    """The scenes of a stored file with even seeds (odd = 0) or odd ones, solved again."""
    found = []
    for run in file.select("status", "converged").runs:
        if run["seed"] % 2 == odd:
            family, errors = run["family"], np.array([run[f"error.{name}"] for name in QUANTITIES])
            found.append(fit.Fitted(family, solved(family, run["seed"]), errors, family == UNFINISHED))
    return found


def draw_figures(_: Path) -> "dict[str, Figure]":
    """None."""
    return {}


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw_figures)


def command(options: Options) -> int:
    """Run the study as asked, or what is left of it, and write the numbers; returns the exit status."""
    status = run_study(STUDY, options)
    if status == 0:
        folder = STUDY.folder(options)
        file = load_study(folder / f"{NAME}.h5")
        numbers = fit.numbers(scenes_of_fit(file, 0))
        rounded = {name: float(f"{value:.2g}") for name, value in asdict(numbers).items()}
        held = fit.held(scenes_of_fit(file, 1), type(numbers)(**rounded))
        path = folder / "calibration.json"
        path.write_text(json.dumps({"numbers": rounded, "held": held}, indent=2) + "\n", encoding="utf-8")
        console.errors.print(f"Numbers: {path}", soft_wrap=True)
    return status
