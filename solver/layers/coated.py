"""A layer bonded to an elastic half-space of its own modulus and Poisson's ratio: the coated half-space.

With the shear moduli's ratio m = mu_1/mu_2 of layer and half-space, alpha = 3 - 4 nu_1, beta = 3 - 4 nu_2, x = 2 q d
and e = exp(-x), the response function of T. Nogi and T. Kato (J. Tribology 119, 493 (1997)), both parts multiplied by
(1 + m beta)(m + alpha), is

    K(q) = (E* q/2) D/N
    D = alpha [1 + e^2] + (alpha^2 + 1 + x^2) e + m [(1-e)(1 + alpha beta + (alpha + beta) e) + (beta-1) x^2 e]
        + m^2 beta [(1-e)^2 - x^2 e]
    N = [alpha (1-e^2) - 2 x e] + m [(2 + beta (alpha-1)) + (alpha + 2 beta - 1) e^2 + (beta-1)(1 - e^2 - 2 x e)]
        + m^2 beta [1 - e^2 + 2 x e]

E* the layer's. Every bracket is positive, and those that cancel for small x come from the series of sinh: 1 - e^2 -
2 x e = 2 (sinh x - x) e and, with z = x/2, (1-e)^2 - x^2 e = 4 (sinh^2 z - z^2) e. For m = 0 it is the bonded layer,
for equal materials the half-space; long waves find the half-space below, short ones that of the layer's material.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .. import checks
from ..arrays import Array64
from .layer import DEFAULT_MODULUS, ElasticLayer, check_modulus, homogeneous_stiffness

_MOST_RATIO = 1e6
"""Of the larger over the smaller of the two contact moduli (dimensionless)."""

_SERIES_BELOW = 2.0  # x below which sinh x - x would cancel


def stiffness(
    q: Array64, thickness: float, poisson_ratio: float, base_ratio: float = 0.0, shear_ratio: float = 0.0
) -> Array64:
    """K(q), see `homogeneous_stiffness`. base_ratio: Poisson's of the base; shear_ratio: m, 0 for a rigid base."""
    m, alpha, beta = shear_ratio, 3 - 4 * poisson_ratio, 3 - 4 * base_ratio

    def factor(x: Array64) -> Array64:
        e, below, below2 = np.exp(-x), -np.expm1(-x), -np.expm1(-2 * x)  # e, 1 - e, 1 - e^2
        e2, tiny = e * e, 2 * _sinh_minus_argument(x)  # 1 - e^2 - 2 x e
        stiff = alpha * (1 + e2) + (alpha**2 + 1 + x**2) * e
        soft = (alpha - 1) * below2 + tiny
        if m:
            z = x / 2
            flat = 4 * _sinh_minus_argument(z) * (below / 2 + z * np.exp(-z))  # (1-e)^2 - x^2 e
            stiff += m * (below * (1 + alpha * beta + (alpha + beta) * e) + (beta - 1) * x**2 * e) + m**2 * beta * flat
            soft += m * (2 + beta * (alpha - 1) + (alpha + 2 * beta - 1) * e2 + (beta - 1) * tiny)
            soft += m**2 * beta * (below2 + 2 * x * e)
        return np.asarray(stiff / soft)

    return homogeneous_stiffness(q, thickness, factor)


def _sinh_minus_argument(x: Array64) -> Array64:
    """(sinh x - x) exp(-x) without cancellation; shape of `x` >= 0."""
    e = np.exp(-x)
    found = -np.expm1(-2 * x) / 2 - x * e
    small, power = x < _SERIES_BELOW, 3
    square = x[small] ** 2
    term = x[small] * square / 6
    series = term.copy()
    while (term > np.finfo(np.float64).eps * series).any():
        power += 2
        term *= square / (power * (power - 1))
        series += term
    found[small] = series * e[small]
    return np.asarray(found)


@dataclass(frozen=True)
class CoatedHalfSpace(ElasticLayer):
    """An elastic layer bonded to an elastic half-space.

    Raises `ValueError`.
    """

    thickness: float
    """Layer thickness d > 0 [length]."""
    base_modulus: float = math.nan
    """E* = E/(1-nu^2) > 0 of the half-space below [pressure], from 1e-6 to 1e6 of the layer's; it must be given."""
    poisson_ratio: float = 0.25
    """Poisson's ratio of the layer, -1 < nu <= 0.5 (dimensionless)."""
    base_poisson_ratio: float = 0.25
    """Poisson's ratio of the half-space below, -1 < nu <= 0.5 (dimensionless)."""
    contact_modulus: float = DEFAULT_MODULUS
    """E* = E/(1-nu^2) > 0 of the layer [pressure]."""
    youngs_modulus: float | None = None
    """E > 0 of the layer [pressure], to give instead of E*, which is computed from it."""
    base_youngs_modulus: float | None = None
    """E > 0 of the half-space below [pressure], to give instead of its E*."""

    name: ClassVar[str] = "coated"

    def __post_init__(self) -> None:
        ratio = "-1 < nu <= 0.5"
        checks.assign(
            self,
            thickness=checks.real("thickness", self.thickness, "a finite length > 0", 0),
            poisson_ratio=checks.real("poisson_ratio", self.poisson_ratio, ratio, -1, 0.5),
            base_poisson_ratio=checks.real("base_poisson_ratio", self.base_poisson_ratio, ratio, -1, 0.5),
        )
        check_modulus(self)
        check_modulus(self, "base_")
        if not 1 / _MOST_RATIO <= self.base_modulus / self.contact_modulus <= _MOST_RATIO:
            least, own = 1 / _MOST_RATIO, self.contact_modulus
            allowed = f"from {least:g} to {_MOST_RATIO:g} of the layer's contact_modulus, {own:g}"
            raise ValueError(f"base_modulus is {self.base_modulus!r}; allowed: {allowed}")

    @property
    def shear_ratio(self) -> float:
        """The layer's shear modulus over that of the half-space below; E* = 2 mu/(1-nu)."""
        of_layer, of_base = (1 - self.poisson_ratio), (1 - self.base_poisson_ratio)
        return self.contact_modulus * of_layer / (self.base_modulus * of_base)

    def stiffness(self, wave_numbers: Array64, period: float) -> Array64:
        ratios = (self.poisson_ratio, self.base_poisson_ratio, self.shear_ratio)
        return stiffness(wave_numbers, self.thickness / period, *ratios)

    def foundation_modulus(self, period: float) -> float:
        return 0.0  # long waves find a half-space

    def to_dict(self) -> dict[str, Any]:
        names = ("thickness", "poisson_ratio", "contact_modulus", "base_modulus", "base_poisson_ratio")
        return {"layer": self.name} | {name: getattr(self, name) for name in names}
