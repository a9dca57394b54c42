"""The figures of the page: indenter and surface, contact pressure and patches, and the two curves about the scene."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, CustomJSTicker, CustomJSTickFormatter, Range1d
from bokeh.plotting import figure
from linecontact.solver import Scene, Solution
from linecontact.solver.arrays import Array64
from linecontact.solver.display import counted
from numpy.typing import ArrayLike

from ..figures.style import COLOURS
from ..figures.thinning import extremes, merged
from ..figures.units import shown_units
from ..scans.preparation import mirrored
from .controls import HALF_SPACE, Control
from .curves import Curve, own_value

_UNKNOWN_WIDTH = 1000  # pixels, until the browser has said
NARROWEST = 340
"""Width of a figure or a text on the page at least [pixels]: that of a telephone."""

_TOOLS = "pan,xwheel_zoom,box_zoom,reset,save"
_MIRROR = "#b0b0b0"

# Powers of ten; 1, 2 and 5 times those on less than three decades; even steps on less than half a decade.
_TICKS = """
const low = Math.min(cb_data.start, cb_data.end), high = Math.max(cb_data.start, cb_data.end)
const decades = Math.log10(high / low)
const ticks = []
if (decades < 0.5) {
    const unit = 10 ** Math.floor(Math.log10(high - low))
    const step = [0.2, 0.5, 1, 2].map((part) => part * unit).find((one) => (high - low) / one < 7)
    for (let k = Math.ceil(low / step); k * step <= high; k++) ticks.push(Number((k * step).toPrecision(12)))
} else {
    const every = Math.ceil(decades / 7)
    for (let k = Math.floor(Math.log10(low)); k <= Math.log10(high); k++)
        for (const part of decades < 3 ? [1, 2, 5] : [1])
            if (k % every === 0) ticks.push(Number(`${part}e${k}`))
}
const shown = ticks.filter((tick) => low <= tick && tick <= Math.min(high, last))
return end === null ? shown : [...shown, end]
"""
_LABEL = """
const number = Number(tick.toPrecision(12)), size = Math.abs(number)
return (0 < size && size < 1e-3 ? number.toExponential() : String(number))"""
_WIDE = ".padStart(8)"  # a browser lays out the whole page anew whenever the labels beside an axis change their width


def _figure(label: str, height: int, **options: object) -> figure:
    wide = {"sizing_mode": "stretch_width", "min_width": NARROWEST}
    made = figure(height=height, tools=_TOOLS, y_axis_label=label, **wide, **options)
    made.toolbar.logo = None  # it links to another host
    made.min_border_left = 75  # both panels begin at the same pixel
    made.axis.minor_tick_line_color = made.outline_line_color = None  # a browser takes its time for every line
    made.yaxis.formatter = CustomJSTickFormatter(code=_LABEL + _WIDE)
    made.yaxis.major_label_text_font = "monospace"
    return made


def _label_logarithmic(axis: Any, end: float | None = None, last: float = 1e300) -> None:
    """Have ticks all along a logarithmic axis, however far it reaches: Bokeh's own bunch up below two decades.

    end: of one tick more, that of a half-space. last: the largest of the others.
    """
    axis.ticker = CustomJSTicker(args={"end": end, "last": last}, major_code=_TICKS)
    if end is not None:
        axis.major_label_overrides = {end: HALF_SPACE}


def _put(source: ColumnDataSource, data: Mapping[str, ArrayLike]) -> None:
    """Set a source's columns if they are others: the same ones are neither sent nor painted again."""
    if any(not np.array_equal(source.data[name], column, equal_nan=True) for name, column in data.items()):
        source.data = dict(data)


def _up(number: float) -> float:
    """The next round number from a positive one on: a range that seldom changes is seldom drawn anew."""
    decade = 10.0 ** math.floor(math.log10(number))
    return next(step * decade for step in (1, 1.5, 2, 3, 5, 7, 10, 15) if step * decade >= number)


def _of_one_length(data: Mapping[str, Array64]) -> dict[str, Array64]:
    """Columns of one length, as a source needs them: the shorter ones end with NaN, which is not drawn."""
    longest = max(column.size for column in data.values())
    return {name: np.append(column, np.full(longest - column.size, np.nan)) for name, column in data.items()}


