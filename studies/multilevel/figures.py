"""The figure of an ensemble: scatter and change over the grids, and the error over the time."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..figures import titles
from ..figures.style import COLOURS, MARKERS, TWO_COLUMNS, NothingToDraw, load, panels
from .estimator import Estimate, differences, term
from .samples import FOUNDATION, Samples, unit_of
from .tasks import found


def draw(path: Path) -> dict[str, Figure]:
    """A row of two panels for each observable whose values differ from surface to surface."""
    study = load(path)
    estimates = found(study)[1].estimates
    if not estimates:
        raise NothingToDraw("too few surfaces are solved on all grids yet")
    shown = {observable: estimate for observable, estimate in estimates.items() if estimate.standard_error > 0}
    if not shown:
        raise NothingToDraw("all surfaces have the same value")
    spent = float(sum(study.column("seconds.total")))
    figure, rows = panels(len(shown), 2, TWO_COLUMNS, 3.4 * len(shown))
    for (left, right), (observable, estimate) in zip(rows, shown.items(), strict=True):
        samples = Samples(study.runs, observable)
        _scatter(left, observable, samples)
        _errors(right, observable, estimate, samples, spent)
    numbers = {f"scene.{name}": value for name, value in study.configuration.get("numbers", {}).items()}
    if numbers:  # not in older files
        finest = max(int(points) for points in study.column("num_points"))
        titles.put(figure, f"{titles.scene(numbers, {'num_points'})}, up to {finest} points")
    return {"": figure}


def _scatter(axes: Axes, observable: str, samples: Samples) -> None:
    sizes = sorted(samples.values.keys() - {FOUNDATION})
    pairs = [(fine, coarse) for coarse, fine in pairwise(sizes) if samples.seeds(coarse, fine)]
    alone = [np.std(list(differences(samples, size, None).values()), ddof=1) for size in sizes]
    axes.plot(sizes, alone, f"{MARKERS[0]}-", ms=3.5, lw=0.8, color=COLOURS[0], label="std of one surface")
    changes = [term(samples, *pair) for pair in pairs]
    finer = [change.num_points for change in changes]
    lines = {
        "std of its change from the grid before": [math.sqrt(change.variance) for change in changes],
        "mean of that change, absolute": [abs(change.mean) for change in changes],
    }
    for i, (label, values) in enumerate(lines.items(), start=1):
        axes.plot(finer, values, f"{MARKERS[i]}-", ms=3.5, lw=0.8, color=COLOURS[i], label=label)
    if FOUNDATION in samples.values:
        _foundation(axes, samples, sizes)
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="grid points (dimensionless)",
        ylabel=f"{observable}: scatter and change\n({unit_of(observable)})",
    )
    axes.set_xscale("log", base=2)
    _legend(axes)


def _foundation(axes: Axes, samples: Samples, sizes: list[int]) -> None:
    """The scatter on the foundation, which has no grid points, and of the change from it to each grid."""
    alone = float(np.std(list(samples.values[FOUNDATION].values()), ddof=1))
    axes.axhline(alone, ls="--", lw=0.8, color=COLOURS[3], label="std on the foundation, times its factor")
    shared = [size for size in sizes if len(samples.seeds(size, FOUNDATION)) > 1]
    change = [math.sqrt(term(samples, size, FOUNDATION).variance) for size in shared]
    label = "std of the change from there to a grid"
    axes.plot(shared, change, f"{MARKERS[3]}-", ms=3.5, lw=0.8, color=COLOURS[3], label=label)


def _legend(axes: Axes) -> None:
    """Below the panel, where it hides nothing."""
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2))


def _errors(axes: Axes, observable: str, estimate: Estimate, samples: Samples, spent: float) -> None:
    finest = estimate.terms[-1].num_points
    seconds = np.geomspace(spent / 30, spent * 30, 30)
    for i, size in enumerate(sorted({t.num_points for t in estimate.terms} - {FOUNDATION})):
        alone = term(samples, size, None)
        error = np.sqrt(alone.variance * samples.seconds(size) / seconds)
        axes.plot(seconds, error, lw=0.8, color=COLOURS[i % len(COLOURS)], label=f"{size} points alone")
    axes.plot(spent, estimate.standard_error, "k*", ms=8, label=f"this ensemble, up to {finest} points")
    if estimate.bias > 0:
        axes.axhline(estimate.bias, color="0.6", ls=":", lw=0.8, label="bias of the finest grid, about")
    axes.set(xscale="log", yscale="log", xlabel="time of solving [s]")
    axes.set_ylabel(f"standard error of {observable}\n({unit_of(observable)})")
    _legend(axes)
