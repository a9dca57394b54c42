"""Where a contact ends between the nodes.

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
(`closed_forms.edge_shift`), so s = 1 - sum_k k l_k/2 - c d. nu = 1/2 has no such far field; a nearly incompressible
layer stands in for it. Against the oracle, for d = 0.03 to 20 spacings, that is right to 0.025 spacings for nu = -0.9
to 0.49 and contacts of 12 nodes and more (mostly to 0.005), to 0.05 for nu = 1/2, and to 0.06 down to five nodes.

`linecontact.studies.edge_curve` measures the half-space's curve on high-resolution solutions.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from .closed_forms import edge_shift, gauss_legendre
from .patches import Array64, Indices, Patches
from .stiffness import foundation_modulus, layer_factor

_TABLE = 64  # beyond, S_j = sqrt(j + s) to 1e-5
_TABLE_LAYER = 128  # longer than what a layer of few spacings remembers
_THIN = 8.0  # grid spacings; thicker layers have the half-space's edge, to 0.01 spacings
_NARROW = 4.0  # layer thicknesses; so do narrower patches on layers of `_THINNEST` spacings and more
_THINNEST = 2.5
_NEARLY_INCOMPRESSIBLE = 0.497
_MEASURED_FROM = 0.03  # grid spacings: thinner incompressible layers press like (a - x)^2, not like their stand-in
_CLOSE, _ALIKE = 0.05, 0.15  # grid spacings between estimates of one edge
COUNTED_BELOW = 3  # nodes; smaller patches are counted


@dataclass(frozen=True)
class EdgeCurve:
    """s and S_j of the module's head; rows: far-field coefficients of j^(3/2), j^(1/2), j^(-1/2) from three nodes.

    rows is None for a thin layer, whose S_j grow like j; its third family would be the patch's other end.
    """

    shift: float
    table: Array64
    rows: Array64 | None

    def at(self, j: Indices) -> Array64:
        """S_j, 0 for j < 0; the far field beyond the table."""
        power, far = (0.5, self.shift) if self.rows is not None else (1.0, self.table[-1] - self.table.size + 1)
        values: Array64 = np.maximum(j + far, 0.0) ** power
        near = j < self.table.size
        values[near] = np.append(self.table, 0.0)[np.maximum(j[near], -1)]  # the last stands for j = -1
        return values


def edge_curve(thickness: float = math.inf, poisson_ratio: float = 0.0) -> EdgeCurve:
    """The universal edge, to 1e-14; or that of a layer thinner than a few grid spacings. thickness [grid spacings]."""
    if thickness > _THIN:
        return _half_space_curve()
    return layer_curve(thickness, poisson_ratio)


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
def layer_curve(thickness: float, poisson_ratio: float) -> EdgeCurve:
    """The edge of a layer of up to some 50 grid spacings. thickness [grid spacings]."""
    thickness = max(thickness, 1e-6)
    # for nu = 1/2: one whose far field begins some 20 spacings from the edge
    nearly_incompressible = 0.5 - min(max((thickness / 20) ** 2 / 2, 1e-5), 0.005)
    poisson_ratio = min(poisson_ratio, nearly_incompressible)
    nodes, weights = gauss_legendre(200)
    root = (nodes + 1) / 2  # q = pi root^2: where nu is close to 1/2 the symbol changes near q = 0
    q = np.pi * root**2
    y = q * thickness
    symbol = y * layer_factor(y, poisson_ratio) / 2 / foundation_modulus(1.0, poisson_ratio)
    factor, slope = _factor(q, weights * np.pi * root * np.log(symbol), _TABLE_LAYER)
    table = np.cumsum(np.cumsum(factor))  # (1-z)^-2
    return EdgeCurve(1 - slope - edge_shift(poisson_ratio) * thickness, table, None)


@cache
def _half_space_curve() -> EdgeCurve:
    nodes, weights = gauss_legendre(120)
    q = (nodes + 1) * np.pi / 2
    factor, slope = _factor(q, weights * np.pi / 2 * np.log(q / 2 / np.sin(q / 2)), _TABLE)
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


def edge_offset(curve: EdgeCurve, pressures: Array64) -> tuple[Array64, Array64, Array64]:
    """theta from the last three nodal pressures, shape (M, 3), last node first; and from the last two. [grid spacings]

    The edge lies theta inside the last contact node (outside for theta < 0); -s <= theta <= 1 - s. The third result is
    how little the pressures look like an edge: by how far the estimates differ, before they are put into these bounds.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = pressures[:, 0] / pressures[:, 1]
        two = curve.table[0] - ratio * curve.table[1]
        two = two / (two + ratio * curve.table[0]) - curve.shift
    two = np.where(np.isfinite(two), two, 0.5 - curve.shift)
    bounded = np.clip(two, -curve.shift, 1 - curve.shift)
    spread = np.abs(two - bounded)
    if curve.rows is None:  # beside it, from the last but one and the last but two
        first, second, third = curve.table[:3]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            ratio = pressures[:, 1] / pressures[:, 2]
            inner = second - ratio * third
            inner = inner / (inner - first + ratio * second) - curve.shift
        return bounded, bounded, np.maximum(spread, np.where(np.isfinite(inner), np.abs(inner - bounded), 1.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        low, middle, high = curve.rows @ pressures.T
        theta = -2 * low / middle
        for _ in range(3):  # -theta middle/2 - 3/8 theta^2 high = low
            theta = -2 * low / (middle + 0.75 * theta * high)
        spread = np.maximum(spread, np.where(np.isfinite(theta), np.abs(theta - bounded), 1.0))
    theta = np.clip(np.where(np.isfinite(theta), theta, bounded), -curve.shift, 1 - curve.shift)
    # two estimates far apart: the patch is too small for a third family
    return np.where(np.abs(theta - bounded) < _ALIKE, theta, bounded), bounded, spread


@dataclass(frozen=True, eq=False)
class Edges:
    """Ends of patches in grid spacings, shape (M,) each; error: of a patch's width; counted: too small for more."""

    left: Array64
    right: Array64
    error: Array64
    counted: NDArray[np.bool_]

    @property
    def width(self) -> Array64:
        """Widths, shape (M,) [grid spacings]."""
        return self.right - self.left


def find_edges(patches: Patches, pressure: Array64, thickness: float = math.inf, poisson_ratio: float = 0.0) -> Edges:
    """Sub-grid edges of patches from the pressure, shape (contact nodes,) in compact order [any unit].

    The pressure is first divided by the edge function of the patch's other end. Patches of fewer than three nodes end
    half a spacing outside their last nodes, as counting has it, and a full contact has no edge at all.

    thickness [grid spacings], poisson_ratio: of the layer. The error, measured against the oracle, is 0.1 to 0.25 over
    the nodes of the patch plus 0.03 over the thickness, more where the third node corrects much; for layers of few
    spacings 0.02, for nu near 1/2 0.06. Where the pressures do not look like an edge, because the profile bends within
    a few spacings, it is as large as the estimates differ; and of counted patches, that are seen or not, a spacing.
    """
    if patches.full:
        half = np.array([0.5])  # error: a gap between two nodes would not be seen
        return Edges(patches.first - half, patches.last + half, np.ones(1), np.zeros(1, dtype=bool))
    curve = edge_curve(thickness, poisson_ratio)
    theta, spread = _offsets(curve, patches, pressure)
    layer = np.full(patches.count, 0.1 / thickness + 0.5 / thickness**2)
    if curve.rows is None:
        narrow = (patches.size < _NARROW * thickness) & (thickness > _THINNEST)
        own = 0.02 if poisson_ratio < _NEARLY_INCOMPRESSIBLE else 0.06 if thickness > _MEASURED_FROM else 0.5
        layer = np.where(narrow, layer, own)
        if narrow.any():
            other = _offsets(_half_space_curve(), patches, pressure)
            theta, spread = np.where(narrow, other, (theta, spread))
    counted = patches.size < COUNTED_BELOW
    outside = np.where(counted, 0.5, -theta)
    beyond = np.append(patches.first[1:], patches.first[:1] + patches.num_points) - patches.last - 1
    narrow_gap = 3.0 / np.stack([np.roll(beyond, 1), beyond]) ** 2
    fitted = np.where(spread < _CLOSE, 0.3 * spread, spread) + 0.3 / patches.size + 10.0 / patches.size**2
    fitted += layer + narrow_gap
    fitted = np.where(spread < _ALIKE, np.minimum(fitted, 0.5), np.clip(spread, 0.5, 1.0))
    each = np.where(counted, math.sqrt(0.5), fitted)
    left, right = patches.first - outside[0], patches.last + outside[1]
    # patches one node apart: not beyond each other
    overlap = np.maximum(right - np.append(left[1:], left[:1] + patches.num_points), 0.0) / 2
    return Edges(left + np.roll(overlap, 1), right - overlap, np.hypot(*each), counted)


def _offsets(curve: EdgeCurve, patches: Patches, pressure: Array64) -> tuple[Array64, Array64]:
    """theta of left and right ends, and how little they look like edges, shape (2, M) each; see `edge_offset`."""
    m, inward = patches.count, np.arange(3)
    steps = np.minimum(inward, patches.size[:, None] - 1)
    left = pressure[patches.offset[:, None] + steps]
    right = pressure[(patches.offset + patches.size - 1)[:, None] - steps]
    ends = np.stack([left, right])
    away = patches.size[:, None] - 1 - inward
    theta = np.full((2, m), 0.5 - curve.shift)
    for _ in range(3):
        across = np.maximum(edge_function(curve, (theta + curve.shift)[::-1, :, None], away), 1e-3)
        theta, _, spread = (t.reshape(2, m) for t in edge_offset(curve, (ends / across).reshape(2 * m, 3)))
    return theta, spread


def edge_moves(patches: Patches, pressure: Array64) -> Indices:
    """Nodes by which a wrong contact is too large (> 0) or too small (< 0) at the ends of its patches, shape (2, M).

    On a wrong set the edge is still A S_j + B (S_j - S_(j-1)), only that beta = -B/A is not between 0 and 1; its whole
    part is the number of nodes. At most half a patch; 0 for patches of fewer than five nodes.
    """
    table = _half_space_curve().table
    limit = np.where(patches.size < 5, 0, patches.size // 2)
    last = patches.offset + patches.size - 1
    inner = np.minimum(patches.size - 1, 1)
    ends, next_to = (
        pressure[np.stack([patches.offset, last])],
        pressure[np.stack([patches.offset + inner, last - inner])],
    )
    drop = next_to * table[0] - ends * table[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        beta = drop / (drop + ends * table[0])
    beta = np.where(np.isfinite(beta), beta, 0.0)
    return np.clip(np.floor(beta), -limit, limit).astype(np.int64)
