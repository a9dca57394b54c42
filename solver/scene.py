"""The scene: a layer under an indenter. Frozen, validated, and free of any method's choices.

Units are the user's own, but consistent: one unit of length (thickness, radius, period) and one of pressure (contact
modulus, pressure). The defaults are the published study's: all three scales are 1.
"""

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any, Self

import numpy as np

from . import checks, display
from .arrays import Array64
from .indenters import INDENTERS, Indenter, PowerIndenter
from .layers import LAYERS, ElasticLayer, Layer
from .layers.tabulated import CLOSE
from .units import PRESSURES, named
from .value import Value

PRECISIONS = ("float64", "float32", "mixed")
MIN_POINTS, MAX_POINTS = 4, 2**30  # Warp indices are int32
SMALLEST = 1e-60
LARGEST = 1 / SMALLEST
"""Bounds on the units and on the dimensionless ratios of a scene."""

_LONG = (1e-3, 1e-6, 1e-9)
"""Long waves, over those of the longer of period and thickness; rounding may spoil K of the longest."""
_PRESSURE = float("2e-3")  # the default, an object of its own, by which it is told from a pressure that is given


@dataclass(frozen=True)
class Scene(Value):
    """A layer, an indenter, the mean external pressure, and the grid they are solved on.

    Everything is the same along a second axis (line contact, plane strain) and periodic along the first. There is
    neither friction nor adhesion; the layer is linear elastic, and strains and slopes count as small.

    Raises `ValueError`.
    """

    layer: ElasticLayer = field(default_factory=Layer)
    """The layer, for instance a `Layer`; see `ElasticLayer` for its members."""
    indenter: Indenter = field(default_factory=PowerIndenter)
    """The indenter, for instance a `PowerIndenter`; see `Indenter` for its members."""
    pressure: float = _PRESSURE
    """Mean external pressure p >= 0 [pressure]; at 0 nothing touches, and beyond full contact is allowed. NaN where the
    approach is given."""
    period: float = 1.0
    """Period L > 0 [length]."""
    num_points: int = 2**18
    """Grid points N, 4 to 2^30; x_i = i L/N. Any number will do; products of small primes transform fastest."""
    precision: str = "float64"
    """Precision of the iteration: 'float64', 'float32', or 'mixed': FIRE's transforms in float32, residuals in float64.
    The certificate is always float64."""
    approach: float | None = None
    """Rigid approach since first touch [length], to give instead of the pressure, which is then found; up to 0 nothing
    touches. See `Observables.approach`."""
    pressure_unit: str | None = None
    """Name of the unit of pressures and moduli where they are shown, 'Pa', 'kPa', 'MPa' or 'GPa'; it converts
    nothing."""

    def __post_init__(self) -> None:
        self._check_load()
        points = f"an integer from {MIN_POINTS} to {MAX_POINTS}"
        period = checks.real("period", self.period, "a finite length > 0", 0)
        num_points = checks.integer("num_points", self.num_points, points, MIN_POINTS, MAX_POINTS)
        checks.assign(self, period=period, num_points=num_points)
        checks.choice("precision", self.precision, PRECISIONS)
        if self.pressure_unit is not None:
            checks.choice("pressure_unit", self.pressure_unit, tuple(PRESSURES))
        _check_indenter(self.indenter, self.num_points, self.period)
        _check_layer(self.layer, self.period)
        self._check_scales()
        _check_foundation(self.layer, self.period)

    def _check_load(self) -> None:
        """Of pressure and approach one must be given, or none."""
        if self.approach is None:
            allowed = "a finite pressure >= 0, or an approach instead"
            pressure = checks.real("pressure", self.pressure, allowed, checks.BELOW_ZERO)
            checks.assign(self, pressure=pressure)
            return
        unknown = isinstance(self.pressure, float) and math.isnan(self.pressure)
        if self.pressure is not _PRESSURE and not unknown:
            raise ValueError(f"approach is {self.approach!r}, and pressure {self.pressure!r}; allowed: one of the two")
        approach = checks.real("approach", self.approach, "a finite length; up to 0 nothing touches")
        checks.assign(self, approach=approach, pressure=math.nan)

    def __repr__(self) -> str:
        """Layer, indenter and load, in a few lines with units; arrays and long texts are left out."""
        about = self.to_dict()
        shown = [name for name in ("pressure", "approach", "period", "num_points") if name in about]
        rows = (display.row(name, about[name], self.units) for name in shown)
        lines = "\n".join(
            [f"{display.sentence('Scene', rows)}, {self.precision}", *map(repr, (self.layer, self.indenter))]
        )
        for word, name in self.units.items():
            lines = lines.replace(f"[{word}]", f"[{name}]")
        return lines.replace("\n", "\n  ")

    def _repr_html_(self) -> str:
        """The same as a table, for a notebook."""
        return display.html_table("Scene", self.rows())

    def rows(self) -> list[display.Row]:
        """Everything that is known of the scene, as it is shown in a table."""
        rows = [display.row(name, value, self.units) for name, value in self.to_dict().items()]
        if self.approach is None:
            rows.append(display.Row("pressure/contact_modulus", display.number(self.reduced_load), "-"))
        return rows

    @property
    def length_unit(self) -> str:
        """The unit of length, where a scan has brought one with it; 'length' where it is the user's own."""
        return self.units["length"]

    @property
    def units(self) -> dict[str, str]:
        """The units of 'length' and 'pressure', as far as a scan or `pressure_unit` names them."""
        return named(self.to_dict())

    def _check_scales(self) -> None:
        """Refuse units and ratios whose products would overflow or underflow."""
        numbers = {"period [length]": self.period, "contact_modulus [pressure]": self.layer.contact_modulus}
        if self.approach:
            numbers["|approach|/period"] = abs(self.approach) / self.period
        if self.approach is None and self.pressure:
            numbers["pressure/contact_modulus"] = self.reduced_load
        numbers |= self.indenter.ratios(self.period) | self.layer.ratios(self.period)
        for name, value in numbers.items():
            if not SMALLEST <= value <= LARGEST:
                raise ValueError(f"{name} is {value:.3g}; allowed: from {SMALLEST:.0e} to {LARGEST:.0e}")

    @property
    def reduced_load(self) -> float:
        """p/E* (dimensionless); NaN where the approach is given."""
        return self.pressure / self.layer.contact_modulus

    @property
    def x(self) -> Array64:
        """Grid x_i = i L/N, shape (N,) [length]."""
        return self.period * (np.arange(self.num_points) / self.num_points)

    @property
    def profile(self) -> Array64:
        """Heights h(x_i) above the lowest point, shape (N,) [length]."""
        return self.period * self.indenter.profile(self.num_points, self.period)

    @property
    def first_node(self) -> float:
        """The approach at which the first node touches [length]; the lowest point between the nodes touches at 0."""
        return self.indenter.depth_between_nodes(self.profile)

    @property
    def foundation_modulus(self) -> float:
        """k_W of the layer [pressure/length]; 0 for a half-space, `inf` for an incompressible layer."""
        return self.layer.foundation_modulus(1.0) * self.layer.contact_modulus

    def on_grid(self, num_points: int) -> Self:
        """The same scene on another grid."""
        if num_points == self.num_points:
            return self
        return replace(self, indenter=self.indenter.on_grid(num_points, self.period), num_points=num_points)

    def to_dict(self) -> dict[str, Any]:
        """Flat, JSON-ready description under the command line's names; an infinite thickness becomes 'inf'."""
        load = {"pressure": self.pressure} if self.approach is None else {"approach": self.approach}
        grid = {name: getattr(self, name) for name in ("period", "num_points", "precision", "pressure_unit")}
        described = {**self.indenter.to_dict(), **load, **self.layer.to_dict(), **grid}
        return {name: checks.plain(value) for name, value in described.items() if value is not None}


