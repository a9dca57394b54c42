"""Output on the terminal: progress with residual and remaining time, and the exit statuses."""

import contextlib
import math
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TextIO, TypeVar

from linecontact.kernels import undivided
from linecontact.solver import Status
from linecontact.solver.methods import Progress as Report
from rich import box
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column
from rich.text import Text

from . import arguments
from .tables import Whole
from .text import BUG, OUTPUT, is_refusal, printable

KEPT = "; finished tasks are kept"
_SOON, _AGAIN = 1.0, 0.01  # s after Ctrl-C, and until it is tried again
_WAIT = "linecontact: interrupted; finishing what there is, unless Ctrl-C comes again"
Parsed = TypeVar("Parsed")

EXIT_BAD_INPUT = 2
EXIT_NOT_CONVERGED = 3
EXIT_FAILED = 4
EXIT_INTERRUPTED = 130
EXIT_BROKEN_PIPE = 141


class Plain(Console):
    """A console that takes text as it is: no markup, no names of emoji, nothing that steers the terminal.

    Sentences are wrapped on a terminal only: in a file and a pipe a sentence is a line. Nothing is cut off.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, **options)
        if not self.width:  # $COLUMNS may be 0
            self.width = 80

    def print(self, *objects: Any, **options: Any) -> None:
        """As of any console."""
        sentences = all(isinstance(one, str) for one in objects)
        super().print(*objects, **{"soft_wrap": sentences and not self.is_terminal, "crop": False} | options)

    def render_str(self, text: str, **options: Any) -> Text:
        """Whatever is printed, and the cells of tables, come through here."""
        return super().render_str(printable(text), **options)


class _Messages(Plain):
    """Standard error. Where it cannot be written nothing more is said, and the command ends as it would have."""

    def _check_buffer(self) -> None:
        """All of Rich's output goes through here, its thread's, too."""
        try:
            super()._check_buffer()
        except OSError:
            self.on_broken_pipe()

    def on_broken_pipe(self) -> None:
        """Rich would end the process with status 1."""
        self.quiet = True
        silence(sys.stderr)


class Output(Plain):
    """Standard output; a reader that went away is the caller's to handle."""

    def on_broken_pipe(self) -> None:
        """Rich would end the process with status 1."""
        raise BrokenPipeError


def silence(stream: TextIO) -> None:
    """Let a stream that cannot be written go nowhere: the flush at exit must not fail again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


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


_BAR = 10  # columns


class Bar:
    """Progress on standard error: a bar on a terminal, a plain line every `every` seconds elsewhere."""

    every = 5.0
    shown: Progress | None = None

    def __init__(self, what: str) -> None:
        self._what, self._begin, self._said = what, time.monotonic(), time.monotonic()
        self._start: float | None = None  # share of the work when it was shown first
        self._done, self._broken = 0.0, False
        bar = BarColumn(_BAR, table_column=Column(no_wrap=True))
        columns = (TextColumn("{task.description}"), bar, TextColumn("{task.percentage:3.0f} %"))
        state = TextColumn("{task.fields[state]}", table_column=Column(overflow="fold"))  # alone is wrapped
        self._progress = Progress(*columns, state, TimeElapsedColumn(), console=errors, transient=True)
        self._task = self._progress.add_task(what, total=1.0, state="")

    def __enter__(self) -> "Bar":
        if errors.is_terminal:  # elsewhere rich before 14.3 ends it with an empty line
            Bar.shown = self._progress
            with undivided():  # half begun it would hide the cursor for good
                self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        Bar.end()

    @classmethod
    def end(cls) -> None:
        """Take away the bar that is shown, if any; Ctrl-C may have kept it from its own end."""
        if cls.shown:
            with undivided():
                cls.shown.stop()
                cls.shown = None

    def show(self, tell: Callable[[], tuple[float, str]]) -> None:
        """Show `tell()`: the share of the work that is done, 0 to 1, and a text to stand before the time left.

        Whatever goes wrong in that, or in showing it, is said once and ends no work.
        """
        if not self._broken:
            try:
                self._show(*tell())
            except Exception as error:
                self._broken = True
                errors.print(f"a bug, please report it: no progress is shown ({error!r}, {place(error)})", markup=False)

    def _show(self, done: float, state: str) -> None:
        done = self._done = min(max(done, self._done), 1.0) if done == done else self._done  # it never goes back
        self._start = done if self._start is None else self._start
        since = (done - self._start) / max(1e-9, 1 - self._start)
        text = f"{state}, {remaining(since, time.monotonic() - self._begin)}" if done < 1 else state
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


_LARGEST = 10.0  # residual from which on decades are counted


@contextlib.contextmanager
def solve_progress(tolerance: float) -> Iterator[Report]:
    """Reports a solve: progress counts decades of the residual, which fall at an even pace on the average."""
    worst = tolerance
    with Bar("solve") as progress:

        def share(residual: float) -> float:
            nonlocal worst
            left = min(max(residual, tolerance), _LARGEST) if residual == residual else _LARGEST
            worst = max(worst, left)
            return math.log(worst / left) / math.log(worst / tolerance) if worst > tolerance else 1.0

        def report(iteration: int, residual: float) -> None:
            progress.show(lambda: (share(residual), f"iteration {iteration}, residual {residual:.1e}"))

        yield report


def place(error: BaseException) -> str:
    """Where an exception was raised, like 'in line 12 of tasks.py'."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"in line {last.lineno} of {Path(last.filename).name}"


