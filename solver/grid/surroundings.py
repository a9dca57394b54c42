"""What everything else does where a patch or a gap of a few nodes is.

The displacement around a patch has two parts. What the patch's own pressure causes bends within a grid spacing where
the patch ends, and no grid resolves that. What all other patches and the layer's base cause is smooth. At the nodes it
is the displacement plus what the patch's own pressure causes on the grid of a half-space (`few_nodes.response`);
between them it is the polynomial through these values (least squares).

For a gap it is the same with the pressure in the place of the displacement: the pressure less what the gap's own
opening causes (`few_nodes.stiffness`), which is the one that closing this gap alone would leave.

Units: grid spacings, and E* = 1.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.polynomial.polynomial import polyval

from ..arrays import Array64, Indices, Mask
from .few_nodes import MARGIN, response, stiffness

Field = Callable[[Indices], Array64]
"""Values at nodes, of any shape, which may lie beyond the ends of the period."""

_DEGREE = 6  # of the polynomials, at most
_TERMS = np.arange(_DEGREE + 1)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A smooth field around some runs of nodes, as polynomials in t = (x - middle)/half."""

    middle: Array64
    """Halfway between the end nodes, shape (runs,) [grid spacings]."""
    half: Array64
    """From there to the last node that was looked at, shape (runs,) [grid spacings]."""
    coefficients: Array64
    """From the constant to the highest power, shape (runs, 7) [unit of the field]."""

    @classmethod
    def of_patches(cls, first: Indices, size: Indices, gap: Indices, pressure: Field, displacement: Field) -> Self:
        """The displacement [grid spacings] that is not caused by some patches' own pressures, of each alone.

        first, size: first nodes and numbers of nodes of the patches, up to `few_nodes.MOST_NODES`; gap: nodes of the
        narrower one of the gaps beside each; all of shape (runs,). pressure: over E*.
        """
        return cls._of(first, size, gap, pressure, displacement, _fit_of_patch)

    @classmethod
    def of_gaps(cls, first: Indices, size: Indices, patch: Indices, opening: Field, pressure: Field) -> Self:
        """The pressure over E* that is not caused by some gaps' own openings, of each alone.

        first, size: first nodes and numbers of nodes of the gaps, up to `few_nodes.MOST_NODES`; patch: nodes of the
        narrower one of the patches beside each; all of shape (runs,). opening: h - u [grid spacings]; pressure: over
        E*, 0 on the open nodes.
        """
        return cls._of(first, size, patch, opening, pressure, _fit_of_gap)

    @classmethod
    def _of(cls, first: Indices, size: Indices, beside: Indices, own: Field, field: Field, fit: "_Fit") -> Self:
        margin = np.clip(beside // 2, 1, MARGIN)
        coefficients = np.zeros((size.size, _TERMS.size))
        kinds = size * (MARGIN + 1) + margin
        for kind in np.unique(kinds):
            (which,) = np.nonzero(kinds == kind)
            nodes, beyond = divmod(int(kind), MARGIN + 1)
            of_field, of_own = fit(nodes, beyond)
            at = first[which, None] + np.arange(-beyond, nodes + beyond)
            coefficients[which] = field(at) @ of_field + own(at[:, beyond : beyond + nodes]) @ of_own
        return cls(first + (size - 1) / 2, (size - 1) / 2 + margin, coefficients)

    def part(self, which: Mask) -> Self:
        """That around some of the runs, shape (runs,)."""
        return type(self)(self.middle[which], self.half[which], self.coefficients[which])

    def slope(self, which: Indices, at: Array64) -> tuple[Array64, Array64]:
        """First and second derivative around some of the runs at places, shape (which, places)."""
        half = self.half[which, None]
        t, c = (at - self.middle[which, None]) / half, self.coefficients[which]
        first, second = np.zeros_like(t), np.zeros_like(t)
        for k in _TERMS[:0:-1]:
            second = second * t + first
            first = first * t + k * c[:, k, None]
        return first / half, second / half**2

    def values(self, which: Indices, at: Array64) -> Array64:
        """The field around some of the runs at places, shape (which, places)."""
        t = (at - self.middle[which, None]) / self.half[which, None]
        return np.asarray(polyval(t, self.coefficients[which].T[:, :, None], tensor=False))


class _Fit(Protocol):
    """Makes coefficients of a run of `size` nodes from the field there and on `margin` nodes to each side, by a matrix
    of shape (size + 2 margin, 7), and from the run's own values, by one of shape (size, 7).
    """

    def __call__(self, size: int, margin: int) -> tuple[Array64, Array64]: ...


def _fit(size: int, margin: int, caused: Array64) -> tuple[Array64, Array64]:
    """See `_Fit`. caused: what a unit value takes off the field so many nodes away."""
    nodes = np.arange(-margin, size + margin)
    degree = max(2, min(_DEGREE, nodes.size - 2))
    t = (nodes - (size - 1) / 2) / ((size - 1) / 2 + margin)
    fitted = np.zeros((nodes.size, _TERMS.size))
    fitted[:, : degree + 1] = np.linalg.pinv(np.vander(t, degree + 1, increasing=True)).T
    of_own = caused[np.abs(nodes[:, None] - np.arange(size))].T @ fitted
    fitted.flags.writeable = of_own.flags.writeable = False
    return fitted, of_own


@functools.cache
def _fit_of_patch(size: int, margin: int) -> tuple[Array64, Array64]:
    return _fit(size, margin, response())


@functools.cache
def _fit_of_gap(size: int, margin: int) -> tuple[Array64, Array64]:
    return _fit(size, margin, -stiffness())
