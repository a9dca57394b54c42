"""The figure of the edge curve: its closed form with the measured places, and their distance from it."""

from itertools import cycle
from pathlib import Path

import numpy as np
from linecontact.solver.grid import edges
from linecontact.solver.grid.edge_curves import half_space_curve
from matplotlib.figure import Figure

from ..figures.style import COLOURS, MARKERS, ONE_COLUMN, distinct, layer, legend_below, load, panels


def draw(path: Path) -> dict[str, Figure]:
    """The universal edge curve with the measured places, and their distance from it."""
    study = load(path)
    figure, grid = panels(2, 1, ONE_COLUMN, 4.8, sharex=True)
    above, below = grid[:, 0]
    curve = half_space_curve()
    ratio = np.linspace(1e-3, curve.table[0] / curve.table[1], 200)
    pressures = np.stack([ratio, np.ones_like(ratio), np.ones_like(ratio)], axis=1)
    offset = edges.edge_offset(curve, pressures)[1]
    above.plot(ratio, offset, "k-", lw=0.9, label="closed form (Wiener-Hopf)")
    scenes = [tuple(run[f"scene.{n}"] for n in ("exponent", "thickness", "poisson_ratio")) for run in study.runs]
    for scene, colour, marker in zip(distinct(scenes), cycle(COLOURS), cycle(MARKERS), strict=False):
        chosen = np.array([s == scene for s in scenes])
        x, offset = study.column("ratio")[chosen], study.column("offset")[chosen]
        label = f"$n={scene[0]:g}$, {layer(float(scene[1]))}, $\\nu={scene[2]:g}$"
        above.plot(x, offset, marker, ms=3.5, color=colour, label=label)
        for nodes, fill in (("two", "none"), ("three", colour)):
            error = np.abs(study.column(f"offset.{nodes}_nodes")[chosen] - offset)
            below.plot(x, error, marker, ms=3.5, color=colour, mfc=fill)
    above.set(ylabel="edge inside the last node\n[grid spacings]")
    above.plot([], [], "ks", ms=3.5, mfc="none", label="below, hollow: from two nodes")
    above.plot([], [], "ks", ms=3.5, label="below, filled: from three nodes")
    legend_below(figure, above, 1)
    below.set(yscale="log", xlabel="ratio of the last two nodal pressures", ylabel="|error| [grid spacings]")
    return {"": figure}
