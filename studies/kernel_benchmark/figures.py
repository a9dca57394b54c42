"""Figures: bandwidth over the working set beside the memory's, the roofline, transforms over N, and users'
variants beside C.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..figures.style import (
    COLOURS,
    MARKERS,
    TWO_COLUMNS,
    NothingToDraw,
    distinct,
    legend_below,
    load,
    panels,
    plain,
)
from ..files.study_files import StudyFile
from .benchmark import PRECISIONS
from .cells import GROUPED, Cell, Run, Scatter, cells, machine, own_names

_STYLES = {
    "c": ("C", COLOURS[3], "^"),
    "warp": ("Warp, as the program runs it (band: all kernels)", COLOURS[0], "o"),
    "numpy": ("reference kernel", COLOURS[2], "D"),
    "element": ("Warp, a thread for each point", COLOURS[4], "v"),
}
_MEMORY = {"read": ":", "write": "-.", "copy": "-", "update": "--"}
_ROOFS = (2**12, 2**18, 2**22)  # numbers of points; those of them that were measured are shown


def draw(path: Path) -> dict[str, Figure]:
    """The figures by the endings of their names: of kernels the bandwidth and the roofline, or of transforms one, and
    one of users' variants.
    """
    study = load(path)
    found = {"": bandwidth(study) or transforms(study), "-roofline": roofline(study), "-variants": own_variants(study)}
    drawn = {name: figure for name, figure in found.items() if figure}
    if not drawn:
        raise NothingToDraw(f"file {path} holds neither kernels nor transforms nor variants of your own yet")
    return drawn


def _group(study: StudyFile, group: str) -> list[Cell]:
    return [cell for cell in cells(study.runs).values() if cell.benchmark.group == group]


def bandwidth(study: StudyFile) -> Figure | None:
    """Medians over the kernels; of the recorded ones also the least and the largest."""
    kernels, roofs = (_group(study, group) for group in ("kernels", "roofs"))
    kernels = [cell for cell in kernels if cell.value("flops") > 0]
    if not kernels:
        return None
    figure, grid = panels(1, 2, TWO_COLUMNS, 3.7, sharey=True)
    for axes, precision in zip(grid[0], PRECISIONS, strict=True):
        for variant, (label, colour, marker) in _STYLES.items():
            own = [cell for cell in kernels if cell.key.precision == precision]
            _line(axes, own, variant, label, colour, marker)
        for name, dashes in _MEMORY.items():
            own = [cell for cell in roofs if (cell.key.benchmark, cell.key.precision) == (name, precision)]
            points = sorted((cell.value("bytes.working_set"), cell.bandwidth("c")) for cell in own)
            if points:
                axes.plot(*zip(*points, strict=True), "k", ls=dashes, lw=1, label=f"memory: {name}")
        axes.set(xscale="log", yscale="log", xlabel="working set [byte]", title=precision)
        axes.set_xscale("log", base=2)
        axes.margins(x=0.07)
        _mark_caches(axes, machine(study))
    grid[0][0].set_ylabel("bandwidth [$10^9$ byte/s]")
    legend_below(figure, grid[0][0], 3)
    return figure


def _mark_caches(axes: Axes, about: Run) -> None:
    for name, size in about.items():
        if name.startswith("bytes.cache.") and axes.get_xlim()[0] < size < axes.get_xlim()[1]:
            axes.axvline(size, color="0.5", ls=":", lw=0.9)
            text = name.removeprefix("bytes.cache.")
            axes.text(size * 0.93, 0.02, text, transform=axes.get_xaxis_transform(), ha="right", color="0.4")


def _line(axes: Axes, own: Sequence[Cell], variant: str, label: str, colour: str, marker: str) -> None:
    sizes = sorted({cell.key.num_points for cell in own})
    groups = [[c for c in own if c.key.num_points == size and c.seconds(variant) > 0] for size in sizes]
    groups = [group for group in groups if group]
    if not groups:  # C, without a compiler
        return
    x = [float(np.median([cell.value("bytes.working_set") for cell in group])) for group in groups]
    y = [[cell.bandwidth(variant) for cell in group] for group in groups]
    axes.plot(
        x, [float(np.median(values)) for values in y], label=label, color=colour, marker=marker, ms=4, lw=1, zorder=3
    )
    if variant == "warp":
        axes.fill_between(x, [min(v) for v in y], [max(v) for v in y], color=colour, alpha=0.13, lw=0)


def roofline(study: StudyFile) -> Figure | None:
    """Recorded kernels below the roofs of the memory, which are of updates in place, and of the processor."""
    kernels = [cell for cell in _group(study, "kernels") if cell.value("flops") > 0]
    updates = {c.key[1:]: c.bandwidth("c") for c in _group(study, "roofs") if c.key.benchmark == "update"}
    if not kernels or not updates:
        return None
    figure, grid = panels(1, 2, TWO_COLUMNS, 4.4, sharex=True, sharey=True)
    sizes = sorted({cell.key.num_points for cell in kernels})
    for axes, precision in zip(grid[0], PRECISIONS, strict=True):
        own = [cell for cell in kernels if cell.key.precision == precision]
        intensities = [cell.value("flops") / cell.value("bytes.traffic") for cell in own]
        ends = np.array([min(intensities) / 1.4, max(intensities) * 1.4])
        peak = machine(study).get(f"peak.{precision}", np.nan) / 1e9
        axes.plot(ends, [peak, peak], "k-", lw=1, label="multiply-adds in registers")
        for size, colour, marker in zip([s for s in _ROOFS if s in sizes] or sizes[-1:], COLOURS, "os^", strict=False):
            rate = updates.get((precision, size), np.nan)
            axes.plot(ends, rate * ends, "-", color=colour, lw=1, label=f"memory, {_points(size)}")
            points = [c for c in own if c.key.num_points == size]
            x = np.array([c.value("flops") / c.value("bytes.traffic") for c in points])
            y = x * [c.bandwidth("warp") for c in points]
            axes.plot(x, y, marker, color=colour, ms=5, label=f"kernels, {_points(size)}")
        _names(axes, own)
        axes.set(xscale="log", yscale="log", xlabel="arithmetic intensity [flop/byte]", title=precision)
    bottom, top = grid[0][0].get_ylim()
    grid[0][0].set_ylim(bottom / 10, top)  # room for the names
    grid[0][0].set_ylabel("speed [$10^9$ flop/s]")
    legend_below(figure, grid[0][0], 4)
    return figure


def _points(size: int) -> str:
    return f"$2^{{{size.bit_length() - 1}}}$ points" if size & (size - 1) == 0 else f"{size} points"


def _names(axes: Axes, own: Sequence[Cell]) -> None:
    """Names of the kernels at the bottom, kept apart, each with a line to its intensity."""
    across = axes.get_xaxis_transform()
    place = 0.0
    named = {cell.key.benchmark: cell.value("flops") / cell.value("bytes.traffic") for cell in own}
    for name, intensity in sorted(named.items(), key=lambda item: item[::-1]):
        place = max(intensity / 1.06, place * 1.17)
        axes.annotate(
            name,
            (intensity, 0.33),
            (place, 0.27),
            xycoords=across,
            textcoords=across,
            fontsize=7,
            rotation=90,
            ha="center",
            va="top",
            arrowprops={"arrowstyle": "-", "lw": 0.4, "color": "0.6", "relpos": (0.5, 1.0)},
        )


def transforms(study: StudyFile) -> Figure | None:
    """Time for each point over N, by library and planning effort."""
    found = _group(study, "transforms")
    if not found:
        return None
    names = list(dict.fromkeys(cell.key.benchmark for cell in found))
    figure, grid = panels(2, len(names), TWO_COLUMNS, 5.0, sharex=True, sharey=True)
    variants = list(dict.fromkeys(v for cell in found for v in cell.variants))
    for row, precision in zip(grid, PRECISIONS, strict=True):
        for axes, name in zip(row, names, strict=True):
            own = sorted((c for c in found if c.key[:2] == (name, precision)), key=lambda cell: cell.key.num_points)
            for variant, colour in zip(variants, COLOURS * 2, strict=False):
                for even, style in ((True, "o-"), (False, "x")):  # powers of two, and others
                    points = [c for c in own if (c.key.num_points & (c.key.num_points - 1) == 0) == even]
                    x = [c.key.num_points for c in points]
                    y = [c.seconds(variant) / c.key.num_points * 1e9 for c in points]
                    axes.plot(x, y, style, color=colour, ms=4, lw=1, label=variant if even else None)
            axes.set(xscale="log", yscale="log")
            axes.set_xscale("log", base=2)
        row[0].set_ylabel(f"{precision}: ns for each point")
    for axes, name in zip(grid[0], names, strict=True):
        axes.set_title(name.replace("_", " "))
    for axes in grid[1]:
        axes.set_xlabel("N")
    legend_below(figure, grid[0][0], 4)
    return figure


def own_variants(study: StudyFile) -> Figure | None:
    """Times of users' variants and of Warp over C's, with their intervals, over N; a row for each benchmark."""
    measured = list(cells(study.runs).values())
    found = [cell for cell in measured if cell.benchmark.group in GROUPED and own_names([cell])]
    if not found:
        return None
    names = distinct(cell.key.benchmark for cell in found)
    scatters = {variant: Scatter(measured, variant) for variant in ("warp", *own_names(found))}
    figure, grid = panels(len(names), 2, TWO_COLUMNS, 0.7 + 1.6 * len(names), sharex=True, sharey="row")
    for row, name in zip(grid, names, strict=True):
        some = [cell for cell in found if cell.key.benchmark == name]
        for axes, precision in zip(row, PRECISIONS, strict=True):
            own = sorted((c for c in some if c.key.precision == precision), key=lambda cell: cell.key.num_points)
            for i, variant in enumerate(["warp", *own_names(some)]):
                x = [c.key.num_points * 2 ** (0.08 * i) for c in own]  # side by side
                y = [c.ratio(variant) for c in own]
                half = [scatters[variant].half_width(c, variant) for c in own]
                marker, colour = MARKERS[i % len(MARKERS)], COLOURS[i % len(COLOURS)]
                axes.errorbar(x, y, half, marker=marker, color=colour, ms=4, lw=1, label=plain(variant))
            axes.axhline(1, color="0.5", ls=":", lw=0.9)  # C
            axes.set_xscale("log", base=2)
            axes.set_title(f"{name}, {precision}")
        bottom, top = row[0].get_ylim()
        row[0].set_ylim(min(bottom, 0.9), max(top, 1.1))  # less is not told from other work on the machine
        row[1].legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    sizes = [cell.key.num_points for cell in found]
    for axes in grid[-1]:
        axes.set(xlabel="points $N$ (dimensionless)", xlim=(min(sizes) / 1.3, max(sizes) * 1.6))
    figure.supylabel("time over C's\n(dimensionless), 95 % intervals", fontsize=8)
    return figure
