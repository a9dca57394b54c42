"""The figure of the edge curves: their closed forms with the measured places, and the distance from them."""

from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver.grid.layer_on_grid import layer_on_grid
from matplotlib.figure import Figure

from ..figures.style import COLOURS, MARKERS, ONE_COLUMN, legend_below, load, panels
from .scenes import by_scene, from_two, layer_of

_FINE = 2**20  # points of the grid on which the closed forms are drawn; only the thickness in spacings matters


def draw(path: Path) -> dict[str, Figure]:
    """The edge curves with the measured places, and their distance from them."""
    figure, grid = panels(2, 1, ONE_COLUMN, 6.2, sharex=True)
    above, below = grid[:, 0]
    drawn = set()
    scenes = by_scene(load(path))
    for i, scene in enumerate(scenes):
        colour = COLOURS[i % len(COLOURS)]
        marker = MARKERS[(i + i // len(COLOURS)) % len(MARKERS)]  # no pair twice
        exponent, kind, spacings, nu, base = scene
        curve = layer_on_grid(layer_of(kind, float(spacings) / _FINE, nu, base), _FINE, 1.0).edge_curve
        if curve.shift not in drawn:
            ratio = np.linspace(1e-3, curve.table[0] / curve.table[1], 200)
            above.plot(ratio, from_two(curve, ratio), "k-", lw=0.7, zorder=1)
        drawn.add(curve.shift)
        x, offset = (np.array([run[name] for run in scenes[scene]]) for name in ("ratio", "offset"))
        label = f"$n={exponent:g}$, {_layer(kind, spacings, nu, base)}"
        above.plot(x, offset, marker, ms=3.5, color=colour, label=label)
        for nodes, fill in (("two", "none"), ("three", colour)):
            error = np.abs(np.array([run[f"offset.{nodes}_nodes"] for run in scenes[scene]]) - offset)
            below.plot(x, error, marker, ms=3.5, color=colour, mfc=fill)
    above.set(ylabel="edge inside the last node\n[grid spacings]")
    above.plot([], [], "k-", lw=0.7, label="closed forms (Wiener-Hopf)")
    above.plot([], [], "ks", ms=3.5, mfc="none", label="below, hollow: from two nodes")
    above.plot([], [], "ks", ms=3.5, label="below, filled: from three nodes")
    legend_below(figure, above, 1)
    below.set(yscale="log", xlabel="ratio of the last two nodal pressures", ylabel="|error| [grid spacings]")
    return {"": figure}


def _layer(kind: str, spacings: Any, nu: float, base: float) -> str:
    if np.isinf(float(spacings)):
        return "half-space"
    thick = f"{kind}, $d={float(spacings):g}$ spacing{'' if float(spacings) == 1 else 's'}"
    return thick + {"sliding": "", "coated": f", base {base:g} $E^*$"}.get(kind, f", $\\nu={nu:g}$")
