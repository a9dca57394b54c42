"""The pressure at a contact edge on a grid: curves by Wiener-Hopf factorisation, one for every layer.

Derived in docs/edges.md. In units of the grid spacing and of E*/2 the stiffness is |q| f(q),
|q| <= pi, with f = 2K/(E* |q|), 1 on the half-space. With z = exp(iq) it is c(z) c(1/z) |1 - z|, where

    ln c(z) = l_0/4 + sum_k>0 (l_k/2) z^k,   l_k = (2/pi) int_0^pi {ln[(q/2)/sin(q/2)] + ln f(q)} cos(kq) dq,

and the pressures of a contact on the nodes j >= 0 are sum_j sigma_j z^j = c(z) sum_m a_m (1-z)^-(m+1/2). m = 0 and 1
are the edge: sigma_j = A [(1-beta) S_j + beta S_(j-1)], S_j the coefficients of c(z) (1-z)^-3/2. sigma_0 >= 0 and a gap
>= 0 at j = -1 hold for exactly 0 <= beta <= 1. m = 2 is the first effect of the profile's own scale (order dx/l). Three
nodes give a_0, a_1, a_2.

For a_2 = 0 the edge lies beta - s spacings inside the last contact node, s = 3/4 - s_0 - delta, s_0 = sum_k k l_k/2 of
f = 1 (s = 0.80999 on the half-space), with

    delta = (1/2 pi) int_0^pi ln f(q) [2/q^2 - 1/(1 - cos q)] dq + (1/pi) int_pi^inf ln f(q)/q^2 dq.

Nothing is asked of f at q = 0, where a foundation may be, an incompressible layer or another half-space. In contacts
narrower than some layer thicknesses each end feels the other; they have the half-space's edge where they look like it
(see `edges`). `linecontact study edge-curve` measures these curves on high-resolution solutions.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from ..arrays import Array64, Indices, gauss_legendre

Logarithm = Callable[[Array64], Array64]
"""ln f of wave numbers q > 0 [1/grid spacing], of their shape."""

_TABLE = 128  # beyond, S_j follows a power of the distance
UNKNOWN = 1.0
"""Error of an end that no curve tells, and from where the part of delta by waves that the grid has not is no layer's:
real ones have up to 0.31 [grid spacings]."""
_OF_BINOMIALS = np.array([[1, 3 / 8, 65 / 128], [0, 1, 15 / 8], [0, 0, 1]]) / [math.gamma(m + 0.5) for m in range(3)]
"""Coefficients of j^(r-1/2) in those of (1-z)^-(m+1/2) for large j, by r and m."""


@dataclass(frozen=True)
class EdgeCurve:
    """The pressure at an edge, see the beginning of this file."""

    shift: float
    """s [grid spacings]."""
    table: Array64
    """S_j for j = 0, 1, ..., shape (table length,), dimensionless."""
    rows: Array64
    """Coefficients, shape (3, 3), that make the far field's j^(3/2), j^(1/2), j^(-1/2) on the half-space from the last
    three nodes' pressures (dimensionless)."""
    strength: float
    """Pressure of a flat punch's last node, over the term 1/sqrt(distance) of its end at the distance 1
    (dimensionless)."""
    power: float
    """Of the distance, with which S_j goes on beyond the table."""
    delta: float
    """By how much further inside the edge lies than that far field begins [grid spacings]."""
    error: float
    """What is not known of s [grid spacings]: where the layer does not tell its stiffness for waves shorter than the
    grid's, or where the curve says that nodes pull."""

    @cached_property
    def packed(self) -> Array64:
        """All numbers of the curve as `kernels.layout` has their places. Among them are the pressures of the last three
        nodes under the far fields j^(3/2), j^(1/2), j^(-1/2), shape (3, 3), by far field and node (dimensionless).
        """
        far_fields = np.linalg.inv(self.rows).T[::-1]
        return np.concatenate([[self.shift, self.delta, self.power], self.rows.ravel(), far_fields.ravel(), self.table])

    def at(self, j: Indices) -> Array64:
        """S_j, 0 for j < 0; a power of the distance from the edge beyond the table."""
        last = self.table.size - 1
        values: Array64 = self.table[last] * ((np.maximum(j, last) + self.shift) / (last + self.shift)) ** self.power
        near = j < self.table.size
        values[near] = np.append(self.table, 0.0)[np.maximum(j[near], -1)]  # the last stands for j = -1
        return values


@cache
def half_space_curve() -> EdgeCurve:
    """The half-space's edge, the same for all grids and indenters."""
    return make_curve(np.zeros_like, np.zeros_like)


