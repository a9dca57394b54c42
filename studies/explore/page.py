"""The page of one browser tab: sliders, figures, the answer, and a thread of its own that finds it."""

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from html import escape
from typing import Any

from bokeh.document import Document
from bokeh.events import RangesUpdate
from bokeh.layouts import column, row
from bokeh.models import (
    Button,
    CustomJS,
    CustomJSTickFormatter,
    Div,
    RadioButtonGroup,
    Slider,
    TextAreaInput,
    TextInput,
)
from linecontact.solver.layers import ElasticLayer

from ..terminal.text import complain
from .answers import Answer, DroppedError, answer
from .controls import HALF_SPACE, LOAD, THICKNESS, Control
from .curves import Curve
from .newest import Newest
from .panels import NARROWEST, Fields, Surroundings
from .start import Start
from .wording import doubted, said

Later = Callable[[Callable[[], None]], object]
"""Has something done by whoever may change the document."""

_QUIET = 0.25
"""Time without an event after which curves are computed [s]."""

_PAINTED = 0.04
"""Time that a browser gets for painting an answer before it paints the curves about it [s]."""

_OFTEN = 0.5
"""Time after which a curve that is not yet complete is drawn [s]: every drawing costs the browser a painting."""

_SHOWN = 1.0
"""Time without an answer after which a newer event cuts no solve short [s]: who goes on dragging sees something."""

# Whatever a browser would fetch from elsewhere is refused by itself. Bokeh's scripts need the two that are unsafe.
# The page is as wide as the screen, also on a telephone.
TEMPLATE = """{% block preamble %}<meta http-equiv="Content-Security-Policy" content="default-src 'self' data: blob:
'unsafe-inline' 'unsafe-eval'"><meta name="viewport" content="width=device-width, initial-scale=1">{% endblock %}"""
_BESIDE = {"sizing_mode": "stretch_width", "styles": {"flex-wrap": "wrap"}}
"""Parts stand beside each other, on a narrow screen one below the other."""
_COPY = "navigator.clipboard.writeText(shown.value)"
_READ_ONLY = "for (const box of boxes) Bokeh.index.find_one(box).input_el.readOnly = true"
# Texts that change often stand in inputs: a new text of any other kind has the browser lay out the whole page again.
_SMALL = ["textarea { font: 11px monospace; word-break: break-all }"]
_PLAIN = ".bk-input { border-color: transparent; padding: 0; min-height: 20px }"
_TALL = "@media (max-width: 1100px) { textarea.bk-input { min-height: %dpx } }"
_ANSWER = [_PLAIN, "textarea { font-size: 13px }", _TALL % 170]
_DOUBTS = [_PLAIN, "textarea { font-size: 12px; color: #8a3a00 }", _TALL % 80]
_STATUS = [_PLAIN, "input { font-style: italic; height: 20px }"]


@dataclass(frozen=True)
class Event:
    """The numbers on the sliders at one moment."""

    values: Mapping[str, Any]
    """As in `start.Values`."""
    moment: float
    """When that was [s], of `time.perf_counter`."""


