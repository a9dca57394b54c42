"""Every kernel timed: Warp in three forms, its NumPy twin and a C loop, over N, beside the machine's copy bandwidth.

linecontact study kernels [--quick] [--json] [--folder FOLDER]
linecontact study kernels --compare OLD NEW [--threshold T]

And what a plain FIRE iteration costs outside its transforms. Others on the machine disturb all times alike: trust the
ratios, which are of candidates timed in turn.
"""

import contextlib
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from linecontact import kernels
from linecontact.solver.methods import Progress
from rich.console import RenderableType

from ..files import study_files
from ..files.study_files import StudyFile
from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Record
from . import compare, measure
from . import report as tables
from .candidates import PRECISIONS
from .specs import SPECS

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Configuration:
    """What identifies the study."""

    kernels: tuple[int, ...] = tuple(range(10, 23))
    """log2 of the numbers of points of the kernels."""
    iteration: tuple[int, ...] = (14, 16, 18, 20, 22)
    """log2 of the numbers of points of the FIRE iteration."""
    seconds: float = 0.4
    """Time to measure for, for each task [s]."""

    def plan(self) -> Plan:
        """The tasks. `fire_control` works on float64 sums whatever the precision."""
        runs = [
            Task(kernel, precision, k, self.seconds)
            for kernel in kernels.KERNELS
            for precision in (PRECISIONS if SPECS[kernel].c else ["float64"])
            for k in self.kernels
        ]
        runs += [
            Task(measure.ITERATION, precision, k, self.seconds) for precision in PRECISIONS for k in self.iteration
        ]
        return Plan(tables.KIND, asdict(self), runs, figures=tables.FIGURES)


QUICK = Configuration((10, 14, 18), (14, 18), 0.2)


@dataclass(frozen=True)
class Options(study.Options):
    """Times and bandwidths of every kernel over N, against C and NumPy: data, figures, table."""

    workers: int = 1
    """More than one disturb each other's times."""
    quick: bool = False
    """2^10, 2^14 and 2^18 points only."""
    json: bool = False
    """One JSON object on standard output instead of the tables; figures and data are written all the same."""
    compare: tuple[Path, Path] | None = None
    """Measure nothing; ratios of the second file's times over the first's, each a stored .h5 or a saved --json."""
    threshold: float = 1.2
    """Comparing: what counts as slower, and its inverse as faster; > 1 (dimensionless)."""


@dataclass(frozen=True)
class Task:
    """One kernel, or the FIRE iteration, in one precision on 2^log2_points points."""

    kind: ClassVar[str] = "linecontact.studies.kernels.Task"

    kernel: str
    """Its name, or `measure.ITERATION`."""
    precision: str
    """Of the values per point."""
    log2_points: int
    """log2 of the number of points."""
    seconds: float
    """Time to measure for [s]."""

    def run(self, report: Progress | None) -> Record:
        """Medians and minima of the times by candidate, with the bytes moved and what is known of the machine."""
        n = 2**self.log2_points
        if self.kernel == measure.ITERATION:
            times = measure.iteration_times(self.precision, n, self.seconds)
        else:
            times = measure.kernel_times(self.kernel, self.precision, n, self.seconds)
        names = {"kernel": self.kernel, "precision": self.precision, "log2_points": self.log2_points}
        return names | times | measure.machine()


def plans(options: Options) -> Sequence[Plan]:
    """The tasks at full size, or those of the quick study."""
    return [(QUICK if options.quick else Configuration()).plan()]


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The tables, and what they come to."""
    return [part for file in files.values() if file.complete for part in tables.parts(file)]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


STUDY = Study(name=tables.KIND, options=Options, plans=plans, report=report, draw=draw)


def command(options: Options) -> int:
    """Measure what is left of the study, or compare two files; returns the exit status."""
    if options.compare:
        if options.json:
            raise ValueError("json is True; allowed: without --compare, which prints a table")
        return compare.command(*options.compare, options.threshold)
    if not options.json:
        return run_study(STUDY, options)
    with contextlib.redirect_stdout(sys.stderr):
        status = run_study(replace(STUDY, report=lambda *_: ()), options)
    (plan,) = plans(options)
    print(json.dumps(tables.to_json(study_files.load_study(plan.path(STUDY.folder(options))))), flush=True)
    return status
