"""Studies as lists of independent tasks, run through any `concurrent.futures.Executor`, and nothing is lost.

A task's record is in a file of its own as soon as the task is finished (`tasks.TaskFolder`). Running a study means
doing the tasks that have no such file, in any order and anywhere, and then collecting the records, in the study's
order, into one HDF5 file. So a run that was killed goes on where it was, and the data does not depend on who did what
when, but for rounding.

    records, failures = Ensemble(study.tasks, TaskFolder(path)).run(make_executor)

`make_executor` may be any executor's class: with mpi4py.futures.MPIPoolExecutor the tasks run under MPI.
"""

import contextlib
import json
import math
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from linecontact.solver.relaxation import Progress
from rich.console import RenderableType

from ..files import records, study_files, writing
from ..files.study_files import StudyFile
from ..terminal import console
from . import executors
from .tasks import Record, Task, TaskFolder, identity, lock


@dataclass(frozen=True)
class Options:
    """What every study can be asked for."""

    folder: Path | None = None
    """Where data and figures go; default: results/ and the study's name."""
    workers: int = executors.usable_cores()
    """Processes of one thread each, 1 to 1024; with 1 everything happens in this one. Default: the usable cores."""
    memory: float | None = None
    """Budget of each worker process [GiB]; default: what is free at the start, shared among them."""
    scheduler: str | None = None
    """Address of a Dask scheduler to use instead of processes, like tcp://host:8786."""
    overwrite: bool = False
    """Start anew even if there are results."""


@dataclass(frozen=True)
class Study:
    """kind: name of the study and its file; configuration: what the user chose, JSON-ready; runs: the rows of the file;
    lines: reference curves by name, whose records are columns; figures: endings of its figures' names.
    """

    kind: str
    configuration: dict[str, Any]
    runs: Sequence[Task]
    lines: Mapping[str, Task] = field(default_factory=dict)
    figures: tuple[str, ...] = ("",)

    @property
    def tasks(self) -> list[Task]:
        """Everything there is to do."""
        return [*self.lines.values(), *self.runs]

    def path(self, folder: Path) -> Path:
        """The study's file."""
        return folder / f"{self.kind}.h5"

    def collect(self, records: Mapping[Task, Record], failures: Mapping[Task, str]) -> StudyFile:
        """The study's file as far as it is done."""
        own = set(self.tasks)
        return StudyFile(
            kind=self.kind,
            configuration=self.configuration,
            runs=[records[task] | {"task": identity(task)} for task in self.runs if task in records],
            lines={name: records[task] for name, task in self.lines.items() if task in records},
            failures={identity(task): reason for task, reason in failures.items() if task in own},
            complete=own <= records.keys(),
        )


class TaskError(Exception):
    """What went wrong in a task, on one line: not every exception survives the way from a worker."""


def perform(task: Task, report: Progress | None = None) -> Record:
    """What a worker does. A solve that was interrupted raises `KeyboardInterrupt`, anything else `TaskError`."""
    try:
        record = task.run(report)
        json.dumps(records.plain(record))
    except Exception as error:
        raise TaskError(" ".join(f"{type(error).__name__}: {error}".split())) from None
    if record.get("status") == "interrupted":
        raise KeyboardInterrupt
    return record