def guard(command: Callable[[], int], kept: str = "") -> int:
    """Run a command; bad input ends in one line and status 2, Ctrl-C in 130, a reader that went away in 141.

    kept: text on finished work, shown after Ctrl-C. Any other end is a bug, passed on for a traceback and status 1.
    """
    try:
        with _waiting_told():
            status = command()
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        errors.print(f"linecontact: interrupted{kept}")
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        silence(sys.stdout)
        return EXIT_BROKEN_PIPE
    except Exception as error:
        said = _refusal(error)
        if not said:
            if BUG not in getattr(error, "__notes__", ()):
                error.add_note(BUG)
            raise
        errors.print(f"linecontact: {said}")
        return EXIT_BAD_INPUT
    finally:
        Bar.end()


@contextlib.contextmanager
def _waiting_told() -> Iterator[None]:
    """After Ctrl-C a command may have a result to finish: if that takes longer, it is said."""
    before = signal.getsignal(signal.SIGINT)
    known = before is signal.default_int_handler and threading.current_thread() is threading.main_thread()
    if not known or not hasattr(signal, "setitimer"):
        yield
        return

    def tell(*_: object) -> None:
        with contextlib.suppress(RuntimeError):  # the alarm came while a line was being written
            errors.print(_WAIT)

    def interrupt(_: int, frame: Any) -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGALRM, tell)
        signal.setitimer(signal.ITIMER_REAL, _SOON)
        signal.default_int_handler(signal.SIGINT, frame)

    def lost(told: Any) -> None:
        if not issubclass(told.exc_type, KeyboardInterrupt):
            hook(told)
            return
        signal.signal(signal.SIGALRM, interrupt)  # Ctrl-C came in a place that no error leaves
        signal.setitimer(signal.ITIMER_REAL, _AGAIN)

    alarm, hook = signal.getsignal(signal.SIGALRM), sys.unraisablehook
    signal.signal(signal.SIGINT, interrupt)
    sys.unraisablehook = lost
    try:
        yield
    finally:
        try:
            signal.signal(signal.SIGINT, before)
        finally:  # Ctrl-C may come even now, and starts the timer
            sys.unraisablehook = hook
            if signal.getsignal(signal.SIGALRM) is not alarm:
                signal.setitimer(signal.ITIMER_REAL, 0)
                signal.signal(signal.SIGALRM, alarm)


def _refusal(error: Exception) -> str:
    """The message of an error that is no bug; empty for a bug."""
    text = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return f"not enough memory ({text}); allowed: fewer points"
    if isinstance(error, OSError) and error.filename == OUTPUT:
        silence(sys.stdout)
        return f"{OUTPUT} could not be written ({error.strerror})"
    if isinstance(error, FileNotFoundError) and not error.filename:
        return "the folder that this runs in is gone; allowed: one that exists"
    if isinstance(error, OSError):
        return text if error.filename else ""
    return text if is_refusal(error) else ""


def run(options: type[Parsed], command: Callable[[Parsed], int], prog: str) -> int:
    """Entry point of a study's own script; returns the exit status."""
    return guard(lambda: command(arguments.parse(options, sys.argv[1:], prog)), KEPT)
