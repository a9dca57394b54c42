"""Runs a study as its user asked: does its tasks, stores their records, draws the figures and shows the report."""

import contextlib
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from linecontact.solver.display import counted
from linecontact.solver.strategy.grids import check_memory

from ..figures.style import NothingToDraw
from ..files import study_files, writing
from ..files.marks import is_ours, names
from ..files.records import plain
from ..files.study_files import StudyFile
from ..terminal import console
from . import executors
from .ensemble import Ensemble
from .study import Options, Plan, Study
from .tasks import Task, TaskFolder, lock

Files = dict[str, StudyFile]


def run_study(study: Study, options: Options) -> int:
    """Run a study into one folder, draw it, and show its report; returns the exit status.

    Raises `ValueError` for options that the study or the executors cannot use, and for a folder that cannot be used.
    """
    begin = time.monotonic()
    plans, folder = study.planned(options), study.folder(options)
    executors.check(options.workers, options.memory, options.scheduler)
    writing.make_folder(folder)
    writing.check_folder(folder)
    with lock(folder):
        files = {} if options.overwrite else _finished(plans, folder)
        computed, own = len(files) < len(plans), False
        if computed:
            files, own = _compute(plans, options, folder)
        figures = _draw(study, plans, files, folder, computed, options.overwrite, own)
        with writing.expecting(folder, own):
            parts = study.report(files, folder)
            asked = {plan.kind: plan.configuration for plan in plans}  # a file of something better may be kept
            missed = {kind: study.missed(replace(files[kind], configuration=own)) for kind, own in asked.items()}
    study.check_report(parts)
    output = console.Output()
    for part in parts:
        output.print(part, highlight=False)
    done = "Finished before; nothing computed."
    if any(missed.values()):
        done = "Nothing computed; all that may be done was done before."
    output.print(f"{time.monotonic() - begin:.1f} s in all." if computed else done)
    output.print(f"Data: {', '.join(str(plan.path(folder)) for plan in plans)}", soft_wrap=True)
    if figures:
        output.print(f"Figures: {', '.join(map(str, figures))}", soft_wrap=True)
    return _exit_status(study, files, missed)


def _exit_status(study: Study, files: Files, missed: Mapping[str, Iterable[str]]) -> int:
    """4 if any task failed or there is a defect, 3 if any run is not certified at its tolerance, or what was asked for
    is not reached, else 0.
    """
    status = 0
    for kind, file in files.items():
        for task, reason in file.failures.items():
            console.errors.print(f"linecontact: {kind}: task {task} failed: {reason}")
            status = console.EXIT_FAILED
        for defect in study.defects(file):
            console.errors.print(f"linecontact: {kind}: defect: {defect}")
            status = console.EXIT_FAILED
        unconverged = any(run.get("status", "converged") != "converged" for run in file.runs)
        if unconverged and not status and not study.may_not_converge:
            status = console.EXIT_NOT_CONVERGED
        for reason in missed[kind]:
            console.errors.print(f"linecontact: {kind}: the goal is not reached: {reason}")
            status = status or console.EXIT_NOT_CONVERGED
    return status


def _finished(plans: Sequence[Plan], folder: Path) -> Files:
    found = {}
    for plan in plans:
        path, asked = plan.path(folder), plan.configuration
        file = study_files.finished(path, plan.kind, asked, plan.adjustable, plan.enough)
        if file:
            found[plan.kind] = file
            held = {name: file.configuration.get(name) for name in plan.adjustable}
            other = ", ".join(f"{name} {value}" for name, value in held.items() if value != plain(asked[name]))
            if other:
                console.errors.print(f"{path} is of {other}, and holds all that is asked for", soft_wrap=True)
    return found


def _compute(plans: Sequence[Plan], options: Options, folder: Path) -> tuple[Files, bool]:
    """All tasks of all plans together; finished ones are collected also when the run is cut short. Also returns whether
    none was found done.
    """
    ensemble: Ensemble

    def report(iteration: int, residual: float) -> None:
        def tell() -> tuple[float, str]:
            known = "" if math.isnan(residual) else f", residual {residual:.1e}"
            share, state = progress(ensemble)
            return share, f"{state}; iteration {iteration}{known}"

        bar.show(tell)

    def more() -> list[Task]:
        """The tasks that the plans ask for when they have the records so far."""
        nonlocal plans
        further = [plan.further(ensemble.records) for plan in plans]
        plans = [replace(plan, runs=[*plan.runs, *new]) for plan, new in zip(plans, further, strict=True)]
        tasks = [task for new in further for task in new]
        if options.overwrite:
            ensemble.folder.forget(tasks)
        return tasks

    progress = _Outlook(plans)
    with executors.choose(options.workers, options.memory, options.scheduler, report) as pool:
        if pool.budget:
            _check_memory(plans, pool.budget, options.workers)
        with writing.expecting(folder):
            ensemble = _begin(plans, options, folder)
        with console.Bar(", ".join(plan.kind for plan in plans)) as bar:
            bar.show(lambda: progress(ensemble))
            try:
                ensemble.run(pool.make, pool.limit, lambda now: bar.show(lambda: progress(now)), more)
            except BaseException:
                # a full disk: the tasks' files are there; a finished file, of another accuracy, is worth more
                with contextlib.suppress(writing.StoreError):
                    _save([plan for plan in plans if not _is_finished(plan.path(folder))], ensemble, folder)
                raise
    return _save(plans, ensemble, folder), not ensemble.found