class Ensemble:
    """Tasks with their records, as far as they are done, and the reasons of those that failed.

    Tasks in flight when a worker died come last and one by one, so that the one to blame shows itself.
    """

    deaths = 2  # of its worker, alone, after which a task has failed
    hopeless = 100  # tasks in a row that lost theirs

    def __init__(self, tasks: Iterable[Task], folder: TaskFolder) -> None:
        self.tasks, self.folder = list(dict.fromkeys(tasks)), folder
        self.records = {task: record for task in self.tasks if (record := folder.load(task)) is not None}
        self.failures: dict[Task, str] = {}
        self.found = len(self.records)
        self.worst = max([0.0, *map(_residual, self.records.values())])
        self._waiting = deque(task for task in self.tasks if task not in self.records)
        self._running: dict[Future[Record], Task] = {}
        self._died: dict[Task, int] = {}
        self._in_a_row = 0
        self._begin = time.monotonic()

    @property
    def share(self) -> float:
        """Done or failed, 0 to 1."""
        return (len(self.records) + len(self.failures)) / max(1, len(self.tasks))

    def __str__(self) -> str:
        rate = (len(self.records) - self.found) / max(1e-9, time.monotonic() - self._begin)
        worst = f"{self.worst:.0e}" if self.worst else "none yet"
        return (
            f"{len(self.records)} of {len(self.tasks)} done, {len(self._running)} submitted, "
            f"{len(self.failures)} failed, {rate:.3g} a second, worst residual {worst}"
        )

    def run(
        self,
        make_executor: Callable[[], Executor],
        limit: Callable[[], int] = lambda: 8,
        show: Callable[["Ensemble"], None] = lambda _: None,
    ) -> tuple[dict[Task, Record], dict[Task, str]]:
        """Do what is left; returns the records and the reasons of failures, by task.

        make_executor: called at the start, and again when a worker's death has broken the executor.
        limit: tasks to have submitted at a time; a killed run loses no more than these.

        Raises `StoreError` when a record cannot be written, `LostError` when the executor is gone for good, and passes
        `KeyboardInterrupt` through.
        """
        while self._waiting or self._running:
            with make_executor() as executor, _flag_for_ctrl_c(executor) as interrupted:
                try:
                    while (self._waiting or self._running) and not interrupted.is_set:
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

    def _submit(self, executor: Executor, limit: int, show: Callable[["Ensemble"], None]) -> bool:
        """Keep the executor busy; False if it is broken."""
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
        """Keep what has been finished."""
        for future in wait(self._running, timeout=0.2, return_when=FIRST_COMPLETED).done:
            task = self._running.pop(future)
            try:
                record = future.result()
            except CancelledError as error:  # not by us
                raise executors.LostError("the scheduler is gone; run again to continue") from error
            except BrokenExecutor:
                self._mourn(task)
            except TaskError as error:
                self._fail(task, str(error))
            except Exception as error:  # whatever it is, the others go on
                self._fail(task, " ".join(f"{type(error).__name__}: {error}".split()))
            else:
                self.folder.save(task, record)
                self.records[task] = record
                self.worst = max(self.worst, _residual(record))
                self._in_a_row = 0

    def _mourn(self, task: Task) -> None:
        """Try it again, alone, unless it was alone already when its worker died."""
        self._died[task] = self._died.get(task, -1) + 1
        self._in_a_row += 1
        if self._died[task] < self.deaths:
            console.errors.print(
                f"a worker process died, killed or out of memory; task {identity(task)} is tried again"
            )
            self._waiting.append(task)
        else:
            self._fail(task, "its worker process died, killed or out of memory")
        if self._in_a_row > self.hopeless:
            raise executors.LostError(
                f"{self._in_a_row} tasks in a row lost their worker process; allowed: more memory"
            )

    def _fail(self, task: Task, reason: str) -> None:
        self.folder.save_failure(task, reason)
        self.failures[task] = reason


def _residual(record: Record) -> float:
    residual = float(record.get("certificate.free_residual", 0.0))
    return math.inf if math.isnan(residual) else residual


@dataclass
class _Flag:
    """Without the lock of a `threading.Event`: a handler that a second signal interrupts would wait for itself."""

    is_set: bool = False


@contextlib.contextmanager
def _flag_for_ctrl_c(executor: Executor) -> Iterator[_Flag]:
    """A flag that Ctrl-C sets: raised as an exception, it could be lost in an executor's callback. A second one is
    raised, should something hang.
    """
    flag = _Flag()
    if isinstance(executor, executors.InProcess) or threading.current_thread() is not threading.main_thread():
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


def command(
    studies: Sequence[Study],
    options: Options,
    folder: Path,
    closing: Callable[[dict[str, StudyFile], Path], Sequence[RenderableType]],
    defects: Callable[[StudyFile], Sequence[str]] = lambda _: (),
) -> int:
    """Run studies into one folder, draw them, and print what `closing` makes of them; returns the exit status.

    defects: what in a study must not be, a line each; as bad as a task that failed.
    """
    begin = time.monotonic()
    folder = options.folder or folder
    executors.check(options.workers, options.memory, options.scheduler)
    writing.make_folder(folder)
    writing.check_folder(folder)
    with lock(folder):
        files = {} if options.overwrite else _finished(studies, folder)
        computed = len(files) < len(studies)
        if computed:
            files = _compute(studies, options, folder)
        figures = _draw(studies, files, folder, computed)
        with writing.expecting(folder):
            parts = closing(files, folder)
    output = console.Output()
    for part in parts:
        output.print(part, soft_wrap=isinstance(part, str), highlight=False)
    output.print(f"{time.monotonic() - begin:.1f} s in all." if computed else "Finished before; nothing computed.")
    output.print(f"Data: {', '.join(str(study.path(folder)) for study in studies)}", soft_wrap=True)
    output.print(f"Figures: {', '.join(map(str, figures))}", soft_wrap=True)
    return exit_status(files.values(), defects)


