"""Figures of the map of extremes (certified to which level, where refused, how long it took) and of a soak."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from linecontact.solver.methods import DEFAULT
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..figures.style import COLOURS, ONE_COLUMN, TWO_COLUMNS, load
from ..figures.style import panels as empty_panels
from ..files.study_files import StudyFile
from . import cells
from .verdicts import CERTIFIED, DEFECT, REFUSED

Array64 = NDArray[np.float64]
Indices = NDArray[np.int64]


def draw(path: Path) -> dict[str, Figure]:
    """Three maps over thickness and pressure, and verdicts by everything else."""
    study = load(path)
    column, row = _places(study)
    verdict = study.column("verdict")
    certified = verdict == CERTIFIED
    plain = study.column("asked") == 0
    figure, panels = empty_panels(2, 2, TWO_COLUMNS, 5.6)
    residual = np.maximum(_numbers(study, "certificate.equilibrium_residual"), 1e-17)
    double = certified & plain & (study.column("precision") != "float32")
    places = column, row
    _map(panels[0, 0], places, residual, double, np.max, "viridis", LogNorm(1e-12, 1e-3))
    panels[0, 0].set_title("Largest certified residual over $p$, float64 and mixed", pad=12)
    refused = (verdict != CERTIFIED).astype(np.float64) * 100
    _map(panels[0, 1], places, refused, plain, np.mean, "magma_r", Normalize(0, 20))
    panels[0, 1].set_title("Cells refused [%], all precisions", pad=12)
    iterations = np.maximum(_numbers(study, "iterations"), 1)
    active = certified & plain & (study.column("method") == DEFAULT.name)
    _map(panels[1, 0], places, iterations, active, np.max, "cividis", LogNorm(1, 1e4))
    panels[1, 0].set_title(f"Most iterations of the {DEFAULT.label}", pad=12)
    _bars(panels[1, 1], study, plain)
    figure.supxlabel("Maps: default tolerances only; grey: no such cell among those drawn.", fontsize=7)
    return {"": figure}


def _numbers(study: StudyFile, name: str) -> Array64:
    """A column with 1 where a run has no number."""
    values = np.array([float(run.get(name, math.nan)) for run in study.runs])
    return np.where(np.isfinite(values), values, 1.0)


def _places(study: StudyFile) -> tuple[Indices, Indices]:
    thickness = np.array([float(run["scene.thickness"]) for run in study.runs])
    with np.errstate(invalid="ignore"):
        decade = np.floor(np.log10(np.where(np.isfinite(thickness), thickness, 1e12))) + 12
    column = np.clip(decade, 0, cells.COLUMNS - 1).astype(np.int64)
    low = math.log10(cells.LEAST_LOAD)
    high = np.log10(10 * _numbers(study, "full_load"))
    part = (np.log10(_numbers(study, "scene.pressure")) - low) / np.maximum(high - low, 1.0)
    return column, np.clip(np.floor(part * cells.ROWS), 0, cells.ROWS - 1).astype(np.int64)


def _map(
    axes: Axes,
    places: tuple[Indices, Indices],
    values: Array64,
    chosen: NDArray[np.bool_],
    how: Callable[[Array64], float],
    colours: str,
    norm: Normalize,
) -> None:
    """Map the values of the chosen cells: at each place, (column, row), `how` makes one number of them."""
    column, row = places
    field = np.full((cells.ROWS, cells.COLUMNS), np.nan)
    for i, j in set(zip(row[chosen].tolist(), column[chosen].tolist(), strict=True)):
        field[i, j] = how(values[chosen & (row == i) & (column == j)])
    axes.set_facecolor("#dddddd")
    image = axes.imshow(field, origin="lower", aspect="auto", cmap=colours, norm=norm)
    axes.figure.colorbar(image, ax=axes)
    axes.set_xticks([0, 6, 12, 18, 24], ["$10^{-12}$", "$10^{-6}$", "1", "$10^6$", "$\\infty$"])
    axes.set_xlabel("$d/L$, one decade a column")
    axes.set_yticks([-0.5, cells.ROWS - 0.5], ["$10^{-15}E^*$", "10 x $p$ of\nfull contact"], fontsize=7)
    axes.set_ylabel("$p$, even steps of $\\log p$", labelpad=-24)


def _bars(axes: Axes, study: StudyFile, plain: NDArray[np.bool_]) -> None:
    """Shares of the verdicts by precision, method and number of points, and of the requests for more."""
    groups: list[tuple[str, NDArray[np.bool_]]] = []
    for name in ("precision", "method"):
        values = study.column(name)
        groups += [(str(value), plain & (values == value)) for value in sorted(set(values[plain].tolist()))]
    points, method = _numbers(study, "scene.num_points"), study.column("method")
    for low, high in ((4, 64), (64, 2**13), (2**13, 2**24 + 1)):
        if points.max() < low:
            continue
        high = min(high, int(points.max()) + 1)
        groups.append((f"{low} to {high - 1} points", plain & (points >= low) & (points < high)))
    groups.append(("a tolerance asked", ~plain & (method != "to an accuracy")))
    groups.append(("an accuracy asked", ~plain & (method == "to an accuracy")))
    verdict = study.column("verdict")
    left = np.zeros(len(groups))
    for kind, colour in zip((CERTIFIED, REFUSED, DEFECT), (COLOURS[1], COLOURS[2], COLOURS[3]), strict=True):
        share = np.array([100 * float(np.mean(verdict[own] == kind)) if own.any() else 0.0 for _, own in groups])
        axes.barh(range(len(groups)), share, left=left, color=colour, label=kind)
        left += share
    axes.set_yticks(range(len(groups)), [f"{name}: {int(own.sum())}" for name, own in groups], fontsize=7)
    axes.set(xlabel="share of the cells [%]", xlim=(0, 100))
    axes.invert_yaxis()
    axes.legend(fontsize=7, ncols=3, loc="lower center", bbox_to_anchor=(0.4, 1.0))


def soak(path: Path) -> dict[str, Figure]:
    """Memory and open files over the time of a soak, and the scenes that were done."""
    study = load(path)
    hours = np.cumsum(study.column("seconds.stretch")) / 3600
    scenes = np.cumsum(sum(study.column(verdict) for verdict in (CERTIFIED, REFUSED, DEFECT)))
    figure, grid = empty_panels(3, 1, ONE_COLUMN, 4.6, sharex=True)
    panels = grid[:, 0]
    resident = study.column("bytes.resident") / 2**20
    for axes, values, label in zip(
        panels,
        (resident, study.column("open_files"), scenes / 1000),
        ("resident memory\n[MiB]", "open files\n(dimensionless)", "scenes so far\n[thousands]"),
        strict=True,
    ):
        axes.plot(hours, values, "o-", ms=3, lw=0.8, color=COLOURS[0])
        axes.set(ylabel=label, ylim=(0, 1.15 * float(np.max(values))))
    panels[-1].set(xlabel="time [h]")
    panels[0].set_title(
        "Random scenes in one process" if len(set(study.column("process").tolist())) == 1 else "Random scenes"
    )
    return {"": figure}
