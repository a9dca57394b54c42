"""A layer that slides on a rigid base without friction.

    K(q) = (E* q/2) f(q d),  f(y) = (sinh 2y + 2y)/(cosh 2y - 1)

(K. L. Johnson, Contact Mechanics, 1985, section 5.8). With x = 2y and both parts times exp(-x),

    numerator   = (1 - e^-2x)/2 + x e^-x
    denominator = (1 - e^-x)^2/2,

so nothing overflows or cancels. Poisson's ratio is in E* alone. The long waves find the foundation modulus E*/d: the
layer may spread along the base, so also an incompressible one is compressed.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .. import checks
from ..arrays import Array64
from .layer import DEFAULT_MODULUS, ElasticLayer, check_modulus, homogeneous_stiffness


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
        if self.poisson_ratio is not None and self.youngs_modulus is None:
            raise ValueError(f"poisson_ratio is {self.poisson_ratio}; allowed: with youngs_modulus; E* tells all")
        check_modulus(self)
        checks.assign(self, thickness=thickness, poisson_ratio=None)

    def stiffness(self, wave_numbers: Array64, period: float) -> Array64:
        def factor(x: Array64) -> Array64:
            return np.asarray((-np.expm1(-2 * x) + 2 * x * np.exp(-x)) / np.expm1(-x) ** 2)

        return homogeneous_stiffness(wave_numbers, self.thickness / period, factor)

    def foundation_modulus(self, period: float) -> float:
        return period / self.thickness
