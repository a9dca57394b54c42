"""The scene: what is pressed against what. Frozen, validated, and free of any method's choices.

Units are the user's own, but consistent: one unit of length (thickness, radius, period) and one of pressure (contact
modulus, pressure). The defaults are the published study's: all three scales are 1.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from . import checks, display
from .arrays import Array64
from .indenters import Indenter, PowerIndenter
from .layers import ElasticLayer, Layer
from .units import PRESSURES, named
from .validate import check_foundation, check_indenter, check_layer
from .value import Value

PRECISIONS = ("float64", "float32", "mixed")
MIN_POINTS, MAX_POINTS = 4, 2**30  # Warp indices are int32
SMALLEST = 1e-60
LARGEST = 1 / SMALLEST
"""Bounds on the units and on the dimensionless ratios of a scene."""

_PRESSURE = float("2e-3")  # the default, an object of its own, by which it is told from a pressure that is given


@dataclass(frozen=True)
class Scene(Value):
    """A layer, an indenter, the mean external pressure, and the grid they are solved on.

    Everything is the same along a second axis (line contact, plane strain) and periodic along the first. There is
    neither friction nor adhesion; the layer is linear elastic, and strains and slopes count as small.

    Raises `ValueError`.
    """

    layer: ElasticLayer = field(default_factory=Layer)
    """The layer, for instance a `Layer`; see `ElasticLayer` for what it must offer."""
    indenter: Indenter = field(default_factory=PowerIndenter)
    """The indenter, for instance a `PowerIndenter`; see `Indenter` for what it must offer."""
    pressure: float = _PRESSURE
    """Mean external pressure p >= 0 [pressure]; at 0 nothing touches, and beyond full contact is allowed. NaN where the
    approach is given."""
    period: float = 1.0
    """Period L > 0 [length]."""
    num_points: int = 2**18
    """Grid points N, 4 to 2^30; x_i = i L/N. Any number will do; products of small primes transform fastest."""
    precision: str = "float64"
    """Precision of the iteration: 'float64', 'float32', or 'mixed': float32 transforms inside, residuals in
    float64. The certificate is always float64."""
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
        check_indenter(self.indenter, self.num_points, self.period)
        check_layer(self.layer, self.period)
        self._check_scales()
        check_foundation(self.layer, self.period)

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
        """What is pressed against what, in a few lines with units; arrays and long texts are left out."""
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
