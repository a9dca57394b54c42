"""The choices of the user at the start: layer, indenters, grid, and a scan if it is one.

From here on a scene is told by a few numbers, its `Values`: those of a link, and those that the sliders move.
"""

import math
import os
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Self
from urllib.parse import urlencode

from linecontact.solver import Indenter, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene
from linecontact.solver.scene import PRECISIONS
from linecontact.solver.units import shown, unit

from ..figures.units import shown_units
from ..terminal.options import flag
from ..terminal.text import number
from .controls import CONTROLS, Control

_LARGEST = 2.0**63  # of a number in a link, but for infinity
_SHOWN = 40  # characters of a bad one

Values = Mapping[str, Any]
"""The indenter's name under 'profile', and the numbers of all controls by name, in the scene's units."""


@dataclass(frozen=True)
class Scan:
    """The file of a measured scan, which was read once."""

    path: Path
    """The file, as the user named it."""
    words: tuple[str, ...]
    """The words of a command line that read it."""
    stamp: tuple[int, int] | None
    """Its size and time when it was read."""

    @classmethod
    def of(cls, path: Path, options: Mapping[str, Any]) -> Self:
        """The scan that a file holds now; options: those that read it, by name."""
        words: list[str] = []
        own = {} if options.get("scene_units") else {"length_unit": "m"}  # unit of the numbers
        for name, value in {**own, **options}.items():
            if name not in ("num_points", "period"):  # the scene says them
                words += [flag(name)] if value is True else [flag(name), str(value)]
        return cls(path, tuple(words), cls.stamp_of(path))

    @staticmethod
    def stamp_of(path: Path) -> tuple[int, int] | None:
        """Size [bytes] and time of change [ns] of a file; None if it is not there."""
        try:
            found = os.stat(path)
        except OSError:
            return None
        return found.st_size, found.st_mtime_ns

    def trouble(self) -> str:
        """How the file has changed since it was read; empty if it has not."""
        now = self.stamp_of(self.path)
        if now == self.stamp:
            return ""
        return f"scan {self.path} {'has changed' if now else 'is no longer there'} since it was read"


@dataclass(frozen=True)
class Start:
    """The scene at the start, and all other choices. Period, grid and E* stay as they are here."""

    first: Scene
    """The scene at the start."""
    scan: Scan | None = None
    """Its scan, if its indenter is one."""
    indenters: dict[str, Indenter] = field(init=False)
    """The choices on the page, by name: a scan alone, for its period and grid belong to no other."""

    def __post_init__(self) -> None:
        own = self.first.indenter
        others = () if isinstance(own, MeasuredIndenter) else (PowerIndenter(radius=self.first.period), RoughIndenter())
        object.__setattr__(self, "indenters", {own.name: own})
        for other in others:
            self.indenters.setdefault(other.name, other)

    def controls(self) -> tuple[Control, ...]:
        """Those whose field one of the scenes has; the thickness of a layer that cannot be a half-space has an end."""
        along, _, pressures = shown_units(self.first.to_dict())
        units = {"thickness": along, "pressure": pressures}
        found = (control for control in CONTROLS if control.name in self.values())
        found = (c.shown_as(units[c.name], self.first) if c.name in units else c for c in found)
        return tuple(
            control if not control.endless or self._may_be_infinite(control) else replace(control, endless=False)
            for control in found
        )

    def values(self) -> dict[str, Any]:
        """The values of the scene at the start, and first values of the other indenters."""
        found: dict[str, Any] = {"profile": self.first.indenter.name}
        for control in CONTROLS:
            for owner in self._owners(control):
                if getattr(owner, control.name, None) is not None:
                    found.setdefault(control.name, getattr(owner, control.name))
        return found

    def uses(self, control: Control, profile: str) -> bool:
        """Whether a control moves anything in scenes with the indenter of that name."""
        return control.part != "indenter" or control.name in _names(self.indenters[profile])

    def scene(self, values: Values) -> Scene:
        """The scene of these values. Raises `ValueError`."""
        parts: dict[str, dict[str, Any]] = {"layer": {}, "indenter": {}, "scene": {}}
        for control in self.controls():
            if self.uses(control, values["profile"]):
                parts[control.part][control.name] = values[control.name]
        indenter = self.indenters[values["profile"]]
        if parts["indenter"]:
            indenter = replace(indenter, **parts["indenter"])  # type: ignore[type-var]
        layer = replace(self.first.layer, **parts["layer"])  # type: ignore[type-var]
        return replace(self.first, layer=layer, indenter=indenter, **parts["scene"])

    def read_link(self, arguments: Mapping[str, list[bytes]]) -> dict[str, Any]:
        """The values of a link's query; others are as at the start. Raises `ValueError`."""
        found = self.values()
        for name, texts in arguments.items():
            text = texts[-1].decode(errors="replace")
            if name.startswith("bokeh-"):
                continue  # of the server's own client
            if name not in found:
                raise ValueError(f"the link gives {name}; allowed: {', '.join(found)}")
            own = shown(unit(name), self.first.units)
            found[name] = _choice(text, self.indenters) if name == "profile" else _number(name, text, own)
        for profile, indenter in self.indenters.items():
            if profile == found["profile"] or _names(indenter) & set(arguments):
                self.scene(found | {"profile": profile})  # refuses values out of bounds
        return found

    def query(self, values: Values) -> str:
        """The values as the query of a link."""
        used = {c.name: values[c.name] for c in self.controls() if self.uses(c, values["profile"])}
        return urlencode({"profile": values["profile"]} | used)

    def command(self, scene: Scene) -> str:
        """The command line that solves a scene of these."""
        given = scene.to_dict()
        if self.scan:
            own = {name: given[name] for name in given if not name.startswith("profile")}
            words = ["--profile", scene.indenter.name, *self.scan.words]
            given = {name: value for name, value in own.items() if name != "period"}
        else:
            words = ["--profile", given.pop("profile")]
        if given.get("precision") == PRECISIONS[0]:
            given.pop("precision")
        for name, value in given.items():
            words += [flag(name), str(value)]
        return shlex.join(["linecontact", "solve", *words])

    def _may_be_infinite(self, control: Control) -> bool:
        """Whether the layer takes that number of its own, which a coating's thickness cannot be."""
        try:
            replace(self.first.layer, **{control.name: math.inf})  # type: ignore[type-var]
        except ValueError:
            return False
        return True

    def _owners(self, control: Control) -> list[Any]:
        if control.part == "indenter":
            return list(self.indenters.values())
        return [self.first.layer if control.part == "layer" else self.first]


def _names(part: Any) -> set[str]:
    return {entry.name for entry in fields(part) if entry.init}


def _choice(text: str, indenters: Mapping[str, Indenter]) -> str:
    if text not in indenters:
        raise ValueError(f"profile is {text!r}; allowed: {', '.join(indenters)}")
    return text


def _number(name: str, text: str, unit: str) -> float:
    for kind in (int, number):
        try:
            found = kind(text)
            if float(found) < _LARGEST or found == math.inf:
                return found
        except (ValueError, OverflowError):
            continue
    raise ValueError(f"{name} is {text[:_SHOWN]!r}; allowed: a number alone [{unit}], below {_LARGEST:g}")
