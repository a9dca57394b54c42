"""The scene: what is pressed against what. Frozen, validated, and free of any method's choices.

Units are the user's own, but consistent: one unit of length (thickness, radius, period) and one of pressure (contact
modulus, pressure). The defaults are the published study's: all three scales are 1.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import checks
from .indenters import Indenter, PowerIndenter

Array64 = NDArray[np.float64]

PRECISIONS = ("float64", "float32", "mixed")
MIN_POINTS, MAX_POINTS = 4, 2**30  # Warp indices are int32
SMALLEST, LARGEST = 1e-60, 1e60
"""Of the units and ratios of a scene (dimensionless ratios; any unit of length or pressure)."""


@dataclass(frozen=True)
class Layer:
    """An elastic layer bonded to a rigid base.

    thickness: d > 0 [length]; `inf` is the half-space.
    poisson_ratio: -1 < nu <= 1/2 [-].
    contact_modulus: E* = E/(1-nu^2) > 0 [pressure].

    Raises `ValueError`.
    """

    thickness: float = math.inf
    poisson_ratio: float = 0.25
    contact_modulus: float = 1.0

    def __post_init__(self) -> None:
        checks.assign(
            self, "thickness", checks.real("thickness", self.thickness, "a length > 0, or inf", 0, infinite=True)
        )
        checks.assign(
            self, "poisson_ratio", checks.real("poisson_ratio", self.poisson_ratio, "-1 < nu <= 0.5", -1, 0.5)
        )
        checks.assign(
            self, "contact_modulus", checks.real("contact_modulus", self.contact_modulus, "a finite pressure > 0", 0)
        )


@dataclass(frozen=True)
class Scene:
    """A layer, an indenter, the mean external pressure, and the grid they are solved on.

    pressure: mean external pressure p > 0 [pressure]; beyond full contact is allowed.
    period: L > 0 [length].
    num_points: N, 4 to 2^30; x_i = i L/N. Any number will do (kernels pad), products of small primes transform fastest.
    precision: of the iteration, 'float64', 'float32', or 'mixed': float32 inside with residuals in float64; the
        certificate is always float64.

    Raises `ValueError`.
    """

    layer: Layer = field(default_factory=Layer)
    indenter: Indenter = field(default_factory=PowerIndenter)
    pressure: float = 2e-3
    period: float = 1.0
    num_points: int = 2**18
    precision: str = "float64"

    def __post_init__(self) -> None:
        if not isinstance(self.layer, Layer):
            raise ValueError(f"layer is {self.layer!r}; allowed: a Layer")
        if not hasattr(self.indenter, "profile") or isinstance(self.indenter, type):
            raise ValueError(
                f"indenter is {self.indenter!r}; allowed: a PowerIndenter, RoughIndenter or MeasuredIndenter"
            )
        checks.assign(self, "pressure", checks.real("pressure", self.pressure, "a finite pressure > 0", 0))
        checks.assign(self, "period", checks.real("period", self.period, "a finite length > 0", 0))
        allowed = f"an integer from {MIN_POINTS} to {MAX_POINTS}"
        points = checks.integer("num_points", self.num_points, allowed, MIN_POINTS, MAX_POINTS)
        checks.assign(self, "num_points", points)
        checks.choice("precision", self.precision, PRECISIONS)
        self.indenter.check(self.num_points)
        self._check_scales()

    def _check_scales(self) -> None:
        """Reject units and ratios whose products would overflow or underflow."""
        numbers = {"period [length]": self.period, "contact_modulus [pressure]": self.layer.contact_modulus}
        numbers |= {"pressure/contact_modulus": self.pressure / self.layer.contact_modulus}
        numbers |= self.indenter.ratios(self.period)
        if math.isfinite(self.layer.thickness):
            numbers["thickness/period"] = self.layer.thickness / self.period
        for name, value in numbers.items():
            if not SMALLEST <= value <= LARGEST:
                raise ValueError(f"{name} is {value:.3g}; allowed: from {SMALLEST:.0e} to {LARGEST:.0e}")

    @property
    def working_precision(self) -> str:
        """Of the transforms: 'float64' or 'float32'."""
        return "float32" if self.precision == "mixed" else self.precision

    @property
    def x(self) -> Array64:
        """Grid x_i = i L/N, shape (N,) [length]."""
        return self.period * (np.arange(self.num_points) / self.num_points)

    @property
    def profile(self) -> Array64:
        """Heights h(x_i) above the lowest point, shape (N,) [length]."""
        return self.period * self.indenter.profile(self.num_points, self.period)

    def to_dict(self) -> dict[str, Any]:
        """Flat, JSON-ready description under the command line's names; an infinite thickness becomes 'inf'."""
        thickness = self.layer.thickness
        return {
            **self.indenter.to_dict(),
            "pressure": self.pressure,
            "thickness": thickness if math.isfinite(thickness) else "inf",
            "poisson_ratio": self.layer.poisson_ratio,
            "contact_modulus": self.layer.contact_modulus,
            "period": self.period,
            "num_points": self.num_points,
            "precision": self.precision,
        }
