"""The figure of a single solution: the indenter on the layer, the pressure between them, and one patch enlarged."""

import io
import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from linecontact.solver import LAYERS, Solution, Status
from linecontact.solver.arrays import Array64
from linecontact.solver.grid.contact import ends
from linecontact.solver.grid.patches import Patches
from linecontact.solver.layers import ElasticLayer
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from ..files import solution_files, writing
from ..files.marks import is_ours, marked
from ..files.solution_files import Name, StoredSolution
from . import titles
from .scales import Scales, scales
from .style import COLOURS, ONE_COLUMN, STYLE, typeset, typeset_error
from .thinning import extremes, merged
from .ticks import few_ticks

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
        self.savefig(image, format="png", dpi="figure")
        return image.getvalue()


@dataclass(frozen=True)
class Contact:
    """The contact patches, each between its edges."""

    left: Array64
    """Left edges, shape (number of patches,), in the solution's own unit of length."""
    right: Array64
    """Right edges; beyond the period for a patch that goes on at its beginning."""

    @property
    def widest(self) -> int:
        """The number of the widest patch, counted from 0."""
        return int(np.argmax(self.right - self.left))

    def width(self, number: int) -> float:
        """The width of a patch."""
        return float(self.right[number] - self.left[number])

    def up_to(self, x: float) -> "Contact":
        """The patches that begin before x; all if none does."""
        chosen = self.left < x
        return Contact(self.left[chosen], self.right[chosen]) if chosen.any() else self


def draw(path: Path) -> dict[str, Figure]:
    """The figure of a stored solution."""
    return {"": figure(solution_files.load(path))}


def plot(solution: Solution | StoredSolution, path: Name | None = None, overwrite: bool = False) -> Figure:
    """The figure of a solution, or of what `load` has read from its file; no window is opened.

    Heights and pressure over the period with the contact patches, and the widest patch enlarged; lengths in the units
    of the scan if there is one, else over the period; pressures over E*.

    path: where to write it, as .png, .pdf, .svg or what else Matplotlib writes. overwrite: whether a file may be
    replaced that is no figure of linecontact's. Raises `ValueError` for anything else, and for a file that cannot be
    written.
    """
    if not isinstance(solution, Solution | StoredSolution):
        raise ValueError(f"solution is {str(solution)[:40]!r}; allowed: a Solution, or what `load` returns")
    stored = solution_files.stored(solution) if isinstance(solution, Solution) else solution
    file = None if path is None else writing.as_path("path", path)
    if file:
        writing.check_target(file, overwrite or is_ours(file))
    with matplotlib.rc_context(STYLE):
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
    units, contact = scales(solution), _contact(solution)
    enlarged = bool(contact.left.size) and contact.width(contact.widest) < _WIDE * units.period
    rows = [["heights", "heights"], ["pressure", "pressure"]] + [["near heights", "near pressure"]] * enlarged
    drawn = Drawing(figsize=(ONE_COLUMN, 5.0 if enlarged else 3.8), dpi=160, layout="constrained")
    axes: dict[str, Axes] = drawn.subplot_mosaic(rows)
    axes["heights"].sharex(axes["pressure"])
    axes["heights"].tick_params(labelbottom=False)
    whole = (solution.profile, solution.displacement, solution.contact_pressure)
    h, u, pressure = (np.append(values, values[0]) for values in whole)  # up to where the period begins again
    x = np.append(solution.x, units.period)
    _heights(axes["heights"], x / units.x, h / units.z, u / units.z)
    _pressure(axes["pressure"], x / units.x, pressure / units.pressure)
    axes["heights"].set(ylabel=units.z_label)
    axes["pressure"].set(ylabel=units.pressure_label)
    axes["pressure"].set(xlabel=units.x_label, xlim=(0, units.period / units.x))
    notes = ["The indenter presses from above: its peaks point down.", units.told]
    notes += ["Patches of the mirror image are counted, too."] * units.mirrored
    axes["heights"].set_title("\n".join(filter(None, notes)), fontsize=7)
    for name in ("heights", "pressure"):
        _bars(axes[name], contact.left / units.x, contact.right / units.x, units.period / units.x)
        if units.mirrored:
            half = units.period / units.x / 2
            axes[name].axvspan(
                half, 2 * half, fc="none", ec=_MIRROR, hatch="////", lw=0, zorder=-0.5
            )  # over the bodies
    if enlarged:
        _enlarge(axes, units, contact, solution)
    titles.put(drawn, _title(solution.results, units, contact.left.size))
    drawn.legend(
        handles=_legend(units, contact.left.size > 0, enlarged), loc="outside lower center", ncols=2, columnspacing=1.2
    )
    return drawn


