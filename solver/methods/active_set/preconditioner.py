"""The preconditioner of the active set: every patch inverted on its own, the patches' loads solved together.

Unknown is the contact pressure on the contact nodes C; the operator is G_CC, G = 1/K without the mean mode.

Local part. Every patch on its own (`RunByRun`); in full contact K of all nodes, which is the inverse. G is a Toeplitz
matrix, so all patches share one inverse Cholesky factor, whose leading m x m block serves a patch of m nodes
(`inverse_cholesky`). For longer patches K restricted to the patch, by a short transform, is nearly the inverse: K_bb >=
G_bb^-1, and K_bb G_bb has the spectrum 1 except one outlier for each edge (3 to 11 on the half-space). Both are
deflated with K_bb 1 and K_bb x; 1 to 1.4 is left. Gaps are inverted run by run, too, with K instead of G; long
ones by 1/K on a ring, without deflation (`free_nodes`).

Coarse part (deflation). One unknown per patch: the load of its flat punch, G_bb^-1 1. The entries of Z'GZ need no
transform: the sum of the Green's function over two patches is a four-term difference of its second running sum
(`patch_sums`), scaled to the punches' loads. Where patches are too many for that, neighbours share an unknown.

The parts are kept apart: the local part carries no load, the coarse one makes the loads' sum zero. So the correction
leaves the total load as it is, and a constant in the residual (the rigid approach) has no effect.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from ...arrays import Array64
from ...grid.patches import Patches
from .greens_function import HARD, SMALL, GreensFunction, patch_sums

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
            z[index] = ((padded[index] @ factor.T) * mask) @ factor
        for part, inverse in self._long:
            z[part] = inverse(residual[part])
        return z[:-1]


class LongPatch:
    """Approximate inverse of G on a patch of m nodes, by short transforms."""

    def __init__(self, green: GreensFunction, size: int) -> None:
        self._ring = ring = green.ring(size)
        # 1 is even and x is odd on the patch, and both operators keep that: one transform for the two
        self._basis = _even_and_odd(ring(ring.stiffness, 1 + np.linspace(-1, 1, size)))
        self._image = _even_and_odd(ring(ring.compliance, self._basis.sum(axis=0)))
        self._inverse = np.linalg.inv(self._basis @ self._image.T)

    def __call__(self, residual: Array64) -> Array64:
        """About G_bb^-1 residual, shape (m,); symmetric and positive definite."""
        coarse = self._inverse @ (self._basis @ residual)
        z = self._ring(self._ring.stiffness, residual - coarse @ self._image)
        return np.asarray(z + (coarse - self._inverse @ (self._image @ z)) @ self._basis)


def _even_and_odd(values: Array64) -> Array64:
    """The even and the odd part of values on a patch, shape (2, m)."""
    return np.stack([values + values[::-1], values - values[::-1]]) / 2


class PatchDeflation:
    """Preconditioner for one contact set; see the module's head."""

    def __init__(self, green: GreensFunction, patches: Patches, cautious: bool = False) -> None:
        """cautious: more coarse unknowns than cost a few transform pairs: patches that share one make a set under a
        stiff coating ill-conditioned.
        """
        self.patches, self._green = patches, green
        self._factor = np.ones((1, 1))
        if patches.full:
            return
        self._local = RunByRun(patches, green.factor, partial(LongPatch, green))
        self._punch = self._local(np.ones(patches.nodes.size))
        share = -(-patches.count // max(HARD if cautious else 0, _unknowns(patches.num_points)))
        starts = np.arange(0, patches.count, share)
        self._of_node = patches.label // share
        self._first = patches.offset[starts]  # compact index of each unknown's first node
        self._loads = np.add.reduceat(self._punch, self._first)
        if patches.count > 1:
            # as if the load were spread from the first to the last of the patches that share an unknown
            first, last = patches.first[starts], patches.last[np.append(starts[1:], patches.count) - 1]
            density = self._loads / (last - first + 1)
            coarse = patch_sums(green.layer.second_sum, first, last) * np.outer(density, density)
            own = self._loads if share == 1 else coarse.diagonal() + self._loads  # a flat punch under itself
            np.fill_diagonal(coarse, own)
            self._factor = _inverse_factor(coarse, self._loads)
        self._constant = self._factor.T @ (self._factor @ self._loads)

    def __call__(self, residual: Array64) -> Array64:
        """Preconditioned residual (a pressure), both shape (contact nodes,) in compact order; its sum is 0."""
        if self.patches.full:
            whole = self._green.convolution(residual.size)
            return whole(whole.stiffness, residual)
        loads = self._loads
        moments = np.add.reduceat(self._punch * residual, self._first)
        z = self._local(residual - (moments / loads)[self._of_node])
        coarse = self._factor.T @ (self._factor @ moments)
        coarse -= self._constant * (self._loads @ coarse) / (self._loads @ self._constant)
        coarse -= np.add.reduceat(z, self._first) / loads
        return np.asarray(z + coarse[self._of_node] * self._punch)


def _unknowns(num_points: int) -> int:
    """Coarse unknowns whose dense inverse costs a few transform pairs of that length."""
    return max(16, int(8 * num_points ** (1 / 3)))


def _inverse_factor(coarse: Array64, loads: Array64) -> Array64:
    """R with R'R = coarse^-1; of its diagonal where patches that nearly touch, or rounding, have spoilt it.

    loads > 0 stand for diagonal entries that rounding has left none of.
    """
    try:
        return _inverse_triangle(np.asarray(np.linalg.cholesky(coarse), dtype=np.float64))
    except np.linalg.LinAlgError:
        own = np.diag(coarse)
        return np.diag(1 / np.sqrt(np.where(own > 0, own, loads)))


def _inverse_triangle(lower: Array64) -> Array64:
    """Inverse of a lower triangle by halves: matrix products, where `numpy.linalg.inv` takes five times longer."""
    half = lower.shape[0] // 2
    if half < 24:
        return np.asarray(np.linalg.inv(lower))
    inverse = np.zeros_like(lower)
    inverse[:half, :half] = _inverse_triangle(lower[:half, :half])
    inverse[half:, half:] = _inverse_triangle(lower[half:, half:])
    inverse[half:, :half] = -inverse[half:, half:] @ (lower[half:, :half] @ inverse[:half, :half])
    return inverse
