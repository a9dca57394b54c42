"""The pressure at a contact edge on a grid: universal curves by Wiener-Hopf factorisation.

Near an edge of a contact every profile is smooth, and every layer but the thinnest a half-space. In units of the grid
spacing the discrete problem K u + sigma = p, u <= h there has the symbol |q|, |q| <= pi, and no scale, so its solution
is one function of the distance. The Wiener-Hopf factors of the symbol give it in closed form: with |q| = c_+(z)
c_+(1/z) |1 - z|, z = exp(iq), and the contact on the nodes j >= 0,

    sum_j sigma_j z^j = c_+(z) sum_m a_m (1-z)^-(m+1/2),   ln c_+(z) = l_0/4 + sum_k>0 (l_k/2) z^k,
    l_k = (2/pi) int_0^pi ln[(q/2)/sin(q/2)] cos(kq) dq.

m = 0 and 1 are the universal edge: sigma_j = A [(1-beta) S_j + beta S_(j-1)], S_j the coefficients of c_+(z)
(1-z)^-3/2. sigma_0 >= 0 and a gap >= 0 at j = -1 hold for exactly 0 <= beta <= 1, and far away sigma_j -> sqrt(j -
theta) with theta = beta - s, s = 3/4 - sum_k k l_k/2 = 0.80999: the edge lies beta - s grid spacings inside the last
contact node. m = 2 is the first effect of the profile's and the layer's own scales (order dx/l). Three nodes give a_0,
a_1, a_2, and theta is where the far field a (j - theta)^1/2 + b (j - theta)^3/2 begins.

Layers thinner than a few grid spacings have a symbol of their own, K(q)/K(0) = c_+(z) c_+(1/z), regular at q = 0. The
same steps give sigma_j = A [(1-beta) S_j + beta S_(j-1)], S_j the coefficients of c_+(z) (1-z)^-2, which far away grow
like j - theta_f, theta_f = beta - 1 + sum_k k l_k/2. That far field ends c(nu) d outside of the true edge
(`ElasticLayer.edge_shift`), so s = 1 - sum_k k l_k/2 - c d. nu = 1/2 has no such far field; a nearly incompressible
layer stands in for it. Against the oracle, for d = 0.03 to 20 spacings, that is right to 0.025 spacings for nu = -0.9
to 0.49 and contacts of 12 nodes and more (mostly to 0.005), to 0.05 for nu = 1/2, and to 0.06 down to five nodes.

`linecontact study edge-curve` measures the half-space's curve on high-resolution solutions.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from ..arrays import Array64, Indices
from ..layers import EdgeSymbol
from ..quadrature import gauss_legendre

_TABLE = 64  # beyond, S_j = sqrt(j + s) to 1e-5
_TABLE_LAYER = 128  # longer than what a layer of few spacings remembers
_THIN = 8.0  # grid spacings; thicker layers have the half-space's edge, to 0.01 spacings


@dataclass(frozen=True)
class EdgeCurve:
    """The pressure at an edge, see the beginning of this file."""

    shift: float
    """s [grid spacings]."""
    table: Array64
    """S_j for j = 0, 1, ..., shape (table length,), dimensionless."""
    rows: Array64 | None
    """Coefficients, shape (3, 3), that make the far field's j^(3/2), j^(1/2), j^(-1/2) from the last three nodes'
    pressures; None for a thin layer, whose S_j grow like j and whose third family would be the patch's other end."""

    @property
    def thin(self) -> bool:
        """Whether this is the edge of a layer of few grid spacings."""
        return self.rows is None

    def at(self, j: Indices) -> Array64:
        """S_j, 0 for j < 0; the far field beyond the table."""
        power, far = (0.5, self.shift) if self.rows is not None else (1.0, self.table[-1] - self.table.size + 1)
        values: Array64 = np.maximum(j + far, 0.0) ** power
        near = j < self.table.size
        values[near] = np.append(self.table, 0.0)[np.maximum(j[near], -1)]  # the last stands for j = -1
        return values


def edge_curve(symbol: EdgeSymbol) -> EdgeCurve:
    """The half-space's edge, to 1e-14; or that of a layer thinner than a few grid spacings."""
    return thin_curve(symbol) if symbol.thickness <= _THIN else half_space_curve()


