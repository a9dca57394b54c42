"""The figure of a single solution: the indenter on the layer, the pressure between them, and one patch enlarged."""

import io
import math
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from linecontact.locks import DRAWING
from linecontact.solver import Solution, Status, checks
from linecontact.solver.arrays import Array64
from linecontact.solver.grid.patches import Patches
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from ..files import solution_files, writing
from ..files.marks import is_ours, marked
from ..files.solution_files import Name, StoredSolution
from ..scans.preparation import mirrored
from . import titles
from .scales import base, load, of, of_scene, shown, sign, thickness, told
from .style import COLOURS, ONE_COLUMN, STYLE, kind, typeset, typeset_error
from .thinning import extremes, merged
from .ticks import few_ticks
from .units import Shown, shown_units

_PLACES = 2000  # along an axis: more than a page can show
_INDENTER, _SURFACE, _CONTACT, _ENLARGED = "k", COLOURS[0], COLOURS[3], COLOURS[4]
_INDENTER_BODY, _LAYER_BODY, _MIRROR = "0.82", "#d9e8f2", "0.55"
_FEW = 40  # nodes in the enlarged patch that are shown one by one
_WIDE = 0.4  # of the period: no patch as wide as that needs to be enlarged


class Drawing(Figure):  # type: ignore[misc]  # Matplotlib has no types here
    """A figure that a notebook shows as an image, once, whether or not pyplot is used there."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        FigureCanvasAgg(self)  # one renderer for layout and image, so that each formula is read once

    def _repr_png_(self) -> bytes:
        image = io.BytesIO()
        with DRAWING:
            self.savefig(image, format="png", dpi="figure")
        return image.getvalue()


def draw(path: Path) -> dict[str, Figure]:
    """The figure of a stored solution."""
    return {"": figure(solution_files.load(path))}


def plot(solution: Solution | StoredSolution, path: Name | None = None, overwrite: bool = False) -> Figure:
    """The figure of a solution, or of a `StoredSolution` that `load` has read; no window is opened.

    Heights and pressure over the period with the contact patches, and the widest patch enlarged; in the units of
    the scene, where it has some; else lengths over the period, pressures over E*.

    path: where to write it, as .png, .pdf, .svg or another format of Matplotlib. overwrite: whether a file may be
    replaced that is no figure of linecontact's. Raises `ValueError` for anything else, and for a file that cannot be
    written.
    """
    if not isinstance(solution, Solution | StoredSolution):
        raise checks.refusal("solution", solution, "a Solution or a StoredSolution")
    stored = solution_files.stored(solution) if isinstance(solution, Solution) else solution
    file = None if path is None else writing.as_path("path", path)
    if file:
        writing.check_target(file, overwrite or is_ours(file))
    with DRAWING, matplotlib.rc_context(STYLE):
        drawn = figure(stored)
        known = drawn.canvas.get_supported_filetypes()
        if file and file.suffix[1:].lower() not in known:
            raise ValueError(f"path is {file}; allowed: a name that ends in {', '.join(f'.{form}' for form in known)}")
        drawn.draw_without_rendering()  # ticks take their style from here
        if file:
            image = io.BytesIO()
            form = file.suffix.lower()
            drawn.savefig(image, format=form[1:], metadata=marked(form))
            writing.write_bytes(file, [image.getvalue()])
    return drawn


def figure(solution: StoredSolution) -> Figure:
    """Profile and surface, contact pressure, and one patch enlarged; pyplot knows nothing of the figure."""
    about, (left, right) = of_scene(solution.results), _ends(solution)
    period, image = float(about["period"]), mirrored(about)
    along, up, pressures = units = shown_units(about)
    own = _widest(left, right, period / 2 if image else period) if left.size else (0.0, period)
    enlarged = own[1] - own[0] < _WIDE * period
    rows = [["heights", "heights"], ["pressure", "pressure"]] + [["near heights", "near pressure"]] * enlarged
    drawn = Drawing(figsize=(ONE_COLUMN, 5.0 if enlarged else 3.8), dpi=160, layout="constrained")
    axes: dict[str, Axes] = drawn.subplot_mosaic(rows)
    axes["heights"].sharex(axes["pressure"])
    axes["heights"].tick_params(labelbottom=False)
    whole = (solution.profile, solution.displacement, solution.contact_pressure)
    h, u, pressure = (np.append(values, values[0]) for values in whole)  # up to where the period begins again
    x, end = np.append(solution.x, period) * along.factor, period * along.factor
    _heights(axes["heights"], x, h * up.factor, u * up.factor)
    _pressure(axes["pressure"], x, pressure * pressures.factor)
    axes["heights"].set(ylabel=f"height{of(up)}")
    axes["pressure"].set(ylabel=f"pressure{of(pressures)}")
    axes["pressure"].set(xlabel=f"position $x${of(along)}", xlim=(0, end))
    notes = ["The indenter presses from above: its peaks point down.", told(units)]
    notes += ["Patches of the mirror image are counted, too."] * image
    axes["heights"].set_title("\n".join(filter(None, notes)), fontsize=7)
    for name in ("heights", "pressure"):
        _bars(axes[name], left * along.factor, right * along.factor, end)
        if image:  # over the bodies
            axes[name].axvspan(end / 2, end, fc="none", ec=_MIRROR, hatch="////", lw=0, zorder=-0.5)
    if enlarged:
        _enlarge(axes, units, (left, right), own, solution)
    titles.put(drawn, _title(solution.results, left.size))
    handles = _legend(left.size > 0, enlarged, image)
    drawn.legend(handles=handles, loc="outside lower center", ncols=2, columnspacing=1.2)
    return drawn


def _ends(solution: StoredSolution) -> tuple[Array64, Array64]:
    """Left and right ends of the patches, shape (their number,); half a spacing from their nodes where they are not
    stored, as in a file of an earlier version.
    """
    if solution.patches is not None:
        return solution.patches.left, solution.patches.right
    patches, spacing = Patches.of(solution.contact_pressure > 0), float(solution.x[1])
    return np.asarray((patches.first - 0.5) * spacing), np.asarray((patches.last + 0.5) * spacing)


def _widest(left: Array64, right: Array64, before: float) -> tuple[float, float]:
    """The ends of the widest patch that begins before a place; of any if none does. There must be one."""
    inside = left < before if (left < before).any() else np.full(left.shape, True)
    widest = int(np.argmax(np.where(inside, right - left, -np.inf)))
    return float(left[widest]), float(right[widest])


def _thinned(x: Array64, *curves: Array64) -> list[Array64]:
    """The same curves on few enough points to draw, their extremes among them."""
    places = np.unique(np.concatenate([extremes(curve, _PLACES) for curve in curves]))
    return [values[places] for values in (x, *curves)]


def _heights(axes: Axes, x: Array64, profile: Array64, surface: Array64, marker: str = "") -> None:
    """Indenter and layer as two bodies; of the indenter the part near the layer."""
    x, h, u = _thinned(x, profile, surface)
    low, reach = float(min(u.min(), h.min())), float(np.ptp(u)) or float(np.ptp(h)) or 1.0
    top = min(float(h.max()), float(u.max()) + reach)
    bottom, top = low - 0.25 * reach, top + 0.08 * reach
    axes.fill_between(x, h, np.maximum(h, top), color=_INDENTER_BODY, lw=0, zorder=-1)
    axes.fill_between(x, bottom, u, color=_LAYER_BODY, lw=0, zorder=-1)
    axes.plot(x, h, color=_INDENTER, lw=0.8, marker=marker, ms=2)
    axes.plot(x, u, color=_SURFACE, lw=0.8, marker=marker, ms=2)
    axes.set(ylim=(bottom, top))
    few_ticks(axes)


def _pressure(axes: Axes, x: Array64, pressure: Array64, marker: str = "") -> None:
    x, pressure = _thinned(x, pressure)
    axes.fill_between(x, 0, pressure, color=_CONTACT, alpha=0.2, lw=0)
    axes.plot(x, pressure, color=_CONTACT, lw=0.8, marker=marker, ms=2)
    most = float(pressure.max()) or 1.0
    axes.set(ylim=(-0.12 * most, 1.08 * most))
    few_ticks(axes)


def _bars(axes: Axes, left: Array64, right: Array64, period: float) -> None:
    """Bars at the foot of a panel where the contact is; patches closer than a page can show are one bar.

    left, right: the edges of the patches, and the period, in the panel's unit.
    """
    low, high = axes.get_xlim()
    left, right = merged(left, right, (high - low) / _PLACES)
    bars = [(a + shift, b - a) for a, b in zip(left, right, strict=True) for shift in (-period, 0.0, period)]
    seen = [(a, width) for a, width in bars if a < high and a + width > low]
    foot = axes.get_xaxis_transform()
    axes.broken_barh(seen, (0.02, 0.05), transform=foot, fc=_CONTACT, ec=_CONTACT, lw=0.6, zorder=3)
    axes.set_xlim(low, high)


def _enlarge(
    axes: dict[str, Axes],
    units: tuple[Shown, Shown, Shown],
    ends: tuple[Array64, Array64],
    own: tuple[float, float],
    solution: StoredSolution,
) -> None:
    """A patch with its edges, and where it is. ends: of all patches; own: of this one."""
    along, up, pressures = units
    left, right = own
    count, middle = solution.x.size, (left + right) / 2
    spacing = float(solution.results["scene.period"]) / count
    reach = min(0.8 * (right - left) + 2 * spacing, spacing * count / 2)
    nodes = np.arange(round((middle - reach) / spacing), round((middle + reach) / spacing) + 1)
    marker = "." if right - left < _FEW * spacing else ""
    power = math.floor(math.log10(reach * along.factor))
    power = 0 if -2 < power < 4 else power
    size = 10.0**power / along.factor
    x, inside = np.asarray((nodes * spacing - middle) / size), nodes % count
    near = axes["near heights"], axes["near pressure"]
    _heights(near[0], x, solution.profile[inside] * up.factor, solution.displacement[inside] * up.factor, marker)
    _pressure(near[1], x, solution.contact_pressure[inside] * pressures.factor, marker)
    for panel, label in zip(near, (f"height{of(up)}", f"pressure{of(pressures)}"), strict=True):
        unit = f"$10^{{{power}}}$ " * bool(power) + (shown(along.unit) or sign(along))
        panel.set(xlabel=f"distance ({unit})", ylabel=label, xlim=(-reach / size, reach / size))
        panel.xaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
        panel.spines[:].set_color(_ENLARGED)
        for edge in own:
            panel.axvline((edge - middle) / size, color=_ENLARGED, lw=0.7, ls="--", zorder=0)
        _bars(panel, (ends[0] - middle) / size, (ends[1] - middle) / size, spacing * count / size)
    for name in ("heights", "pressure"):
        place = middle % (spacing * count) * along.factor
        axes[name].plot(place, 1, "v", color=_ENLARGED, ms=4, transform=axes[name].get_xaxis_transform(), clip_on=False)


def _legend(touching: bool, enlarged: bool, image: bool) -> list[Line2D | Patch]:
    found: list[Line2D | Patch] = [
        Line2D([], [], color=_INDENTER, lw=0.8, label="indenter $h$"),
        Line2D([], [], color=_SURFACE, lw=0.8, label="surface $u$ of the layer"),
    ]
    if touching:
        found.append(Patch(fc=_CONTACT, label="contact patches"))
    if enlarged:
        found.append(Line2D([], [], color=_ENLARGED, ls="--", lw=0.7, marker="v", ms=4, label="enlarged, its edges"))
    if image:
        found.append(Patch(fc="none", ec=_MIRROR, hatch="////", lw=0, label="mirror image of the scan"))
    return found


def _title(results: dict[str, Any], patches: int) -> str:
    area, error = results["contact_area_subgrid"], results["contact_area_error"]
    found = f"$a_r = {typeset(area, 6)} \\pm {typeset_error(error)}$ in {patches} patch{'es' if patches != 1 else ''}"
    status = Status(results["status"])  # a file's text is not drawn if it is none of these
    ended = "" if status is Status.CONVERGED else f"\nNot as asked: {status}"
    about, below = of_scene(results), base(results)
    of_layer = [kind(str(about.get("layer", "bonded"))), thickness(about), titles.poisson(results)]
    told = ", ".join(
        filter(None, (*of_layer, f"\n{below}" * bool(below), load(about)))
    )  # the base on a line of its own
    return "\n".join(filter(None, (titles.pressed(results), told, titles.own(results), found))) + ended
