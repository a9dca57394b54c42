"""Kernels, sequences of them, whole iterations and transforms timed beside C, NumPy and variants of one's own.

linecontact study kernels [--kernel NAME] [--size N] [--variants FILE] [--quick] [--json] [--folder FOLDER]
linecontact study kernels --compare OLD NEW [--threshold T]

Others on the machine disturb all times alike: trust the ratios, which are of variants timed in turn.
"""

import contextlib
import hashlib
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from linecontact.kernels import CHUNK
from linecontact.solver import checks
from linecontact.solver.methods import Progress
from linecontact.solver.provenance import provenance
from rich.console import RenderableType

from ..files import records, study_files
from ..files.study_files import StudyFile
from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Record
from ..terminal.options import one_of, options_of, told
from . import compare, cores, machine, measure, variants
from . import report as tables
from .benchmark import LARGEST, PRECISIONS, Benchmark
from .benchmarks import BENCHMARKS, GROUPS
from .c_code import compile_c
from .cells import GROUPED, MACHINE
from .shipped import check_names

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_EVEN = tuple(2**k for k in range(10, 23, 2))
SIZES = {
    "kernels": _EVEN,
    "sequences": _EVEN,
    "iterations": (2**14, 2**18),
    "transforms": (*_EVEN, 2**24, 3**11, 5**8, 262139),
    "roofs": _EVEN,
}
"""Numbers of points by group; of the transforms also a power of three, of five, and a prime."""
QUICK = (2**10, 2**14, 2**18)
_SECONDS = 0.05  # to measure for, in each repetition
_LONG = 2**22  # points from which a repetition takes as long as on all smaller grids together
_REPEATS, _THRESHOLD = 4, 1.05
_LEFT_OUT = ("transforms",)  # FFTW plans for minutes


@dataclass(frozen=True)
class Options(study.Options):
    """Times of kernels, sequences, iterations and transforms beside C, NumPy and variants of your own."""

    workers: int = 1
    """Always 1: others would disturb the times."""
    kernel: str | None = one_of((*GROUPS, *BENCHMARKS), None)
    """One benchmark, or one group of them; default: all groups but the transforms. With --variants only those that the
    file has a variant of."""
    size: int | None = None
    """Number of points, like 2^18; default: from 2^10 to 2^22."""
    variants: Path | None = None
    """A Python file that registers variants of your own, see docs/kernels.md."""
    repeats: int | None = None
    """Times that everything is measured on new buffers, 2 to 100; on 2^22 points and more half as many, but two;
    default: 4."""
    quick: bool = False
    """2^10, 2^14 and 2^18 points only."""
    json: bool = False
    """One JSON object on standard output instead of the tables; figures and data are written all the same."""
    compare: tuple[Path, Path] | None = None
    """Measure nothing; show changes from the first to the second: stored .h5, a saved --json, or folders with such."""
    threshold: float | None = None
    """Comparing: the least change that counts, 1 to 10 (dimensionless); default: 1.05."""


@dataclass(frozen=True)
class Task:
    """A benchmark in one precision on so many points, on buffers of its own."""

    kind: ClassVar[str] = "kernels.Task"

    benchmark: str
    """Its name, or `MACHINE`."""
    precision: str
    """Of the values per point."""
    num_points: int
    """Number of points."""
    repeat: int
    """Number of the repetition, from 0."""
    seconds: float
    """Time to measure for [s]."""
    variants: str
    """Path of the user's file of variants; empty without."""
    identity: str
    """Key of the identity that times depend on, the file of variants included."""

    def run(self, report: Progress | None) -> Record:
        """Times and their ratios by variant, see `measure.measure`; of the machine the numbers that are needed once."""
        if self.variants:
            variants.load_file(Path(self.variants))
        names = {"benchmark": self.benchmark, "precision": self.precision, "num_points": self.num_points}
        with cores.pinned() as core:
            if self.benchmark == MACHINE:
                found = machine.once()
            else:
                first = self.repeat == 0
                found = measure.measure(self.benchmark, self.precision, self.num_points, self.seconds, first)
        return names | {"repeat": self.repeat, "core": core} | found | records.flatten({"provenance": provenance()})


