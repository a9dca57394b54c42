"""Where narrow patches end, from their loads: to a hundredth of a grid spacing or two, also for patches of a few nodes.

Beside the half-space's own singular response everything varies slowly over a patch that is narrow beside the layer's
thickness. With the slope g = h' + w' over it, w being the displacement by all other patches, and its Chebyshev
coefficients b_k = 2/pi int g(m + a t) T_k(t) (1 - t^2)^-1/2 dt over -1 < t < 1, a patch from m - a to m + a has

    the load P = pi/4 E* a b_1, and its centre of pressure at m + a b_2/(2 b_1)

(inversion of the finite Hilbert transform, K. L. Johnson, Contact Mechanics (1985), section 2.7, with pressures that
are 0 at both ends). Loads and centres of pressure are sums over nodes, which a grid has right to a thousandth even
where the patch has one node; these two equations then give m and a, by Newton's method.

A neighbour at the distance D with the load P and the half-width a adds the slope of a Hertz contact, in units of E*,

    w'(D) = -4 P/pi / (D + (D^2 - a^2)^1/2),

those further away as if their load were spread evenly. By the layer every load P, the patch's own included, adds

    P/pi int (2 - q/K(q)) sin(q D) dq  over q > 0.

Patches that are not narrow beside the layer's thickness can be estimated only: as if the layer were a half-space of the
modulus 2K(q)/q at q = 3 pi/(4 a), which makes a parabola's load right on the half-space and on a Winkler foundation.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import Array64, Indices, Mask
from .patches import Patches

Modulus = Callable[[Array64], Array64]
"""2K(q)/q over E* for waves q [1/grid spacing]: 1 on the half-space."""

_SAMPLES = 8  # of the slope over a patch
_ANGLES = np.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
_T1, _T2, _T3 = (np.cos(k * _ANGLES) for k in (1, 2, 3))
_MOMENTS = 2 / _SAMPLES * np.stack([_T1, _T2, _T3], axis=1)
_BENT_MOMENTS = 2 / _SAMPLES * np.stack([_T1, _T1 * _T1, _T2, _T1 * _T2], axis=1)
_STENCIL = np.arange(-2, 4)  # nodes through which heights are interpolated
_POWERS = np.linalg.inv(np.vander(_STENCIL, increasing=True)).T  # to coefficients of the polynomial
_NEIGHBOURS = 4  # on each side
_WAVE = 3 * np.pi / 4  # q a at which the layer's modulus is taken
_REACH = 2.0  # layer thicknesses over which a load is felt
_WAVES, _SHORTEST, _PLACES = np.polynomial.legendre.leggauss(32), 12.0, 256  # how the layer's part is integrated
_THICK = 4.0  # grid spacings; the part of a thinner layer is not computed
_HALF_SPACE = 2.0  # nodes of a patch over the thickness, below which 2K(q)/q is the half-space's
_STEPS, _STEP, _CLOSE = 6, 0.25, 1e-3  # of Newton's method: most, their length and the last one's [grid spacings]


@dataclass(frozen=True, eq=False)
class Heights:
    """The indenter's heights, and the slope between them."""

    profile: Array64
    """h on the grid, shape (N,) [any length]."""
    scale: float
    """What makes grid spacings of that length."""

    def slope(self, at: Array64) -> tuple[Array64, Array64]:
        """h' and h'' [1/grid spacing] at places between the nodes [grid spacings], from six of them."""
        node = np.floor(at).astype(np.int64)
        part = at - node
        nodes = node[..., None] + _STENCIL
        if nodes.size and (nodes.min() < 0 or nodes.max() >= self.profile.size):
            nodes %= self.profile.size
        powers = self.profile[nodes] @ (_POWERS * self.scale)
        first, second = np.zeros_like(part), np.zeros_like(part)
        for k in range(_STENCIL.size - 1, 0, -1):
            second = second * part + first
            first = first * part + k * powers[..., k]
        return first, second


@dataclass(frozen=True, eq=False)
class FromLoads:
    """Ends of some patches."""

    centre: Array64
    """m, shape (patches,) [grid spacings]."""
    half_width: Array64
    """a, shape (patches,) [grid spacings]."""
    skew: Array64
    """|b_2/b_1|: how unlike the patch's two halves are, shape (patches,) (dimensionless)."""
    bend: Array64
    """|b_3/b_1|: how far from a parabola the profile is, shape (patches,) (dimensionless)."""
    solved: Mask
    """For which the equations were solved, shape (patches,)."""