def _clear(source: ColumnDataSource) -> None:
    _put(source, {name: np.empty(0) for name in source.data})


class Fields:
    """Indenter and surface above, contact pressure and patches below, over the position in the period."""

    def __init__(self, scene: Scene) -> None:
        self._along, self._heights, self._pressures = shown_units(scene.to_dict())
        self._whole = scene.period * self._along.factor
        self._solution: Solution | None = None
        self._pixels = _UNKNOWN_WIDTH
        self.x_range = Range1d(0, self._whole)
        self._indenter = ColumnDataSource({"x": [], "h": []})
        # one source for all that every solution changes: each that is sent costs the browser some milliseconds
        self._found = ColumnDataSource({name: [] for name in ("u_x", "u", "p_x", "p", "left", "right")})
        label = f"height{self._heights.symbol}, peaks down"
        self.shape = _figure(label, 275, x_range=self.x_range, y_range=Range1d(0, 1))
        self.pressure = _figure(f"pressure{self._pressures.symbol}", 255, x_range=self.x_range, y_range=Range1d(0, 1))
        self.shape.xaxis.visible = False
        self.pressure.xaxis.axis_label = f"position x{self._along.symbol}"
        self.pressure.xaxis.formatter = CustomJSTickFormatter(code=_LABEL)
        self.shape.line("x", "h", source=self._indenter, color="black", legend_label="indenter h")
        self.shape.line("u_x", "u", source=self._found, color=COLOURS[0], legend_label="surface u")
        self.pressure.line("p_x", "p", source=self._found, color=COLOURS[3], legend_label="pressure")
        bar = {"source": self._found, "y0": 0, "y1": 0, "line_width": 6, "color": COLOURS[1]}
        self.pressure.segment(x0="left", x1="right", legend_label="contact patches", **bar)
        if mirrored(scene.indenter.to_dict()):
            half = {"x0": self._whole / 2, "x1": self._whole, "level": "underlay"}
            plain = {"fill_color": None, "line_color": None}
            hatch = {"hatch_pattern": "/", "hatch_color": _MIRROR, "hatch_weight": 0.5, "hatch_scale": 14}
            for panel, named in ((self.shape, {"legend_label": "mirror image"}), (self.pressure, {})):
                panel.vstrip(**half, **plain, **hatch, **named)
        for panel in (self.shape, self.pressure):
            panel.legend.orientation, panel.legend.padding, panel.legend.border_line_color = "horizontal", 3, None
            (legend,) = panel.legend
            panel.center.remove(legend)  # Bokeh's older versions do not move it
            panel.add_layout(legend, "above")  # where it hides no curve
        self.shape.on_change("inner_width", lambda _, old, new: self._resize(int(new or 0)))

    def _resize(self, pixels: int) -> None:
        if pixels > 0 and pixels != self._pixels:
            self._pixels = pixels
            self.thin()

    def show(self, solution: Solution | None) -> None:
        """Draw a solution, or nothing."""
        self._solution = solution
        if solution is None:
            _clear(self._indenter)
            _clear(self._found)
        else:
            self.thin()

    def thin(self) -> None:
        """Draw the part of the solution on the screen, with as many points as it has pixels for."""
        solution = self._solution
        if solution is None:
            return
        low, high = sorted((float(self.x_range.start), float(self.x_range.end)))
        spacing = self._whole / solution.scene.num_points
        first = max(0, math.floor(low / spacing) - 1)
        last = min(solution.scene.num_points, math.ceil(high / spacing) + 2)
        if last - first < 2:
            first, last = 0, solution.scene.num_points
        pixels = self._pixels
        part = slice(first, last)
        height = self._heights.factor
        indenter = solution.scene.profile[part] * height
        surface = solution.displacement[part] * height
        pressure = solution.contact_pressure[part] * self._pressures.factor

        def thinned(values: Array64, x: str, y: str) -> dict[str, Array64]:
            places = extremes(values, pixels)
            return {x: np.asarray((first + places) * spacing), y: values[places]}

        _put(self._indenter, thinned(indenter, "x", "h"))
        found = thinned(surface, "u_x", "u") | thinned(pressure, "p_x", "p")
        _put(self._found, _of_one_length(found | self._shown_patches(solution, (high - low) / pixels)))
        self._set_ranges(indenter, surface, float(pressure.max()))

    def _shown_patches(self, solution: Solution, pixel: float) -> dict[str, Array64]:
        """Left and right ends of the patches, those closer than a pixel as one."""
        found, factor, whole = solution.patches, self._along.factor, self._whole
        left, right = found.left * factor, found.right * factor
        over = right > whole  # a patch that goes on at the beginning of the period
        left = np.concatenate([left, np.zeros(int(over.sum()))])
        right = np.concatenate([np.minimum(right, whole), right[over] - whole])
        order = np.argsort(left)
        left, right = merged(left[order], right[order], pixel)
        return {"left": left, "right": right}

    def _set_ranges(self, indenter: Array64, surface: Array64, peak: float) -> None:
        """The surface fills a quarter to a half of its panel: the indenter's higher parts are far from it."""
        low, high = float(surface.min()), float(surface.max())
        room = _up((high - low) or float(np.ptp(indenter)) or 1.0)
        top = min(high + room, max(high, float(indenter.max())))
        step = 0.2 * room
        self.shape.y_range.update(start=(math.floor(low / step) - 0.5) * step, end=(math.ceil(top / step) + 0.5) * step)
        most = _up(peak or 1.0)
        self.pressure.y_range.update(start=-0.08 * most, end=1.08 * most)