class Page:
    """Widgets, figures and texts of one document, and their effects."""

    def __init__(self, start: Start, values: Mapping[str, Any], address: str, later: Later) -> None:
        """values: to begin with. address: of the page, for its link. later: runs changes of the document."""
        self._start, self._values, self._address, self._later = start, dict(values), address, later
        self._controls = start.controls()
        first = start.first
        given = {control: [start.values()[control.name], values[control.name]] for control in self._controls}
        self._spans = {c: c.span([value / c.scale(first) for value in given[c]]) for c in self._controls}
        self._sliders = {control: self._slider(control) for control in self._controls}
        names = list(start.indenters)
        self._profile = RadioButtonGroup(name="profile", labels=names, active=names.index(values["profile"]))
        self._profile.on_change("active", lambda _, old, new: self._moved("profile", names[new]))
        self._status = TextInput(name="status", stylesheets=_STATUS, sizing_mode="stretch_width")
        wide: dict[str, Any] = {"max_length": None, "sizing_mode": "stretch_width"}
        self._answer = TextAreaInput(name="answer", rows=5, stylesheets=_ANSWER, **wide)
        self._doubts = TextAreaInput(name="doubts", rows=3, stylesheets=_DOUBTS, **wide)
        self._note = Div(name="note", styles={"color": "#8a5a00"})
        options = {"rows": 6, "max_length": None, "width": 330, "stylesheets": _SMALL}
        self._link, self._command = (TextAreaInput(name=name, **options) for name in ("link", "command"))
        self._fields = Fields(first)
        named = {control.name: control for control in self._controls}
        around = [named[control.name] for control in (LOAD, THICKNESS) if control.name in named]
        self._curves = {control: Curve(control) for control in around}
        self._around = {control: Surroundings(control, self._spans[control]) for control in around}
        self._fields.shape.on_event(RangesUpdate, lambda _: self._fields.thin())
        self._answered = time.perf_counter()
        self._newest = Newest(self._work)
        self._show_controls()
        self.ask()

    def layout(self) -> Any:
        """Everything, as the document's one root."""
        copies = []
        for text, shown in (("link", self._link), ("command", self._command)):
            button = Button(label=f"Copy the {text}", width=160)
            button.js_on_click(CustomJS(args={"shown": shown}, code=_COPY))
            copies += [button, shown]
        title = Div(text=f"<b>linecontact explore</b>: {_described(self._start.first.layer)}, under a rigid indenter")
        side = column(title, self._profile, *self._sliders.values(), *copies, self._note, width=350)
        curves = row(*(around.figure for around in self._around.values()), **_BESIDE)
        fields = (self._fields.shape, self._fields.pressure)
        parts = (self._answer, self._doubts, self._status, *fields, curves)
        return row(side, column(*parts, sizing_mode="stretch_width", min_width=NARROWEST), **_BESIDE)

    @property
    def texts(self) -> list[Any]:
        """The boxes that are to be read and copied, and not to be written in."""
        return [self._status, self._answer, self._doubts, self._link, self._command]

    def complain(self, text: str) -> None:
        """Say beside the sliders why a link is wrong."""
        self._note.text = escape(text)

    def end(self, patience: float = 0.0) -> None:
        """Stop working; waits so long for the work under way [s]."""
        self._newest.end(patience)

    def ask(self) -> None:
        """Have the scene on the sliders solved."""
        self._status.value = "Solving the scene on the sliders; the results shown are of the scene that they name."
        self._newest.ask(Event(dict(self._values), time.perf_counter()))

    def _slider(self, control: Control) -> Slider:
        low, high = self._spans[control]
        number = self._values[control.name] / control.scale(self._start.first)
        slider = Slider(
            name=control.name,
            title=control.title,
            start=low,
            end=high + control.step * control.endless,
            step=control.step,
            value=control.position(number, high),
            width=330,
        )
        if control.logarithmic:
            number_text = "Number((10**tick).toPrecision(3)).toString()"
            ends = f"tick > {high + control.step / 2} ? '{HALF_SPACE}' : " if control.endless else ""
            slider.format = CustomJSTickFormatter(code=f"return {ends}{number_text}")
        slider.on_change("value", lambda _, old, new: self._slid(control, float(new)))
        return slider

    def _slid(self, control: Control, position: float) -> None:
        number = control.value(position, self._spans[control][1])
        value = number * control.scale(self._start.first)
        self._moved(control.name, float(f"{value:.12g}") if control.logarithmic else value)

    def _moved(self, name: str, value: Any) -> None:
        self._values[name] = value
        if name == "profile":
            self._show_controls()
        self.ask()

    def _show_controls(self) -> None:
        for control, slider in self._sliders.items():
            slider.visible = self._start.uses(control, self._values["profile"])

    def _work(self, event: Event) -> None:
        """Answer an event, then look around it; on the thread of `Newest`."""
        with suppress(DroppedError):
            found = answer(lambda: self._start.scene(event.values), self._overtaken)
            self._answered = time.perf_counter()
            scene = found.scene if found.solution else None
            self._later(partial(self._show, event, found))
            if scene:
                for curve in self._curves.values():
                    curve.aim(scene)
                self._newest.outdated(_PAINTED)  # a pause, which a newer event ends
            curves = {control: curve.copy() for control, curve in self._curves.items()}
            self._later(partial(self._show_around, event, found, curves))
            if scene is None or self._newest.outdated(_QUIET):
                return
            for control, curve in self._curves.items():
                shown = time.perf_counter()
                for last in curve.work(scene, self._spans[control], self._newest.outdated):
                    if last or time.perf_counter() - shown > _OFTEN:
                        shown = time.perf_counter()
                        self._later(partial(self._around[control].show_curve, curve.copy()))

    def _overtaken(self) -> bool:
        """Whether the solve that is under way is to be cut short."""
        recent = time.perf_counter() - self._answered < _SHOWN
        return self._newest.ended or (recent and self._newest.outdated())

    def _show(self, event: Event, found: Answer) -> None:
        solution = found.solution
        self._answer.value, self._doubts.value = said(found, time.perf_counter() - event.moment), doubted(found)
        self._fields.show(solution)
        if self._start.scan and (trouble := self._start.scan.trouble()):
            _tell(trouble)
            self.complain(f"The {trouble}: the page goes on with the scan it has, the command may not repeat it.")

    def _show_around(self, event: Event, found: Answer, curves: Mapping[Control, Curve]) -> None:
        solution = found.solution
        for control, around in self._around.items():
            around.show_point(solution)
            around.show_curve(curves[control] if solution else None)
        self._command.value = self._start.command(found.scene) if found.scene else ""
        self._link.value = f"{self._address}?{self._start.query(event.values)}"
        if event.values == self._values:
            self._status.value = ""


def _described(layer: ElasticLayer) -> str:
    """The kind of layer, by the first sentence of its class's docstring, or by its name."""
    kind, doc = type(layer), type(layer).__doc__ or ""
    if not doc or doc.startswith(f"{kind.__name__}("):  # the one that Python makes
        return f"a layer of the kind {escape(layer.name)}"
    return escape(doc[0].lower() + doc[1:].split(".")[0])


@cache
def _tell(trouble: str) -> None:
    """One line on standard error for each trouble, however many pages find it."""
    complain(trouble)


def document(start: Start, address: str, doc: Document, arguments: Mapping[str, list[bytes]]) -> Page:
    """Fill a document for a link's arguments; errors in them are told on the page."""
    wrong, values = "", start.values()
    try:
        values = start.read_link(arguments)
    except ValueError as error:
        wrong = f"{error}; the page begins with the scene of the start instead"
    page = Page(start, values, address, doc.add_next_tick_callback)
    if wrong:
        page.complain(wrong)
    doc.title, doc.template = "linecontact explore", TEMPLATE
    doc.add_root(page.layout())
    doc.js_on_event("document_ready", CustomJS(args={"boxes": page.texts}, code=_READ_ONLY))
    return page
