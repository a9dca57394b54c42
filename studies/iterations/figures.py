"""The figure of the iterations: transform pairs and seconds per point over N."""

from itertools import cycle
from pathlib import Path

import numpy as np
from linecontact.solver import METHODS
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from ..figures.style import COLOURS, MARKERS, distinct, load


def draw(path: Path) -> dict[str, Figure]:
    """Transform pairs, and seconds per point, over N for every method."""
    study = load(path)
    figure, panels = plt.subplots(2, 1, figsize=(5.2, 5.4), sharex=True)
    kinds = sorted(distinct((run["name"], run["method"]) for run in study.runs))
    for (name, method), colour, marker in zip(kinds, cycle(COLOURS), cycle(MARKERS), strict=False):
        runs = study.select("name", name).select("method", method)
        n, pairs = runs.column("scene.num_points"), runs.column("transform_pairs")
        kind = METHODS.get(method)  # None for one that a stored file still has
        label = f"{kind.label if kind else method}, {name}"
        panels[0].plot(n, pairs, marker + "-", ms=4.5, lw=0.9, color=colour, label=label)
        panels[1].plot(n, runs.column("seconds.solve") / n * 1e6, marker + "-", ms=4.5, lw=0.9, color=colour)
        if kind and kind.grows:
            panels[0].plot(n, pairs[0] * np.sqrt(n / n[0]), "--", color=colour, lw=0.7, label=r"$\sqrt{N}$")
    panels[0].set(yscale="log", ylabel="transform pairs (dimensionless)", ylim=(1, 1e5))
    panels[0].set_title(f"Half-space, residual {study.configuration['tolerance']:g}")
    panels[0].legend(fontsize=7, ncols=2, loc="upper right")
    panels[1].set(yscale="log", xlabel="grid points $N$", ylabel=r"solving time per point [$\mu$s]")
    panels[1].set_xscale("log", base=2)
    return {"": figure}
