"""A layer that slides on a rigid base without friction.

    K(q) = (E* q/2) f(q d),  f(y) = (sinh 2y + 2y)/(cosh 2y - 1)

(K. L. Johnson, Contact Mechanics, 1985, section 5.8). With x = 2y and both parts times exp(-x),

    numerator   = (1 - e^-2x)/2 + x e^-x
    denominator = (1 - e^-x)^2/2,

so nothing overflows or cancels. Poisson's ratio is in E* alone. The long waves find the foundation modulus E*/d: the
layer may spread along the base, so also an incompressible one is compressed.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from .. import checks
from ..arrays import Array64
from .layer import DEFAULT_MODULUS, ElasticLayer, check_modulus

_HALF_SPACE_FROM = 25.0  # q d from which f differs from 1 by less than rounding


def sliding_factor(y: Array64) -> Array64:
    """f(y), the layer's stiffness over the half-space's, for y = q d > 0 of any size; shape of `y`, dimensionless."""
    y = np.asarray(y, dtype=np.float64)
    found = np.ones_like(y)
    deep = y < _HALF_SPACE_FROM
    x = 2 * y[deep]
    found[deep] = (-np.expm1(-2 * x) + 2 * x * np.exp(-x)) / np.expm1(-x) ** 2
    return found


@dataclass(frozen=True)
class SlidingLayer(ElasticLayer):
    """An elastic layer on a rigid base without friction.

    Raises `ValueError`.
    """

    thickness: float
    """Layer thickness d > 0 [length]; inf is the half-space."""
    contact_modulus: float = DEFAULT_MODULUS
    """E* = E/(1-nu^2) > 0 [pressure]."""
    youngs_modulus: float | None = None
    """E > 0 [pressure], to give with Poisson's ratio instead of E*, which is computed from them."""
    poisson_ratio: float | None = None
    """Poisson's ratio, -1 < nu <= 0.5, of Young's modulus (dimensionless); without that E* tells all."""

    name: ClassVar[str] = "sliding"

    def __post_init__(self) -> None:
        thickness = checks.real("thickness", self.thickness, "a length > 0, or inf", 0, infinite=True)
        if self.poisson_ratio is not None:
            checks.real("poisson_ratio", self.poisson_ratio, "-1 < nu <= 0.5", -1, 0.5)
            if self.youngs_modulus is None:
                raise ValueError(f"poisson_ratio is {self.poisson_ratio}; allowed: with youngs_modulus; E* tells all")
        check_modulus(self)
        checks.assign(self, thickness=thickness, poisson_ratio=None)

    def stiffness(self, wave_numbers: Array64, period: float) -> Array64:
        k = wave_numbers / 2
        if math.isinf(self.thickness):
            return k
        return np.asarray(k * sliding_factor(wave_numbers * (self.thickness / period)))

    def foundation_modulus(self, period: float) -> float:
        return period / self.thickness

    def to_dict(self) -> dict[str, Any]:
        return {"layer": self.name, "thickness": self.thickness, "contact_modulus": self.contact_modulus}

    def ratios(self, period: float) -> dict[str, float]:
        return {"thickness/period": self.thickness / period} if math.isfinite(self.thickness) else {}

    def in_units(self, length: float, pressure: float) -> Self:
        return replace(self, thickness=self.thickness * length, contact_modulus=self.contact_modulus * pressure)
