"""The published study's layer: elastic, of any thickness and Poisson's ratio, bonded to a rigid base.

Convention: u(x) = sum_k u_k exp(i q_k x) with q_k = 2 pi k/L; the elastic pressure of mode k is K(q_k) u_k.

    K(q) = (E* q/2) f(q d),  f(y) = [(3-4nu) cosh 2y + 2y^2 - 4nu(3-2nu) + 5] / [(3-4nu) sinh 2y - 2y]

(G. Carbone and L. Mangialardi, J. Mech. Phys. Solids 56, 684 (2008); the published study's eq. 4.) As it stands, cosh
overflows at q d = 355, and the denominator cancels for small q d as nu goes to 1/2. With x = 2y and both parts times
exp(-x),

    numerator   = (3-4nu) (1 + e^-2x)/2 + (x^2/2 + 5 - 12nu + 8nu^2) e^-x
    denominator = (2-4nu) (1 - e^-2x)/2 + (sinh x - x) e^-x,

every term is positive; sinh x - x comes from its series where it would cancel.
"""

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, ClassVar, Self

import numpy as np

from .. import checks
from ..arrays import Array64
from .edge_shift import wiener_hopf_shift
from .exponentials import sinh_minus_argument
from .layer import DEFAULT_MODULUS, ElasticLayer, check_modulus

_HALF_SPACE_FROM = 25.0  # q d from which f differs from 1 by less than rounding: by 2000 exp(-50), nu = 1/2


def layer_factor(y: Array64, poisson_ratio: float) -> Array64:
    """f(y), the layer's stiffness over the half-space's, for y = q d > 0 of any size; shape of `y`, dimensionless."""
    y = np.asarray(y, dtype=np.float64)
    found, nu = np.ones_like(y), poisson_ratio
    deep = y < _HALF_SPACE_FROM
    x = 2 * y[deep]
    with np.errstate(under="ignore"):
        e = np.exp(-x)
        e2 = np.exp(-2 * x)
        numerator = (3 - 4 * nu) * (1 + e2) / 2 + (x**2 / 2 + (5 - 12 * nu + 8 * nu**2)) * e
        denominator = (2 - 4 * nu) * -np.expm1(-2 * x) / 2 + sinh_minus_argument(x)
    found[deep] = numerator / denominator
    return found


def stiffness(wave_numbers: Array64, thickness: float, poisson_ratio: float) -> Array64:
    """K(q) for wave numbers q > 0 of any shape, in the unit of E* q (the published study's eq. 4).

    thickness: d in the unit of 1/q, `inf` for the half-space.
    """
    k = wave_numbers / 2
    return k * layer_factor(wave_numbers * thickness, poisson_ratio) if math.isfinite(thickness) else k


def foundation_modulus(thickness: float, poisson_ratio: float) -> float:
    """Winkler modulus k_W = E* (1-nu)^2/((1-2nu) d), the limit K(0) for nu < 1/2, in units of E* over d's unit.

    0 for the half-space, `inf` for nu = 1/2.
    """
    if poisson_ratio == 0.5:
        return math.inf
    return (1 - poisson_ratio) ** 2 / ((1 - 2 * poisson_ratio) * thickness)


def foundation_compliance(poisson_ratio: float) -> float:
    """(1-2nu)/(1-nu)^2, the compliance 1/k_W of the Winkler foundation in units of d/E* (dimensionless)."""
    return (1 - 2 * poisson_ratio) / (1 - poisson_ratio) ** 2


@cache
def edge_shift(poisson_ratio: float) -> float:
    """c(nu) of the thin layer's effective half-width a + c d (dimensionless), see `wiener_hopf_shift`."""
    nu = poisson_ratio

    def factor(y: Array64) -> Array64:
        return layer_factor(y, nu)

    if nu == 0.5:
        return wiener_hopf_shift(factor, 4 / 3, 2, 1e-3)
    return wiener_hopf_shift(factor, foundation_compliance(nu), 0, 1e-3 * math.sqrt(1 - 2 * nu))


@dataclass(frozen=True)
class Layer(ElasticLayer):
    """An elastic layer bonded to a rigid base.

    Raises `ValueError`.
    """

    thickness: float = math.inf
    """Layer thickness d > 0 [length]; inf is the half-space."""
    poisson_ratio: float = 0.25
    """Poisson's ratio, -1 < nu <= 0.5 (dimensionless)."""
    contact_modulus: float = DEFAULT_MODULUS
    """E* = E/(1-nu^2) > 0 [pressure]."""
    youngs_modulus: float | None = None
    """E > 0 [pressure], to give instead of E*, which is computed from it (and is what the layer then keeps)."""

    name: ClassVar[str] = "bonded"

    def __post_init__(self) -> None:
        checks.assign(
            self,
            thickness=checks.real("thickness", self.thickness, "a length > 0, or inf", 0, infinite=True),
            poisson_ratio=checks.real("poisson_ratio", self.poisson_ratio, "-1 < nu <= 0.5", -1, 0.5),
        )
        check_modulus(self)

    def stiffness(self, wave_numbers: Array64, period: float) -> Array64:
        return stiffness(wave_numbers, self.thickness / period, self.poisson_ratio)

    def foundation_modulus(self, period: float) -> float:
        return foundation_modulus(self.thickness / period, self.poisson_ratio)

    def to_dict(self) -> dict[str, Any]:
        return {
            "layer": self.name,
            "thickness": self.thickness,
            "poisson_ratio": self.poisson_ratio,
            "contact_modulus": self.contact_modulus,
        }

    def ratios(self, period: float) -> dict[str, float]:
        return {"thickness/period": self.thickness / period} if math.isfinite(self.thickness) else {}

    def in_units(self, length: float, pressure: float) -> Self:
        return replace(self, thickness=self.thickness * length, contact_modulus=self.contact_modulus * pressure)

    @property
    def edge_shift(self) -> float | None:
        """c(nu) d, see `ElasticLayer`."""
        return edge_shift(self.poisson_ratio) * self.thickness

    @property
    def bonded(self) -> tuple[float, float] | None:
        return self.thickness, self.poisson_ratio
