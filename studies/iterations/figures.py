"""The figure of the iterations: transform pairs and seconds per point over N."""

from itertools import cycle
from pathlib import Path

import numpy as np
from linecontact.solver import METHODS
from matplotlib.figure import Figure

from ..figures.style import COLOURS, MARKERS, ONE_COLUMN, distinct, legend_below, load, panels, typeset


def draw(path: Path) -> dict[str, Figure]:
    """Transform pairs, and seconds per point, over N for every method."""
    study = load(path)
    figure, grid = panels(2, 1, ONE_COLUMN, 4.6, sharex=True)
    above, below = grid[:, 0]
    kinds = sorted(distinct((run["name"], run["method"]) for run in study.runs))
    for (name, method), colour, marker in zip(kinds, cycle(COLOURS), cycle(MARKERS), strict=False):
        runs = study.select("name", name).select("method", method)
        n, pairs = runs.column("scene.num_points"), runs.column("transform_pairs")
        kind = METHODS.get(method)  # None for one that a stored file still has
        label = f"{kind.label if kind else method}, {name}"
        above.plot(n, pairs, marker + "-", ms=3.5, lw=0.9, color=colour, label=label)
        below.plot(n, runs.column("seconds.solve") / n * 1e6, marker + "-", ms=3.5, lw=0.9, color=colour)
        if kind and kind.grows:
            above.plot(n, pairs[0] * np.sqrt(n / n[0]), "--", color=colour, lw=0.7, label=r"$\sqrt{N}$")
    above.set(yscale="log", ylabel="transform pairs (dimensionless)", ylim=(1, 1e5))
    above.set_title(f"Half-space, residual ${typeset(study.configuration['tolerance'])}$")
    legend_below(figure, above, 2)
    below.set(yscale="log", xlabel="grid points $N$", ylabel=r"solving time per point [$\mu$s]")
    below.set_xscale("log", base=2)
    return {"": figure}
