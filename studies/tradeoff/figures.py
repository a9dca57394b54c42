"""Figures of the tradeoff: seconds over errors for every choice, with the Pareto fronts."""

import itertools
import math
from pathlib import Path

import numpy as np
from linecontact.solver import METHODS
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..figures.style import COLOURS, MARKERS, TWO_COLUMNS, NothingToDraw, load
from ..figures.style import panels as empty_panels
from ..files.study_files import StudyFile
from . import front, report
from .ensembles import ALONE, ENSEMBLES, MANY
from .families import FAMILIES

_METHODS = dict(zip(METHODS, itertools.cycle(MARKERS), strict=False))
_PRECISIONS = {"float64": COLOURS[0], "mixed": COLOURS[1], "float32": COLOURS[2]}
_PEERS = "Pv"
_LEAST = 1e-14  # errors below are drawn there


def draw(path: Path) -> dict[str, Figure]:
    """Errors of the contact area, and of the pressure field."""
    study = load(path)
    if not front.runs_of(study, "choice"):
        raise NothingToDraw(f"file {path} holds no choice yet")
    drawn = {ending: panels(study, what) for ending, what in front.FIGURES.items()}
    return drawn | {front.ENSEMBLES_FIGURE: ensembles(study)}


def panels(study: StudyFile, what: str) -> Figure:
    """A panel for each family. what: one of `front.FRONTS`."""
    figure, grid = empty_panels(2, 2, TWO_COLUMNS, 6.8, sharey=True)
    for axes, family in zip(grid.flat, FAMILIES, strict=True):
        _panel(axes, study, family, what)
        axes.set(xscale="log", yscale="log", title=family)
        axes.invert_xaxis()
        axes.minorticks_off()
        axes.grid(color="0.92", lw=0.5)
    noun = "$a_r$" if what == "a_r" else "the pressure, rms"
    for axes in grid[1]:
        axes.set_xlabel(f"relative error of {noun}\n(dimensionless; right is better)")
    for axes in grid[:, 0]:
        axes.set_ylabel("seconds in all [s]")
    figure.legend(handles=_legend(study, what), loc="outside lower center", ncols=4)
    return figure


def ensembles(study: StudyFile) -> Figure:
    """A panel for each ensemble, and one for the estimated errors of single scenes."""
    figure, grid = empty_panels(2, 2, TWO_COLUMNS, 6.4)
    for axes, family in zip(grid.flat, ENSEMBLES, strict=False):
        _ensemble(axes, study, family)
    _estimates(grid[1, 1], study)
    shown: dict[str, Line2D] = {}
    for panel in grid.flat:
        shown |= {label: handle for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)}
    figure.legend(shown.values(), shown, loc="outside lower center", ncols=3)
    return figure


def _ensemble(axes: Axes, study: StudyFile, family: str) -> None:
    """Relative standard errors over seconds: plain sampling on each grid, and the rounds of a multilevel ensemble."""
    rounds, alone = (front.runs_of(study, kind, family) for kind in (MANY, ALONE))
    axes.set(title=family, xscale="log", yscale="log", xlabel="time of solving [s]")
    axes.set_ylabel("standard error of $\\kappa$, relative\n(dotted: bias)")
    if not rounds:
        return
    mean, spent = rounds[-1]["mean"], rounds[-1]["seconds.total"]
    seconds = np.geomspace(spent / 20, spent * 20, 40)
    for run, colour in zip(alone, itertools.cycle(COLOURS), strict=False):
        size = f"2^{{{math.log2(run['scene.num_points']):.0f}}}"
        error = run["std"] / mean * np.sqrt(run["seconds.total"] / seconds)
        axes.plot(seconds, error, color=colour, lw=0.8, label=f"plain sampling, ${size}$ points")
        if run["bias"] > 0:
            axes.axhline(run["bias"] / mean, color=colour, ls=":", lw=0.8)
    x, y = ([run[name] for run in rounds] for name in ("seconds.total", "standard_error"))
    axes.plot(x, np.array(y) / mean, "k*-", ms=7, lw=0.8, label="multilevel")
    axes.set_ylim(0.3 * min(y) / mean, 3 * max(y) / mean)


