"""Where narrow patches end, from their loads, and narrow gaps: also those of a few nodes.

Over a patch from m - a to m + a let g = h' - w' be the indenter's slope less that of the surface around it
(`surroundings`), and M_k the means of g(m + a t) t^k with the weight (1 - t^2)^-1/2 over -1 < t < 1. The patch then has

    the load P = pi/2 E* a M_1, and M_0 = 0

(inversion of the finite Hilbert transform, K. L. Johnson, Contact Mechanics (1985), section 2.7, with pressures that
are 0 at both ends: for that M_0 has to be 0). These two equations give m and a, by Newton's method. The load is a sum
over the nodes.

If one gap were pressed shut, the pressure there would be partly negative. The gap opens so far that no pressure is left
in it, and closes smoothly: at its ends the pressure is 0 and not infinite. With that pressure instead of g, M_0 =
M_1 = 0 (both stress intensity factors of a crack with this tension on its faces are 0; H. Tada, P. C. Paris and G. R.
Irwin, The Stress Analysis of Cracks Handbook (1973)).

A patch with the load P is pressed into the surface around it by w - h = 2 P/(pi E*) ln(2/a), its mean with the same
weight, lengths in grid spacings; by how much w - h differs from that `shares` puts right.

On a layer that the grid does not resolve a patch of one or two nodes is estimated as if nothing were around it on a
half-space of the modulus 2K(q)/q at q = 3 pi/(4 a), which is right for a parabola on a Winkler foundation, too.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import Array64, Indices, Mask
from .surroundings import Heights, Surroundings

_SAMPLES = 8  # of the slope over a patch, or of the pressure over a gap
_T1 = np.cos(np.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES)
MEANS = _T1[:, None] ** np.arange(3) / _SAMPLES
"""Makes M_0, M_1 and M_2 of values at `samples`."""
_WAVE = 3 * np.pi / 4  # q a at which the layer's modulus is taken
_STEPS, _STEP, _NEARLY = 24, 0.25, 0.02
"""Of Newton's method: most, their length and that of the last one, at most [grid spacings]; the last one is at most
that part of the half-width, too. In the second half longer ones are halved, as they may go to and fro about a node,
where the polynomials of the heights change."""
_CLOSE = _NEARLY**2  # length of a step that needs no other, over the half-width or the spacing


@dataclass(frozen=True, eq=False)
class Ends:
    """Where some patches or gaps end."""

    middle: Array64
    """m, shape (runs,) [grid spacings]."""
    half_width: Array64
    """a, shape (runs,) [grid spacings]."""
    solved: Mask
    """For which the equations were solved, shape (runs,)."""

    @property
    def both(self) -> Array64:
        """Left and right ends, shape (2, runs) [grid spacings]."""
        return np.stack([self.middle - self.half_width, self.middle + self.half_width])


def from_loads(
    load: Array64,
    heights: Heights,
    begin: tuple[Array64, Array64],
    around: Surroundings | None = None,
    modulus: Callable[[Array64], Array64] | None = None,
) -> Ends:
    """Ends of some patches. load: over E* [grid spacings]; begin: middles and half-widths to begin with [grid
    spacings]; all of shape (patches,). modulus: see `LayerOnGrid`, where the grid does not resolve the layer and
    nothing is `around`.
    """

    def slope(which: Indices, at: Array64) -> tuple[Array64, Array64]:
        _, first, second = heights.at(at)
        if around is None:
            return first, second
        _, first_around, second_around = around.at(which, at)
        return first - first_around, second - second_around

    def moment(which: Indices, a: Array64) -> Array64:
        return 2 / np.pi * load[which] / (a * modulus(_WAVE / a) if modulus else a)

    found = _newton(slope, moment, *begin, 1)
    return Ends(found.middle, found.half_width, found.solved & (load > 0))


def gap_ends(closed: Surroundings, left: Array64, right: Array64) -> Ends:
    """Ends of some gaps. closed: the pressure without each; left, right: where to begin, (gaps,) [grid spacings]."""

    def pressure(which: Indices, at: Array64) -> tuple[Array64, Array64]:
        return closed.at(which, at)[:2]

    return _newton(pressure, lambda which, a: np.zeros_like(a), (left + right) / 2, (right - left) / 2, -1)


def samples(middle: Array64, half_width: Array64) -> Array64:
    """Places whose mean is the one with the weight (1 - t^2)^-1/2, shape (runs, samples) [grid spacings]."""
    return middle[:, None] + half_width[:, None] * _T1


def _newton(
    field: Callable[[Indices, Array64], tuple[Array64, Array64]],
    moment: Callable[[Indices, Array64], Array64],
    middle: Array64,
    half_width: Array64,
    sign: int,
) -> Ends:
    """M_0 = 0 and M_1 = moment(a). field: g, or the pressure, with its derivative; middle, half_width: where to begin;
    sign: of the equations' determinant.
    """
    m, a, going_on = middle.copy(), np.maximum(half_width, _CLOSE), np.arange(middle.size)
    solved = np.zeros(m.size, dtype=bool)
    for turn in range(_STEPS):
        half = a[going_on]
        value, slope = field(going_on, samples(m[going_on], half))
        (m_0, m_1), (by_m, by_both, by_a) = (value @ MEANS[:, :2]).T, (slope @ MEANS).T
        wanted, beyond = moment(going_on, half), moment(going_on, half * (1 + _CLOSE))
        f, by_a = m_1 - wanted, by_a - (beyond - wanted) / (half * _CLOSE)
        determinant = by_m * by_a - by_both**2
        usable = sign * determinant > 0
        step = np.stack([m_0 * by_a - f * by_both, f * by_m - m_0 * by_both]) / np.where(usable, determinant, np.inf)
        length, most = np.abs(step).max(axis=0), np.minimum(_STEP, half / 2)
        step = np.clip(step, -most, most) * np.where((turn >= _STEPS // 2) & (length > _NEARLY), 0.5, 1.0)
        m[going_on], a[going_on] = m[going_on] - step[0], half - step[1]
        solved[going_on] = usable & (length < np.minimum(_NEARLY, _STEP * half))
        going_on = going_on[usable & (length >= _CLOSE * np.minimum(half, 1.0))]
        if not going_on.size:
            break
    return Ends(m, a, solved)
