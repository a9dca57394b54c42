"""How far the contact on a thin layer reaches beyond that on its foundation."""

import math
from collections.abc import Callable

import numpy as np

from ..arrays import Array64
from ..quadrature import gauss_legendre

_LAST = 1e4  # s beyond which every layer is a half-space


def wiener_hopf_shift(factor: Callable[[Array64], Array64], limit: float, power: int, first: float) -> float:
    """c of a thin layer's effective half-width a + c d (dimensionless).

    c = -(1/pi) int_0^inf ln[C(s)/C_0(s)]/s^2 ds with the layer's compliance C(q d) = 1/K and its limit C_0 for s -> 0:
    the first-order term of the Wiener-Hopf factor of the compliance (V. M. Alexandrov's asymptotics for large a/d).

    factor: f(s) of K = (E* q/2) f(q d). limit, power: C_0 = limit s^power in units of d/E*. first: s below which the
    integrand is constant to 1e-6 and rounding would swamp it.
    """
    # in y = ln s, panel by panel; ds/s^2 = exp(-y) dy; beyond `_LAST` the half-space's C = 2/s leaves an elementary one
    nodes, weights = gauss_legendre(20)
    edges = np.linspace(math.log(first), math.log(_LAST), 81)
    width = np.diff(edges)[:, None]
    s = np.append(np.exp((edges[:-1, None] + width * (nodes + 1) / 2).ravel()), first)
    logarithm = np.log(2 / (s * factor(s)) / (limit * s**power))
    middle = np.sum((width * weights / 2).ravel() * logarithm[:-1] / s[:-1])
    tail = (math.log(2 / (limit * _LAST ** (power + 1))) - (power + 1)) / _LAST
    return float(-(logarithm[-1] / first + middle + tail) / np.pi)