def _estimates(axes: Axes, study: StudyFile) -> None:
    """How many of the random scenes' estimated errors are at most so many times the true one."""
    solved = [run for run in front.runs_of(study, "scene") if "claimed.former" in run and run["error.area"] > 0]
    for name, label, style in (
        ("claimed", "now", "k-"),
        ("claimed.former", "by the rule of 0.1.0", "k--"),
    ):
        ratio = np.sort([run[name] / run["error.area"] for run in solved])
        axes.step(ratio, np.arange(1, ratio.size + 1) / max(1, ratio.size), style, lw=1.0, label=label)
    axes.axvline(1, color="0.6", lw=0.6)
    axes.set(xscale="log", xlim=(0.1, 1e5), title="estimated errors of single scenes")
    axes.set(xlabel="estimated error over true error of $a_r$", ylabel="share of the random scenes")


def _panel(axes: Axes, study: StudyFile, family: str, what: str) -> None:
    found = front.points(front.runs_of(study, "choice", family), what)
    for method, precision, counted in itertools.product(_METHODS, _PRECISIONS, (True, False)):
        kind = method, precision, counted
        own = [p for p in found if (p.run["method"], p.run["precision"], p.counted) == kind]
        colour = _PRECISIONS[precision]
        x, y, face = [_x(p) for p in own], [p.seconds for p in own], "none" if counted else colour
        axes.plot(x, y, _METHODS[method], ms=3, mec=colour, mfc=face, mew=0.7, alpha=0.6, zorder=2)
    _line(axes, front.front(found), "-", "k", 1.6)
    others = {"oracle": (":", COLOURS[4], "D"), "accuracy": ("--", COLOURS[3], "X")}
    for name, (style, colour, marker) in others.items():
        own = [p for p in front.points(front.runs_of(study, name, family), what) if not p.counted]
        _line(axes, sorted(own, key=lambda p: -p.error), style, colour, 0.9, marker)
    for peer, marker in zip(study.configuration["peers"], itertools.cycle(_PEERS), strict=False):
        own = [p for p in front.points(front.runs_of(study, "peer", family), what) if p.run["method"] == peer]
        _line(axes, own, "-", COLOURS[5], 0.7, marker)
    paper = report.paper_choice(study, family)
    for p in front.points([paper] if paper else [], what):
        if p.counted or what != "a_r":
            axes.plot(_x(p), p.seconds, "*", ms=15, color=COLOURS[3], mec="k", mew=0.8, zorder=6)


def _x(point: front.Point) -> float:
    return max(point.error, _LEAST)


def _line(axes: Axes, found: list[front.Point], style: str, colour: str, width: float, marker: str = "") -> None:
    x, y = [_x(p) for p in found], [p.seconds for p in found]
    axes.plot(x, y, style, marker=marker, ms=5, color=colour, lw=width, zorder=4, mec="w" if marker else None, mew=0.5)


def _legend(study: StudyFile, what: str) -> list[Line2D]:
    def entry(label: str, marker: str, colour: str, style: str = "", **more: object) -> Line2D:
        return Line2D([], [], marker=marker, color=colour, ls=style, label=label, **more)  # type: ignore[arg-type]

    size, area = study.configuration["paper"], what == "a_r"
    methods = [entry(METHODS[name].label, marker, "0.5") for name, marker in _METHODS.items()]
    precisions = [entry(name, "o", colour) for name, colour in _PRECISIONS.items()]
    best = [entry("front of all these", "", "k", "-")]
    paper = [entry(f"the published choice: plain FIRE, $2^{{{size}}}$", "*", COLOURS[3], ms=12, mec="k")]
    kinds = [entry("filled: sub-grid edges", "o", "0.3"), entry("hollow: nodes counted", "o", "0.3", mfc="none")]
    others = [entry("--accuracy", "X", COLOURS[3], "--"), entry("collocation", "D", COLOURS[4], ":")]
    others += [
        entry(peer, marker, COLOURS[5], "-")
        for peer, marker in zip(study.configuration["peers"], itertools.cycle(_PEERS), strict=False)
    ]
    # columns of three or four
    return methods + best * area + precisions + best * (not area) + paper + kinds * area + others
