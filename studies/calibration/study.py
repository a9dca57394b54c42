"""The numbers in estimated errors: fitted to random scenes, and tried on others.

linecontact study calibration [--quick] [--folder FOLDER]

Scenes with even seeds serve the fit, those with odd ones try it. Numbers and shares that hold go to
calibration.json in the folder; the solver takes the numbers of solver/calibration.json.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from linecontact.solver import QUANTITIES, Solution, Status, solve
from linecontact.solver.methods import Progress
from rich.console import RenderableType

from ..files.study_files import StudyFile, load_study
from ..files.writing import write_bytes
from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Record
from ..terminal import console
from .fit import Known, fitted, held, values
from .scenes import FAMILIES, UNFINISHED, draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "calibration"
_REFERENCE = 1e-9  # tolerance of the references
_TOLERANCES = -6.0, -2.0  # log10 of those of unfinished iterations


@dataclass(frozen=True)
class Options(study.Options):
    """Fit the numbers in estimated errors to random scenes: data and numbers; a quarter of an hour."""

    quick: bool = False
    """A few scenes only."""


@dataclass(frozen=True)
class Task:
    """The reference of a scene."""

    kind: ClassVar[str] = "linecontact.studies.calibration.Task"

    family: str
    """One of `FAMILIES`."""
    seed: int
    """Of everything that is drawn."""

    def run(self, report: Progress | None) -> Record:
        """The true values, of scenes that can be solved."""
        own: Record = {"family": self.family, "seed": self.seed, "status": "refused"}
        try:
            true = solve(draw(self.family, self.seed)[1], tolerance=_REFERENCE, progress=report)
        except ValueError:
            return own
        return (
            own
            | {"status": str(true.status)}
            | dict(zip(QUANTITIES, map(float, values(true.observables)), strict=True))
        )


def plans(options: Options) -> Sequence[Plan]:
    """The tasks."""
    count = 4 if options.quick else 400
    runs = [Task(family, seed) for family in FAMILIES for seed in range(count)]
    return [Plan(NAME, {"count": count}, runs, figures=())]


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """How many references there are."""
    done = [len(file.select("status", str(Status.CONVERGED)).runs) for file in files.values()]
    return [f"{sum(done)} scenes have a reference."]


def known(file: StudyFile, odd: int) -> list[Known]:
    """The scenes of a stored file with even seeds (odd = 0) or odd ones, solved on their own grids."""
    found = []
    for run in file.select("status", str(Status.CONVERGED)).runs:
        if run["seed"] % 2 == odd:
            try:
                solution = _solved(run["family"], run["seed"])
            except ValueError:
                continue
            if solution.status is Status.CONVERGED and solution.certificate:
                true = np.array([run[name] for name in QUANTITIES])
                found.append(Known(run["family"], solution, true, run["family"] == UNFINISHED))
    return found


def _solved(family: str, seed: int) -> Solution:
    scene, _ = draw(family, seed)
    if family == UNFINISHED:  # FIRE leaves as much as it may
        return solve(scene, method="fire", tolerance=float(10 ** np.random.default_rng(seed).uniform(*_TOLERANCES)))
    return solve(scene)


def no_figures(_: Path) -> "dict[str, Figure]":
    """None."""
    return {}


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=no_figures, may_not_converge=True)


def command(options: Options) -> int:
    """Run the study, or the rest of it, and write the numbers; returns the exit status."""
    status = run_study(STUDY, options)
    if status == 0:
        folder = STUDY.folder(options)
        file = load_study(folder / f"{NAME}.h5")
        numbers = fitted(known(file, 0))
        found = {"numbers": numbers, "held": held(known(file, 1), numbers)}
        path = folder / "calibration.json"
        write_bytes(path, [json.dumps(found, indent=2).encode(), b"\n"])
        console.errors.print(f"Numbers: {path}", soft_wrap=True)
    return status
