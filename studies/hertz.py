"""The Hertz study (the published study's Figure 2): kappa_d/kappa_inf over d/a_r for a parabola on layers of any
thickness.

    python -m linecontact.studies.hertz [--quick] [--folder FOLDER]

n = 2, p = 2e-3 E*, R = L = E* = 1. The thicknesses are those at which the collocation oracle finds the wanted d/a_r,
and the oracle's area and peak pressure are stored beside each run's.
"""

import contextlib
import importlib
import multiprocessing
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from linecontact.solver import Layer, Scene, checks, closed_forms, collocation, solve, transforms
from numpy.typing import NDArray
from rich import box
from rich.console import Console
from rich.table import Table

from . import console, store

Array64 = NDArray[np.float64]

EXPONENT, RADIUS = 2.0, 1.0
KIND = "hertz"


@dataclass(frozen=True)
class Configuration:
    """What identifies the study; a file of another configuration is not continued.

    reduced_thicknesses: the wanted d/(a_r L), from thick to thin (dimensionless).
    """

    num_points: int = 2**18
    pressure: float = 2e-3
    poisson_ratios: tuple[float, ...] = (0.0, 0.25, 0.4, 0.45, 0.49, 0.5)
    reduced_thicknesses: tuple[float, ...] = tuple(round(float(t), 6) for t in np.geomspace(4, 0.008, 13))
    tolerance: float = 1e-8
    method: str = "active-set"
    line_points: int = 30


QUICK = Configuration(num_points=2**12, reduced_thicknesses=Configuration.reduced_thicknesses[:12:2], line_points=14)


@dataclass(frozen=True)
class Task:
    """One run: a Poisson's ratio and a place in the list of reduced thicknesses."""

    configuration: Configuration
    poisson_ratio: float
    index: int


_reports: Any = None  # queue to the parent, set in every worker


def run_task(task: Task) -> tuple[Task, dict[str, Any]]:
    """Solve one task; returns its flat record."""
    c = task.configuration
    wanted = c.reduced_thicknesses[task.index]
    thickness, exact = collocation.solve_reduced_thickness(c.pressure, EXPONENT, RADIUS, wanted, task.poisson_ratio)
    scene = Scene(Layer(thickness, task.poisson_ratio), pressure=c.pressure, num_points=c.num_points)

    def report(iteration: int, residual: float) -> None:
        if _reports is not None:
            _reports.put((task.poisson_ratio, wanted, iteration, residual))

    solution = solve(scene, method=c.method, tolerance=c.tolerance, progress=report)
    record = store.run_record(solution) | {
        "index": task.index,
        "oracle.contact_area": exact.contact_area,
        "oracle.peak_pressure": exact.peak_pressure,
        "oracle.approach": exact.approach,
        "oracle.kappa_ratio": exact.kappa_ratio,
    }
    return task, record


def oracle_line(configuration: Configuration, poisson_ratio: float) -> tuple[str, dict[str, Array64]]:
    """The oracle's kappa_d/kappa_inf over d/a_r, as a line."""
    ends = configuration.reduced_thicknesses[0] * 1.3, configuration.reduced_thicknesses[-1] / 1.3
    wanted = np.geomspace(*ends, configuration.line_points)
    ratios = [
        collocation.solve_reduced_thickness(configuration.pressure, EXPONENT, RADIUS, t, poisson_ratio)[1].kappa_ratio
        for t in wanted
    ]
    return f"nu={poisson_ratio:g}", {"reduced_thickness": wanted, "kappa_ratio": np.array(ratios)}


def _start_worker(reports: Any) -> None:
    """End with the parent, should it be killed."""
    global _reports
    _reports = reports

    def watch() -> None:
        parent = multiprocessing.parent_process()
        if parent:
            parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextlib.contextmanager
