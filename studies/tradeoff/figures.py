"""Figures of the tradeoff: seconds over errors for every choice, with the Pareto fronts."""

import itertools
from pathlib import Path

from linecontact.solver import METHODS
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..figures.style import COLOURS, MARKERS, TWO_COLUMNS, NothingToDraw, load
from ..figures.style import panels as empty_panels
from ..files.study_files import StudyFile
from . import front, report
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
    return {ending: panels(study, what) for ending, what in front.FIGURES.items()}


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
    others = [entry("--accuracy", "X", COLOURS[3], "--"), entry("collocation oracle", "D", COLOURS[4], ":")]
    others += [
        entry(peer, marker, COLOURS[5], "-")
        for peer, marker in zip(study.configuration["peers"], itertools.cycle(_PEERS), strict=False)
    ]
    # columns of three or four
    return methods + best * area + precisions + best * (not area) + paper + kinds * area + others
