"""The indenter's heights between the nodes of a grid."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.polynomial import polyval

from ..arrays import Array64

_STENCIL = np.arange(-2, 4)  # nodes through which heights are interpolated
_POWERS = np.linalg.inv(np.vander(_STENCIL, increasing=True)).T  # to coefficients of the polynomial
_SIDES = np.array([-1e-6, 1e-6])  # places beside a node, whose cells tell two slopes and curvatures [grid spacings]


@dataclass(frozen=True, eq=False)
class Heights:
    """The indenter's heights, and the slope between them."""

    profile: Array64
    """h on the grid, shape (N,) [any length]."""
    scale: float
    """What makes grid spacings of that length."""

    def slope(self, at: Array64) -> tuple[Array64, Array64]:
        """h' and h'' [1/grid spacing] at places between the nodes [grid spacings], from six of them."""
        part, powers = self._polynomials(at)
        first, second = np.zeros_like(part), np.zeros_like(part)
        for k in range(_STENCIL.size - 1, 0, -1):
            second = second * part + first
            first = first * part + k * powers[..., k]
        return first, second

    def values(self, at: Array64) -> Array64:
        """h at places between the nodes [grid spacings], from six of them [grid spacings]."""
        part, powers = self._polynomials(at)
        return np.asarray(polyval(part, np.moveaxis(powers, -1, 0), tensor=False))

    def _polynomials(self, at: Array64) -> tuple[Array64, Array64]:
        """Places as distances from the nodes before them, and the coefficients of the polynomials there, shape
        (..., 6), from the constant to the highest power [grid spacings].
        """
        node = np.floor(at).astype(np.int64)
        nodes = node[..., None] + _STENCIL
        if nodes.size and (nodes.min() < 0 or nodes.max() >= self.profile.size):
            nodes %= self.profile.size
        return at - node, self.profile[nodes] @ (_POWERS * self.scale)

    def slope_in_the_middle(self, at: Array64) -> tuple[Array64, Array64]:
        """h' and h'' [1/grid spacing] at nodes, or halfway between two of them, shape (places,) [grid spacings]; at a
        node the mean of what its two cells tell, so that the mirror image has the same.
        """
        first, second = self.slope(at[:, None] + _SIDES)
        return first.mean(axis=1), second.mean(axis=1)
