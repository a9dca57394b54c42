"""Figures of the map of extremes (certified to which level, where refused, what it took) and of a soak."""

import math
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from .. import store
from ..extremes import cells
from ..extremes.verdicts import CERTIFIED, DEFECT, REFUSED
from .style import COLOURS, load

Array64 = NDArray[np.float64]
Indices = NDArray[np.int64]


def draw(path: Path) -> dict[str, Figure]:
    """Three maps over thickness and pressure, and verdicts by everything else."""
    study = load(path)
    column, row = _places(study)
    verdict = study.column("verdict")
    certified = verdict == CERTIFIED
    figure, panels = plt.subplots(2, 2, figsize=(9.6, 7.0))
    figure.subplots_adjust(left=0.08, right=0.97, top=0.94, bottom=0.09, hspace=0.34, wspace=0.42)
    plain = study.column("asked") == 0
    residual = np.log10(np.maximum(_numbers(study, "certificate.free_residual"), 1e-17))
    double = certified & plain & (study.column("precision") != "float32")
    _map(panels[0, 0], column, row, residual, double, np.max, "viridis", "worst free residual, $\\log_{10}$ of $p$")
    panels[0, 0].set_title("certified; float64 and mixed, default tolerance")
    refused = (verdict != CERTIFIED).astype(np.float64) * 100
    _map(panels[0, 1], column, row, refused, plain, np.mean, "magma_r", "refused [% of cells]")
    panels[0, 1].set_title("all precisions, default tolerance")
    iterations = np.log10(np.maximum(_numbers(study, "iterations"), 1))
    active = certified & plain & (study.column("method") == "active-set")
    _map(panels[1, 0], column, row, iterations, active, np.max, "cividis", "most iterations, $\\log_{10}$")
    panels[1, 0].set_title("active set, default tolerance")
    _bars(panels[1, 1], study)
    return {"": figure}


def _numbers(study: store.StudyFile, name: str) -> Array64:
    """A column with 1 where a run has no number."""
    values = np.array([float(run.get(name, math.nan)) for run in study.runs])
    return np.where(np.isfinite(values), values, 1.0)


def _places(study: store.StudyFile) -> tuple[Indices, Indices]:
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
    column: Indices,
    row: Indices,
    values: Array64,
    chosen: NDArray[np.bool_],
    how: object,
    colours: str,
    label: str,
) -> None:
    """What `how` makes of the chosen cells' values at each place; white where there is none."""
    field = np.full((cells.ROWS, cells.COLUMNS), np.nan)
    for place in set(zip(row[chosen].tolist(), column[chosen].tolist(), strict=True)):
        field[place] = how(values[chosen & (row == place[0]) & (column == place[1])])  # type: ignore[operator]
    image = axes.imshow(field, origin="lower", aspect="auto", cmap=colours)
    axes.figure.colorbar(image, ax=axes, label=label)
    axes.set_xticks([0, 6, 12, 18, 24], ["-12", "-6", "0", "6", "$\\infty$"])
    axes.set_xlabel("$\\log_{10}(d/L)$, one decade a column")
    axes.set_yticks([-0.5, cells.ROWS - 0.5], ["$10^{-15}E^*$", "10 x full\ncontact"])
    axes.set_ylabel("pressure, logarithmic", labelpad=-20)


def _bars(axes: Axes, study: store.StudyFile) -> None:
    """Shares of the verdicts by shape, method, precision and number of points."""
    groups: list[tuple[str, NDArray[np.bool_]]] = []
    asked = study.column("asked") > 0
    for name in ("precision", "method"):
        values = study.column(name)
        groups += [(str(value), values == value) for value in sorted(set(values.tolist()))]
    points = _numbers(study, "scene.num_points")
    groups += [(f"N from {low} to {high}", (points >= low) & (points < high)) for low, high in ((4, 64), (64, 2**13))]
    groups.append(("N from 2^13 to 2^24", points >= 2**13))
    groups += [("tolerance or accuracy asked", asked)]
    verdict = study.column("verdict")
    left = np.zeros(len(groups))
    for kind, colour in zip((CERTIFIED, REFUSED, DEFECT), (COLOURS[1], COLOURS[2], COLOURS[3]), strict=True):
        share = np.array(
            [100 * float(np.mean(verdict[chosen] == kind)) if chosen.any() else 0.0 for _, chosen in groups]
        )
        axes.barh(range(len(groups)), share, left=left, color=colour, label=kind)
        left += share
    axes.set_yticks(range(len(groups)), [f"{name} ({int(chosen.sum())})" for name, chosen in groups], fontsize=7)
    axes.set(xlabel="share of the cells [%]", xlim=(0, 100))
    axes.invert_yaxis()
    axes.legend(fontsize=7, ncols=3, loc="lower center", bbox_to_anchor=(0.4, 1.0))


def soak(path: Path) -> dict[str, Figure]:
    """Memory and open files over the time of a soak, and the scenes that were done."""
    study = load(path)
    hours = (study.column("stretch") + 1) * study.configuration["seconds"] / 3600
    scenes = np.cumsum(sum(study.column(verdict) for verdict in (CERTIFIED, REFUSED, DEFECT)))
    figure, panels = plt.subplots(3, 1, figsize=(5.2, 5.4), sharex=True)
    resident = study.column("bytes.resident") / 2**20
    for axes, values, label in zip(
        panels,
        (resident, study.column("open_files"), scenes),
        ("resident memory\n[MiB]", "open files\n(dimensionless)", "scenes so far\n(dimensionless)"),
        strict=True,
    ):
        axes.plot(hours, values, "o-", ms=3, lw=0.8, color=COLOURS[0])
        axes.set(ylabel=label, ylim=(0, 1.15 * float(np.max(values))))
    panels[-1].set(xlabel="time [h]")
    panels[0].set_title(
        "Random scenes in one process" if len(set(study.column("process").tolist())) == 1 else "Random scenes"
    )
    return {"": figure}
