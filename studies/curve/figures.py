"""The figure of a curve: contact area, kappa and contact stiffness over the number that is varied."""

from pathlib import Path

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.units import unit
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..figures import titles
from ..figures.scales import of_scene, shown, sign
from ..figures.style import COLOURS, ONE_COLUMN, NothingToDraw, load, panels
from ..figures.ticks import few_ticks
from ..figures.units import shown_units
from ..files.study_files import StudyFile
from .tasks import column

_DECADE = 10.0  # ratio of the ends from which an axis is logarithmic
_BINS = 6  # intervals between the numbers at an axis, at most


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
    hidden, infinite = 0, 0
    for axes, (name, error, label) in zip(grid[:, 0], _PANELS, strict=True):
        y, said = _shown(study, name)
        y = y[order]
        bars = study.column(error).astype(np.float64)[order] if error else None
        hidden += _panel(axes, value[shown], y[shown], None if bars is None else bars[shown], joined=over != "seed")
        infinite += int(np.isposinf(y[shown]).sum())
        axes.set_ylabel(f"{label}\n({said})")
        for beyond in y[~shown] if error else ():  # a half-space, whose approach compares with no other
            axes.axhline(beyond, color=COLOURS[3], ls="--", lw=0.8, label="half-space")
            _make_room(axes, beyond)
    for axes in grid[:, 0]:
        few_ticks(axes, _BINS)
    if over == "seed":
        grid[-1, 0].xaxis.set_major_locator(MaxNLocator(integer=True))
    grid[-1, 0].set_xlabel(f"{over.replace('_', ' ').replace('poisson ', 'Poisson ')} ({along})")
    note = f"\nError bars not known, or too long for their panels: {hidden}." if hidden else ""
    note += "\nTriangle at the top: infinite, in full contact." if infinite else ""
    values = len(study.configuration["values"])
    note += f"\nNot finished: {len(study.runs)} of {values} values." if len(study.runs) < values else ""
    titles.put(figure, titles.scene(study.runs[0], {over}) + note)
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
    """A quantity over the runs as it is drawn, shape (M,), and its unit, or its divisor.

    name: of the quantity; stored: name of its column, by default the same.
    """
    values = study.column(stored or name).astype(np.float64)
    if unit(name) == "1":
        return values, "dimensionless"
    told = []
    for place, of in enumerate(unit(name).split("/")):
        scales = [shown_units(of_scene(run))[0 if of == "length" else 2] for run in study.runs]
        if not scales[0].unit and (name in _SCALES or sign(scales[0]) not in _SIGNS):
            return values, "in the scene's unit"
        values = values * np.array([scale.factor for scale in scales]) ** (-1 if place else 1)
        told.append(shown(scales[0].unit) or sign(scales[0]))
    return values, "over " * (told[0] in _SIGNS) + "/".join(told)


_SCALES = ("contact_modulus", "period")
_SIGNS = ("$E^*$", "$L$")


def _panel(axes: Axes, x: Array64, y: Array64, error: Array64 | None, joined: bool) -> int:
    """Draw a curve; returns how many of its error bars are left out: not known, or too long for the panel."""
    there, beyond, top = np.isfinite(y), x[np.isposinf(y)], axes.get_xaxis_transform()
    x_log, y_log = _logarithmic(x), _logarithmic(y[there])
    x, y, error = x[there], y[there], (np.zeros_like(y) if error is None else error)[there]
    span = float(np.ptp(y)) if y.size else 0.0
    most = 0.9 * y if y_log else np.full_like(y, span or np.inf)  # long error bars do not hide the curve
    seen = error < most
    error = np.where(seen, error, 0.0)
    if beyond.size:
        axes.plot(beyond, np.ones(beyond.size), "^", ms=4, color=COLOURS[0], transform=top, clip_on=False)
    line = "o" if not joined else "o-" if x.size < 100 else "-"
    axes.errorbar(x, y, yerr=error, fmt=line, ms=2.5, lw=0.9, color=COLOURS[0])
    if x_log:
        axes.set_xscale("log")
    if y_log:
        axes.set_yscale("log")
    elif span:
        low, high = float((y - error)[seen].min(initial=y.min())), float((y + error)[seen].max(initial=y.max()))
        axes.set_ylim(low - 0.1 * span, high + 0.1 * span)
    return int((~seen).sum())


def _make_room(axes: Axes, y: float) -> None:
    """Have a panel reach beyond a value, which may be NaN."""
    low, high = axes.get_ylim()
    if axes.get_yscale() == "log":
        axes.set_ylim(np.fmin(low, y / 1.1), np.fmax(high, 1.1 * y))
    else:
        axes.set_ylim(np.fmin(low, y - 0.1 * abs(high - y)), np.fmax(high, y + 0.1 * abs(y - low)))


def _logarithmic(values: Array64) -> bool:
    return bool(values.size and values.min() > 0 and values.max() >= _DECADE * values.min())
