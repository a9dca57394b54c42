"""The published study's layer: elastic, of any thickness and Poisson's ratio, bonded to a rigid base.

Convention: u(x) = sum_k u_k exp(i q_k x) with q_k = 2 pi k/L; the elastic pressure of mode k is K(q_k) u_k.

    K(q) = (E* q/2) f(q d),  f(y) = [(3-4nu) cosh 2y + 2y^2 - 4nu(3-2nu) + 5] / [(3-4nu) sinh 2y - 2y]

(G. Carbone and L. Mangialardi, J. Mech. Phys. Solids 56, 684 (2008); the published study's eq. 4.) That is the coated
half-space on a base of infinite modulus; `coated` has the form that neither overflows nor cancels.
"""

import math
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np

from .. import checks
from ..arrays import Array64, gauss_legendre
from . import coated
from .layer import DEFAULT_MODULUS, HALF_SPACE_FROM, ElasticLayer, check_modulus


def foundation_modulus(thickness: float, poisson_ratio: float) -> float:
    """Winkler modulus k_W = E* (1-nu)^2/((1-2nu) d), the limit K(0) for nu < 1/2, in units of E* over d's unit.

    0 for the half-space, `inf` for nu = 1/2.
    """
    return 1 / foundation_compliance(poisson_ratio) / thickness if poisson_ratio < 0.5 else math.inf


def foundation_compliance(poisson_ratio: float) -> float:
    """(1-2nu)/(1-nu)^2, the compliance 1/k_W of the Winkler foundation in units of d/E* (dimensionless)."""
    return (1 - 2 * poisson_ratio) / (1 - poisson_ratio) ** 2


@cache
def edge_shift(poisson_ratio: float) -> float:
    """c(nu) of the thin layer's effective half-width a + c d (dimensionless).

    c = -(1/pi) int_0^inf ln[C(s)/C_0(s)]/s^2 ds with the layer's compliance C(q d) = 1/K and its limit C_0 for s -> 0:
    the first-order term of the Wiener-Hopf factor of the compliance (V. M. Alexandrov's asymptotics for large a/d).
    """
    nu, last = poisson_ratio, HALF_SPACE_FROM
    limit, power = (4 / 3, 2) if nu == 0.5 else (foundation_compliance(nu), 0)  # C_0 = limit s^power
    # below `first` the integrand is constant to 1e-6, and rounding would swamp it; beyond `last` C = 2/s
    first = 1e-3 * (math.sqrt(1 - 2 * nu) if nu < 0.5 else 1.0)
    nodes, weights = gauss_legendre()
    width = math.log(last / first)  # in y = ln s, ds/s^2 = exp(-y) dy
    s = np.append(first, first * np.exp(width * (nodes + 1) / 2))
    logarithm = -np.log(coated.stiffness(s, 1.0, nu) * limit * s**power)
    middle = width / 2 * float(weights @ (logarithm[1:] / s[1:]))
    tail = (math.log(2 / (limit * last ** (power + 1))) - (power + 1)) / last
    return -(float(logarithm[0]) / first + middle + tail) / math.pi


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
        return coated.stiffness(wave_numbers, self.thickness / period, self.poisson_ratio)

    def foundation_modulus(self, period: float) -> float:
        return foundation_modulus(self.thickness / period, self.poisson_ratio)

    def to_dict(self) -> dict[str, Any]:
        names = ("thickness", "poisson_ratio", "contact_modulus")
        return {"layer": self.name} | {name: getattr(self, name) for name in names}

    @property
    def edge_shift(self) -> float | None:
        """c(nu) d, see `ElasticLayer`."""
        return edge_shift(self.poisson_ratio) * self.thickness

    @property
    def bonded(self) -> tuple[float, float] | None:
        return self.thickness, self.poisson_ratio
