"""The preconditioner of the active set: every patch inverted on its own, the patches' loads solved together.

Unknown is the contact pressure on the contact nodes C; the operator is G_CC, G = 1/K without the mean mode.

Local part. Every patch on its own (`local_inverses`); in full contact K of all nodes, which is the inverse.

Coarse part (deflation). One unknown per patch: the load of its flat punch, G_bb^-1 1. The entries of Z'GZ need no
transform: the sum of the Green's function over two patches is a four-term difference of its second running sum
(`patch_sums`), scaled to the punches' loads. Where patches are too many for that, neighbours share an unknown.

The parts are kept apart: the local part carries no load, the coarse one makes the loads' sum zero. So the correction
leaves the total load as it is, and a constant in the residual (the rigid approach) has no effect.
"""

import numpy as np

from ...arrays import Array64
from ...grid.patches import Patches
from .greens_function import GreensFunction, patch_sums
from .local_inverses import PatchByPatch
from .long_patch import LongPatch

_MOST = 2048  # coarse unknowns of a search that is cautious
_EXACT_SHARE = 16  # patches of one unknown whose mutual influence is summed up, patch by patch


class PatchDeflation:
    """Preconditioner for one contact set; see the module's head."""

    def __init__(
        self,
        green: GreensFunction,
        patches: Patches,
        previous: "PatchDeflation | None" = None,
        cautious: bool = False,
    ) -> None:
        """`previous`: of a similar set, whose coarse inverse serves again if the patches are as many, and whose long
        patches do if they have the same size. cautious: more coarse unknowns than cost a few
        transform pairs: patches that share one make a set under a stiff coating ill-conditioned.
        """
        self.patches, self._green = patches, green
        self._most = max(_MOST if cautious else 0, _unknowns(patches.num_points))
        self._build, self._borders, self._factor = 0, np.zeros(0), np.ones((1, 1))
        self.long_patches: dict[int, LongPatch] = {}
        """By their size."""
        if patches.full:
            return
        self._local = PatchByPatch(green, patches, previous.long_patches if previous else {})
        self.long_patches = self._local.long_patches
        self._punch = self._local.punch
        loads = patches.sums(self._punch)
        if previous and patches.count == previous._build:
            self._build, self._borders, self._factor = previous._build, previous._borders, previous._factor
        elif patches.count > 1:
            self._couple(loads)
        self._of_patch = np.searchsorted(self._borders, patches.first, side="right")
        self._of_node = self._of_patch[patches.label]
        self._loads = np.bincount(self._of_patch, weights=loads, minlength=len(self._factor))
        self._constant = self._factor.T @ (self._factor @ self._loads)

    def _couple(self, loads: Array64) -> None:
        """The coarse inverse, and the borders between its unknowns in the gaps between patches."""
        patches = self.patches
        share = -(-patches.count // self._most)
        starts = np.arange(0, patches.count, share)
        # each row the patches of one unknown; the last row is filled up with patches without load
        member = starts[:, None] + np.arange(share)
        there = member < patches.count
        member = np.minimum(member, patches.count - 1)
        load = np.where(there, loads[member], 0.0)
        # between unknowns: as if the load were spread from the first to the last of the patches
        first, last, total = patches.first[starts], patches.last[member[:, -1]], load.sum(axis=1)
        density = total / (last - first + 1)
        second_sum = self._green.tables.response.second_sum
        coarse = patch_sums(second_sum, first, last) * np.outer(density, density)
        if share <= _EXACT_SHARE:
            shape = load / patches.size[member]
            within = patch_sums(second_sum, patches.first[member], patches.last[member])
            within *= shape[:, :, None] * shape[:, None, :]
            within[:, np.arange(share), np.arange(share)] = load  # a flat punch under itself
            np.fill_diagonal(coarse, within.sum(axis=(1, 2)))
        else:
            coarse[np.diag_indices_from(coarse)] += total
        self._build, self._factor = patches.count, _inverse_factor(coarse, total)
        self._borders = (first[1:] + last[:-1]) / 2

    @property
    def share(self) -> float:
        """Patches over coarse unknowns (dimensionless): how many share one."""
        return self.patches.count / len(self._factor)

    def _sums(self, values: Array64) -> Array64:
        """Sums over the patches of each unknown."""
        return np.bincount(self._of_patch, self.patches.sums(values), len(self._factor)).astype(np.float64)

    def apply(self, residual: Array64) -> Array64:
        """Preconditioned residual (a pressure), both shape (contact nodes,) in compact order; its sum is 0."""
        if self.patches.full:
            whole = self._green.convolution(residual.size)
            return whole(whole.rigidity, residual)
        loads = np.maximum(self._loads, 1e-300)  # 0 where an unknown has lost its patches
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