def plan(options: Options) -> Plan:
    """The tasks, repetition by repetition, so that the repetitions of one are far apart. Raises `ValueError`."""
    repeats = _REPEATS if options.repeats is None else options.repeats
    checks.integer("repeats", repeats, "an integer from 2 to 100", 2, 100)
    if options.workers != 1:
        raise ValueError(f"workers is {options.workers}; allowed: 1, because two would disturb each other's times")
    if options.quick and options.size is not None:
        raise ValueError("quick is True; allowed: without --size, which says on how many points")
    path, content = "", b""
    if options.variants:
        variants.load_file(options.variants)
        path, content = str(options.variants.resolve()), options.variants.read_bytes()
    chosen = _chosen(options)
    sizes = {one.name: _sizes(one.group, options) for one in chosen}
    for name, some in sizes.items():
        for own in variants.own(name):
            if all(size % own.multiple for size in some):
                allowed = f"multiples of {own.multiple}, for variant {own.name} of {name}"
                raise ValueError(f"size is {options.size}; allowed: {allowed}")
    configuration = {
        "sizes": {name: list(values) for name, values in sizes.items()},
        "repeats": repeats,
        "variants": hashlib.sha256(content).hexdigest()[:12] if path else "",
        "identity": machine.identity(),
    }
    identity = machine.key(configuration)
    tasks = [Task(MACHINE, "", 0, 0, 0.0, "", identity)] if len(chosen) > 1 else []
    for repeat in range(repeats):
        for one in chosen:
            for precision in ("float64",) if one.name == "fire_control" else PRECISIONS:
                for n in sizes[one.name]:
                    if n < _LONG or repeat < max(2, repeats / 2):  # one alone would have no error
                        tasks.append(Task(one.name, precision, n, repeat, _SECONDS, path, identity))
    groups = {one.group for one in chosen}
    figures = [""] * bool(groups & {"kernels", "transforms"}) + ["-roofline"] * ({"kernels", "roofs"} <= groups)
    figures += ["-variants"] * bool(path and groups & set(GROUPED))
    return Plan(tables.KIND, configuration, tasks, figures=figures)


def _chosen(options: Options) -> list[Benchmark]:
    """The benchmarks asked for, of a file of variants only those that it has one of; by default all that take no
    minutes.
    """
    chosen = [one for one in BENCHMARKS.values() if options.kernel in (one.name, one.group)]
    if options.variants:
        known = [name for name, own in variants.OWN.items() if own]
        chosen = [one for one in chosen or BENCHMARKS.values() if one.name in known]
        if not chosen:
            of = f" of {options.kernel}; allowed: --kernel {' or '.join(known)}"
            said = of if known else "; allowed: a file that registers one"
            raise ValueError(f"variants: file {options.variants} registers no variant{said}")
        for one in chosen:
            check_names(one)
    chosen = chosen or [one for one in BENCHMARKS.values() if one.group not in _LEFT_OUT]
    if not compile_c().libraries:
        chosen = [one for one in chosen if one.group != "roofs"]
    if not chosen:
        raise ValueError(f"kernel is {options.kernel!r}; allowed without a C compiler: all but the roofs")
    return chosen


def _sizes(group: str, options: Options) -> tuple[int, ...]:
    if options.size is not None:
        size = checks.integer("size", options.size, "an integer from 2^10 to 2^28", 2**10, LARGEST)
        if size % CHUNK and group != "transforms":
            raise ValueError(f"size is {size}; allowed: a multiple of {CHUNK}, or --kernel transforms")
        return (size,)
    return tuple(n for n in SIZES[group] if n in QUICK) if options.quick else SIZES[group]


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The tables and their summary."""
    return [part for file in files.values() if file.complete for part in tables.parts(file)]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


def plans(options: Options) -> Sequence[Plan]:
    """The tasks that were asked for."""
    return [plan(options)]


STUDY = Study(name=tables.KIND, options=Options, plans=plans, report=report, draw=draw)


def _check_together(options: Options) -> None:
    """Raise `ValueError` for options of the comparison without one, and for others with one.

    All but the workers, of which there is one in any case, have defaults that nobody can give.
    """
    for name, option in options_of(Options).items():
        value = getattr(options, name)
        if name != "compare" and value != option.default and (name == "threshold") != bool(options.compare):
            which = "without --compare, which measures nothing" if options.compare else "with --compare"
            raise ValueError(f"{told(name, value)}; allowed: {which}")


def command(options: Options) -> int:
    """Measure the rest of the study, or compare two files; returns the exit status.

    Results lie in a folder of their own for every source, machine and choice of measurements.
    """
    _check_together(options)
    if options.compare:
        return compare.command(*options.compare, _THRESHOLD if options.threshold is None else options.threshold)
    (planned,) = plans(options)
    # the quick study needs no folder of its own name, because its key is another
    folder = STUDY.folder(replace(options, quick=False)) / machine.key(planned.configuration)
    options = replace(options, folder=folder)
    if not options.json:
        return run_study(STUDY, options)
    with contextlib.redirect_stdout(sys.stderr):
        status = run_study(replace(STUDY, report=lambda *_: ()), options)
    print(json.dumps(tables.to_json(study_files.load_study(planned.path(folder)))), flush=True)
    return status
