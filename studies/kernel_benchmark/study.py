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
from dataclasses import asdict, dataclass
from pathlib import Path

from linecontact import kernels
from linecontact.solver.relaxation import Progress
from rich.console import RenderableType

from ..files import study_files
from ..files.study_files import StudyFile
from ..runner import ensemble
from ..runner.tasks import Record
from . import compare, measure, report
from .candidates import PRECISIONS
from .specs import SPECS

KIND = report.KIND


@dataclass(frozen=True)
class Configuration:
    """log2 of the numbers of points, of the kernels and of the FIRE iteration; seconds: of timing, for each task."""

    kernels: tuple[int, ...] = tuple(range(10, 23))
    iteration: tuple[int, ...] = (14, 16, 18, 20, 22)
    seconds: float = 0.4

    def study(self) -> ensemble.Study:
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
        return ensemble.Study(KIND, asdict(self), runs, figures=("", "-roofline"))


QUICK = Configuration((10, 14, 18), (14, 18), 0.2)


@dataclass(frozen=True)
class Options(ensemble.Options):
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

    kernel: str
    precision: str
    log2_points: int
    seconds: float

    def run(self, report: Progress | None) -> Record:
        """Medians and minima by candidate, with the bytes moved and the machine."""
        n = 2**self.log2_points
        if self.kernel == measure.ITERATION:
            times = measure.iteration_times(self.precision, n, self.seconds)
        else:
            times = measure.kernel_times(self.kernel, self.precision, n, self.seconds)
        names = {"kernel": self.kernel, "precision": self.precision, "log2_points": self.log2_points}
        return names | times | measure.machine()


def command(options: Options) -> int:
    """Measure what is left of the study, or compare two files; returns the exit status."""
    if options.compare:
        if options.json:
            raise ValueError("json is True; allowed: without --compare, which prints a table")
        return compare.command(*options.compare, options.threshold)
    study = (QUICK if options.quick else Configuration()).study()
    folder = options.folder or Path("results/kernels-quick" if options.quick else "results/kernels")
    with contextlib.redirect_stdout(sys.stderr) if options.json else contextlib.nullcontext():
        status = ensemble.command([study], options, folder, _nothing if options.json else closing)
    if options.json:
        print(json.dumps(report.to_json(study_files.load_study(study.path(folder)))), flush=True)
    return status


def _nothing(*_: object) -> Sequence[RenderableType]:
    return ()


def closing(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The tables, and what they come to."""
    return [part for file in files.values() if file.complete for part in report.parts(file)]
