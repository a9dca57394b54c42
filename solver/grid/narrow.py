"""Where narrow patches end, from their loads, and narrow gaps: also those of a few nodes.

Over a patch from m - a to m + a let g = h' - w' be the indenter's slope less that of the surface around it
(see below), and M_k the means of g(m + a t) t^k with the weight (1 - t^2)^-1/2 over -1 < t < 1. The patch then has

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

The displacement around a patch has two parts. The patch's own part bends within a grid spacing at its ends, which no
grid resolves. The part of all others is smooth: at the nodes it is the displacement plus the patch's own part on the
grid of a half-space (`few_nodes.node_compliance`), between them the polynomial through these values (least squares).
For a gap it is the pressure less the part of the gap's own opening (`few_nodes.node_stiffness`): the pressure that
closing this gap alone would leave.

Units: grid spacings, and E* = 1.
"""

from dataclasses import dataclass

import numpy as np

from ...kernels import launch, layout
from ..arrays import Array64, Indices, Mask
from .few_nodes import MARGIN, MOST_NODES, node_compliance, node_stiffness
from .layer_on_grid import LayerOnGrid

_SAMPLES = np.concatenate(np.polynomial.legendre.leggauss(MOST_NODES // 2))  # of an integral over a patch
_STENCIL = np.arange(-2, layout.STENCIL - 2)  # nodes through which heights are interpolated
_POWERS = np.linalg.inv(np.vander(_STENCIL)).T  # to coefficients of the polynomial, from the highest power
_WAVE = 3 * np.pi / 4  # q a at which the layer's modulus is taken


@dataclass(frozen=True, eq=False)
class Surface:
    """The fields on a grid of N points, shape (N,) each."""

    profile: Array64
    """h [length]."""
    displacement: Array64
    """u [length]."""
    pressure: Array64
    """Contact pressure [any unit]."""
    spacings: float
    """Grid spacings of a length."""
    scale: float
    """Factor from pressures to those over E*."""


@dataclass(frozen=True, eq=False)
class Ends:
    """Where some patches or gaps end, by the kernel `narrow_ends`."""

    middle: Array64
    """m, shape (runs,) [grid spacings]."""
    half_width: Array64
    """a, shape (runs,) [grid spacings]."""
    solved: Mask
    """For which the equations were solved, shape (runs,)."""
    deeper: Array64
    """Of patches, mean of w - h with the weight of M_k, shape (runs,) [grid spacings]."""
    centre: Array64
    """Of the loads of patches, shape (runs,) [grid spacings]."""
    uneven: Array64
    """How little the nodes tell of the heights between them: fourth and sixth over second differences, by magnitude,
    means at the ends and in the middle of each run, shape (2, runs). The latter is at least the square of the former,
    as under one wave, because it may be small by chance."""

    @property
    def both(self) -> Array64:
        """Left and right ends, shape (2, runs) [grid spacings]."""
        return np.stack([self.middle - self.half_width, self.middle + self.half_width])


def from_loads(
    surface: Surface,
    first: Indices,
    size: Indices,
    gap: Indices,
    load: Array64,
    begin: tuple[Array64, Array64],
    layer: LayerOnGrid,
) -> Ends:
    """Ends of some patches.

    first, size: first nodes and numbers of nodes, up to `few_nodes.MOST_NODES`; gap: nodes of the narrower one of the
    gaps beside each; load: over E* [grid spacings]; begin: middles and half-widths to begin with [grid spacings]; all
    of shape (patches,). On a layer that the grid does not resolve nothing is around them.
    """
    moment, exponent, margin = 2 / np.pi * load, np.zeros(load.size), np.clip(gap // 2, 1, MARGIN)
    if layer.thickness:
        return _narrow_ends(surface, (first, size, margin, moment, exponent), begin)
    for _ in range(layout.TURNS):  # near this half-width the modulus goes like a power of it
        a = np.maximum(begin[1], layout.CLOSE)
        here, beyond = layer.modulus(_WAVE / a), layer.modulus(_WAVE / (a * (1 + layout.CLOSE)))
        exponent = np.log(beyond / here) / np.log1p(layout.CLOSE)
        found = _narrow_ends(surface, (first, size, 0 * size, moment / here * a**exponent, exponent), begin)
        begin = found.middle, found.half_width
    return found


def gap_ends(surface: Surface, first: Indices, size: Indices, patch: Indices, left: Array64, right: Array64) -> Ends:
    """Ends of some gaps. patch: nodes of the narrower one of the patches beside each; left, right: where to begin
    [grid spacings]; the others as for patches.
    """
    none, margin = np.zeros(left.size), np.clip(patch // 2, 1, MARGIN)
    return _narrow_ends(surface, (first, size, margin, none, none), ((left + right) / 2, (right - left) / 2), gaps=True)


def _narrow_ends(
    surface: Surface, runs: tuple[Array64 | Indices, ...], begin: tuple[Array64, Array64], gaps: bool = False
) -> Ends:
    """runs: the rows of the kernel's argument of this name."""
    scale, spacings = surface.scale, surface.spacings
    field, own, caused = surface.displacement, surface.pressure, node_compliance()
    units = spacings, scale, 0.0
    if gaps:
        field, own, caused, units = own, field, node_stiffness(), (scale, spacings, spacings)
    ends = np.zeros((layout.SIXTH + 1, begin[0].size))
    ends[: layout.SOLVED] = begin
    given = surface.profile, field, own, np.append(units, caused), (_POWERS * spacings).ravel(), gaps
    launch("narrow_ends", begin[0].size, (*given, np.concatenate(runs, dtype=np.float64)), (ends.ravel(),))
    middle, half_width, solved, deeper, centre, fourth, sixth = ends
    good = (solved > 0) & (gaps | (runs[layout.MOMENT] > 0))
    return Ends(middle, half_width, good, deeper, centre, np.stack([fourth, np.maximum(sixth, fourth**2)]))


def squared_slopes(profile: Array64, spacings: float, left: Array64, right: Array64) -> Array64:
    """Integrals of h'^2 from some places to others, of their shape (runs,) [grid spacings], by the kernel of this name.

    profile, spacings: see `Surface`.
    """
    ends = np.concatenate([left, right])
    launch("squared_slopes", left.size, (profile, (_POWERS * spacings).ravel(), _SAMPLES), (ends,))
    return ends[: left.size]


def punch_compliance(half_width: Array64) -> Array64:
    """Displacement of flat punches by a unit load, as deep as `few_nodes.node_compliance` has it (E* = 1).

    half_width: [grid spacings].
    """
    return np.asarray(2 / np.pi * np.log(2 / half_width))
