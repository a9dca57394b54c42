"""What the terminal shows: progress with residual and remaining time, and the exit statuses."""

import contextlib
import errno
import math
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from linecontact.solver import Status
from linecontact.solver.methods import Progress as Report
from rich import box
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.text import Text

from . import arguments
from .tables import Whole
from .text import printable

KEPT = "; finished tasks are kept"
Parsed = TypeVar("Parsed")

EXIT_BAD_INPUT = 2
EXIT_NOT_CONVERGED = 3
EXIT_FAILED = 4
EXIT_INTERRUPTED = 130
EXIT_BROKEN_PIPE = 141

_FULL = {errno.ENOSPC, errno.EFBIG, errno.EIO}
"""Error numbers of a disk that cannot be written to."""


class Plain(Console):
    """A console that takes text as it is: no markup, no names of emoji, nothing that steers the terminal.

    Sentences are wrapped on a terminal only: in a file and a pipe a sentence is a line. Nothing is cut off.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, **options)

    def print(self, *objects: Any, **options: Any) -> None:
        """As of any console."""
        sentences = all(isinstance(one, str) for one in objects)
        super().print(*objects, **{"soft_wrap": sentences and not self.is_terminal, "crop": False} | options)

    def render_str(self, text: str, **options: Any) -> Text:
        """Whatever is printed, and the cells of tables, come through here."""
        return super().render_str(printable(text), **options)


class _Messages(Plain):
    """Standard error. Without a reader nothing more is said, and the command ends as it would have."""

    def print(self, *objects: Any, **options: Any) -> None:
        """As of any console; older versions of Rich do not ask `on_broken_pipe`."""
        try:
            super().print(*objects, **options)
        except BrokenPipeError:
            self.on_broken_pipe()

    def on_broken_pipe(self) -> None:
        """Rich would end the process with status 1."""
        self.quiet = True
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())


class Output(Plain):
    """Standard output; a reader that went away is the caller's to handle."""

    def on_broken_pipe(self) -> None:
        """Rich would end the process with status 1."""
        raise BrokenPipeError


errors = _Messages(stderr=True, highlight=False)
"""Progress and messages; results go to standard output."""


def table(**options: Any) -> Whole:
    """A table as all studies close with: no frame, the caption flush left. options: of `rich.table.Table`."""
    return Whole(box=box.SIMPLE, pad_edge=False, caption_justify="left", **options)


def exit_status(status: Status) -> int:
    """Exit status of a process for a solve's status."""
    if status is Status.CONVERGED:
        return 0
    return EXIT_INTERRUPTED if status is Status.INTERRUPTED else EXIT_NOT_CONVERGED


class Bar:
    """Progress on standard error: a bar on a terminal, a plain line every `every` seconds elsewhere."""

    every = 5.0
    start = 0.0
    """Share of the work that was done before."""

    def __init__(self, what: str) -> None:
        self._what, self._begin, self._said = what, time.monotonic(), time.monotonic()
        columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:3.0f} %"))
        state = TextColumn("{task.fields[state]}")
        self._progress = Progress(*columns, state, TimeElapsedColumn(), console=errors, transient=True)
        self._task = self._progress.add_task(what, total=1.0, state="")

    def __enter__(self) -> "Bar":
        if errors.is_terminal:  # elsewhere rich before 14.3 ends it with an empty line
            self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        if errors.is_terminal:
            self._progress.stop()

    def show(self, done: float, state: str) -> None:
        """`done`: share of the work, 0 to 1; `state`: what to say beside it and the time left."""
        since = (done - self.start) / max(1e-9, 1 - self.start)
        text = f"{state}, {remaining(since, time.monotonic() - self._begin)}"
        self._progress.update(self._task, completed=done, state=text)
        if not errors.is_terminal and time.monotonic() - self._said > self.every:
            self._said = time.monotonic()
            errors.print(f"{self._what}: {100 * done:.0f} %, {text}")


def remaining(done: float, elapsed: float) -> str:
    """Time left from the share done, as text."""
    if done <= 0.02:
        return "time left unknown"
    seconds = elapsed * (1 - done) / done
    return f"about {seconds:.0f} s left" if seconds < 100 else f"about {seconds / 60:.0f} min left"


@contextlib.contextmanager
def solve_progress(tolerance: float) -> Iterator[Report]:
    """Reports a solve: progress counts decades of the residual, which fall at an even pace on the average."""
    worst = tolerance
    with Bar("solve") as progress:

        def report(iteration: int, residual: float) -> None:
            nonlocal worst
            worst = max(worst, min(residual, 10.0))
            total = math.log(worst / tolerance)
            done = max(0.0, math.log(worst / max(residual, tolerance)) / total) if total > 0 else 1.0
            progress.show(done, f"iteration {iteration}, residual {residual:.1e}")

        yield report


def place(error: BaseException) -> str:
    """Where an exception was raised, like 'in line 12 of tasks.py'."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"in line {last.lineno} of {Path(last.filename).name}"


def guard(command: Callable[[], int], kept: str = "") -> int:
    """Run a command; bad input ends in one line and status 2, Ctrl-C in 130, a reader that went away in 141.

    kept: what Ctrl-C leaves, to be said.
    """
    try:
        status = command()
        sys.stdout.flush()
        return status
    except ValueError as error:
        errors.print(f"linecontact: {' '.join(str(error).split())}")
        return EXIT_BAD_INPUT
    except KeyboardInterrupt:
        errors.print(f"linecontact: interrupted{kept}")
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the flush at exit must not fail again
        return EXIT_BROKEN_PIPE
    except MemoryError as error:
        errors.print(f"linecontact: not enough memory ({' '.join(str(error).split())}); allowed: fewer points")
        return EXIT_BAD_INPUT
    except OSError as error:
        of_output = error.filename is None and error.errno in _FULL  # of a file it would be a `StoreError`
        said = f"standard output could not be written ({error.strerror})" if of_output else str(error)
        errors.print(f"linecontact: {said}")
        try:
            sys.stdout.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_BAD_INPUT


def run(options: type[Parsed], command: Callable[[Parsed], int], prog: str) -> int:
    """Entry point of a study's own script; returns the exit status."""
    return guard(lambda: command(arguments.parse(options, sys.argv[1:], prog)), KEPT)
