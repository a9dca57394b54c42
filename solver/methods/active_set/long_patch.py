"""Approximate inverse of the response G on a patch too long for a dense factor.

K restricted to the patch, by a short transform, is nearly the inverse: K_bb >= G_bb^-1, and K_bb G_bb has the spectrum
1 but for one outlier for each edge (3 to 11 on the half-space). Both are deflated with K_bb 1 and K_bb x, which leaves
1 to 1.4. Where K is short-ranged it is applied on a ring little longer than the patch: what reaches around that leaves
single values down to 0.6 on the half-space, 0.3 on layers. G needs a ring that is twice as long.
"""

from functools import cached_property

import numpy as np

from ...arrays import Array64
from .greens_function import GreensFunction


class LongPatch:
    """Approximate inverse of G on a patch of m nodes, by short transforms."""

    def __init__(self, green: GreensFunction, size: int) -> None:
        self.size = size
        self._around, self._along = around, along = green.around(size), green.along(size)
        # 1 is even and x is odd on the patch, and both operators keep that: one transform for the two
        self._basis = _even_and_odd(along(along.rigidity, 1 + np.linspace(-1, 1, size)))
        self._image = _even_and_odd(around(around.compliance, self._basis.sum(axis=0)))
        self._inverse = np.linalg.inv(self._basis @ self._image.T)

    def solve(self, residual: Array64) -> Array64:
        """About G_bb^-1 residual, shape (m,); symmetric and positive definite."""
        along = self._along
        coarse = self._inverse @ (self._basis @ residual)
        z = along(along.rigidity, residual - coarse @ self._image)
        return np.asarray(z + (coarse - self._inverse @ (self._image @ z)) @ self._basis)

    @cached_property
    def flat_punch(self) -> Array64:
        """About G_bb^-1 1, shape (m,), by a few steps of conjugate gradients."""
        x, r = np.zeros(self.size), np.ones(self.size)
        d, before = np.zeros(self.size), 1.0
        for _ in range(4):
            z = self.solve(r)
            rz = float(r @ z)
            d = z + rz / before * d
            before = rz
            image = self._around(self._around.compliance, d)
            step = rz / float(d @ image)
            x += step * d
            r -= step * image
            if np.abs(r).max() < 0.03:
                break
        return x


def _even_and_odd(values: Array64) -> Array64:
    """The even and the odd part of values on a patch, shape (2, m)."""
    return np.stack([values + values[::-1], values - values[::-1]]) / 2
