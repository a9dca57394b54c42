"""The preconditioner of the active set: every patch inverted on its own, the patches' loads solved together.

Unknown is the contact pressure on the contact nodes C; the operator is G_CC, G = 1/K without the mean mode.

Local part. Every patch on its own (`local_inverses`); in full contact K of all nodes, which is the inverse.

Coarse part (deflation). One unknown per patch: the load of its flat punch, G_bb^-1 1. The entries of Z'GZ need no
transform: the sum of the Green's function over two patches is a four-term difference of its second running sum
(`patch_sums`), scaled to the punches' loads. Where patches are too many for that, neighbours share an unknown.

The parts are kept apart: the local part carries no load, the coarse one makes the loads' sum zero. So the correction
leaves the total load as it is, and a constant in the residual (the rigid approach) has no effect.
"""

from functools import partial

import numpy as np

from ...arrays import Array64
from ...grid.patches import Patches
from .greens_function import HARD, GreensFunction, patch_sums
from .local_inverses import LongPatch, RunByRun


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
        loads = patches.sums(self._punch)
        share = -(-patches.count // max(HARD if cautious else 0, _unknowns(patches.num_points)))
        self._starts = starts = np.arange(0, patches.count, share)
        self._of_node = patches.label // share
        self._loads = np.add.reduceat(loads, starts)
        if patches.count > 1:
            # as if the load were spread from the first to the last of the patches that share an unknown
            first, last = patches.first[starts], patches.last[np.append(starts[1:], patches.count) - 1]
            density = self._loads / (last - first + 1)
            coarse = patch_sums(green.response.second_sum, first, last) * np.outer(density, density)
            own = self._loads if share == 1 else coarse.diagonal() + self._loads  # a flat punch under itself
            np.fill_diagonal(coarse, own)
            self._factor = _inverse_factor(coarse, self._loads)
        self._constant = self._factor.T @ (self._factor @ self._loads)

    def _sums(self, values: Array64) -> Array64:
        """Sums over the patches of each unknown."""
        return np.add.reduceat(self.patches.sums(values), self._starts)

    def __call__(self, residual: Array64) -> Array64:
        """Preconditioned residual (a pressure), both shape (contact nodes,) in compact order; its sum is 0."""
        if self.patches.full:
            whole = self._green.convolution(residual.size)
            return whole(whole.rigidity, residual)
        loads = self._loads
        moments = self._sums(self._punch * residual)
        z = self._local(residual - (moments / loads)[self._of_node])
        coarse = self._factor.T @ (self._factor @ moments)
        coarse -= self._constant * (self._loads @ coarse) / (self._loads @ self._constant)
        coarse -= self._sums(z) / loads
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