def from_loads(
    patches: Patches,
    chosen: Indices,
    pressure: Array64,
    heights: Heights,
    modulus: Modulus,
    thickness: float,
    half_width: Array64,
) -> FromLoads:
    """Ends of the chosen patches.

    pressure: over E*, on the contact nodes in compact order; thickness: the layer's [grid spacings]; half_width: of all
    patches, as far as known, shape (M,) [grid spacings].
    """
    loads = patches.sums(pressure)
    inside = np.arange(pressure.size) - np.repeat(patches.offset, patches.size)
    middles = patches.first + patches.sums(pressure * inside) / loads
    layer = _LayerSlope.of(modulus, thickness, patches.num_points)
    others = _Neighbours.of(patches, chosen, loads, middles, half_width, _REACH * thickness)
    load, middle = loads[chosen], middles[chosen]
    m, a = middle.copy(), half_width[chosen].copy()
    # everything but the indenter changes little while m and a do
    start = m[:, None] + a[:, None] * _T1
    far, far_bent = others.slope(start, layer)
    if layer.distance.size:
        own, own_bent = layer.slope(start - middle[:, None])
        far, far_bent = far + load[:, None] * own, far_bent + load[:, None] * own_bent
    thick = thickness > _WAVE * _HALF_SPACE * float(patches.size[chosen].max())
    skew, bend, solved = np.zeros(a.size), np.zeros(a.size), np.zeros(a.size, dtype=bool)
    left = np.arange(a.size)
    for _ in range(_STEPS):
        p, x, c = load[left], m[left], a[left]
        at = x[:, None] + c[:, None] * _T1
        g, bent = heights.slope(at)
        g += far[left] + far_bent[left] * (at - start[left])
        bent += far_bent[left]
        b = g @ _MOMENTS
        stiffness = (1.0, 0.0) if thick else _stiffness(modulus, c)
        step, usable = _newton(p, x - middle[left], c, b, bent @ _BENT_MOMENTS, *stiffness)
        most = np.minimum(_STEP, 0.5 * c)
        step = np.minimum(np.maximum(step, -most), most)
        a[left], m[left] = c - step[0], x - step[1]
        with np.errstate(divide="ignore", invalid="ignore"):
            skew[left], bend[left] = np.abs(b[:, 1:].T / b[:, 0])
        moved = np.abs(step).max(axis=0)
        solved[left] = usable & (moved < _CLOSE) & (b[:, 0] > 0)
        left = left[usable & (moved >= _CLOSE)]
        if not left.size:
            break
    return FromLoads(m, a, skew, bend, solved)


def _newton(
    load: Array64, away: Array64, a: Array64, b: Array64, bent: Array64, stiff: Array64 | float, rise: Array64 | float
) -> tuple[Array64, Mask]:
    """The step in a and m, shape (2, patches), of Newton's method for load and moment; and where there is one.

    away: m less the centre of pressure; b, bent: moments of the slope and of its derivative; stiff, rise: modulus over
    E* and its logarithmic derivative with respect to a.
    """
    b1, b2, (of_one, of_t1_t1, of_t2, of_t1_t2) = b[:, 0], b[:, 1], bent.T
    f = np.pi / 4 * stiff * a * b1 - load
    f_a = np.pi / 4 * stiff * ((1 + rise) * b1 + a * of_t1_t1)
    f_m = np.pi / 4 * stiff * a * of_one
    k = np.pi / 8 * stiff * a * a * b2 + load * away
    k_a = np.pi / 8 * stiff * ((2 + rise) * a * b2 + a * a * of_t1_t2)
    k_m = np.pi / 8 * stiff * a * a * of_t2 + load
    determinant = f_a * k_m - f_m * k_a
    usable = determinant > 0
    step = np.stack([f * k_m - k * f_m, k * f_a - f * k_a]) / np.where(usable, determinant, 1.0)
    return np.where(usable, step, 0.0), usable


