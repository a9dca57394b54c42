"""Where narrow patches end, from their loads, also patches of a few nodes: to some thousandths of a grid spacing where
several share the load, and to a millionth where there is one.

Beside the half-space's own singular response everything varies slowly over a patch that is narrow beside the layer's
thickness. Let g = h' + w' be the slope over it, w the displacement into the layer by all other patches, and b_k = 2/pi
int g(m + a t) T_k(t) (1 - t^2)^-1/2 dt over -1 < t < 1. A patch from m - a to m + a then has

    the load P = pi/4 E* a b_1, and b_0 = 0

(inversion of the finite Hilbert transform, K. L. Johnson, Contact Mechanics (1985), section 2.7, with pressures that
are 0 at both ends: for that b_0 has to be 0). These two equations give m and a, by Newton's method. The load is a sum
over the nodes. To b_0 distant loads to one side add a constant slope. It follows from the displacements of the nodes
before and behind the patch, less what the patch's own pressure causes there on the grid.

A neighbour at the distance D with the load P and the half-width a adds the slope of a Hertz contact, in units of E*,

    w'(D) = -4 P/pi / (D + (D^2 - a^2)^1/2),

those further away as if their load were spread evenly. By the layer every load P, the patch's own included, adds

    P/pi int (2 - q/K(q)) sin(q D) dq  over q > 0,

which `layer_slope` has as a table.

Patches that are not narrow beside the layer's thickness can be estimated only: as if the layer were a half-space of the
modulus 2K(q)/q at q = 3 pi/(4 a), which makes a parabola's load right on the half-space and on a Winkler foundation,
and with the centre of pressure, m + a b_2/(2 b_1), in the place of b_0.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from ..arrays import Array64, Indices, Mask
from .heights import Heights
from .layer_slope import NEIGHBOURS, LayerSlope, Modulus
from .patches import Patches

_SAMPLES = 8  # of the slope over a patch
_ANGLES = np.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
_T1, _T2, _T3 = (np.cos(k * _ANGLES) for k in (1, 2, 3))
_MOMENTS = 2 / _SAMPLES * np.stack([_T1, _T2, _T3], axis=1)
_BENT_MOMENTS = 2 / _SAMPLES * np.stack([_T1, _T1 * _T1, _T2, _T1 * _T2], axis=1)
_BLOCK = 2**13  # patches at a time: each takes some kilobytes
_WAVE = 3 * np.pi / 4  # q a at which the layer's modulus is taken
_ACROSS = np.array([-np.sqrt(0.5), 0.0, np.sqrt(0.5)])  # places in a Hertz contact that stand for its load
_SHARES = np.array([0.25, 0.5, 0.25])  # of the load there
_PLACES, _OF_PLACES = np.polynomial.legendre.leggauss(5)  # from the node before a patch to that behind it
_STEPS, _STEP, _CLOSE = 10, 0.25, 1e-3  # of Newton's method: most, their length and the last one's [grid spacings]
_GUESSED = 0.75  # distance of the first guess of a middle from halfway between the end nodes, at most [grid spacings]


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
    by_others: Array64
    """What the other patches add to the change of the slope, all parts of it taken positive, over that change, shape
    (patches,) (dimensionless)."""
    solved: Mask
    """For which the equations were solved, shape (patches,)."""

    @classmethod
    def join(cls, parts: Sequence["FromLoads"]) -> "FromLoads":
        """Several lists of patches, one after the other."""
        return cls(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)))


def from_loads(
    patches: Patches,
    chosen: Indices,
    narrow: Mask,
    pressure: Array64,
    heights: Heights,
    modulus: Modulus,
    layer: LayerSlope,
    half_width: Array64,
    slope_by_others: Array64,
) -> FromLoads:
    """Ends of the chosen patches. narrow: which of them are narrow beside the layer's thickness, of their shape.

    pressure: over E*, on the contact nodes in compact order; layer: its part of the response; half_width: of all
    patches, as far as known, shape (M,) [grid spacings]; slope_by_others: mean of w' from the node before each chosen
    patch to that behind it, of their shape (dimensionless), of no meaning where they are not narrow.
    """
    loads = patches.sums(pressure)
    inside = np.arange(pressure.size) - np.repeat(patches.offset, patches.size)
    middles = patches.first + patches.sums(pressure * inside) / loads
    block = _BLOCK * NEIGHBOURS // layer.neighbours
    blocks = range(0, max(1, chosen.size), block)
    found, between = [], (patches.first + patches.last) / 2
    for i in blocks:
        own, thin = chosen[i : i + block], narrow[i : i + block]
        others = _Neighbours.of(patches, own, loads, middles, half_width, layer)
        across = between[own, None] + (patches.size[own, None] + 1) / 2 * _PLACES
        known = others.slope(across, layer)[0] + others.own_load[:, None] * layer.slope(across - others.own)[0]
        missing = np.where(thin, slope_by_others[i : i + block] - known @ _OF_PLACES / 2, 0.0)
        lowest = _lowest(heights, between[own], known[:, _PLACES.size // 2] + missing)
        centre = np.where(thin, lowest, middles[own])
        found.append(_solved(others, layer, thin, heights, modulus, missing, centre))
    return FromLoads.join(found)


def _solved(
    others: "_Neighbours",
    layer: LayerSlope,
    narrow: Mask,
    heights: Heights,
    modulus: Modulus,
    missing: Array64,
    centre: Array64,
) -> FromLoads:
    """Ends of some patches, those of `others`.

    missing: the constant part of w' that neither `others` nor the layer account for; centre: where to begin [grid
    spacings]; both of shape (patches,).
    """
    load, middle = others.own_load, others.own[:, 0]
    m, a = centre.copy(), others.own_half_width.copy()
    # everything but the indenter changes little while m and a do
    start = m[:, None] + a[:, None] * _T1
    far, far_bent, of_others = others.slope(start, layer)
    if layer.distance.size:
        own, own_bent = (part * (load * narrow)[:, None] for part in layer.slope(start - others.own))
        far, far_bent = far + own, far_bent + own_bent
    far += missing[:, None]
    (skew, bend, share), solved = np.zeros((3, a.size)), np.zeros(a.size, dtype=bool)
    left = np.arange(a.size)
    for _ in range(_STEPS):
        p, x, c = load[left], m[left], a[left]
        at = x[:, None] + c[:, None] * _T1
        g, bent = heights.slope(at)
        g += far[left] + far_bent[left] * (at - start[left])
        bent += far_bent[left]
        b = g @ _MOMENTS
        stiffness = (1.0, 0.0) if narrow.all() else _stiffness(modulus, c, narrow[left])
        mean = np.stack([g.mean(axis=1), bent @ _T1 / _SAMPLES, bent.mean(axis=1)])
        second = np.where(narrow[left], mean, _moment(p, x - middle[left], c, b, bent @ _BENT_MOMENTS, *stiffness))
        step, usable = _newton(p, c, b, bent @ _BENT_MOMENTS, second, *stiffness)
        most = np.minimum(_STEP, 0.5 * c)
        step = np.minimum(np.maximum(step, -most), most)
        a[left], m[left] = c - step[0], x - step[1]
        with np.errstate(divide="ignore", invalid="ignore"):
            skew[left], bend[left] = np.abs(b[:, 1:].T / b[:, 0])
            share[left] = of_others[left] * c / np.abs(b[:, 0])
        moved = np.abs(step).max(axis=0)
        solved[left] = usable & (moved < _CLOSE) & (b[:, 0] > 0)
        left = left[usable & (moved >= _CLOSE)]
        if not left.size:
            break
    return FromLoads(m, a, skew, bend, share, solved)


def _lowest(heights: Heights, at: Array64, slope: Array64) -> Array64:
    """Estimated lowest points of heights plus a constant slope, near some places, shape (patches,) [grid spacings]."""
    own, bent = heights.slope_in_the_middle(at)
    return np.asarray(at - np.clip((own + slope) / np.maximum(bent, 1e-300), -_GUESSED, _GUESSED))


def _moment(
    load: Array64, away: Array64, a: Array64, b: Array64, bent: Array64, stiff: Array64 | float, rise: Array64 | float
) -> Array64:
    """What the centre of pressure leaves, and its derivatives with respect to a and m, shape (3, patches).

    away: m less the centre of pressure; the others as in `_newton`.
    """
    b2, (_, _, of_t2, of_t1_t2) = b[:, 1], bent.T
    k = np.pi / 8 * stiff * a * a * b2 + load * away
    k_a = np.pi / 8 * stiff * ((2 + rise) * a * b2 + a * a * of_t1_t2)
    return np.stack([k, k_a, np.pi / 8 * stiff * a * a * of_t2 + load])


def _newton(
    load: Array64,
    a: Array64,
    b: Array64,
    bent: Array64,
    second: Array64,
    stiff: Array64 | float,
    rise: Array64 | float,
) -> tuple[Array64, Mask]:
    """The step in a and m, shape (2, patches), of Newton's method for the load and a second equation; and where there
    is one.

    b, bent: moments of the slope and of its derivative; second: what is to be 0, b_0/2 or of the moment, and its
    derivatives with respect to a and m, shape (3, patches); stiff, rise: modulus over E* and its logarithmic derivative
    with respect to a.
    """
    b1, (of_one, of_t1_t1, _, _), (k, k_a, k_m) = b[:, 0], bent.T, second
    f = np.pi / 4 * stiff * a * b1 - load
    f_a = np.pi / 4 * stiff * ((1 + rise) * b1 + a * of_t1_t1)
    f_m = np.pi / 4 * stiff * a * of_one
    determinant = f_a * k_m - f_m * k_a
    usable = determinant > 0
    step = np.stack([f * k_m - k * f_m, k * f_a - f * k_a]) / np.where(usable, determinant, 1.0)
    return np.where(usable, step, 0.0), usable


def _stiffness(modulus: Modulus, a: Array64, narrow: Mask) -> tuple[Array64, Array64]:
    """The layer's modulus over E* for patches of the half-width a, and its logarithmic derivative with respect to a;
    for narrow ones the half-space's.
    """
    step = 1e-3
    here, wider = modulus(np.stack([_WAVE / a, _WAVE / (a * (1 + step))]))
    return np.where(narrow, 1.0, here), np.where(narrow, 0.0, (wider / here - 1) / step)


@dataclass(frozen=True, eq=False)
class _Neighbours:
    """The patches on both sides of some, and what is beyond them."""

    middle: Array64
    """Their centres of pressure, shape (patches, neighbours) [grid spacings]."""
    load: Array64
    """Their loads over E*, shape (patches, neighbours) [grid spacings]."""
    half_width: Array64
    """Their half-widths, shape (patches, neighbours) [grid spacings]."""
    own: Array64
    """Centres of pressure of the patches themselves, shape (patches, 1) [grid spacings]."""
    own_load: Array64
    """Loads of the patches themselves over E*, shape (patches,) [grid spacings]."""
    own_half_width: Array64
    """Half-widths of the patches themselves, as far as known, shape (patches,) [grid spacings]."""
    beyond: Array64
    """Curvature of the displacement by what is further away, shape (patches, 1) [1/grid spacing]."""

    @classmethod
    def of(
        cls,
        patches: Patches,
        chosen: Indices,
        load: Array64,
        middle: Array64,
        half_width: Array64,
        layer: LayerSlope,
    ) -> "_Neighbours":
        count = layer.neighbours
        steps = np.concatenate([np.arange(-count - 1, 0), np.arange(1, count + 2)])
        period, which = np.divmod(chosen[:, None] + steps, patches.count)
        place, own = middle[which] + period * patches.num_points, middle[chosen, None]
        distance = np.abs(place - own)
        # the even load begins half way to the first patch that is not looked at
        begins = (distance[:, [0, -1]] + distance[:, [1, -2]]) / 2
        even = 1 / begins - np.pi / 2 * layer.slope(begins)[0]
        beyond = 2 / np.pi * load.sum() / patches.num_points * even.sum(axis=1, keepdims=True)
        near = which[:, 1:-1]
        return cls(place[:, 1:-1], load[near], half_width[near], own, load[chosen], half_width[chosen], beyond)

    def slope(self, at: Array64, layer: LayerSlope) -> tuple[Array64, Array64, Array64]:
        """w' and its derivative [1/grid spacing] at some places of each patch, shape (patches, places); and, averaged
        over the places, the sum of what the single neighbours add to that derivative, by the half-space and by the
        layer, all taken positive, shape (patches,) [1/grid spacing].
        """
        load = self.load[:, None, :]
        distance = at[:, :, None] - self.middle[:, None, :]
        root = np.sqrt(np.maximum(distance**2 - self.half_width[:, None, :] ** 2, 0.25))
        size = 4 / np.pi * load / (np.abs(distance) + root)
        slope, bent = -np.copysign(size, distance), size / root
        parts = bent.mean(axis=1)
        if layer.distance.size:
            by_layer = np.zeros_like(bent)
            for across, share in zip(_ACROSS, _SHARES, strict=True):
                slope_of_one, bent_of_one = layer.slope(distance - across * self.half_width[:, None, :])
                slope, by_layer = slope + share * load * slope_of_one, by_layer + share * load * bent_of_one
            bent = bent + by_layer
            parts = parts + np.abs(by_layer.mean(axis=1))
        far = self.beyond
        return slope.sum(axis=2) + far * (at - self.own), bent.sum(axis=2) + far, parts.sum(axis=1) + far[:, 0]