def _check_memory(plans: Sequence[Plan], budget: int, workers: int) -> None:
    """Raise `ValueError` if a worker's budget [bytes] does not hold the largest grid."""
    try:
        check_memory(max(plan.num_points for plan in plans), available=budget)
    except ValueError as error:
        raise ValueError(f"{error}{', or fewer workers' * (workers > 1)}") from None


class _Outlook:
    """How far a run is: the share of its tasks or, for a study that decides on the way, of the work that it needs."""

    _SELDOM = 20.0  # times the time that it takes, that pass before it is worked out again

    def __init__(self, plans: Sequence[Plan]) -> None:
        self._outlook = plans[0].outlook if len(plans) == 1 else None
        self._next, self._known = 0.0, (0.0, "")

    def __call__(self, ensemble: Ensemble) -> tuple[float, str]:
        """Share of the work that is done, 0 to 1, and words for it."""
        if self._outlook is None:
            return ensemble.share, str(ensemble)
        begin = time.monotonic()
        if begin >= self._next:
            self._known = self._outlook(ensemble.records)
            now = time.monotonic()
            self._next = now + max(1.0, self._SELDOM * (now - begin))
        share, reached = self._known
        return share, f"{reached}; {len(ensemble.records)} of {len(ensemble.tasks)} batches planned so far"


def _begin(plans: Sequence[Plan], options: Options, folder: Path) -> Ensemble:
    """The tasks of all plans, with the records that former runs have left."""
    results = TaskFolder(folder / "tasks")
    # files that a killed process has left unfinished
    writing.remove(*folder.glob(".*.part"), *results.folder.glob(".*.part"))
    tasks = [task for plan in plans for task in plan.tasks]
    if options.overwrite:
        writing.remove(*(plan.path(folder) for plan in plans))
        results.forget(tasks)
    ensemble = Ensemble(tasks, results)
    if ensemble.found:
        told = f"{ensemble.found} of {counted(len(ensemble.tasks), 'task')}"
        if any(plan.more for plan in plans):  # others may be found later
            told = f"at least {counted(ensemble.found, 'task')}"
        console.errors.print(f"continuing: {told} {'is' if ensemble.found == 1 else 'are'} done")
    return ensemble


def _save(plans: Sequence[Plan], ensemble: Ensemble, folder: Path) -> Files:
    """Collect the records and write the files; the report is of the written files, or a result not worth its file."""
    files = {}
    with writing.expecting(folder, own=not ensemble.found):
        for plan in plans:
            path, found = plan.path(folder), plan.collect(ensemble.records, ensemble.failures)
            if plan.enough and not plan.enough(found) and _holds_more(path, found):
                console.errors.print(f"{path} is kept: it is finished, and holds more than this", soft_wrap=True)
                files[plan.kind] = found
            else:
                study_files.save_study(path, found)
                files[plan.kind] = study_files.load_study(path)
    return files


def _holds_more(path: Path, found: StudyFile) -> bool:
    """Whether a file is finished, with no fewer runs than were found now."""
    return _is_finished(path) and len(study_files.load_study(path).runs) >= len(found.runs)


def _is_finished(path: Path) -> bool:
    return path.exists() and study_files.is_complete(path)


def _draw(
    study: Study,
    plans: Sequence[Plan],
    files: Mapping[str, StudyFile],
    folder: Path,
    new: bool,
    overwrite: bool,
    own: bool,
) -> list[Path]:
    """Figures of everything that was computed anew, or that has none yet; returns the files of all figures.

    overwrite: whether other programs' files may be replaced. own: as in `writing.expecting`.
    """
    drawn: list[Path] = []
    for plan in plans:
        path = plan.path(folder)
        figures = names(path, plan.figures) if files[plan.kind].runs else []
        written = path.stat().st_mtime_ns
        there = all(is_ours(figure) and figure.stat().st_mtime_ns >= written for figure in figures)
        if figures and (new or not there):
            from ..figures import saving  # matplotlib takes its time

            try:
                figures = saving.save(path, study.draw, overwrite, own)
            except (NothingToDraw, saving.ForeignFileError) as error:
                console.errors.print(f"{plan.kind}: {error}")
                figures = []
        drawn += figures
    return drawn
