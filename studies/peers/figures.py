"""Figure of the comparison with the nearest peers."""

import math
from itertools import cycle
from pathlib import Path

from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..figures.style import COLOURS, MARKERS, NothingToDraw, distinct, load
from . import report
from .solvers import OURS


def draw(path: Path) -> dict[str, Figure]:
    """Solving time over N for every solver, one panel per family; what differs from ours is hollow."""
    study = load(path)
    found = report.comparisons(study)
    if not found:
        raise NothingToDraw(f"file {path} holds no run of {OURS} yet")
    families = distinct(c.ours["name"] for c in found)
    colours = dict(zip((OURS, *study.configuration["peers"]), COLOURS, strict=False))
    thicknesses = sorted(distinct(float(c.ours["scene.thickness"]) for c in found), reverse=True)
    markers = dict(zip(thicknesses, cycle(MARKERS), strict=False))
    figure, panels = plt.subplots(1, len(families), figsize=(8.2, 3.6), sharey=True, squeeze=False)
    figure.subplots_adjust(left=0.09, right=0.98, top=0.92, bottom=0.25, wspace=0.06)
    for axes, family in zip(panels[0], families, strict=True):
        for thickness, marker in markers.items():
            own = [c for c in found if (c.ours["name"], c.ours["scene.thickness"]) == (family, thickness)]
            for solver, colour in colours.items():
                runs = [c.ours if solver == OURS else c.peers[solver] for c in own if solver in c.solvers]
                n, seconds = [run["scene.num_points"] for run in runs], [run["seconds.solve"] for run in runs]
                axes.plot(n, seconds, marker + "-", ms=4.5, lw=0.9, color=colour, mfc="white")
                same = [solver == OURS or c.agrees(solver) for c in own if solver in c.solvers]
                axes.plot(n, seconds, marker, ms=4.5, color=colour, markevery=same)
        axes.set(yscale="log", xlabel="grid points $N$", title=family if family == "Hertz" else f"rough, ${family}$")
        axes.set_xscale("log", base=2)
    panels[0, 0].set(ylabel="solving time [s]")
    handles = [Line2D([], [], color=colour, label=solver) for solver, colour in colours.items()]
    labels = {d: "half-space" if math.isinf(d) else f"$d={d:g}\\,L$" for d in thicknesses}
    handles += [Line2D([], [], ls="", marker=m, color="#444444", ms=4.5, label=labels[d]) for d, m in markers.items()]
    if not all(c.agrees(peer) for c in found for peer in c.peers):
        handles.append(
            Line2D([], [], ls="", marker="o", color="#444444", mfc="white", ms=4.5, label="differs from ours")
        )
    spacing = {"columnspacing": 0.9, "handlelength": 1.3, "handletextpad": 0.4}
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), fontsize=7.5, **spacing)
    return {"": figure}