def exit_status(files: Iterable[StudyFile], defects: Callable[[StudyFile], Sequence[str]] = lambda _: ()) -> int:
    """4 if any task failed or there is a defect, 3 if any run is not certified at its tolerance, else 0."""
    status = 0
    for file in files:
        for task, reason in file.failures.items():
            console.errors.print(f"linecontact: {file.kind}: task {task} failed: {reason}")
            status = console.EXIT_FAILED
        for defect in defects(file):
            console.errors.print(f"linecontact: {file.kind}: defect: {defect}")
            status = console.EXIT_FAILED
        if not status and any(run.get("status", "converged") != "converged" for run in file.runs):
            status = console.EXIT_NOT_CONVERGED
    return status


def _finished(studies: Sequence[Study], folder: Path) -> dict[str, StudyFile]:
    files = {study.kind: study_files.finished(study.path(folder), study.kind, study.configuration) for study in studies}
    return {kind: file for kind, file in files.items() if file}


def _compute(studies: Sequence[Study], options: Options, folder: Path) -> dict[str, StudyFile]:
    """All tasks of all studies together; what is done is collected also when the run is cut short."""
    ensemble: Ensemble

    def report(iteration: int, residual: float) -> None:
        known = "" if math.isnan(residual) else f", residual {residual:.1e}"
        bar.show(ensemble.share, f"{ensemble}; iteration {iteration}{known}")

    with executors.choose(options.workers, options.memory, options.scheduler, report) as pool:
        with writing.expecting(folder):
            ensemble = _begin(studies, options, folder)
        with console.Bar(", ".join(study.kind for study in studies)) as bar:
            bar.start = ensemble.share
            try:
                ensemble.run(pool.make, pool.limit, lambda _: bar.show(ensemble.share, str(ensemble)))
            except BaseException:
                with contextlib.suppress(writing.StoreError):  # a full disk: the tasks' files are there
                    _save(studies, ensemble, folder)
                raise
    return _save(studies, ensemble, folder)


def _begin(studies: Sequence[Study], options: Options, folder: Path) -> Ensemble:
    """The tasks with what former runs have left of them."""
    results = TaskFolder(folder / "tasks")
    # what a killed process has left unfinished
    writing.remove(*folder.glob(".*.part"), *results.folder.glob(".*.part"))
    tasks = [task for study in studies for task in study.tasks]
    if options.overwrite:
        writing.remove(*(study.path(folder) for study in studies))
        results.forget(tasks)
    ensemble = Ensemble(tasks, results)
    if ensemble.found:
        console.errors.print(f"continuing: {ensemble.found} of {len(ensemble.tasks)} tasks are done")
    return ensemble


def _save(studies: Sequence[Study], ensemble: Ensemble, folder: Path) -> dict[str, StudyFile]:
    """Collect the records and write the files; what is shown is what was written."""
    with writing.expecting(folder):
        for study in studies:
            study_files.save_study(study.path(folder), study.collect(ensemble.records, ensemble.failures))
    return {study.kind: study_files.load_study(study.path(folder)) for study in studies}


def _draw(studies: Sequence[Study], files: Mapping[str, StudyFile], folder: Path, computed: bool) -> list[Path]:
    """Figures of everything that was computed, or that has none yet."""
    drawn: list[Path] = []
    for study in studies:
        path = study.path(folder)
        expected = [path.with_name(path.stem + suffix + end) for suffix in study.figures for end in (".png", ".pdf")]
        written = path.stat().st_mtime_ns
        there = all(figure.is_file() and figure.stat().st_mtime_ns >= written for figure in expected)
        if files[study.kind].runs and (computed or not there):
            from . import drawing  # matplotlib takes its time

            try:
                expected = drawing.draw(path)
            except drawing.NothingToDraw as error:
                console.errors.print(f"{study.kind}: {error}")
                expected = []
        drawn += expected
    return drawn