def _contact(solution: StoredSolution) -> Contact:
    """The patches between their edges; half a spacing from the nodes where the results do not tell the layer."""
    pressure, results = solution.contact_pressure, solution.results
    patches = Patches.of(pressure > 0)
    if not patches.count:
        return Contact(np.zeros(0), np.zeros(0))
    spacing = float(solution.x[1] - solution.x[0])
    layer = _layer(results)
    if layer is None:
        return Contact(*(np.asarray(end * spacing) for end in (patches.first - 0.5, patches.last + 0.5)))
    scale = float(results["scene.pressure"]) / layer.contact_modulus / float(pressure.mean())
    patches, edges = ends(layer, spacing * pressure.size, solution.profile, pressure, scale, solution.displacement)
    return Contact(edges.left * spacing, (edges.left + edges.width) * spacing)


def _layer(results: Mapping[str, Any]) -> ElasticLayer | None:
    """The layer of a solution; None where the results do not tell all of it, as of a table or a kind not known here."""
    kind: Any = LAYERS.get(str(results.get("scene.layer")))
    if kind is None:
        return None
    told = {field.name: results[f"scene.{field.name}"] for field in fields(kind) if f"scene.{field.name}" in results}
    needed = {field.name for field in fields(kind) if field.default is field.default_factory is MISSING}
    return kind(**told) if needed <= told.keys() else None


def _thinned(x: Array64, *curves: Array64) -> list[Array64]:
    """The same curves on few enough points to draw, their extremes among them."""
    places = np.unique(np.concatenate([extremes(curve, _PLACES) for curve in curves]))
    return [values[places] for values in (x, *curves)]


def _heights(axes: Axes, x: Array64, profile: Array64, surface: Array64, marker: str = "") -> None:
    """Indenter and layer as two bodies; of the indenter what is near the layer."""
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


def _enlarge(axes: dict[str, Axes], units: Scales, contact: Contact, solution: StoredSolution) -> None:
    """The widest patch, of a scan rather than of its mirror image, with its edges, and where it is."""
    own = contact.up_to(units.period / 2) if units.mirrored else contact
    left, right = float(own.left[own.widest]), float(own.right[own.widest])
    count, middle = solution.x.size, (left + right) / 2
    spacing = units.period / count
    reach = min(0.8 * (right - left) + 2 * spacing, units.period / 2)
    nodes = np.arange(round((middle - reach) / spacing), round((middle + reach) / spacing) + 1)
    marker = "." if right - left < _FEW * spacing else ""
    power = math.floor(math.log10(reach / units.x))
    power = 0 if -2 < power < 4 else power
    size = units.x * 10.0**power
    x, inside = np.asarray((nodes * spacing - middle) / size), nodes % count
    near = axes["near heights"], axes["near pressure"]
    _heights(near[0], x, solution.profile[inside] / units.z, solution.displacement[inside] / units.z, marker)
    _pressure(near[1], x, solution.contact_pressure[inside] / units.pressure, marker)
    for panel, label in zip(near, (units.z_label, units.pressure_label), strict=True):
        unit = f"$10^{{{power}}}$ {units.x_unit}" if power else units.x_unit
        panel.set(xlabel=f"distance ({unit})", ylabel=label, xlim=(-reach / size, reach / size))
        panel.xaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
        panel.spines[:].set_color(_ENLARGED)
        for edge in (left, right):
            panel.axvline((edge - middle) / size, color=_ENLARGED, lw=0.7, ls="--", zorder=0)
        _bars(panel, (contact.left - middle) / size, (contact.right - middle) / size, units.period / size)
    for name in ("heights", "pressure"):
        place = (middle % units.period) / units.x
        axes[name].plot(place, 1, "v", color=_ENLARGED, ms=4, transform=axes[name].get_xaxis_transform(), clip_on=False)


def _legend(units: Scales, touching: bool, enlarged: bool) -> list[Line2D | Patch]:
    found: list[Line2D | Patch] = [
        Line2D([], [], color=_INDENTER, lw=0.8, label="indenter $h$"),
        Line2D([], [], color=_SURFACE, lw=0.8, label="surface $u$ of the layer"),
    ]
    if touching:
        found.append(Patch(fc=_CONTACT, label="contact patches"))
    if enlarged:
        found.append(Line2D([], [], color=_ENLARGED, ls="--", lw=0.7, marker="v", ms=4, label="enlarged, its edges"))
    if units.mirrored:
        found.append(Patch(fc="none", ec=_MIRROR, hatch="////", lw=0, label="mirror image of the scan"))
    return found


def _title(results: dict[str, Any], units: Scales, patches: int) -> str:
    area, error = results["contact_area_subgrid"], results["contact_area_error"]
    found = f"$a_r = {typeset(area, 6)} \\pm {typeset_error(error)}$ in {patches} patch{'es' if patches != 1 else ''}"
    status = Status(results["status"])  # a file's text is not drawn if it is none of these
    ended = "" if status is Status.CONVERGED else f"\nNot as asked: {status}"
    below = f"\n{units.base}" * bool(units.base)  # on a line of its own
    told = ", ".join(filter(None, (units.thickness, titles.poisson(results), below, units.load)))
    return "\n".join(filter(None, (titles.pressed(results), told, found))) + ended
