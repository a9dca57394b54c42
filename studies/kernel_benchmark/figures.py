"""Figures of the kernels' benchmark: bandwidth over size, with the caches, and the roofline."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..figures.style import COLOURS, NothingToDraw, distinct, load
from ..files.study_files import StudyFile
from . import report

_STYLES = {
    "c": ("C", COLOURS[3], "^"),
    "warp-graph": ("Warp, chunks, recorded (band: all kernels)", COLOURS[0], "o"),
    "warp-launch": ("Warp, chunks, wp.launch", COLOURS[1], "s"),
    "numpy": ("NumPy twin", COLOURS[2], "D"),
    "warp-element": ("Warp, a thread per element", COLOURS[4], "v"),
    "copy": ("copy: the roof", "k", ""),
}
_ROOFS = (12, 18, 22)  # log2 of the points; those of them that were measured are shown


def draw(path: Path) -> dict[str, Figure]:
    """Bandwidth over the working set by variant; flops over arithmetic intensity by kernel."""
    study = load(path)
    if not report.loops(study):
        raise NothingToDraw(f"file {path} holds no kernel with a loop over points yet")
    return dict(zip(report.FIGURES, (bandwidth(study), roofline(study)), strict=True))


def _precisions(study: StudyFile) -> list[str]:
    return sorted(distinct(str(run["precision"]) for run in report.loops(study)))


def bandwidth(study: StudyFile) -> Figure:
    """Medians over the kernels; of the recorded ones also the least and the largest."""
    precisions, caches = _precisions(study), report.caches(study)
    figure: Figure
    figure, panels = plt.subplots(1, len(precisions), figsize=(8.6, 4.2), sharey=True, squeeze=False)
    figure.subplots_adjust(left=0.08, right=0.985, bottom=0.26, top=0.92, wspace=0.07)
    for axes, precision in zip(panels[0], precisions, strict=True):
        runs = [run for run in report.loops(study) if run["precision"] == precision]
        for variant, (label, colour, marker) in _STYLES.items():
            _line(axes, runs, variant, label, colour, marker)
        axes.set(xscale="log", yscale="log", xlabel="working set [byte]", title=precision)
        axes.set_xscale("log", base=2)
        axes.margins(x=0.07)
        for name, size in caches.items():
            if axes.get_xlim()[0] < size < axes.get_xlim()[1]:
                axes.axvline(size, color="0.5", ls=":", lw=0.9)
                axes.text(size * 0.93, 0.02, name, transform=axes.get_xaxis_transform(), ha="right", color="0.4")
    panels[0][0].set_ylabel("bandwidth [$10^9$ byte/s]")
    figure.legend(*panels[0][0].get_legend_handles_labels(), fontsize=8, loc="lower center", ncols=3)
    return figure


def _line(axes: Axes, runs: Sequence[report.Run], variant: str, label: str, colour: str, marker: str) -> None:
    sizes = sorted({run["log2_points"] for run in runs})
    own = [[run for run in runs if run["log2_points"] == size and report.seconds(run, variant) > 0] for size in sizes]
    own = [group for group in own if group]
    if not own:  # C, without a compiler
        return
    x = [float(np.median([run["bytes.working_set"] for run in group])) for group in own]
    y = [[report.bandwidth(run, variant) for run in group] for group in own]
    width = 1.8 if variant == "copy" else 1.0
    medians = [float(np.median(values)) for values in y]
    axes.plot(x, medians, label=label, color=colour, marker=marker, ms=4, lw=width, zorder=3)
    if variant == "warp-graph":
        axes.fill_between(x, [min(v) for v in y], [max(v) for v in y], color=colour, alpha=0.13, lw=0)


def roofline(study: StudyFile) -> Figure:
    """Recorded kernels beside copies of as large working sets: the memory's roof, for reading and writing alike."""
    precisions = _precisions(study)
    figure: Figure
    figure, panels = plt.subplots(1, len(precisions), figsize=(8.6, 5.2), sharex=True, sharey=True, squeeze=False)
    figure.subplots_adjust(left=0.08, right=0.985, bottom=0.2, top=0.93, wspace=0.05)
    sizes = sorted({run["log2_points"] for run in report.loops(study)})
    for axes, precision in zip(panels[0], precisions, strict=True):
        for size, colour, marker in zip([s for s in _ROOFS if s in sizes] or sizes[-1:], COLOURS, "os^", strict=False):
            runs = [r for r in report.loops(study) if (r["precision"], r["log2_points"]) == (precision, size)]
            _roof(axes, runs, f"$2^{{{size}}}$ points", colour, marker)
        _names(axes, runs)
        axes.set(xscale="log", yscale="log", xlabel="arithmetic intensity [flop/byte]", title=precision)
    bottom, top = panels[0][0].get_ylim()
    panels[0][0].set_ylim(bottom / 10, top)  # room for the names
    panels[0][0].set_ylabel("speed [$10^9$ flop/s]")
    figure.legend(*panels[0][0].get_legend_handles_labels(), fontsize=8, loc="lower center", ncols=3)
    return figure


def _names(axes: Axes, runs: Sequence[report.Run]) -> None:
    """Names of the kernels at the bottom, kept apart, each with a line to its intensity."""
    across = axes.get_xaxis_transform()
    place = 0.0
    for intensity, name in sorted((run["flops"] / run["bytes.traffic"], run["kernel"]) for run in runs):
        place = max(intensity / 1.06, place * 1.13)
        axes.annotate(
            name,
            (intensity, 0.33),
            (place, 0.02),
            xycoords=across,
            textcoords=across,
            fontsize=7,
            rotation=90,
            ha="center",
            arrowprops={"arrowstyle": "-", "lw": 0.4, "color": "0.6"},
        )


def _roof(axes: Axes, runs: Sequence[report.Run], label: str, colour: str, marker: str) -> None:
    intensity = np.array([run["flops"] / run["bytes.traffic"] for run in runs])
    speed = intensity * [report.bandwidth(run, "warp-graph") for run in runs]
    copy = float(np.median([report.bandwidth(run, "copy") for run in runs]))
    line = np.array([intensity.min() / 1.4, intensity.max() * 1.4])
    axes.plot(line, copy * line, "-", color=colour, lw=1.0, label=f"copy, {label}")
    axes.plot(intensity, speed, marker, color=colour, ms=5, label=f"kernels, {label}")
