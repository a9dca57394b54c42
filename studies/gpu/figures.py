"""The figure of the GPU: an iteration's time and a whole solve's over N, beside the CPU's."""

from pathlib import Path

import numpy as np
from linecontact.solver import METHODS
from matplotlib.figure import Figure

from ..figures.style import COLOURS, MARKERS, TWO_COLUMNS, NothingToDraw, distinct, load, panels
from .report import of

_STYLES = {"float64": "-", "float32": "--"}


def draw(path: Path) -> dict[str, Figure]:
    """Times of iterations, and of whole solves."""
    study = load(path)
    if not (of(study, "iteration") and of(study, "solve")):
        raise NothingToDraw(f"file {path} holds no iterations and solves; allowed: one of the study gpu")
    figure, grid = panels(1, 2, TWO_COLUMNS, 3.8)
    left, right = grid[0]
    runs = of(study, "iteration")
    for i, method in enumerate(distinct(run["method"] for run in runs)):
        for precision in distinct(run["precision"] for run in runs):
            some = [run for run in runs if (run["method"], run["precision"]) == (method, precision)]
            some.sort(key=lambda run: float(run["num_points"]))
            n = np.array([run["num_points"] for run in some])
            for j, (where, label) in enumerate({"cpu": "CPU", "gpu": "GPU"}.items()):
                seconds = np.array([run.get(f"seconds.{where}", np.nan) for run in some], dtype=float)
                name = f"{METHODS[method].label}, {precision}, {label}"
                style = MARKERS[i] + _STYLES.get(precision, ":")
                left.plot(n, 1e3 * seconds, style, color=COLOURS[3 * j], ms=3.5, lw=0.9, mfc=_fill(i, j), label=name)
    left.set(yscale="log", xlabel="grid points $N$", ylabel="time of an iteration [ms]")
    runs = of(study, "solve")
    for i, (method, where) in enumerate(distinct((run["method"], run["where"]) for run in runs)):
        some = [run for run in runs if (run["method"], run["where"]) == (method, where)]
        some.sort(key=lambda run: float(run["num_points"]))
        n, seconds = (np.array([run[name] for run in some], dtype=float) for name in ("num_points", "seconds.total"))
        label = f"{METHODS[method].label if method in METHODS else method}, {'GPU' if where == 'cuda' else 'CPU'}"
        right.plot(n, seconds, MARKERS[i] + "-", color=COLOURS[i], ms=3.5, lw=0.9, label=label)
    right.set(yscale="log", xlabel="grid points $N$", ylabel="time of a whole solve [s]")
    for axes in (left, right):
        axes.set_xscale("log", base=2)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncol=1)
    return {"": figure}


def _fill(method: int, device: int) -> str:
    return COLOURS[3 * device] if method == 0 else "none"
