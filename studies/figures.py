"""Figures, always drawn from a stored file and put beside it as PNG and PDF."""

from itertools import cycle
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import numpy as np
from linecontact.solver import closed_forms, edges
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from . import store

_COLOURS = (
    "#0072b2",
    "#009e73",
    "#e69f00",
    "#d55e00",
    "#cc79a7",
    "#444444",
)  # Okabe and Ito: safe for colour-blind readers
_MARKERS = "os^Dv*"
_STYLE = {
    "font.size": 9,
    "axes.linewidth": 0.8,
    "axes.titlesize": 9,
    "legend.frameon": False,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "figure.subplot.left": 0.15,
    "figure.subplot.right": 0.97,
    "figure.subplot.bottom": 0.13,
    "figure.subplot.top": 0.92,
    "savefig.dpi": 180,
}


def draw(path: Path) -> list[Path]:
    """Draw everything that a stored file has figures for; returns the files. Raises `store.StoreError`."""
    kind = store.file_kind(path)
    if kind not in _DRAWINGS:
        raise store.StoreError(f"file {path} is of kind {kind!r}; allowed: {', '.join(_DRAWINGS)}")
    files = []
    with plt.rc_context(_STYLE):
        for suffix, figure in _DRAWINGS[kind](path).items():
            for extension in ("png", "pdf"):
                file = path.with_name(f"{path.stem}{suffix}.{extension}")
                try:
                    figure.savefig(file)
                except OSError as error:
                    raise store.StoreError(f"figure {file} could not be written: {error}") from error
                files.append(file)
            plt.close(figure)
    return files


def _hertz(path: Path) -> dict[str, Figure]:
    study = store.load_study(path)
    if not study.runs:
        raise store.StoreError(f"file {path} holds no finished run yet")
    return {"": _hertz_ratio(study), "-accuracy": _hertz_accuracy(study)}


def _hertz_ratio(study: store.StudyFile) -> Figure:
    """The published Figure 2: (kappa_d/kappa_inf)/(d/a_r) over d/a_r, asymptotes, oracle."""
    figure: Figure
    figure, axes = plt.subplots(figsize=(5.2, 4.0))
    ratios = sorted(set(study.column("scene.poisson_ratio")))
    t_all = study.column("reduced_thickness")
    low, high = t_all.min() / 1.4, t_all.max() * 1.4
    y_all = study.column("kappa_ratio") / t_all
    for nu, colour, marker in zip(ratios, cycle(_COLOURS), cycle(_MARKERS), strict=False):
        runs = study.select("scene.poisson_ratio", nu)
        t = runs.column("reduced_thickness")
        line = study.lines.get(f"nu={nu:g}")
        if line:
            axes.plot(line["reduced_thickness"], line["kappa_ratio"] / line["reduced_thickness"], color=colour, lw=0.9)
        grid = np.geomspace(low, 0.5, 50)
        limit = np.array([closed_forms.thin_layer_kappa_ratio(2.0, nu, s) / s for s in grid])
        axes.plot(grid, limit, "--", color=colour, lw=0.7)
        axes.plot(t, runs.column("kappa_ratio") / t, marker, ms=4.5, color=colour, label=rf"$\nu={nu:g}$")
    thick = np.geomspace(0.15, high, 20)
    axes.plot(thick, 1 / thick, "k:", lw=0.9)
    axes.plot([], [], "k-", lw=0.9, label="collocation oracle")
    axes.plot([], [], "k--", lw=0.7, label=r"thin layer, $d/a_r\to0$")
    axes.plot([], [], "k:", lw=0.9, label=r"half-space, $\kappa_d=\kappa_\infty$")
    axes.set(
        xscale="log",
        yscale="log",
        xlim=(low, high),
        ylim=(y_all.min() / 1.6, y_all.max() * 2.2),
        xlabel=r"reduced thickness $d/a_r$ ($L=1$, dimensionless)",
        ylabel=r"$(\kappa_d/\kappa_\infty)\,/\,(d/a_r)$ (dimensionless)",
        title="Hertz, $n=2$, $p={pressure:g}\\,E^*$, {num_points} points".format(**study.configuration),
    )
    axes.legend(fontsize=7, ncols=2, loc="lower center")
    return figure