def _check_layer(layer: ElasticLayer, period: float) -> None:
    """Raise `ValueError` unless this is a layer for the period L [length]."""
    if not isinstance(layer, ElasticLayer):
        raise checks.refusal("layer", layer, "a Layer, or another class that inherits from `ElasticLayer`")
    checks.real("thickness", getattr(layer, "thickness", None), "a length > 0, or inf", 0, infinite=True)
    _check_description("layer", layer, LAYERS)
    checks.real(f"contact_modulus of layer {layer.name}", layer.contact_modulus, "a finite pressure > 0", 0)
    layer.check(period)


def _check_foundation(layer: ElasticLayer, period: float) -> None:
    """Raise `ValueError` unless a layer's foundation modulus is one, and K of some long waves if it is one's own."""
    what, allowed = f"foundation_modulus of layer {layer.name}", "a number >= 0, inf where it is incompressible"
    modulus = checks.real(what, layer.foundation_modulus(period), allowed, checks.BELOW_ZERO, infinite=True)
    if type(layer).__module__.startswith(f"{__package__}."):
        return
    periods = float(layer.thickness) / period
    waves = 2 * np.pi * np.array([1.0, *(one / max(periods if periods < math.inf else 1.0, 1.0) for one in _LONG)])
    found = np.full(waves.shape, np.nan)
    with np.errstate(all="ignore"), suppress(Exception):  # one's own code: its errors are reported where it is used
        found[:] = layer.stiffness(waves, period)
    longest, *long_waves = found.tolist()
    known = [value for value in long_waves if math.isfinite(value) and value != longest]  # a layer may cut off there
    if 0 < modulus < math.inf:
        wrong = bool(known) and all(abs(value / modulus - 1) > CLOSE for value in known)
    else:  # there is no limit to compare with, but a stiffness that hardly changes has a finite one
        alike = all(abs(value - known[0]) <= CLOSE * known[0] for value in known)
        wrong = len(known) > 1 and known[0] > 0 and alike
    if wrong:
        at = ", ".join(f"{wave:.3g}" for wave in waves[1:])
        told = ", ".join(f"{value:.4g}" for value in long_waves)
        allowed = "the limit of its stiffness for long waves, in units of E*/L"
        raise ValueError(f"{what} is {modulus:.6g}, and its stiffness at q L = {at} is {told}; allowed: {allowed}")


