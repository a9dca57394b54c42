"""Where narrow patches end, from their loads, and narrow gaps: also those of a few nodes.

Over a patch from m - a to m + a let g = h' - w' be the indenter's slope less that of the surface around it
(`Surroundings`), and M_k the means of g(m + a t) t^k with the weight (1 - t^2)^-1/2 over -1 < t < 1. The patch then has

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

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ...kernels import launch, layout
from ..arrays import Array64, Indices, Mask
from .few_nodes import MARGIN, MOST_NODES

Field = Callable[[Indices], Array64]
"""Values at nodes, of any shape, which may lie beyond the ends of the period."""

_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(MOST_NODES // 2)  # of an integral over a patch
_STENCIL = np.arange(-2, layout.STENCIL - 2)  # nodes through which heights are interpolated
_POWERS = np.linalg.inv(np.vander(_STENCIL)).T  # to coefficients of the polynomial, from the highest power
_T1 = np.cos(np.pi * (np.arange(layout.SAMPLES) + 0.5) / layout.SAMPLES)
_MEANS = _T1[:, None] ** np.arange(3) / layout.SAMPLES
_WAVE = 3 * np.pi / 4  # q a at which the layer's modulus is taken


@dataclass(frozen=True, eq=False)
class Heights:
    """The indenter's heights."""

    profile: Array64
    """h on the grid, shape (N,) [any length]."""
    scale: float
    """What makes grid spacings of that length."""

    def at(self, places: Array64) -> tuple[Array64, Array64]:
        """h and h' at places between the nodes, of their shape [grid spacings], from six nodes."""
        node = np.floor(places).astype(np.int64)
        nodes = node[..., None] + _STENCIL
        if nodes.size and (nodes.min() < 0 or nodes.max() >= self.profile.size):
            nodes %= self.profile.size
        return _polynomial(places - node, np.moveaxis(self.profile[nodes] @ (_POWERS * self.scale), -1, 0))

    def squared_slopes(self, left: Array64, right: Array64) -> Array64:
        """Integrals of h'^2 from some places to others, of their shape (runs,) [grid spacings]."""
        half = (right - left)[:, None] / 2
        _, slope = self.at((left + right)[:, None] / 2 + half * _PLACES)
        return np.asarray((slope**2 * half) @ _WEIGHTS)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A smooth field around some runs of nodes, as polynomials in t = (x - middle)/half."""

    middle: Array64
    """Halfway between the end nodes, shape (runs,) [grid spacings]."""
    half: Array64
    """From there to the last node that was looked at, shape (runs,) [grid spacings]."""
    coefficients: Array64
    """From the highest power to the constant, shape (degree + 1, runs) [unit of the field]."""

    @classmethod
    def of(
        cls, first: Indices, size: Indices, beside: Indices, own: Field, field: Field, caused: Callable[[], Array64]
    ) -> Self:
        """The displacement that is not caused by some patches' own pressures, of each alone; or the pressure that is
        not caused by some gaps' own openings.

        first, size: first nodes and numbers of nodes of the runs, up to `few_nodes.MOST_NODES`; beside: nodes of the
        narrower one of the gaps, or patches, beside each; all of shape (runs,). own: pressures, or displacements less
        heights, 0 beyond the runs; field: displacements, or pressures. caused: the part that a unit of `own` takes
        off the field so many nodes away, `few_nodes.node_compliance` or `few_nodes.node_stiffness`.
        """
        margin = np.clip(beside // 2, 1, MARGIN)
        coefficients = np.zeros((size.size, layout.DEGREE))
        kinds = size * (MARGIN + 1) + margin
        for kind in np.unique(kinds):
            (which,) = np.nonzero(kinds == kind)
            nodes, beyond = divmod(int(kind), MARGIN + 1)
            of_field, of_own = _fit(nodes, beyond, caused)
            at = first[which, None] + np.arange(-beyond, nodes + beyond)
            coefficients[which] = field(at) @ of_field + own(at[:, beyond : beyond + nodes]) @ of_own
        return cls(first + (size - 1) / 2, (size - 1) / 2 + margin, coefficients.T)

    def at(self, places: Array64) -> tuple[Array64, Array64]:
        """The field and its derivative around the runs at places, shape (runs, places)."""
        half = self.half[:, None]
        value, slope = _polynomial((places - self.middle[:, None]) / half, self.coefficients[..., None])
        return value, slope / half


def _polynomial(t: Array64, coefficients: Array64) -> tuple[Array64, Array64]:
    """Polynomials at t with their derivatives, of its shape. coefficients: from the highest power, along the first
    axis.
    """
    value, slope = np.zeros_like(t), np.zeros_like(t)
    for coefficient in coefficients:
        slope = slope * t + value
        value = value * t + coefficient
    return value, slope


@functools.cache
def _fit(size: int, margin: int, caused: Callable[[], Array64]) -> tuple[Array64, Array64]:
    """Makes coefficients of a run of `size` nodes from the field there and on `margin` nodes to each side, by a matrix
    of shape (size + 2 margin, 7), and from the run's own values, by one of shape (size, 7).
    """
    nodes = np.arange(-margin, size + margin)
    degree = max(2, min(layout.DEGREE - 1, nodes.size - 2))
    t = (nodes - (size - 1) / 2) / ((size - 1) / 2 + margin)
    fitted = np.zeros((nodes.size, layout.DEGREE))
    fitted[:, layout.DEGREE - 1 - degree :] = np.linalg.pinv(np.vander(t, degree + 1)).T
    of_own = caused()[np.abs(nodes[:, None] - np.arange(size))].T @ fitted
    fitted.flags.writeable = of_own.flags.writeable = False
    return fitted, of_own


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
    moment, exponent = 2 / np.pi * load, np.zeros(load.size)
    around = around or Surroundings(exponent, np.ones(load.size), np.zeros((1, load.size)))
    for _ in range(layout.TURNS if modulus else 1):
        if modulus:  # near this half-width it goes like a power of it
            a = np.maximum(begin[1], layout.CLOSE)
            here, beyond = modulus(_WAVE / a), modulus(_WAVE / (a * (1 + layout.CLOSE)))
            exponent = np.log(beyond / here) / math.log1p(layout.CLOSE)
            moment = 2 / np.pi * load / here * a**exponent
        found = _newton(heights, around, moment, exponent, begin)
        begin = found.middle, found.half_width
    return Ends(*begin, found.solved & (load > 0))


def gap_ends(closed: Surroundings, left: Array64, right: Array64) -> Ends:
    """Ends of some gaps. closed: the pressure without each; left, right: where to begin, (gaps,) [grid spacings]."""
    none, flat = np.zeros(left.size), Heights(np.zeros(layout.STENCIL), 0.0)
    integral = -closed.half * closed.coefficients / np.arange(len(closed.coefficients), 0, -1)[:, None]
    of_slope = replace(closed, coefficients=np.vstack([integral, none]))  # whose slope is the negative pressure
    return _newton(flat, of_slope, none, none, ((left + right) / 2, (right - left) / 2))


def level_errors(found: Ends, around: Surroundings, heights: Heights, load: Array64) -> tuple[Array64, Array64]:
    """By how much patches would have to lie deeper for their loads, and centres of these loads, shape (patches,) [grid
    spacings].

    load: as in `from_loads`.
    """
    at = found.middle[:, None] + found.half_width[:, None] * _T1
    surface, slope = around.at(at)
    height, slope_of_heights = heights.at(at)
    _, m_1, m_2 = ((slope_of_heights - slope) @ _MEANS).T
    with np.errstate(divide="ignore", invalid="ignore"):
        centre = found.middle + found.half_width * m_2 / m_1
    return (surface - height).mean(axis=1) - punch_compliance(found.half_width) * load, centre


def punch_compliance(half_width: Array64) -> Array64:
    """Displacement of flat punches by a unit load, as deep as `few_nodes.node_compliance` has it (E* = 1).

    half_width: [grid spacings].
    """
    return np.asarray(2 / np.pi * np.log(2 / half_width))


def _newton(
    heights: Heights, around: Surroundings, moment: Array64, exponent: Array64, begin: tuple[Array64, Array64]
) -> Ends:
    """Ends by the kernel `narrow_ends`."""
    runs, ends = np.zeros((layout.EXPONENT + 1, moment.size)), np.zeros((layout.SOLVED + 1, moment.size))
    runs[layout.DEGREE + 1 - len(around.coefficients) : layout.DEGREE + 1] = around.coefficients
    runs[layout.DEGREE + 1 :] = around.middle, around.half, moment, exponent
    ends[: layout.SOLVED] = begin
    powers = (_POWERS * heights.scale).ravel()
    launch("narrow_ends", moment.size, (heights.profile, powers, runs.ravel()), (ends.ravel(),))
    middle, half_width, solved = ends
    return Ends(middle, half_width, solved > 0)
