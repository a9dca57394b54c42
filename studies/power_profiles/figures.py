"""Figures of one power profile on layers of any thickness."""

from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver.layers.bonded import edge_shift, foundation_compliance
from linecontact.solver.reference import closed_forms
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..figures.style import COLOURS, MARKERS, ONE_COLUMN, NothingToDraw, distinct, legend_below, load, panels
from ..files.study_files import StudyFile
from . import report
from .tasks import FIGURES


def draw(path: Path) -> dict[str, Figure]:
    """kappa over the reduced thickness, and the errors against collocation."""
    study = load(path)
    return dict(zip(FIGURES, (ratio(study), accuracy(study)), strict=True))


def ratio(study: StudyFile) -> Figure:
    """The published Figures 2 to 4: (kappa_d/kappa_inf)/(d/a_r) over d/a_r with limits; below, kappa_d/kappa_inf."""
    figure, ((axes,), (below,)) = panels(2, 1, ONE_COLUMN, 5.6, sharex=True, height_ratios=(5, 3))
    runs, c = report.layers(study), study.configuration
    if not runs.runs:
        raise NothingToDraw("no layer is done yet")
    t_all, kappa_all = report.curve(runs)
    low, high = t_all.min() / 1.4, t_all.max() * 1.4
    y_all = kappa_all[kappa_all > 0] / t_all[kappa_all > 0]  # 0 for contacts of one node
    if not y_all.size:
        raise NothingToDraw("every contact is one node")
    for nu, colour, marker in zip(distinct(c["poisson_ratios"]), cycle(COLOURS), cycle(MARKERS), strict=False):
        own = runs.select("scene.poisson_ratio", nu)
        if not own.runs:
            continue
        t, kappa = report.curve(own)
        axes.plot(t, kappa / t, marker, ms=3.5, color=colour, label=rf"$\nu={nu:g}$")
        below.plot(t, kappa, marker, ms=3.5, color=colour)
        line = study.lines.get(f"nu={nu:g}")
        if line:
            axes.plot(line["reduced_thickness"], line["kappa_ratio"] / line["reduced_thickness"], color=colour, lw=0.9)
            below.plot(line["reduced_thickness"], line["kappa_ratio"], color=colour, lw=0.9)
        _limits(axes, c, nu, colour, low)
    _half_space(axes, below, study, high)
    axes.plot([], [], "k-", lw=0.9, label="collocation")
    axes.plot([], [], "k--", lw=0.7, label=r"first order, exact $\alpha$")
    axes.plot([], [], "k:", lw=0.9, label="second order")
    axes.plot([], [], "k-.", lw=0.5, label=rf"published $\alpha={c['published_alpha']:.4g}$")
    axes.set(
        xscale="log",
        yscale="log",
        xlim=(low, high),
        ylim=(y_all.min() / 1.6, y_all.max() * 2.2),
        ylabel=r"$(\kappa_d/\kappa_\infty)\,/\,(d/a_r)$ (dimensionless)",
        title="$n={exponent:g}$, $p={pressure:g}\\,E^*$, {num_points} points".format(**c),
    )
    label = r"reduced thickness $d/a_r$ ($L=1$, dimensionless)"
    below.set(xlabel=label, ylabel=r"$\kappa_d/\kappa_\infty$ (dimensionless)", ylim=(0, 1.1))
    legend_below(figure, axes, 2)
    return figure


def _limits(axes: Axes, configuration: dict[str, Any], poisson_ratio: float, colour: str, low: float) -> None:
    """The limits of thin layers to first and second order, and the published one."""
    nu, exponent = poisson_ratio, configuration["exponent"]
    grid = np.geomspace(low, 0.3, 50)
    for shift, style, width in ((0.0, "--", 0.7), (edge_shift(nu), ":", 0.9)):
        reach = grid[1 + 2 * shift * grid > 0.2]  # beyond, the expansion is none
        limit = [closed_forms.thin_layer_kappa_ratio(exponent, nu, s, shift) / s for s in reach]
        axes.plot(reach, limit, style, color=colour, lw=width)
    if nu < 0.5:
        published = configuration["published_alpha"] * foundation_compliance(nu)
        axes.plot(grid[[0, -1]], [published] * 2, "-.", color=colour, lw=0.5)


def _half_space(axes: Axes, below: Axes, study: StudyFile, high: float) -> None:
    """kappa_d = kappa_inf, and its part that images in neighbouring periods leave."""
    run = report.half_space(study)
    thick = np.geomspace(0.15, high, 20)
    axes.plot(thick, 1 / thick, "-", color="0.6", lw=0.7, label=r"half-space, $\kappa_d=\kappa_\infty$")
    below.axhline(1, color="0.6", lw=0.7)
    if run:
        with_images = run["oracle.kappa_ratio"]
        label = rf"with images, ${with_images:.4f}\,\kappa_\infty$"
        axes.plot(thick, with_images / thick, "--", color="0.3", lw=0.7, label=label)
        below.axhline(with_images, color="0.3", ls="--", lw=0.7)


def accuracy(study: StudyFile) -> Figure:
    """Errors of area (in grid spacings) and peak pressure against collocation, over d/a_r."""
    figure, grid = panels(3, 1, ONE_COLUMN, 5.6, sharex=True)
    rows = grid[:, 0]
    study = report.layers(study)
    t = study.column("reduced_thickness")
    points = study.configuration["num_points"]
    exact = study.column("oracle.contact_area")
    counted = (study.column("contact_area") - exact) * points
    subgrid = np.abs(study.column("contact_area_subgrid") - exact) * points
    peak = np.abs(study.column("peak_pressure") / study.column("oracle.peak_pressure") - 1)
    nus = study.column("scene.poisson_ratio")
    for nu, colour, marker in zip(sorted(distinct(nus.tolist())), cycle(COLOURS), cycle(MARKERS), strict=False):
        for panel, values in zip(rows, (counted, subgrid, peak), strict=True):
            panel.plot(t[nus == nu], values[nus == nu], marker, ms=3.5, color=colour, label=rf"$\nu={nu:g}$")
    rows[0].axhline(0, color="k", lw=0.6)
    rows[0].set(xscale="log", ylim=(-2, 2), ylabel="error of counted $a_r$\n[grid spacings]")
    rows[1].set(yscale="log", ylabel="|error of sub-grid $a_r$|\n[grid spacings]")
    rows[2].set(
        yscale="log",
        xlabel=r"reduced thickness $d/a_r$ ($L=1$, dimensionless)",
        ylabel="|error of peak pressure|\n(relative)",
    )
    legend_below(figure, rows[0], 3)
    return figure
