"""Independent tasks, run through any `concurrent.futures.Executor`, and nothing is lost.

A task's record is in a file of its own as soon as the task is finished (`tasks.TaskFolder`). Running a study means
doing the tasks that have no such file, in any order and anywhere, and then collecting the records, in the study's
order, into one HDF5 file. So a run that was killed goes on where it was, and the data does not depend on place and
time of the work, but for rounding.

    records, failures = Ensemble(plan.tasks, TaskFolder(path)).run(make_executor)

`make_executor` may be any executor's class: with mpi4py.futures.MPIPoolExecutor the tasks run under MPI.
"""

import contextlib
import math
import reprlib
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass

from linecontact.solver.methods import Progress

from ..terminal import console
from ..terminal.text import is_refusal
from . import executors
from .tasks import Record, Task, TaskFolder, check_record, identity

_SHORT = reprlib.Repr()  # shows a task, without the middle of a long one
_SHORT.maxother = 200


class TaskError(Exception):
    """The error of a task, on one line: not every exception survives the way from a worker."""


def perform(task: Task, report: Progress | None = None) -> Record:
    """The work of a worker. A solve that was interrupted raises `KeyboardInterrupt`, anything else `TaskError`."""
    try:
        record = task.run(report)
        check_record(record)
    except Exception as error:
        where = "" if is_refusal(error) else f", {console.place(error)}"
        raise TaskError(" ".join(f"{type(error).__name__}: {error}{where}".split())) from None
    if record.get("status") == "interrupted":
        raise KeyboardInterrupt
    return record