def _check_indenter(indenter: Indenter, num_points: int, period: float) -> None:
    """Raise `ValueError` unless this is an indenter for a grid of so many points, and for the period L [length]."""
    if not isinstance(indenter, Indenter):
        allowed = "a PowerIndenter, RoughIndenter, MeasuredIndenter or another class that inherits from `Indenter`"
        raise checks.refusal("indenter", indenter, allowed)
    _check_description("indenter", indenter, INDENTERS)
    wave, allowed = indenter.shortest_wave(num_points), "an integer >= 0, 0 for a smooth profile"
    checks.integer(f"shortest_wave of indenter {indenter.name}", wave, allowed, 0, 2**53)
    own = indenter.given_period
    if own is not None:
        own = checks.real(f"given_period of indenter {indenter.name}", own, "a finite length > 0, or None", 0)
        if not math.isclose(period, own):
            raise ValueError(f"period is {period:.10g}; allowed: {own:.10g}, for which the heights were given")
    indenter.check(num_points)


def _check_description(what: str, part: Any, listed: Mapping[str, type]) -> None:
    """Raise `ValueError` unless a part has a name of its own and a description that can be stored."""
    name = getattr(part, "name", None)
    if not isinstance(name, str) or not name:
        raise checks.refusal(f"name of {what}", name, "a text that is not empty")
    owner = listed.get(name)
    if owner and not isinstance(part, owner) and owner.__module__.startswith(f"{__package__}."):
        raise ValueError(f"name of {what} is {name!r}, which is that of {owner.__name__}; allowed: another one")
    described = part.to_dict()
    if not isinstance(described, Mapping) or described.get(part.part) != name:
        allowed = f"a dictionary with {name!r} under {part.part!r}"
        raise ValueError(f"to_dict of {what} {name} gives {str(described)[:60]}; allowed: {allowed}")
    for key, value in described.items():
        several = value if isinstance(value, list | tuple) else [value]
        if any(not isinstance(one, (str, Real, np.bool_)) for one in several):
            allowed = "a number, a text, True or False, or several of them"
            raise ValueError(f"to_dict of {what} {name} has {key} {repr(value)[:40]}; allowed: {allowed}")