class Surroundings:
    """A curve of contact areas along one slider, with the point of the scene on it."""

    def __init__(self, control: Control, span: tuple[float, float]) -> None:
        self._control, self._high = control, span[1]
        self._curve = ColumnDataSource({"x": [], "y": [], "low": [], "high": []})
        self._point = ColumnDataSource({"x": [], "y": []})
        self.figure = _figure(
            "contact area a_r (dimensionless)", 280, x_axis_type="log", y_axis_type="log", y_range=Range1d(0.01, 1)
        )
        self.figure.xaxis.axis_label = control.title
        self.figure.x_range.update(start=10 ** (span[0] - 0.2), end=10 ** (span[1] + 0.7))
        self.figure.title.text_font_style = "normal"
        _label_logarithmic(self.figure.yaxis[0])
        self.figure.xaxis.formatter = CustomJSTickFormatter(code=_LABEL)
        if control.endless:
            _label_logarithmic(self.figure.xaxis[0], self._place(math.inf), 0.99 * 10 ** span[1])
        else:
            _label_logarithmic(self.figure.xaxis[0])
        self.figure.line("x", "y", source=self._curve, color=COLOURS[5])
        self.figure.scatter("x", "y", source=self._curve, color=COLOURS[5], size=4)
        self.figure.segment(x0="x", y0="low", x1="x", y1="high", source=self._curve, color=COLOURS[5])
        self.figure.scatter("x", "y", source=self._point, color=COLOURS[3], size=11, line_color="black")

    def show_point(self, solution: Solution | None) -> None:
        """Set the point to a solution, or take it away."""
        if solution is None:
            _clear(self._point)
            return
        place = self._place(own_value(self._control, solution.scene))
        area = solution.observables.contact_area_subgrid
        _put(self._point, {"x": np.array([place]), "y": np.array([area])})
        self._set_range()

    def show_curve(self, curve: Curve | None) -> None:
        """Draw a curve as far as it is known, and say on which grid it was computed; None: take it away."""
        if curve is None or not curve.found:
            _clear(self._curve)
            self.figure.title.text = "the curve follows when nothing moves"
            return
        value, area, error = curve.points()
        x = np.array([self._place(v) for v in value])
        _put(self._curve, {"x": x, "y": area, "low": np.maximum(area - error, 1e-3 * area), "high": area + error})
        failed = f", {curve.failed} without an answer" if curve.failed else ""
        self.figure.title.text = f"{counted(value.size, 'scene')} on {curve.num_points} points each{failed}"
        self._set_range()

    def _set_range(self) -> None:
        """Show the point and the curve; an error bar may reach down to 0."""
        area = np.concatenate([self._point.data["y"], self._curve.data["y"]])
        if area.size and area.min() > 0:
            self.figure.y_range.update(start=1 / _up(1.2 / area.min()), end=_up(1.2 * area.max()))

    def _place(self, value: float) -> float:
        """Where a number stands on the axis; the half-space at its end."""
        return value if math.isfinite(value) else 10 ** (self._high + 0.5)
