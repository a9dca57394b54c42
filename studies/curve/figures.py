"""The figure of a curve: contact area, kappa and contact stiffness over the number that is varied."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver.units import unit
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ..figures.style import COLOURS, ONE_COLUMN, NothingToDraw, load, panels, typeset
from ..files.study_files import StudyFile
from .tasks import column, unit_in

Array64 = NDArray[np.float64]

_DECADE = 10.0  # ratio of the ends from which an axis is logarithmic


def draw(path: Path) -> dict[str, Figure]:
    """The three panels of a stored curve."""
    study = load(path)
    over = str(study.configuration["over"])
    value, along = _shown(study, over, column(over))
    order = np.argsort(value)
    value = value[order]
    shown = np.isfinite(value)
    if not shown.any():
        raise NothingToDraw("a curve whose only value is infinite has no place on an axis")
    figure, grid = panels(3, 1, ONE_COLUMN, 6.0, sharex=True)
    for axes, (name, error, label) in zip(grid[:, 0], _PANELS, strict=True):
        y, said = _shown(study, name)
        y = y[order]
        bars = study.column(error).astype(np.float64)[order] if error else np.zeros_like(y)
        _panel(axes, value[shown], y[shown], bars[shown], joined=over != "seed")
        axes.set_ylabel(f"{label}\n({said})")
        for beyond in y[~shown] if error else ():  # a half-space, whose approach compares with no other
            axes.axhline(beyond, color=COLOURS[3], ls="--", lw=0.8, label="half-space")
    if over == "seed":
        grid[-1, 0].xaxis.set_major_locator(MaxNLocator(integer=True))
    grid[-1, 0].set_xlabel(f"{over.replace('_', ' ')} ({along})")
    figure.suptitle(_scene(study.runs[0], over), fontsize=8)
    if not shown.all():
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center")
    return {"": figure}


_PANELS = (
    ("contact_area_subgrid", "contact_area_error", "contact area $a_r$"),
    ("kappa_subgrid", "kappa_error", "$\\kappa=a_r/p^*$"),
    ("contact_stiffness", "", "contact stiffness\n$dp/d$(approach)"),
)
"""Column, column of its error, and label of each panel."""


def _shown(study: StudyFile, name: str, stored: str = "") -> tuple[Array64, str]:
    """A quantity over the runs as it is drawn, shape (M,), and what it is over: E*, L, or the unit of a scan.

    name: of the quantity; stored: name of its column, by default the same.
    """
    values = study.column(stored or name).astype(np.float64)
    dimension, known = unit(name), unit_in(study, "period")
    if dimension == "1":
        return values, "dimensionless"
    scales = [np.array([float(run.get(f"scene.{of}", np.nan)) for run in study.runs]) for of in _SCALES]
    if name in _SCALES or np.isnan(scales).any():
        return values, "in the scene's unit"
    modulus, period = scales
    length, over = (period, "$L$") if known == "length" else (np.ones_like(period), known)
    if dimension == "pressure":
        return values / modulus, "over $E^*$"
    if dimension == "length":
        return values / length, f"over {over}" if known == "length" else over
    return values / modulus * length, f"over $E^*$/{over}"


_SCALES = ("contact_modulus", "period")


def _panel(axes: Axes, x: Array64, y: Array64, error: Array64, joined: bool) -> None:
    there = np.isfinite(y)
    error = np.where(np.isfinite(error), error, 0.0)
    line = "o" if not joined else "o-" if x.size < 100 else "-"
    axes.errorbar(x[there], y[there], yerr=error[there], fmt=line, ms=2.5, lw=0.9, color=COLOURS[0])
    if _logarithmic(x):
        axes.set_xscale("log")
    if _logarithmic(y[there]):
        axes.set_yscale("log")
    elif there.any() and np.ptp(y[there]) > 0:  # long error bars do not hide the curve
        margin = 0.1 * float(np.ptp(y[there]))
        axes.set_ylim(float(y[there].min()) - margin, float(y[there].max()) + margin)


def _logarithmic(values: Array64) -> bool:
    return bool(values.size and values.min() > 0 and values.max() >= _DECADE * values.min())


def _scene(run: Mapping[str, Any], over: str) -> str:
    """What all points have in common, in a line: numbers in the units of the scene."""
    told = {name: run[f"scene.{name}"] for name in _SYMBOLS if name != over and f"scene.{name}" in run}
    numbers = [f"${_SYMBOLS[name]}={typeset(float(value))}$" for name, value in told.items() if np.isfinite(value)]
    base = str(run["scene.layer"])
    half_space = ["half-space"] * (told.get("thickness") == np.inf) + [base] * (base != "bonded")
    load = float(run["scene.pressure"]) / float(run.get("scene.contact_modulus", np.nan))
    if over not in ("pressure", "approach") and np.isfinite(load):
        half_space.append(f"$p={typeset(load)}\\,E^*$")
    points = [] if over == "num_points" else [f"{run['scene.num_points']} points"]
    return ", ".join([str(run["scene.profile"]), *half_space, *numbers, *points])


_SYMBOLS = {"exponent": "n", "hurst": "H", "thickness": "d", "poisson_ratio": "\\nu"}
"""Numbers of a scene that are told above its curve, with their symbols."""
