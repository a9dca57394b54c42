"""A layer bonded to an elastic half-space of its own modulus and Poisson's ratio: the coated half-space."""

import math
from dataclasses import dataclass
from typing import ClassVar

from .. import checks
from ..arrays import Array64
from .bonded import stiffness
from .layer import DEFAULT_MODULUS, ElasticLayer, check_modulus

_MOST_RATIO = 1e6
"""Of the larger over the smaller of the two contact moduli (dimensionless)."""


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
        checks.assign(self, thickness=checks.real("thickness", self.thickness, "a finite length > 0", 0))
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