def _worker_settings() -> Iterator[None]:
    """What spawned workers inherit: one BLAS thread each, and Ctrl-C left to the parent."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value


@contextlib.contextmanager
def _flag_for_ctrl_c() -> Iterator[threading.Event]:
    """An event that Ctrl-C sets: raised as an exception, it could be lost in a pool's callback."""
    event = threading.Event()
    handler = signal.signal(signal.SIGINT, lambda *_: event.set())
    try:
        yield event
    finally:
        signal.signal(signal.SIGINT, handler)


def run(study: store.StudyFile, configuration: Configuration, path: Path, workers: int, planning: str) -> None:
    """Run what `study` does not hold yet and keep `path` up to date run by run; Ctrl-C passes through."""
    if planning != "estimate":
        transforms.plan_ahead(configuration.num_points, "float64", planning)
    context = multiprocessing.get_context("spawn")
    reports = context.Queue()
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, context, _start_worker, (reports,))
    try:
        with _worker_settings():
            waiting = _submit(study, configuration, pool)
        with _flag_for_ctrl_c() as interrupted:
            _drive(study, configuration, path, waiting, reports, interrupted)
    except BaseException as error:
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        if isinstance(error, BrokenProcessPool):
            raise ValueError("a worker process died; run the study again to continue") from error
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    study.complete = True
    store.save_study(path, study)


def _submit(study: store.StudyFile, configuration: Configuration, pool: ProcessPoolExecutor) -> set[Future[Any]]:
    """Every run and every line of the oracle that `study` does not hold yet."""
    done = {(run["scene.poisson_ratio"], run["index"]) for run in study.runs}
    waiting: set[Future[Any]] = set()
    for nu in configuration.poisson_ratios:
        for index in range(len(configuration.reduced_thicknesses)):
            if (nu, index) not in done:
                waiting.add(pool.submit(run_task, Task(configuration, nu, index)))
        if f"nu={nu:g}" not in study.lines:
            waiting.add(pool.submit(oracle_line, configuration, nu))
    return waiting


def _drive(
    study: store.StudyFile,
    configuration: Configuration,
    path: Path,
    waiting: set[Future[Any]],
    reports: Any,
    interrupted: threading.Event,
) -> None:
    """Store each result as it comes."""
    total = len(configuration.poisson_ratios) * len(configuration.reduced_thicknesses)
    already = len(study.runs)
    with console.Bar(f"Hertz study, {configuration.num_points} points") as progress:
        while waiting:
            finished, waiting = wait(waiting, timeout=0.2, return_when=FIRST_COMPLETED)
            for future in finished:
                result = future.result()
                if isinstance(result[0], Task):
                    _keep(study, path, *result)
                else:
                    study.lines[result[0]] = result[1]
            share = (len(study.runs) - already) / max(1, total - already)
            progress.show(share, f"{len(study.runs)} of {total} runs{_latest(reports)}")
            if interrupted.is_set():
                raise KeyboardInterrupt


def _keep(study: store.StudyFile, path: Path, task: Task, record: dict[str, Any]) -> None:
    study.runs.append(record)
    study.runs.sort(key=lambda run: (run["scene.poisson_ratio"], run["index"]))
    store.save_study(path, study)


def _latest(reports: Any) -> str:
    text = ""
    try:
        while True:
            nu, wanted, iteration, residual = reports.get_nowait()
            text = f", nu={nu:g}, d/a_r = {wanted:.3g}: iteration {iteration}, residual {residual:.1e}"
    except queue.Empty:
        return text


