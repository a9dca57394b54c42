"""Approximate inverses on runs of neighbouring nodes, run by run: of the response G on patches, of K on gaps.

G and K are Toeplitz matrices, so all runs share one inverse Cholesky factor, whose leading m x m block serves a run of
m nodes (`inverse_cholesky`).

For longer patches K restricted to the patch, by a short transform, is nearly the inverse: K_bb >= G_bb^-1, and K_bb
G_bb has the spectrum 1 except one outlier for each edge (3 to 11 on the half-space). Both are deflated with K_bb 1 and
K_bb x; 1 to 1.4 is left.
"""

from collections.abc import Callable

import numpy as np

from ...arrays import Array64
from ...grid.patches import Patches
from .greens_function import SMALL, GreensFunction

Inverse = Callable[[Array64], Array64]


class RunByRun:
    """Approximate inverse of a Toeplitz matrix on runs of nodes, every run on its own, in their compact order."""

    def __init__(self, runs: Patches, factor: Callable[[int], Array64], long: Callable[[int], Inverse]) -> None:
        """factor: the inverse Cholesky factor of at least an order; long: the inverse on a run too long for that."""
        short = runs.size <= SMALL
        widths = np.where(short, np.maximum(8, 2 ** np.ceil(np.log2(runs.size)).astype(np.int64)), 0)
        self._blocks = []
        for width in np.unique(widths[short])[::-1]:  # the longest first, whose factor serves the others
            alike = np.flatnonzero(widths == width)
            width = int(runs.size[alike].max())
            mask = np.arange(width) < runs.size[alike, None]
            # outside of a run: the slot behind the last node
            index = np.where(mask, runs.offset[alike, None] + np.arange(width), runs.nodes.size)
            self._blocks.append((factor(width)[:width, :width], index, mask))
        by_size = {size: long(size) for size in set(runs.size[~short].tolist())}
        sizes = zip(runs.offset[~short].tolist(), runs.size[~short].tolist(), strict=True)
        self._long = [(slice(start, start + size), by_size[size]) for start, size in sizes]

    def __call__(self, residual: Array64) -> Array64:
        """The inverse times a residual, both shape (nodes,)."""
        padded = np.append(residual, 0.0)
        z = np.zeros_like(padded)
        for factor, index, mask in self._blocks:
            z[index] = ((padded[index] @ factor.T) * mask) @ factor * mask
        for part, inverse in self._long:
            z[part] = inverse(residual[part])
        return z[:-1]


class LongPatch:
    """Approximate inverse of G on a patch of m nodes, by short transforms."""

    def __init__(self, green: GreensFunction, size: int) -> None:
        self._ring = ring = green.ring(size)
        # 1 is even and x is odd on the patch, and both operators keep that: one transform for the two
        self._basis = _even_and_odd(ring(ring.rigidity, 1 + np.linspace(-1, 1, size)))
        self._image = _even_and_odd(ring(ring.compliance, self._basis.sum(axis=0)))
        self._inverse = np.linalg.inv(self._basis @ self._image.T)

    def __call__(self, residual: Array64) -> Array64:
        """About G_bb^-1 residual, shape (m,); symmetric and positive definite."""
        coarse = self._inverse @ (self._basis @ residual)
        z = self._ring(self._ring.rigidity, residual - coarse @ self._image)
        return np.asarray(z + (coarse - self._inverse @ (self._image @ z)) @ self._basis)


def _even_and_odd(values: Array64) -> Array64:
    """The even and the odd part of values on a patch, shape (2, m)."""
    return np.stack([values + values[::-1], values - values[::-1]]) / 2
