"""Figures of the area-pressure relation over the load."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from linecontact.solver.layers.bonded import edge_shift
from linecontact.solver.reference import closed_forms
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..figures.style import COLOURS, MARKERS, TWO_COLUMNS, NothingToDraw, layer, legend_below, load, panels
from ..files.study_files import StudyFile
from ..rough_surfaces.means import Mean
from .analysis import CONSTANT, Curve, Point, curves, parabola
from .tasks import FIGURES, line_name

_THIN = 0.2  # d/(a_r L) up to which the thin layer's second order is drawn


def draw(path: Path) -> dict[str, Figure]:
    """kappa of rough surfaces, its collapse over the reduced thickness, and kappa of power profiles."""
    study = load(path)
    every = [curve for curve in _shown(study) if curve.points]
    rough, smooth = [c for c in every if c.rough], [c for c in every if not c.rough]
    if not (rough and smooth):
        raise NothingToDraw("no rough surface, or no power profile, is done yet")
    return dict(zip(FIGURES, (kappa(study, rough), collapse(every), profiles(smooth)), strict=True))


def _shown(study: StudyFile) -> list[Curve]:
    """The half-space and the layers of the Poisson's ratio in the middle."""
    ratios = study.configuration["poisson_ratios"]
    middle = ratios[len(ratios) // 2]
    return [curve for curve in curves(study) if curve.is_half_space or curve.poisson_ratio == middle]


def _by_shape(every: Sequence[Curve]) -> dict[str, list[Curve]]:
    return {name: [c for c in every if c.name == name] for name in dict.fromkeys(c.name for c in every)}


def _over(axes: Axes, curve: Curve, x: str, y: str, number: int) -> None:
    """Draw two quantities of the points of a curve."""
    across, up = ([getattr(point, name) for point in curve.points] for name in (x, y))
    axes.errorbar(
        [value.value if isinstance(value, Mean) else value for value in across],
        [value.value for value in up],
        yerr=[value.error if np.isfinite(value.error) else 0 for value in up],
        fmt=f"{MARKERS[number % len(MARKERS)]}-",
        ms=3,
        lw=0.8,
        color=COLOURS[number % len(COLOURS)],
        label=layer(curve.thickness),
    )


def kappa(study: StudyFile, rough: Sequence[Curve]) -> Figure:
    """a_r/p* over the load: above with the gradient over the contact, below with that of the whole surface."""
    shapes = _by_shape(rough)
    figure, grid = panels(2, len(shapes), TWO_COLUMNS, 4.6, sharex=True, sharey="row")
    for column, (name, own) in enumerate(shapes.items()):
        above, below = grid[:, column]
        for i, curve in enumerate(own):
            _over(above, curve, "pressure", "kappa", i)
            _over(below, curve, "pressure", "kappa_surface", i)
            line = study.lines.get(line_name(curve.shape, curve.poisson_ratio, curve.thickness))
            if line:
                p = line["pressure"]
                below.plot(p, line["contact_area"] / p, "--", lw=0.7, color=COLOURS[i % len(COLOURS)])
            if curve.is_half_space and curve.constant:
                values = [point.kappa.value for point in curve.constant]
                above.axhspan(min(values), min(values) * (1 + CONSTANT), color="0.88", lw=0)
        above.set(title=f"${name}$", yscale="log", xscale="log")
        below.set(yscale="log", xlabel="$p/E^*$ (dimensionless)")
    grid[0, 0].set_ylabel("$\\kappa=a_r/p^*$, gradient\nover the contact (dimensionless)")
    grid[1, 0].set_ylabel("$a_r/p^*$, gradient of the\nwhole surface (dimensionless)")
    grid[0, 0].axhspan(np.nan, np.nan, color="0.88", label=f"within {100 * CONSTANT:g} %")
    grid[0, 0].plot([], [], "k--", lw=0.7, label="Persson's theory")
    legend_below(figure, grid[0, 0], 4)
    return figure


def collapse(every: Sequence[Curve]) -> Figure:
    """kappa_d over kappa_inf at the same load, over the thickness; one parabola beside every kind of roughness.

    Above the thickness is over the whole contact, below over the mean width of a patch.
    """
    shapes = _by_shape([curve for curve in every if curve.rough])
    figure, grid = panels(2, len(shapes), TWO_COLUMNS, 4.8, sharex=True, sharey=True)
    for row, x in zip(grid, ("reduced_thickness", "per_width"), strict=True):
        for axes, own in zip(row, shapes.values(), strict=True):
            for i, curve in enumerate(own):
                if not curve.is_half_space:
                    _over(axes, curve, x, "ratio", i)
            axes.plot(*parabola(every), "k-", lw=0.8, label="one parabola")
            axes.set(xscale="log", yscale="log")
    for axes, name in zip(grid[0], shapes, strict=True):
        axes.set(title=f"${name}$", xlabel="$d/a_r$ ($L=1$, dimensionless)")
    for axes in grid[1]:
        axes.set_xlabel("$d$ over the mean width\nof a patch (dimensionless)")
    for axes in grid[:, 0]:
        axes.set_ylabel("$\\kappa_d/\\kappa_\\infty$ at the same load\n(dimensionless)")
    legend_below(figure, grid[0, 0], 6)
    return figure


def profiles(smooth: Sequence[Curve]) -> Figure:
    """kappa over the lone asperity's on the half-space, over the load, with closed forms."""
    shapes = _by_shape(smooth)
    figure, grid = panels(1, len(shapes), TWO_COLUMNS, 2.9, sharey=True)
    for axes, (name, own) in zip(grid[0], shapes.items(), strict=True):
        for i, curve in enumerate(own):
            _over(axes, curve, "pressure", "ratio", i)
            exact = np.array([_closed_form(curve, point) for point in curve.points])
            p = np.array([point.pressure for point in curve.points])
            axes.plot(p, exact, "k:" if curve.is_half_space else "k--", lw=1.0, zorder=4)
        axes.set(title=f"${name}$", xscale="log", yscale="log", xlabel="$p/E^*$ (dimensionless)")
    grid[0, 0].plot([], [], "k:", lw=0.8, label="exact, periodic half-space")
    grid[0, 0].plot([], [], "k--", lw=0.8, label="thin layer, second order")
    grid[0, 0].set_ylabel(r"$\kappa/\kappa_\infty(n)$ (dimensionless)")
    legend_below(figure, grid[0, 0], 4)
    return figure


def _closed_form(curve: Curve, point: Point) -> float:
    """kappa/kappa_inf by closed forms; NaN where there is none."""
    if curve.is_half_space:
        return point.exact_kappa / closed_forms.kappa_half_space(curve.shape)
    thickness, nu = point.reduced_thickness.value, curve.poisson_ratio
    if thickness > _THIN:
        return np.nan
    return closed_forms.thin_layer_kappa_ratio(curve.shape, nu, thickness, edge_shift(nu))
