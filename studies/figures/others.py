"""Figures of the studies of methods, and of single solutions."""

from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver import edges
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from .. import store
from .style import COLOURS, MARKERS, distinct, load


def iterations(path: Path) -> dict[str, Figure]:
    """Transform pairs, and seconds per point, over N for every method."""
    study = load(path)
    figure, panels = plt.subplots(2, 1, figsize=(5.2, 5.4), sharex=True)
    kinds = sorted(distinct((run["name"], run["method"]) for run in study.runs))
    for (name, method), colour, marker in zip(kinds, cycle(COLOURS), cycle(MARKERS), strict=False):
        runs = study.select("name", name).select("method", method)
        n, pairs = runs.column("scene.num_points"), runs.column("transform_pairs")
        label = f"{method}, {name}"
        panels[0].plot(n, pairs, marker + "-", ms=4.5, lw=0.9, color=colour, label=label)
        panels[1].plot(n, runs.column("seconds.solve") / n * 1e6, marker + "-", ms=4.5, lw=0.9, color=colour)
        if method == "fire":
            panels[0].plot(n, pairs[0] * np.sqrt(n / n[0]), "--", color=colour, lw=0.7, label=r"$\sqrt{N}$")
    panels[0].set(yscale="log", ylabel="transform pairs (dimensionless)")
    panels[0].set_title(f"Half-space, residual {study.configuration['tolerance']:g}")
    panels[0].legend(fontsize=7)
    panels[1].set(yscale="log", xlabel="grid points $N$", ylabel=r"solving time per point [$\mu$s]")
    panels[1].set_xscale("log", base=2)
    return {"": figure}


def edge_curve(path: Path) -> dict[str, Figure]:
    """The universal edge curve with the measured places, and their distance from it."""
    study = load(path)
    figure, panels = plt.subplots(2, 1, figsize=(5.2, 5.0), sharex=True)
    ratio = np.linspace(1e-3, edges.edge_curve().table[0] / edges.edge_curve().table[1], 200)
    pressures = np.stack([ratio, np.ones_like(ratio), np.ones_like(ratio)], axis=1)
    panels[0].plot(
        ratio, edges.edge_offset(edges.edge_curve(), pressures)[1], "k-", lw=0.9, label="closed form (Wiener-Hopf)"
    )
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


def solution(path: Path) -> dict[str, Figure]:
    """Profile, displaced surface and contact pressure over x; the contact region enlarged."""
    fields, attributes = store.load_solution(path)
    x, pressure = fields["x"], fields["contact_pressure"]
    figure, panels = plt.subplots(2, 1, figsize=(5.2, 4.6), sharex=True)
    panels[0].plot(x, fields["profile"], color="k", lw=0.9, label="indenter $h$")
    panels[0].plot(x, fields["displacement"], color=COLOURS[0], lw=0.9, label="surface $u$")
    panels[0].set(ylabel="height [length]", title=_title(attributes))
    panels[0].legend(fontsize=8)
    panels[1].plot(x, pressure, color=COLOURS[3], lw=0.9)
    panels[1].set(xlabel="$x$ [length]", ylabel="contact pressure [pressure]")
    touching = np.flatnonzero(pressure > 0)
    if touching.size:
        left, right = x[touching[0]], x[touching[-1]]
        margin = 0.5 * (right - left) + 4 * (x[1] - x[0])
        window = (max(x[0], left - margin), min(x[-1], right + margin))
        inside = (x >= window[0]) & (x <= window[1])
        heights = np.concatenate([fields["profile"][inside], fields["displacement"][inside]])
        room = 0.05 * float(np.ptp(heights)) or 1.0
        panels[0].set(xlim=window, ylim=(heights.min() - room, heights.max() + room))
    return {"": figure}


def _title(attributes: dict[str, Any]) -> str:
    thickness = float(attributes["scene.thickness"])
    return (
        f"d = {thickness:.4g} [length], nu = {attributes['scene.poisson_ratio']:g}, "
        f"a_r = {attributes['contact_area_subgrid']:.6g}, {attributes['status']}"
    )