def _hertz_accuracy(study: store.StudyFile) -> Figure:
    """Errors of area (in grid spacings) and peak pressure against the oracle, over d/a_r."""
    figure: Figure
    figure, panels = plt.subplots(3, 1, figsize=(5.2, 6.2), sharex=True)
    figure.subplots_adjust(bottom=0.08, top=0.97)
    t = study.column("reduced_thickness")
    points = study.configuration["num_points"]
    exact = study.column("oracle.contact_area")
    counted = (study.column("contact_area") - exact) * points
    subgrid = np.abs(study.column("contact_area_subgrid") - exact) * points
    peak = np.abs(study.column("peak_pressure") / study.column("oracle.peak_pressure") - 1)
    nus = study.column("scene.poisson_ratio")
    for nu, colour, marker in zip(sorted(set(nus)), cycle(_COLOURS), cycle(_MARKERS), strict=False):
        for panel, values in zip(panels, (counted, subgrid, peak), strict=True):
            panel.plot(t[nus == nu], values[nus == nu], marker, ms=4.5, color=colour, label=rf"$\nu={nu:g}$")
    panels[0].axhline(0, color="k", lw=0.6)
    panels[0].set(xscale="log", ylim=(-2, 2), ylabel="counted $a_r$ minus oracle\n[grid spacings]")
    panels[0].legend(fontsize=7, ncols=6, loc="upper center", columnspacing=1, handletextpad=0.2)
    panels[1].set(yscale="log", ylabel="|sub-grid $a_r$ minus oracle|\n[grid spacings]")
    panels[2].set(
        yscale="log",
        xlabel=r"reduced thickness $d/a_r$ ($L=1$, dimensionless)",
        ylabel="|peak pressure error|\n(relative)",
    )
    return figure


def _iterations(path: Path) -> dict[str, Figure]:
    """Transform pairs, and seconds per point, over N for every method."""
    study = store.load_study(path)
    if not study.runs:
        raise store.StoreError(f"file {path} holds no finished run yet")
    figure, panels = plt.subplots(2, 1, figsize=(5.2, 5.4), sharex=True)
    kinds = sorted(set(zip(study.column("name").tolist(), study.column("method").tolist(), strict=True)))
    for (name, method), colour, marker in zip(kinds, cycle(_COLOURS), cycle(_MARKERS), strict=False):
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


def _edge_curve(path: Path) -> dict[str, Figure]:
    """The universal edge curve with the measured places, and their distance from it."""
    study = store.load_study(path)
    figure, panels = plt.subplots(2, 1, figsize=(5.2, 5.0), sharex=True)
    ratio = np.linspace(1e-3, edges.edge_curve().table[0] / edges.edge_curve().table[1], 200)
    pressures = np.stack([ratio, np.ones_like(ratio), np.ones_like(ratio)], axis=1)
    panels[0].plot(ratio, edges.edge_offset(pressures)[1], "k-", lw=0.9, label="closed form (Wiener-Hopf)")
    scenes = [tuple(run[f"scene.{n}"] for n in ("exponent", "thickness", "poisson_ratio")) for run in study.runs]
    for scene, colour, marker in zip(dict.fromkeys(scenes), cycle(_COLOURS), cycle(_MARKERS), strict=False):
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


def _solution(path: Path) -> dict[str, Figure]:
    """Profile, displaced surface and contact pressure over x; the contact region enlarged."""
    fields, attributes = store.load_solution(path)
    x, pressure = fields["x"], fields["contact_pressure"]
    figure, panels = plt.subplots(2, 1, figsize=(5.2, 4.6), sharex=True)
    panels[0].plot(x, fields["profile"], color="k", lw=0.9, label="indenter $h$")
    panels[0].plot(x, fields["displacement"], color=_COLOURS[0], lw=0.9, label="surface $u$")
    panels[0].set(ylabel="height [length]", title=_title(attributes))
    panels[0].legend(fontsize=8)
    panels[1].plot(x, pressure, color=_COLOURS[3], lw=0.9)
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


_DRAWINGS = {"hertz": _hertz, "iterations": _iterations, "edge-curve": _edge_curve, "solution": _solution}
