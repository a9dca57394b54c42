"""Cheap tasks for test_ensemble.py, in a module of their own because worker processes have to import them.

They keep a log in $DUMMY_FOLDER, by which a test knows what was done and where, and look there for the files that tell
them to go on.
"""

import math
import os
import signal
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

from linecontact.studies.runner.run import run_study
from linecontact.studies.runner.study import Options, Plan, Study
from linecontact.studies.terminal import console
from linecontact.studies.terminal.arguments import parse


def there(name):
    return (Path(os.environ["DUMMY_FOLDER"]) / name).exists()


def note(name, text=""):
    """Append to a file, whole even when others do so at the same time; returns its path."""
    path = Path(os.environ["DUMMY_FOLDER"]) / name
    handle = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(handle, text.encode())
    os.close(handle)
    return path


def log():
    """(number, process) of every task that was begun, in that order."""
    path = Path(os.environ["DUMMY_FOLDER"]) / "log"
    return [tuple(map(int, line.split())) for line in path.read_text().splitlines()] if path.exists() else []


@dataclass(frozen=True)
class Square:
    """The square of a number after a pause [s], and not before a file named `gate` is there."""

    kind: ClassVar[str] = "square"

    number: int
    pause: float = 0.0
    gate: str = ""

    def run(self, _):
        begin = time.perf_counter()
        note("log", f"{self.number} {os.getpid()}\n")
        time.sleep(self.pause)
        while self.gate and not there(self.gate):
            if time.perf_counter() > begin + 60:  # a test that fails must end, too
                raise TimeoutError(self.gate)
            time.sleep(0.01)
        record = {"status": "converged", "number": self.number, "square": self.number**2, "root": self.number**0.5}
        return record | ({"seconds.total": time.perf_counter() - begin} if self.pause else {})


@dataclass(frozen=True)
class Raises(Square):
    """Fails until it is mended."""

    kind: ClassVar[str] = "raises"

    def run(self, report):
        record = super().run(report)
        if not there("mended"):
            raise ArithmeticError(f"no square of {self.number} today")
        return record


@dataclass(frozen=True)
class Kills(Square):
    """Kills its process, every time or only the first."""

    kind: ClassVar[str] = "kills"

    once: bool = False

    def run(self, report):
        record = super().run(report)
        if not (self.once and there(f"killed {self.number}")):
            note(f"killed {self.number}")
            os.kill(os.getpid(), signal.SIGKILL)
        return record


STUDY = Study(name="dummy", options=Options, plans=lambda _: [], report=lambda *_: [], draw=lambda _: {})


def plan(tasks, kind="dummy"):
    """A plan that knows no figures: matplotlib takes its time, and there is nothing to draw of a dummy."""
    return Plan(kind, {"numbers": [task.number for task in tasks]}, tasks, figures=())


def real_plans():
    """A little of the paper at 2^10 points, without figures."""
    from linecontact.studies.power_profiles import tasks as power_profiles
    from linecontact.studies.rough_surfaces import tasks as rough_surfaces

    hertz = power_profiles.Configuration(
        exponent=2.0,
        published_alpha=3 * math.pi / 4,
        num_points=2**10,
        poisson_ratios=(0.0, 0.45),
        reduced_thicknesses=(1.0, 0.1),
        line_points=4,
    )
    surfaces = rough_surfaces.Configuration(
        num_points=2**10,
        cut_off_ratio=0.5,
        hursts=(0.5,),
        poisson_ratios=(0.25,),
        thicknesses=(0.1, 1e-3),
        realisations=2,
    )
    plans = [power_profiles.plan("hertz", hertz), rough_surfaces.plan(surfaces)]
    return [replace(plan, figures=()) for plan in plans]


def command(plans, options):
    """Run these plans as a program would: one line for bad input, and a status."""
    study = replace(STUDY, plans=lambda _: plans)
    return console.guard(lambda: run_study(study, options))


def main(plans, *arguments):
    """The same as a program of its own; `plans`: Python text."""
    return command(eval(plans), parse(Options, arguments, "dummy_tasks"))