def _factor(q: Array64, weighted: Array64, length: int) -> tuple[Array64, float]:
    """Coefficients of c_+ and sum_k k l_k/2 from the logarithm of the symbol at q, times the quadrature's weights."""
    k = np.arange(length)
    half = np.cos(np.outer(k, q)) @ weighted / np.pi  # l_k/2
    half[0] /= 2
    slope = -float(np.sum(weighted / np.sin(q / 2) ** 2)) / (4 * np.pi)
    factor = np.zeros(length)  # n c_n = sum_k k (l_k/2) c_(n-k)
    factor[0] = math.exp(half[0])
    for n in range(1, length):
        factor[n] = (k[1 : n + 1] * half[1 : n + 1]) @ factor[n - 1 :: -1][:n] / n
    return factor, slope


@lru_cache(maxsize=256)
def thin_curve(symbol: EdgeSymbol) -> EdgeCurve:
    """The edge of a layer of up to some 50 grid spacings."""
    nodes, weights = gauss_legendre(200)
    root = (nodes + 1) / 2  # q = pi root^2: where nu is close to 1/2 the symbol changes near q = 0
    logarithm = np.log(symbol.symbol(np.pi * root**2))
    factor, slope = _factor(np.pi * root**2, weights * np.pi * root * logarithm, _TABLE_LAYER)
    table = np.cumsum(np.cumsum(factor))  # (1-z)^-2
    return EdgeCurve(1 - slope - symbol.shift, table, None)


@cache
def _half_space_factor() -> tuple[Array64, float]:
    nodes, weights = gauss_legendre(120)
    q = (nodes + 1) * np.pi / 2
    return _factor(q, weights * np.pi / 2 * np.log(q / 2 / np.sin(q / 2)), _TABLE)


def punch_end() -> tuple[float, float]:
    """How far outside of its last node a flat punch ends [grid spacings], and the last node's pressure over that which
    goes like 1/sqrt(distance) far from the end, at the distance 1 (dimensionless).

    Its pressure is the family m = 0, the coefficients of c_+(z) (1-z)^-1/2.
    """
    factor, slope = _half_space_factor()
    return 0.25 - slope, float(factor[0]) * math.sqrt(math.pi)


@cache
def half_space_curve() -> EdgeCurve:
    """The universal edge, to 1e-14."""
    factor, slope = _half_space_factor()
    families = [np.convolve(factor, _binomial(m + 0.5))[:_TABLE] for m in range(3)]
    # c_+ about z = 1: 1 - slope (1-z) + bend (1-z)^2, from ln c_+ = slope (z-1) + ... and |ln c_+|'' = 1/24 at q = 0
    bend = (-1 / 24 - slope + slope**2) / 2
    far = np.zeros((3, 3))  # far[r, m]: coefficient of j^(r-1/2) in the family m
    for m in range(3):
        for power, coefficient in ((m, 1.0), (m - 1, -slope), (m - 2, bend)):
            for r, value in zip(range(power, -1, -1), _far_binomial(power + 0.5), strict=False):
                far[r, m] += coefficient * value
    first = np.array([[family[j] for family in families] for j in range(3)])
    table = families[1] * math.sqrt(math.pi) / 2
    return EdgeCurve(0.75 - slope, table, far @ np.linalg.inv(first))


def _binomial(a: float) -> Array64:
    """Coefficients of (1-z)^-a."""
    n = np.arange(1.0, _TABLE)
    return np.append(1.0, np.cumprod((a + n - 1) / n))


def _far_binomial(a: float) -> tuple[float, float, float]:
    """Coefficients of j^(a-1), j^(a-2), j^(a-3) in the large-j expansion of `_binomial`."""
    return tuple(  # type: ignore[return-value]
        c / math.gamma(a) for c in (1.0, a * (a - 1) / 2, a * (a - 1) * (a - 2) * (3 * a - 1) / 24)
    )


def edge_function(curve: EdgeCurve, beta: Array64, j: Indices) -> Array64:
    """The edge pressure at the nodes j >= 0 from the last contact node inwards; ~ sqrt(j - theta) on thick layers.

    beta, j: broadcast against each other; the result has their common shape.
    """
    return np.asarray((1 - beta) * curve.at(j) + beta * curve.at(j - 1))
