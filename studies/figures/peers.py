"""Figure of the comparison with the nearest peers."""

from itertools import cycle
from pathlib import Path

from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .. import peers
from .style import COLOURS, MARKERS, load


def draw(path: Path) -> dict[str, Figure]:
    """Solving time over N for every solver, one panel per family; what disagrees with ours is hollow."""
    study = load(path)
    found = peers.comparisons(study)
    names = list(dict.fromkeys(c.ours["name"] for c in found))
    solvers = (peers.OURS, *study.configuration["peers"])
    thicknesses = sorted({float(c.ours["scene.thickness"]) for c in found}, reverse=True)
    figure, panels = plt.subplots(1, len(names), figsize=(2.2 + 2.0 * len(names), 3.6), sharey=True, squeeze=False)
    figure.subplots_adjust(left=0.09, right=0.98, top=0.92, bottom=0.32, wspace=0.06)
    for axes, name in zip(panels[0], names, strict=True):
        for solver, colour in zip(solvers, COLOURS, strict=False):
            for thickness, marker in zip(thicknesses, cycle(MARKERS), strict=False):
                own = [c for c in found if (c.ours["name"], c.ours["scene.thickness"]) == (name, thickness)]
                runs = [(c, c.ours if solver == peers.OURS else c.peers.get(solver)) for c in own]
                points = [
                    (run["scene.num_points"], run["seconds.solve"], solver == peers.OURS or c.agrees(solver))
                    for c, run in runs
                    if run
                ]
                axes.plot([n for n, _, _ in points], [t for _, t, _ in points], "-", lw=0.9, color=colour)
                for n, t, agrees in points:
                    axes.plot(n, t, marker, ms=4.5, color=colour, mfc=colour if agrees else "none")
        axes.set(yscale="log", xlabel="grid points $N$", title=name if name == "Hertz" else f"rough, ${name}$")
        axes.set_xscale("log", base=2)
    panels[0, 0].set(ylabel="solving time [s]")
    handles = [Line2D([], [], color=c, label=s) for s, c in zip(solvers, COLOURS, strict=False)]
    handles += [
        Line2D(
            [], [], ls="", marker=m, color="#444444", ms=4.5, label="half-space" if d == float("inf") else f"$d={d:g}$"
        )
        for d, m in zip(thicknesses, cycle(MARKERS), strict=False)
    ]
    figure.legend(handles=handles, loc="lower center", ncols=4, fontsize=8)
    return {"": figure}
