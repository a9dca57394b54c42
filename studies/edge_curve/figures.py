"""The figure of the edge curve: its closed form with the measured places, and their distance from it."""

from itertools import cycle
from pathlib import Path

import numpy as np
from linecontact.solver.grid import edges
from linecontact.solver.grid.edge_curves import half_space_curve
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from ..figures.style import COLOURS, MARKERS, distinct, load


def draw(path: Path) -> dict[str, Figure]:
    """The universal edge curve with the measured places, and their distance from it."""
    study = load(path)
    figure, panels = plt.subplots(2, 1, figsize=(5.2, 5.0), sharex=True)
    curve = half_space_curve()
    ratio = np.linspace(1e-3, curve.table[0] / curve.table[1], 200)
    pressures = np.stack([ratio, np.ones_like(ratio), np.ones_like(ratio)], axis=1)
    offset = edges.edge_offset(curve, pressures)[1]
    panels[0].plot(ratio, offset, "k-", lw=0.9, label="closed form (Wiener-Hopf)")
    scenes = [tuple(run[f"scene.{n}"] for n in ("exponent", "thickness", "poisson_ratio")) for run in study.runs]
    for scene, colour, marker in zip(distinct(scenes), cycle(COLOURS), cycle(MARKERS), strict=False):
        chosen = np.array([s == scene for s in scenes])
        x, offset = study.column("ratio")[chosen], study.column("offset")[chosen]
        label = f"$n={scene[0]:g}$, $d/L={float(scene[1]):g}$, $\\nu={scene[2]:g}$"
        panels[0].plot(x, offset, marker, ms=4, color=colour, label=label)
        for nodes, fill in (("two", "none"), ("three", colour)):
            error = np.abs(study.column(f"offset.{nodes}_nodes")[chosen] - offset)
            panels[1].plot(x, error, marker, ms=4, color=colour, mfc=fill)
    panels[0].set(ylabel="edge inside the last node\n[grid spacings]")
    panels[0].legend(fontsize=7)
    panels[1].plot([], [], "ks", ms=4, mfc="none", label="from two nodes")
    panels[1].plot([], [], "ks", ms=4, label="from three nodes")
    panels[1].legend(fontsize=7)
    panels[1].set(yscale="log", xlabel="ratio of the last two nodal pressures", ylabel="|error| [grid spacings]")
    return {"": figure}