def summary(study: store.StudyFile) -> Table:
    """The closing table: one row per Poisson's ratio, errors against the oracle."""
    points = study.configuration["num_points"]
    table = Table(
        box=box.SIMPLE,
        pad_edge=False,
        title=f"Hertz study, {points} points, p = {study.configuration['pressure']:g} E*, against the oracle",
        caption="ok: runs certified; count, sub-grid: largest |error| of a_r in grid spacings, nodes counted and "
        "between sub-grid edges; peak err: largest |relative error| of the peak pressure; y = "
        "(kappa_d/kappa_inf)/(d/a_r) at the least d/a_r, beside the thin-layer limit to first and second order; "
        "pairs: transforms in all; s: seconds of solving in all. All but s dimensionless.",
        caption_justify="left",
    )
    headings = ("nu", "ok", "count", "sub-\ngrid", "peak\nerr", "y", "y/1st\n- 1", "y/2nd\n- 1")
    for heading in (*headings, "pairs", "s"):
        table.add_column(heading, justify="right", no_wrap=True)
    for nu in sorted(set(study.column("scene.poisson_ratio"))):
        part = study.select("scene.poisson_ratio", nu)
        t, ratio = part.column("reduced_thickness"), part.column("kappa_ratio")
        thin = int(np.argmin(t))
        limit = closed_forms.thin_layer_kappa_ratio(EXPONENT, nu, t[thin])
        second = closed_forms.thin_layer_kappa_ratio(EXPONENT, nu, t[thin], closed_forms.edge_shift(nu))
        area = np.abs(part.column("contact_area") - part.column("oracle.contact_area")) * points
        subgrid = np.abs(part.column("contact_area_subgrid") - part.column("oracle.contact_area")) * points
        peak = np.abs(part.column("peak_pressure") / part.column("oracle.peak_pressure") - 1)
        table.add_row(
            f"{nu:g}",
            f"{np.sum(part.column('status') == 'converged')}/{len(part.runs)}",
            f"{area.max():.2f}",
            f"{subgrid.max():.1g}",
            f"{peak.max():.0e}",
            f"{ratio[thin] / t[thin]:.4g}",
            f"{ratio[thin] / limit - 1:+.0e}",
            f"{ratio[thin] / second - 1:+.0e}",
            str(int(part.column("transform_pairs").sum())),
            f"{part.column('seconds.total').sum():.3g}",
        )
    return table


@dataclass(frozen=True)
class Options:
    """The Hertz study (the published study's Figure 2) at 2^18 points: data, figures and a closing table.

    Run again after an interruption, it continues; run again when finished, it only draws.
    """

    quick: bool = False
    """2^12 points instead of 2^18, in seconds."""
    folder: Path | None = None
    """Where hertz.h5 and the figures go; default results/hertz, or results/hertz-quick."""
    workers: int = 2
    """Processes, 1 to 256."""
    planning: Literal["estimate", "measure", "patient"] = "estimate"
    """FFTW's planning effort; what it finds is kept for later runs."""
    overwrite: bool = False
    """Start anew even if there is a file."""


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    checks.integer("workers", options.workers, "an integer from 1 to 256", 1, 256)
    configuration = QUICK if options.quick else Configuration()
    folder = options.folder or Path("results/hertz-quick" if options.quick else "results/hertz")
    store.make_folder(folder)
    path = folder / "hertz.h5"
    store.check_target(path, overwrite=True)
    begin = time.perf_counter()
    study = store.open_study(KIND, asdict(configuration), path, options.overwrite)
    computed = not study.complete
    if computed and study.runs:
        console.errors.print(f"continuing: {len(study.runs)} runs are done", highlight=False)
    if computed:
        # matplotlib takes a second to import: meanwhile the workers compute, and they never need it
        threading.Thread(target=importlib.import_module, args=("linecontact.studies.figures",), daemon=True).start()
        run(study, configuration, path, options.workers, options.planning)
    from . import figures

    drawn = figures.draw(path)
    output = Console()
    output.print(summary(study))
    output.print(f"{time.perf_counter() - begin:.1f} s in all." if computed else "Finished before; nothing computed.")
    output.print(f"Data: {path}\nFigures: {', '.join(str(figure) for figure in drawn)}", soft_wrap=True)
    failed = int(np.sum(study.column("status") != "converged"))
    return console.EXIT_NOT_CONVERGED if failed else 0


def main() -> int:
    """Entry point of `python -m linecontact.studies.hertz`."""
    options = console.parse(Options, None, "python -m linecontact.studies.hertz", Options.__doc__ or "")
    return console.guard(lambda: command(options))


if __name__ == "__main__":
    sys.exit(main())
