"""The report: times of iterations, bandwidths of kernels, whole solves, and whether the answers are the same."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from linecontact.solver.display import rounded_up
from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from ..runner.tasks import Record
from ..terminal import console


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The tables, and sentences on the rest."""
    parts: list[RenderableType] = []
    for file in files.values():
        for what, part in _PARTS.items():
            if runs := of(file, what):
                parts.append(part(runs))
    return parts


def of(file: StudyFile, what: str) -> list[Record]:
    """The rows of one sort."""
    return [run for run in file.runs if run["what"] == what]


def _known(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def machine(runs: Sequence[Record]) -> str:
    """The machine of the measurements."""
    first = runs[0]
    return f"{first['device']}, and {first['provenance.processor']} with {first['provenance.cores']} cores"


def iterations(runs: Sequence[Record]) -> Table:
    """A row for every method, precision and number of points."""
    both = [run for run in runs if _known(run.get("seconds.cpu"))]
    cores = sorted(run["seconds.cores"] / run["seconds.cpu"] for run in both)
    all_cores = f"; on all cores it takes {cores[0]:.2g} to {cores[-1]:.2g} times as long" if cores else ""
    table = console.table(
        title="An iteration on the GPU and on the CPU",
        caption=f"Milliseconds an iteration on {machine(runs)}. CPU: FFTW on one thread, the default{all_cores}; "
        "ratio: CPU over GPU (dimensionless). Where the CPU's time is missing it was not measured.",
    )
    for heading in ("method", "precision", "N", "CPU (ms)", "GPU (ms)", "ratio"):
        table.add_column(heading, justify="right", no_wrap=True)
    for run in sorted(runs, key=lambda run: (run["method"], run["precision"] == "float32", run["num_points"])):
        gpu, cpu = run["seconds.gpu"], run.get("seconds.cpu", math.nan)
        here, ratio = (f"{1e3 * cpu:.3g}", f"{cpu / gpu:.3g}") if _known(cpu) else ("-", "-")
        n = f"2^{round(math.log2(run['num_points']))}"
        table.add_row(run["method"], run["precision"], n, here, f"{1e3 * gpu:.3g}", ratio)
    return table


def kernels(runs: Sequence[Record]) -> Table:
    """A row for every kernel."""
    copies = {run["precision"]: run["bytes_per_second"] for run in runs}
    rates = " and ".join(f"{rate / 1e12:.3g} TB/s in {precision}" for precision, rate in copies.items())
    table = console.table(
        title="Bandwidth of the kernels on the GPU",
        caption=f"The bytes that a kernel reads and writes in a second, over those of a copy, {rates} on "
        f"{machine(runs)}, on arrays of 2^{round(math.log2(runs[0]['num_points']))} values (dimensionless).",
    )
    table.add_column("kernel")
    for precision in copies:
        table.add_column(precision, justify="right", no_wrap=True)
    for name in dict.fromkeys(run["kernel"] for run in runs):
        shares = {run["precision"]: run["share"] for run in runs if run["kernel"] == name}
        table.add_row(name, *(f"{shares[precision]:.2f}" for precision in copies))
    return table


def solves(runs: Sequence[Record]) -> Table:
    """A row for every whole solve."""
    table = console.table(
        title="Whole solves with their certificates",
        caption=f"On {machine(runs)}, FFTW on one thread: a rough surface, H = 0.8, on a layer of d = 0.1 L, "
        "tolerance 1e-8. solve: iterations and preparation; all: with set-up and certificate, which are the CPU's; "
        "residual: by the certificate (dimensionless). On the same grid their contact areas between sub-grid edges "
        f"differ by up to {_spread(runs):.0e} of themselves.",
    )
    for heading in ("method", "on", "N", "iterations", "solve\n(s)", "all\n(s)", "residual"):
        table.add_column(heading, justify="right", no_wrap=True)
    for run in sorted(runs, key=lambda run: (run["where"], run["method"], run["num_points"])):
        table.add_row(
            run["method"],
            {"cuda": "GPU", "cpu": "CPU"}[run["where"]],
            f"2^{round(math.log2(run['num_points']))}",
            str(round(run["iterations"])),
            f"{run['seconds.solve']:.3g}",
            f"{run['seconds.total']:.3g}",
            rounded_up(run["certificate.equilibrium_residual"]),
        )
    return table


def _spread(runs: Sequence[Record]) -> float:
    """The largest relative difference of two contact areas on the same grid."""
    areas: dict[int, list[float]] = {}
    for run in runs:
        areas.setdefault(run["num_points"], []).append(run["contact_area_subgrid"])
    return max(max(found) / min(found) - 1 for found in areas.values())


def agreement(runs: Sequence[Record]) -> str:
    """Comparison of CPU and GPU."""
    certified = [run for run in runs if run["certified"]]
    same = sum(run["nodes_that_differ"] == 0 for run in certified)
    most = max((run["nodes_that_differ"] for run in certified), default=0)
    worst = max(
        (abs(run["equilibrium_residual.gpu"] / run["equilibrium_residual.cpu"] - 1) for run in certified), default=0.0
    )
    others = [run for run in runs if not run["certified"]]
    alike = sum(run["status.cpu"] == run["status.gpu"] for run in others)
    points = [run["num_points"] for run in runs]
    told = (
        f"{len(runs)} random scenes of {min(points):.0f} to {max(points):.0f} points, by mass-weighted FIRE in float64 "
        f"on CPU and GPU: {len(certified)} certified on both, {same} of them with the same nodes in contact"
    )
    told += f" (the others differ in up to {most:.0f} nodes)" if most else ""
    told += f"; the equilibrium residuals of their certificates differ by up to {100 * worst:.1g} %."
    return told + (f" Of the other {len(others)} solves {alike} end with the same status." if others else "")


_PARTS: dict[str, Callable[[Sequence[Record]], RenderableType]] = {
    "iteration": iterations,
    "kernel": kernels,
    "solve": solves,
    "agreement": agreement,
}
"""The words for each sort of rows."""
