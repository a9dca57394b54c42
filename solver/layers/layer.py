"""The members that a layer must have, and those that it may have so that a solve to an accuracy can take shortcuts.

A new layer is a frozen dataclass that inherits from `ElasticLayer`. It must offer everything without a default here;
the defaults of the rest say "not known", and then no shortcut is taken.
"""

import math
from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from .. import checks
from ..arrays import Array64
from ..value import Kind

DEFAULT_MODULUS = float(1)
"""The default E* [pressure], an object of its own: a modulus that is given is another one."""

HALF_SPACE_FROM = 25.0
"""q d from which a homogeneous layer is a half-space to rounding: to 2000 exp(-50), bonded with nu = 1/2."""


def homogeneous_stiffness(q: Array64, thickness: float, factor: Callable[[Array64], Array64]) -> Array64:
    """K(q) = (q/2) f(q d) for q > 0 of any shape, in the unit of E* q.

    thickness: d in the unit of 1/q, `inf` for the half-space. factor: f, asked for x = 2 q d, where it differs from 1.
    """
    q = np.asarray(q, dtype=np.float64)  # a number is of a shape, too
    k, long = np.array(q / 2), q < HALF_SPACE_FROM / thickness
    with np.errstate(under="ignore"):
        k[long] *= factor(2 * thickness * q[long])
    return k


def own_stiffness(what: str, unit: str, function: Callable[[Array64], Any], q: Array64, part: object = None) -> Array64:
    """K(q) > 0 by a function that may be one's own, shape of `q`. unit: of q, with its name; part: see `own_code`.

    Raises `ValueError` for a function that fails, and for values not positive and finite, or not of that shape.
    """
    with checks.own_code(what, "allowed: a function of an array of wave numbers", part):
        found = np.asarray(function(q))
    if found.shape != q.shape or found.dtype.kind not in "fiu":
        allowed = f"real numbers of the wave numbers' shape, {q.shape}"
        raise ValueError(f"{what} has shape {found.shape} and type {found.dtype}; allowed: {allowed}")
    if not 0 < found.min() <= found.max() < math.inf:
        bad = np.flatnonzero(~((found > 0) & (found < math.inf)))[0]
        raise ValueError(f"{what} is {found[bad]:.3g} at {unit} = {q[bad]:.6g}; allowed: finite numbers > 0")
    return found


def check_modulus(layer: Any, prefix: str = "") -> None:
    """Check Poisson's ratio, where there is one, and E* > 0 of a layer that is being made, and compute E* where E is
    given instead. Raises `ValueError`.

    prefix: of the fields of the base.
    """
    modulus, young, ratio = f"{prefix or 'contact_'}modulus", f"{prefix}youngs_modulus", f"{prefix}poisson_ratio"
    known, given, nu = (getattr(layer, name) for name in (modulus, young, ratio))
    fields = type(layer).__dataclass_fields__
    if nu is not None or fields[ratio].default is not None:  # some layers do without
        nu = checks.real(ratio, nu, "-1 < nu <= 0.5", -1, 0.5)
    missing = known is fields[modulus].default
    both = "allowed: one of the two, E* = E/(1-nu^2)"
    if given is None and missing and math.isnan(known):
        raise ValueError(f"{modulus} (or {young}) is missing; {both}")
    if given is not None:
        if not missing:
            raise ValueError(f"{young} is {given!r}, and {modulus} {known!r}; {both}")
        if nu is None:
            raise ValueError(f"{ratio} is missing; allowed: -1 < nu <= 0.5 beside {young}, for E* = E/(1-nu^2)")
        known = checks.real(young, given, "a finite pressure > 0", 0) / (1 - nu**2)
        checks.real(young, known, "one whose E* = E/(1-nu^2) is finite", 0)
    checks.assign(layer, **{modulus: checks.real(modulus, known, "a finite pressure > 0", 0), young: None, ratio: nu})


class ElasticLayer(Kind):
    """An elastic layer and its base, as the program needs to know them."""

    part: ClassVar[str] = "layer"

    contact_modulus: float
    """E* > 0 [pressure], the modulus with which short waves find a half-space: K(q) = E* q/2."""
    thickness: float
    """d > 0 [length], the layer's length scale: much shorter waves find a half-space; `inf` for a half-space. On a grid
    whose shortest wave does not find one, K(q) alone is believed."""

    @abstractmethod
    def stiffness(self, wave_numbers: Array64, period: float) -> Array64:
        """K(q) of the waves q = `wave_numbers`/L > 0, of their shape, in units of E*/L.

        wave_numbers: q L > 0 of any shape (dimensionless). period: L [length].
        """

    @abstractmethod
    def foundation_modulus(self, period: float) -> float:
        """K(0), the modulus k_W of the Winkler foundation that long waves find, in units of E*/L.

        0 for a half-space, `inf` for an incompressible layer. period: L [length].
        """

    @property
    def has_default_modulus(self) -> bool:
        """Whether nobody gave E* when this was made, so that pressures are in units of it. Copies do not know."""
        return self.contact_modulus is DEFAULT_MODULUS

    def check(self, period: float) -> None:
        """Raise `ValueError` if this is no layer for the period L [length]."""
        return

    def ratios(self, period: float) -> dict[str, float]:
        return {"thickness/period": self.thickness / period} if math.isfinite(self.thickness) else {}

    @property
    def edge_shift(self) -> float | None:
        """How far a contact reaches beyond that on the Winkler foundation, to first order [length]; None: not known."""
        return None

    @property
    def bonded(self) -> tuple[float, float] | None:
        """Thickness [length] and Poisson's ratio where this is the bonded layer of the closed forms and the collocation
        (`linecontact.solver.reference`); None for any other layer.
        """
        return None
