"""A soak: random scenes for hours in one process, every answer looked at twice; memory and open files must stay flat.

linecontact study soak [--hours 1] [--folder FOLDER]

The scenes are drawn like the cells of the map (`extremes`), with another seed. One task is a minute of them; a soak
that was stopped goes on.
"""

import math
import os
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from linecontact.solver import checks
from linecontact.solver.display import counted
from linecontact.solver.methods import Progress
from rich.console import RenderableType

from ..files.study_files import StudyFile
from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Record
from . import study as extremes
from .verdicts import CERTIFIED, DEFECT, REFUSED, judge

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "soak"
_SEED = 2
_MOST = 10**6  # scenes a minute
_MIDDLE = 0.02  # share of scenes with 2^13 points and more


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the soak."""

    stretches: int = 60
    """How many stretches of time, each a task."""
    seconds: float = 60.0
    """Length of each [s]."""

    def plan(self) -> Plan:
        """The tasks."""
        return Plan(NAME, asdict(self), [Task(number, self.seconds) for number in range(self.stretches)])


@dataclass(frozen=True)
class Options(study.Options):
    """Random scenes for hours: every one certified or refused, memory and open files flat. Data, figure, summary."""

    workers: int = 1
    """More than one share the work, and the memory shown is of the one that did the minute."""
    hours: float = 1.0
    """How long [h], 0 to 1000, in whole minutes."""


@dataclass(frozen=True)
class Task:
    """One stretch of time, filled with random scenes."""

    kind: ClassVar[str] = "linecontact.studies.soak.Task"

    number: int
    """Which of the stretches."""
    seconds: float
    """Length [s]."""

    def run(self, report: Progress | None) -> Record:
        """How many scenes came to which verdict, and the process's memory and open files after them."""
        begin, verdicts, asked, longest, why = time.monotonic(), list[str](), 0, 0.0, ""
        rng = np.random.default_rng([_SEED, self.number])
        while time.monotonic() - begin < self.seconds and len(verdicts) < _MOST:
            size = "middle" if rng.random() < _MIDDLE else "small"
            record = judge(extremes.Task(_SEED, self.number * _MOST + len(verdicts), size).cell())
            if record["verdict"] == DEFECT and not why:
                why = f"scene {len(verdicts)}: {record['why']}"
            verdicts.append(record["verdict"])
            asked += bool(record["asked"] and record["verdict"] == REFUSED)
            longest = max(longest, record["seconds.cell"])
            if report:
                report(len(verdicts), math.nan)
        return {
            "stretch": self.number,
            **{verdict: verdicts.count(verdict) for verdict in (CERTIFIED, REFUSED, DEFECT)},
            "refused_asked": asked,
            "first_defect": why,
            "seconds.stretch": time.monotonic() - begin,
            "seconds.longest": longest,
            "bytes.resident": _resident(),
            "open_files": len(os.listdir("/dev/fd")),
            "process": os.getpid(),
        }


def _resident() -> int:
    """Memory of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The summary."""
    return [summary(file) for file in files.values() if file.runs]


def summary(file: StudyFile) -> str:
    """Counts, memory and files, in a few sentences."""
    runs = file.runs
    count = {verdict: int(sum(run[verdict] for run in runs)) for verdict in (CERTIFIED, REFUSED, DEFECT)}
    total, asked = sum(count.values()), int(sum(run["refused_asked"] for run in runs))
    resident = [run["bytes.resident"] / 2**20 for run in runs]
    files = [run["open_files"] for run in runs]
    tenth = max(1, len(runs) // 10)
    first, last = (float(np.median(part)) for part in (resident[:tenth], resident[-tenth:]))
    hours, longest = sum(run["seconds.stretch"] for run in runs) / 3600, max(run["seconds.longest"] for run in runs)
    return (
        f"{total} random scenes in {hours:.2g} h: {count[CERTIFIED]} certified, {count[REFUSED]} refused with a reason "
        f"({asked} of them asked for a tolerance or an accuracy of their own), {counted(count[DEFECT], 'defect')}. The "
        f"longest took {longest:.3g} s. Resident memory: {first:.0f} MiB in the first tenth of the time, "
        f"{last:.0f} MiB in the last (medians), at most {max(resident):.0f} MiB. "
        f"Open files: {min(files)} to {max(files)}."
    )


def defects(file: StudyFile) -> list[str]:
    """A line on each stretch in which a scene came to a defect."""
    return [f"stretch {run['stretch']}, {run['first_defect']}" for run in file.runs if run["first_defect"]]


def plans(options: Options) -> Sequence[Plan]:
    """As many minutes as were asked for."""
    hours = checks.real("hours", options.hours, "0 < hours <= 1000", 0, 1000)
    return [Configuration(max(1, round(60 * hours))).plan()]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.soak(path)


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw, defects=defects)


def command(options: Options) -> int:
    """Run the soak, or the rest of it; returns the exit status, 4 if there is a defect."""
    return run_study(STUDY, options)