@cache
def _quadrature() -> tuple[Array64, Array64, Array64, Array64, Array64, Array64, float]:
    """How the integrals over ln f are made: waves q below pi, dense towards 0, where layers change; (1/pi) cos(k q)
    times their weights, shape (table length, waves); [2/q^2 - 1/(1 - cos q)]/(2 pi) times them; waves from infinity
    down to pi; 1/(pi q^2) times their weights; l_k/2 of ln[(q/2)/sin(q/2)], shape (table length,); s_0.
    """
    nodes, weights = gauss_legendre()
    root = (nodes + 1) / 2
    q, weights_q = np.pi * root**2, weights * np.pi * root
    cosines = np.cos(np.outer(np.arange(_TABLE), q)) * weights_q / np.pi
    sine = np.sin(q / 2) ** 2
    difference = np.where(q > 0.01, 2 / q**2 - 1 / (2 * sine), -1 / 6 - q**2 / 120)  # which cancels
    of_delta = weights_q * difference / (2 * np.pi)
    of_grid = np.log(q / 2 / np.sin(q / 2))
    slope = -float(np.sum(weights_q * np.where(q > 0.01, of_grid / sine, 1 / 6 + 11 * q**2 / 720))) / (4 * np.pi)
    return q, cosines, of_delta, np.pi / root**2, weights * root / np.pi**2, cosines @ of_grid, slope


def make_curve(on_grid: Logarithm, anywhere: Logarithm) -> EdgeCurve:
    """The curve of ln f. on_grid: where waves that the grid has not count as its longest or shortest; anywhere: as they
    are.
    """
    q, cosines, of_delta, shorter, of_beyond, of_grid, slope = _quadrature()
    at_end = float(on_grid(np.array([np.pi]))[0])
    inside = on_grid(q) - at_end
    rest = np.full_like(shorter, np.nan)
    with suppress(ValueError), np.errstate(all="ignore"):  # a table ends
        rest = anywhere(shorter) - at_end
    known = np.isfinite(rest)
    last = float(rest[known][0]) if known.any() else 0.0  # of the shortest wave known, for those that are not
    beyond = float(of_beyond @ np.where(known, rest, last))
    if not abs(beyond) < UNKNOWN:  # nonsense
        known[:], beyond, last = False, 0.0, 0.0
    rise = 0.0 if known.any() else float(inside[-1]) / math.log(q[-1] / np.pi)
    error = float(of_beyond[~known].sum()) * (abs(last + at_end) + 2 * abs(rise))
    delta = float(of_delta @ inside) + beyond
    series = of_grid + cosines @ inside
    mean = series[0] / 2
    series[0] = of_grid[0] / 2  # f may be large or small
    factor = _exponential(series)
    steps = np.arange(1, _TABLE)
    binomial = np.append(1.0, np.cumprod((steps - 0.5) / steps))  # coefficients of (1-z)^(-1/2)
    family = np.convolve(factor, binomial)[:_TABLE]
    families = np.stack([family, np.cumsum(family), np.cumsum(np.cumsum(family))])
    shift, table = 0.75 - slope - delta, families[1] * math.sqrt(math.pi) / 2
    if table.min() <= 0:  # a coating so stiff that contacts split at their edges on the grid
        error += UNKNOWN
    power, last = 0.5, _TABLE - 1 + shift
    if 0 < table[-2] < table[-1]:  # not on a stiff layer on a very soft base, pressed at its edges
        power = math.log(table[-1] / table[-2]) / math.log(last / (last - 1))
    return EdgeCurve(
        shift=shift,
        table=table,
        rows=_far_field(slope) @ np.linalg.inv(families[:, :3].T),
        power=power,
        strength=math.exp(mean + at_end / 2) * math.sqrt(math.pi),
        delta=delta,
        error=error,
    )


def _exponential(series: Array64) -> Array64:
    """Coefficients of the exponential of a power series with these coefficients."""
    steps = np.arange(series.size) * series
    found = np.empty_like(series)
    found[0] = math.exp(series[0])
    for n in range(1, series.size):  # n c_n = sum_k k s_k c_(n-k)
        found[n] = steps[1 : n + 1] @ found[n - 1 :: -1][:n] / n
    return found


def _far_field(slope: float) -> Array64:
    """Coefficients of j^(r-1/2) in the half-space's families m far from the edge, shape (3, 3), by r and m."""
    # c about z = 1: 1 - slope (1-z) + bend (1-z)^2, from ln c = slope (z-1) + ... and |ln c|'' = 1/24 at q = 0
    bend = (-1 / 24 - slope + slope**2) / 2
    lower = np.eye(3, k=1)  # 1 - z makes the family m - 1 of the family m
    return _OF_BINOMIALS @ (np.eye(3) - slope * lower + bend * lower @ lower)