def _stiffness(modulus: Modulus, a: Array64) -> tuple[Array64, Array64]:
    """The layer's modulus for patches of the half-width a, and its logarithmic derivative with respect to a."""
    step = 1e-3
    here, wider = modulus(np.stack([_WAVE / a, _WAVE / (a * (1 + step))]))
    return here, (wider / here - 1) / step


@dataclass(frozen=True, eq=False)
class _LayerSlope:
    """w' by a unit load on a layer less that on the half-space, over the distance."""

    distance: Array64
    """From 0 to the reach [grid spacings]; of size 0 where that is not computed."""
    table: Array64
    """w' [1/E*/grid spacing]."""
    derivative: Array64

    @classmethod
    def of(cls, modulus: Modulus, thickness: float, num_points: int) -> "_LayerSlope":
        if not _THICK < thickness < num_points:
            return cls(np.zeros(0), np.zeros(0), np.zeros(0))
        nodes, weights = _WAVES
        longest = 2 * np.pi / num_points
        half = (min(_SHORTEST / thickness, np.pi) - longest) / 2
        q = longest + half * (nodes + 1)
        part = half * weights * (2 - 2 / modulus(q)) / np.pi
        distance = np.linspace(0.0, _REACH * thickness, _PLACES)
        phase = distance[:, None] * q
        return cls(distance, np.sin(phase) @ part, np.cos(phase) @ (part * q))

    def slope(self, distance: Array64) -> tuple[Array64, Array64]:
        """w' and its derivative at distances to either side; 0 beyond the reach."""
        away = np.abs(distance)
        slope = np.interp(away, self.distance, self.table, right=0.0)
        return np.copysign(slope, distance), np.interp(away, self.distance, self.derivative, right=0.0)


@dataclass(frozen=True, eq=False)
class _Neighbours:
    """The patches on both sides of some, and what is beyond them."""

    middle: Array64
    """Their centres of pressure, shape (patches, neighbours) [grid spacings]."""
    load: Array64
    """Their loads over E*, 0 beyond the reach, shape (patches, neighbours) [grid spacings]."""
    half_width: Array64
    """Their half-widths, shape (patches, neighbours) [grid spacings]."""
    own: Array64
    """Centres of pressure of the patches themselves, shape (patches, 1) [grid spacings]."""
    beyond: Array64
    """Curvature of the displacement by what is further away, shape (patches, 1) [1/grid spacing]."""

    @classmethod
    def of(
        cls, patches: Patches, chosen: Indices, load: Array64, middle: Array64, half_width: Array64, reach: float
    ) -> "_Neighbours":
        steps = np.concatenate([np.arange(-_NEIGHBOURS - 1, 0), np.arange(1, _NEIGHBOURS + 2)])
        period, which = np.divmod(chosen[:, None] + steps, patches.count)
        place, own = middle[which] + period * patches.num_points, middle[chosen, None]
        distance = np.abs(place - own)
        # the even load begins half way to the first patch that is not looked at, and ends at the reach
        begins = (distance[:, [0, -1]] + distance[:, [1, -2]]) / 2
        even = np.maximum(1 / begins - 1 / reach, 0.0).sum(axis=1, keepdims=True)
        near = slice(1, -1)
        felt = np.where(distance < reach, load[which], 0.0)[:, near]
        beyond = 2 / np.pi * load.sum() / patches.num_points * even
        return cls(place[:, near], felt, half_width[which][:, near], own, beyond)

    def slope(self, at: Array64, layer: _LayerSlope) -> tuple[Array64, Array64]:
        """w' and its derivative [1/grid spacing] at some places of each patch, shape (patches, places)."""
        load = self.load[:, None, :]
        distance = at[:, :, None] - self.middle[:, None, :]
        root = np.sqrt(np.maximum(distance**2 - self.half_width[:, None, :] ** 2, 0.25))
        size = 4 / np.pi * load / (np.abs(distance) + root)
        slope, bent = -np.copysign(size, distance), size / root
        if layer.distance.size:
            by_layer, bent_by_layer = layer.slope(distance)
            slope, bent = slope + load * by_layer, bent + load * bent_by_layer
        return slope.sum(axis=2) + self.beyond * (at - self.own), bent.sum(axis=2) + self.beyond