class Ensemble:
    """Tasks with their records, as far as they are done, and the reasons of those that failed.

    Tasks in flight when a worker died come last and one by one, so that the one that kills its worker shows itself.
    """

    most_deaths = 2
    """Deaths of its worker, while the task was alone, after which a task has failed."""
    most_lost_in_a_row = 100
    """Tasks in a row that lost their worker, after which the run gives up."""

    def __init__(self, tasks: Iterable[Task], folder: TaskFolder) -> None:
        self.folder = folder
        self.tasks: list[Task] = []
        self.records: dict[Task, Record] = {}
        self.failures: dict[Task, str] = {}
        self.worst = 0.0
        self.found = 0  # records that were there
        self._waiting: deque[Task] = deque()
        self.add(tasks)
        self._running: dict[Future[Record], Task] = {}
        self._died: dict[Task, int] = {}
        self._lost_in_a_row = 0
        self._begin = time.monotonic()

    def add(self, tasks: Iterable[Task]) -> bool:
        """Take on tasks, and say whether any is new; those that a former run has done have their records at once."""
        known = set(self.tasks)
        self.tasks += (task for task in dict.fromkeys(tasks) if task not in known)
        for task in self.tasks[len(known) :]:
            record = self.folder.load(task)
            if record is None:
                self._waiting.append(task)
            else:
                self.found += 1
                self.records[task] = record
                self.worst = max(self.worst, _residual(record))
        return len(self.tasks) > len(known)

    @property
    def share(self) -> float:
        """Share of the tasks that are done or have failed, 0 to 1."""
        return (len(self.records) + len(self.failures)) / max(1, len(self.tasks))

    def __str__(self) -> str:
        rate = (len(self.records) - self.found) / max(1e-9, time.monotonic() - self._begin)
        worst = f", worst residual {self.worst:.0e}" if self.worst else ""
        return (
            f"{len(self.records)} of {len(self.tasks)} done, {len(self._running)} submitted, "
            f"{len(self.failures)} failed, {rate:.3g} a second{worst}"
        )

    def run(
        self,
        make_executor: Callable[[], Executor],
        limit: Callable[[], int] = lambda: 8,
        show: Callable[["Ensemble"], None] = lambda _: None,
        more: Callable[[], Iterable[Task]] = tuple,
    ) -> tuple[dict[Task, Record], dict[Task, str]]:
        """Do the rest; returns the records and the reasons of failures, by task.

        make_executor: called at the start, and again when a worker's death has broken the executor.
        limit: tasks to have submitted at a time; a killed run loses no more than these.
        more: called when everything is done; gives further tasks, or none at the end.

        Raises `StoreError` when a record cannot be written, `LostError` when the executor is gone for good, and passes
        `KeyboardInterrupt` through.
        """
        while self._left(more):
            with make_executor() as executor, _flag_for_ctrl_c(executor) as interrupted:
                try:
                    while not interrupted.is_set and self._left(more):
                        if not self._submit(executor, limit(), show):
                            break
                        self._receive()
                        show(self)
                    if interrupted.is_set:  # perhaps while the executor broke
                        raise KeyboardInterrupt
                except BaseException:
                    executors.abandon(executor, self._running)
                    raise
        return self.records, self.failures

    def _left(self, more: Callable[[], Iterable[Task]]) -> bool:
        """Whether anything is left to do, further tasks included."""
        while not (self._waiting or self._running):
            if not self.add(more()):
                return False
        return True

    def _submit(self, executor: Executor, limit: int, show: Callable[["Ensemble"], None]) -> bool:
        """Submit tasks up to the limit; False if the executor is broken."""
        while self._waiting:
            task = self._waiting[0]
            alone = task in self._died or any(other in self._died for other in self._running.values())
            if len(self._running) >= (1 if alone else limit):
                break
            try:
                self._running[executor.submit(perform, task)] = task
            except BrokenExecutor:
                self._receive()
                return False
            except Exception as error:
                raise executors.LostError(
                    f"tasks can no longer be submitted ({error}); run again to continue"
                ) from error
            self._waiting.popleft()
            show(self)
        return True

    def _receive(self) -> None:
        """Keep the records of tasks that have been finished, and the reasons of those that failed."""
        for future in wait(self._running, timeout=0.2, return_when=FIRST_COMPLETED).done:
            task = self._running.pop(future)
            try:
                record = future.result()
            except CancelledError as error:  # not by us
                raise executors.LostError("the scheduler is gone; run again to continue") from error
            except BrokenExecutor:
                self._worker_died(task)
            except TaskError as error:
                self._fail(task, str(error))
            except Exception as error:  # whatever it is, the others go on
                self._fail(task, " ".join(f"{type(error).__name__}: {error}".split()))
            else:
                self.folder.save(task, record)
                self.records[task] = record
                self.worst = max(self.worst, _residual(record))
                self._lost_in_a_row = 0

    def _worker_died(self, task: Task) -> None:
        """Try a task again, alone, unless it was alone already when its worker died."""
        self._died[task] = self._died.get(task, -1) + 1
        self._lost_in_a_row += 1
        if self._died[task] < self.most_deaths:
            console.errors.print(
                f"a worker process died, killed or out of memory; task {identity(task)} is tried again"
            )
            self._waiting.append(task)
        else:
            self._fail(task, "its worker process died, killed or out of memory")
        if self._lost_in_a_row > self.most_lost_in_a_row:
            raise executors.LostError(
                f"{self._lost_in_a_row} tasks in a row lost their worker process; allowed: more memory"
            )

    def _fail(self, task: Task, reason: str) -> None:
        reason = f"{reason} ({_SHORT.repr(task)})"
        self.folder.save_failure(task, reason)
        self.failures[task] = reason


def _residual(record: Record) -> float:
    residual = float(record.get("certificate.equilibrium_residual", 0.0))
    return math.inf if math.isnan(residual) else residual


@dataclass
class _Flag:
    """Whether Ctrl-C was pressed, without the lock of a `threading.Event`.

    A handler that a second signal interrupts would wait for itself.
    """

    is_set: bool = False
    """True from the first Ctrl-C on."""


@contextlib.contextmanager
def _flag_for_ctrl_c(executor: Executor) -> Iterator[_Flag]:
    """A flag that Ctrl-C sets; a second Ctrl-C is raised, should something hang.

    Raised as an exception, the first could be lost in an executor's callback.
    """
    flag = _Flag()
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN  # as in a script's background
    elsewhere = threading.current_thread() is not threading.main_thread()
    if isinstance(executor, executors.InProcess) or ignored or elsewhere:
        yield flag
        return

    def interrupt(*_: object) -> None:
        if flag.is_set:
            raise KeyboardInterrupt
        flag.is_set = True

    handler = signal.signal(signal.SIGINT, interrupt)
    try:
        yield flag
    finally:
        signal.signal(signal.SIGINT, handler)
