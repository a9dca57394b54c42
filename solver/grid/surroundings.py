"""Heights between the nodes, and the displacement around a patch of a few nodes that all others cause.

The displacement around a patch has two parts. The patch's own part bends within a grid spacing at its ends, which no
grid resolves. The part of all others is smooth: at the nodes it is the displacement plus the patch's own part on the
grid of a half-space (`few_nodes.node_compliance`), between them the polynomial through these values (least squares).
For a gap it is the pressure less the part of the gap's own opening (`few_nodes.node_stiffness`): the pressure that
closing this gap alone would leave.

Units: grid spacings, and E* = 1.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np

from ..arrays import Array64, Indices
from .few_nodes import MARGIN, MOST_NODES

Field = Callable[[Indices], Array64]
"""Values at nodes, of any shape, which may lie beyond the ends of the period."""

_DEGREE = 2 * MARGIN  # of the polynomials, at most
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(MOST_NODES // 2)  # of an integral over a patch
_STENCIL = np.arange(-2, 4)  # nodes through which heights are interpolated
_POWERS = np.linalg.inv(np.vander(_STENCIL)).T  # to coefficients of the polynomial, from the highest power


@dataclass(frozen=True, eq=False)
class Heights:
    """The indenter's heights."""

    profile: Array64
    """h on the grid, shape (N,) [any length]."""
    scale: float
    """What makes grid spacings of that length."""

    def at_nodes(self, nodes: Indices) -> Array64:
        """h at nodes, which may lie beyond the ends of the period [grid spacings]."""
        return self.profile[nodes % self.profile.size] * self.scale

    def at(self, places: Array64) -> tuple[Array64, Array64, Array64]:
        """h, h' and h'' at places between the nodes, of their shape [grid spacings], from six nodes."""
        node = np.floor(places).astype(np.int64)
        nodes = node[..., None] + _STENCIL
        if nodes.size and (nodes.min() < 0 or nodes.max() >= self.profile.size):
            nodes %= self.profile.size
        return _polynomial(places - node, np.moveaxis(self.profile[nodes] @ (_POWERS * self.scale), -1, 0))

    def squared_slopes(self, left: Array64, right: Array64) -> Array64:
        """Integrals of h'^2 from some places to others, of their shape (runs,) [grid spacings]."""
        half = (right - left)[:, None] / 2
        _, slope, _ = self.at((left + right)[:, None] / 2 + half * _PLACES)
        return np.asarray((slope**2 * half) @ _WEIGHTS)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A smooth field around some runs of nodes, as polynomials in t = (x - middle)/half."""

    middle: Array64
    """Halfway between the end nodes, shape (runs,) [grid spacings]."""
    half: Array64
    """From there to the last node that was looked at, shape (runs,) [grid spacings]."""
    coefficients: Array64
    """From the highest power to the constant, shape (7, runs) [unit of the field]."""

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
        coefficients = np.zeros((size.size, _DEGREE + 1))
        kinds = size * (MARGIN + 1) + margin
        for kind in np.unique(kinds):
            (which,) = np.nonzero(kinds == kind)
            nodes, beyond = divmod(int(kind), MARGIN + 1)
            of_field, of_own = _fit(nodes, beyond, caused)
            at = first[which, None] + np.arange(-beyond, nodes + beyond)
            coefficients[which] = field(at) @ of_field + own(at[:, beyond : beyond + nodes]) @ of_own
        return cls(first + (size - 1) / 2, (size - 1) / 2 + margin, coefficients.T)

    def at(self, which: Indices, places: Array64) -> tuple[Array64, Array64, Array64]:
        """The field with its first and second derivative around some of the runs at places, shape (which, places)."""
        half = self.half[which, None]
        t = (places - self.middle[which, None]) / half
        value, first, second = _polynomial(t, self.coefficients[:, which, None])
        return value, first / half, second / half**2


def _polynomial(t: Array64, coefficients: Array64) -> tuple[Array64, Array64, Array64]:
    """Polynomials at t with their first and second derivatives, of its shape. coefficients: from the highest power,
    along the first axis.
    """
    value, first, second = coefficients[0] * np.ones_like(t), np.zeros_like(t), np.zeros_like(t)
    for coefficient in coefficients[1:]:
        second = second * t + first
        first = first * t + value
        value = value * t + coefficient
    return value, first, 2 * second


@functools.cache
def _fit(size: int, margin: int, caused: Callable[[], Array64]) -> tuple[Array64, Array64]:
    """Makes coefficients of a run of `size` nodes from the field there and on `margin` nodes to each side, by a matrix
    of shape (size + 2 margin, 7), and from the run's own values, by one of shape (size, 7).
    """
    nodes = np.arange(-margin, size + margin)
    degree = max(2, min(_DEGREE, nodes.size - 2))
    t = (nodes - (size - 1) / 2) / ((size - 1) / 2 + margin)
    fitted = np.zeros((nodes.size, _DEGREE + 1))
    fitted[:, _DEGREE - degree :] = np.linalg.pinv(np.vander(t, degree + 1)).T
    of_own = caused()[np.abs(nodes[:, None] - np.arange(size))].T @ fitted
    fitted.flags.writeable = of_own.flags.writeable = False
    return fitted, of_own
