"""Figures of randomly rough surfaces on layers of any thickness: means over realisations with their standard error."""

from itertools import cycle
from pathlib import Path

import numpy as np
from linecontact.solver.layers.bonded import foundation_compliance
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..figures.style import COLOURS, MARKERS, TWO_COLUMNS, NothingToDraw, distinct, legend_below, load, panels
from ..files.study_files import StudyFile
from . import ensembles, means
from .tasks import FIGURES


def draw(path: Path) -> dict[str, Figure]:
    """The published Figure 5, the share of the patches in it, and the bias of counting nodes."""
    study = load(path)
    if ensembles.is_one(study):
        found = ensembles.states(study)
        known = {hurst: ensembles.kappa_inf(found, hurst) for hurst in study.configuration["hursts"]}
        return {"": ratio(study, list(ensembles.points(found)), {h: k.mean for h, k in known.items() if k})}
    kappas = {h: float(np.mean(list(means.half_space(study, h).values()))) for h in study.configuration["hursts"]}
    return dict(zip(FIGURES, (ratio(study, _points(study), kappas), patches(study), bias(study)), strict=True))


def _panels(study: StudyFile, rows: int) -> tuple[Figure, list[list[Axes]], list[float]]:
    """Rows of panels, one column for each Hurst exponent."""
    hursts = distinct(study.configuration["hursts"])
    figure, grid = panels(rows, len(hursts), TWO_COLUMNS, 0.9 + 2.2 * rows, sharex=True, sharey="row")
    for column, hurst in enumerate(hursts):
        grid[0, column].set_title(f"$H={hurst:g}$")
        grid[-1, column].set(xscale="log", xlabel=r"$d/a_r$ ($L=1$, dimensionless)")
    return figure, grid.tolist(), hursts


def _plot(axes: Axes, points: list[means.Point], x: str, y: str, colour: str, marker: str, label: str) -> None:
    horizontal, vertical = ([getattr(p, name) for p in points] for name in (x, y))
    axes.errorbar(
        [m.value for m in horizontal],
        [m.value for m in vertical],
        xerr=[m.error for m in horizontal],
        yerr=[m.error for m in vertical],
        fmt=marker,
        ms=3,
        lw=0.8,
        color=colour,
        label=label,
    )


def _points(study: StudyFile) -> list[means.Point]:
    points = list(means.points(study))
    if not points:
        raise NothingToDraw("no surface is done both on a layer and on the half-space yet")
    return points


def ratio(study: StudyFile, points: list[means.Point], kappas: dict[float, float]) -> Figure:
    """(kappa_d/kappa_inf)/(d/a_r) over d/a_r with its limits and Persson's prediction; kappas: kappa_inf by H."""
    if not points:
        raise NothingToDraw("no mean is known both on a layer and on the half-space yet")
    figure, rows, hursts = _panels(study, 1)
    x = np.array([p.reduced_thickness.value for p in points])
    for axes, hurst in zip(rows[0], hursts, strict=True):
        kappa = kappas.get(hurst, means.PUBLISHED_KAPPA)
        for nu, colour, marker in zip(
            study.configuration["poisson_ratios"], cycle(COLOURS), cycle(MARKERS), strict=False
        ):
            own = [p for p in points if (p.hurst, p.poisson_ratio) == (hurst, nu)]
            _plot(axes, own, "reduced_thickness", "slope", colour, marker, rf"$\nu={nu:g}$")
            thin = np.array([x.min() / 1.5, 0.05])
            axes.plot(thin, np.full(2, means.single_patch(nu, kappa)), "--", color=colour, lw=0.8)
            published = means.PUBLISHED_ALPHA * foundation_compliance(nu)
            axes.plot(thin, np.full(2, published), "-.", color=colour, lw=0.6)
            line = study.lines.get(f"persson H={hurst:g} nu={nu:g}")
            if line:
                t = line["reduced_thickness"]
                axes.plot(t, line["kappa_ratio"] / t, "-", color=colour, lw=0.6, alpha=0.7)
        thick = np.geomspace(0.1, x.max() * 1.5, 20)
        axes.plot(thick, 1 / thick, "k:", lw=0.9)
        y = [p.slope.value for p in points]
        axes.set(yscale="log", xlim=(x.min() / 1.5, x.max() * 1.5), ylim=(min(y) / 2, max(y) * 2))
    axes = rows[0][0]
    axes.plot([], [], "k--", lw=0.8, label=r"one patch, $2\sqrt{3}(1-2\nu)/(1-\nu)^2/\kappa_\infty$")
    axes.plot([], [], "k-.", lw=0.6, label=r"published, $(2\pi/3)(1-2\nu)/(1-\nu)^2$")
    axes.plot([], [], "k-", lw=0.6, alpha=0.7, label="Persson's theory")
    axes.plot([], [], "k:", lw=0.9, label=r"half-space, $\kappa_d=\kappa_\infty$")
    axes.set(ylabel=r"$(\kappa_d/\kappa_\infty)\,/\,(d/a_r)$ (dimensionless)")
    legend_below(figure, axes, 4)
    return figure


def patches(study: StudyFile) -> Figure:
    """kappa_d/(d/a_r) over the number of patches, on the value of one patch, and that number."""
    figure, rows, hursts = _panels(study, 2)
    points = _points(study)
    for row in rows:
        for axes in row:
            axes.set(xlabel="" if row is rows[0] else "$d$ over patch width,\n$M\\,d/a_r$ (dimensionless)")
    for column, hurst in enumerate(hursts):
        for nu, colour, marker in zip(
            study.configuration["poisson_ratios"], cycle(COLOURS), cycle(MARKERS), strict=False
        ):
            own = [p for p in points if (p.hurst, p.poisson_ratio) == (hurst, nu)]
            for row, name in zip(rows, ("per_patch", "patches"), strict=True):
                _plot(row[column], own, "per_width", name, colour, marker, rf"$\nu={nu:g}$")
        rows[0][column].axhline(2 * np.sqrt(3), color="k", ls="--", lw=0.8, label=r"one patch, $2\sqrt{3}$")
        for row in rows:
            row[column].set(yscale="log")
    rows[0][0].set(ylabel="$\\kappa_d\\,/\\,(d/a_r)\\,/\\,M\\cdot(1-\\nu)^2/(1-2\\nu)$\n(dimensionless)")
    rows[1][0].set(ylabel="contact patches $M$ (dimensionless)")
    legend_below(figure, rows[0][0], 5)
    return figure


def bias(study: StudyFile) -> Figure:
    """The bias of counting nodes in the area."""
    figure, rows, hursts = _panels(study, 1)
    points = _points(study)
    for axes, hurst in zip(rows[0], hursts, strict=True):
        for nu, colour, marker in zip(
            study.configuration["poisson_ratios"], cycle(COLOURS), cycle(MARKERS), strict=False
        ):
            own = [p for p in points if (p.hurst, p.poisson_ratio) == (hurst, nu)]
            _plot(axes, own, "reduced_thickness", "bias", colour, marker, rf"$\nu={nu:g}$")
        axes.axhline(1, color="k", lw=0.6)
    rows[0][0].set(ylabel="$a_r$ counted over\n$a_r$ between sub-grid edges")
    legend_below(figure, rows[0][0], 5)
    return figure
