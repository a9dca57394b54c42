"""A layer bonded to a rigid base, as in the published study; and the stiffness of one bonded to an elastic base.

Convention: u(x) = sum_k u_k exp(i q_k x) with q_k = 2 pi k/L; the elastic pressure of mode k is K(q_k) u_k. On a rigid
base (G. Carbone and L. Mangialardi, J. Mech. Phys. Solids 56, 684 (2008); the published study's eq. 4)

    K(q) = (E* q/2) f(q d),  f(y) = [(3-4nu) cosh 2y + 2y^2 - 4nu(3-2nu) + 5] / [(3-4nu) sinh 2y - 2y]

On an elastic half-space, with the shear moduli's ratio m = mu_1/mu_2 of layer and half-space, alpha = 3 - 4 nu_1, beta
= 3 - 4 nu_2, x = 2 q d and e = exp(-x), it is the response function of T. Nogi and T. Kato (J. Tribology 119, 493
(1997)), both parts multiplied by (1 + m beta)(m + alpha):

    K(q) = (E* q/2) D/N
    D = alpha [1 + e^2] + (alpha^2 + 1 + x^2) e + m [(1-e)(1 + alpha beta + (alpha + beta) e) + (beta-1) x^2 e]
        + m^2 beta [(1-e)^2 - x^2 e]
    N = [alpha (1-e^2) - 2 x e] + m [(2 + beta (alpha-1)) + (alpha + 2 beta - 1) e^2 + (beta-1)(1 - e^2 - 2 x e)]
        + m^2 beta [1 - e^2 + 2 x e]

E* the layer's. Every bracket is positive, and those that cancel for small x come from the series of sinh: 1 - e^2 -
2 x e = 2 (sinh x - x) e and, with z = x/2, (1-e)^2 - x^2 e = 4 (sinh^2 z - z^2) e. So nothing overflows or cancels.
m = 0 is the rigid base, equal materials are the half-space; long waves find the half-space below, short ones that of
the layer's material.
"""

import math
from dataclasses import dataclass
from functools import cache
from typing import ClassVar

import numpy as np

from .. import checks
from ..arrays import Array64, gauss_legendre
from .layer import DEFAULT_MODULUS, HALF_SPACE_FROM, ElasticLayer, check_modulus, homogeneous_stiffness

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
    logarithm = -np.log(stiffness(s, 1.0, nu) * limit * s**power)
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
    """E > 0 [pressure], to give instead of E*, which is computed from it (and is then kept)."""

    name: ClassVar[str] = "bonded"

    def __post_init__(self) -> None:
        thickness = checks.real("thickness", self.thickness, "a length > 0, or inf", 0, infinite=True)
        checks.assign(self, thickness=thickness)
        check_modulus(self)

    def stiffness(self, wave_numbers: Array64, period: float) -> Array64:
        return stiffness(wave_numbers, self.thickness / period, self.poisson_ratio)

    def foundation_modulus(self, period: float) -> float:
        nu = self.poisson_ratio
        return 1 / foundation_compliance(nu) / (self.thickness / period) if nu < 0.5 else math.inf

    @property
    def edge_shift(self) -> float | None:
        """c(nu) d, see `ElasticLayer`."""
        return edge_shift(self.poisson_ratio) * self.thickness

    @property
    def bonded(self) -> tuple[float, float] | None:
        return self.thickness, self.poisson_ratio
