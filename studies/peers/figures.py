"""Figure of the comparison with the nearest peers."""

from itertools import cycle
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..figures.style import COLOURS, MARKERS, TWO_COLUMNS, NothingToDraw, distinct, layer, load, panels
from . import report
from .solvers import OURS


def draw(path: Path) -> dict[str, Figure]:
    """Solving time over N for every solver, one panel per family; results that differ from ours are hollow."""
    study = load(path)
    found = report.comparisons(study)
    if not found:
        raise NothingToDraw(f"file {path} holds no run of {OURS} yet")
    families = distinct(c.ours["name"] for c in found)
    colours = dict(zip((OURS, *study.configuration["peers"]), COLOURS, strict=False))
    thicknesses = sorted(distinct(float(c.ours["scene.thickness"]) for c in found), reverse=True)
    markers = dict(zip(thicknesses, cycle(MARKERS), strict=False))
    figure, grid = panels(1, len(families), TWO_COLUMNS, 3.2, sharey=True)
    for axes, family in zip(grid[0], families, strict=True):
        for thickness, marker in markers.items():
            own = [c for c in found if (c.ours["name"], c.ours["scene.thickness"]) == (family, thickness)]
            for solver, colour in colours.items():
                runs = [c.ours if solver == OURS else c.peers[solver] for c in own if solver in c.solvers]
                n, seconds = [run["scene.num_points"] for run in runs], [run["seconds.solve"] for run in runs]
                axes.plot(n, seconds, marker + "-", ms=3.5, lw=0.9, color=colour, mfc="white")
                same = [solver == OURS or c.agrees(solver) for c in own if solver in c.solvers]
                axes.plot(n, seconds, marker, ms=3.5, color=colour, markevery=same)
        axes.set(yscale="log", xlabel="grid points $N$", title=family if family == "Hertz" else f"rough, ${family}$")
        axes.set_xscale("log", base=2)
    grid[0, 0].set(ylabel="solving time [s]")
    handles = [Line2D([], [], color=colour, label=solver) for solver, colour in colours.items()]
    handles += [Line2D([], [], ls="", marker=m, color="#444444", ms=3.5, label=layer(d)) for d, m in markers.items()]
    if not all(c.agrees(peer) for c in found for peer in c.peers):
        handles.append(
            Line2D([], [], ls="", marker="o", color="#444444", mfc="white", ms=3.5, label="differs from ours")
        )
    spacing = {"columnspacing": 0.9, "handlelength": 1.3, "handletextpad": 0.4}
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), **spacing)
    return {"": figure}
