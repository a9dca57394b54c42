"""The preconditioner of the active set: every patch inverted on its own, the patches' loads solved together.

Unknown is the contact pressure on the contact nodes C; the operator is G_CC, G = 1/K without the mean mode.

Local part. G is a Toeplitz matrix, so all patches share one inverse Cholesky factor, whose leading m x m block serves a
patch of m nodes (`inverse_cholesky`). Patches too long for that use K restricted to the patch, by a short transform.
K_bb >= G_bb^-1, and K_bb G_bb has the spectrum 1 but for one outlier per edge (3 to 11 on the half-space); both are
deflated with K_bb 1 and K_bb x, which leaves 1 to 1.4.

Coarse part (deflation). One unknown per patch: the load of its flat punch, G_bb^-1 1. The entries of Z'GZ need no
transform: the sum of the Green's function over two patches is a four-term difference of its second running sum
(`GreensFunction.patch_sums`). With more patches than `_unknowns` allows, neighbours share an unknown.

The parts are kept apart: the local part carries no load, the coarse one makes the loads' sum zero. So the correction
leaves the total load as it is, and a constant in the residual (the rigid approach) has no effect.
"""

from functools import cached_property

import numpy as np
import pyfftw
from numpy.typing import NDArray

from .patches import Patches

Array64 = NDArray[np.float64]

LONGEST_DENSE = 256  # nodes; the factor of longer patches costs more than short transforms


def inverse_cholesky(column: Array64, order: int) -> Array64:
    """Lower triangular R with (R_m)' R_m = T_m^-1 for every leading block T_m, m <= order, of a Toeplitz matrix T.

    column: first column of the symmetric positive definite T, at least `order` values. Levinson-Durbin recursion.
    """
    factor = np.zeros((order, order))
    column = column[:order]
    backwards = column[::-1].copy()
    predictor = np.zeros(order)
    predictor[0], error = 1.0, float(column[0])
    factor[0, 0] = 1 / np.sqrt(error)
    for k in range(1, order):
        reflection = -float(predictor[:k] @ backwards[order - 1 - k : order - 1]) / error
        predictor[: k + 1] += reflection * predictor[k::-1]
        error *= 1 - reflection * reflection
        np.multiply(predictor[k::-1], 1 / np.sqrt(error), out=factor[k, : k + 1])
    return factor


class GreensFunction:
    """Real-space G and K of one grid. stiffness: K(q_k), shape (N//2 + 1,) [E*/L]."""

    def __init__(self, stiffness: Array64) -> None:
        self._stiffness = stiffness
        self.num_points = 2 * (stiffness.size - 1)
        self._factor = np.zeros((0, 0))
        self._symbols: dict[int, tuple[Array64, Array64]] = {}

    @cached_property
    def compliance(self) -> Array64:
        """G(q_k) = 1/K(q_k), 0 for the mean mode; shape (N//2 + 1,)."""
        return np.append(0.0, 1 / self._stiffness[1:])

    @cached_property
    def response(self) -> Array64:
        """G in real space, shape (N,): displacement around a node of unit pressure."""
        return np.fft.irfft(self.compliance, self.num_points)

    @cached_property
    def _rigidity(self) -> Array64:
        return np.fft.irfft(self._stiffness, self.num_points)

    @cached_property
    def _second_sum(self) -> Array64:
        """T with T(k+1) - 2 T(k) + T(k-1) = G(k), shape (N,)."""
        sine = np.sin(np.pi * np.arange(self.num_points // 2 + 1) / self.num_points)
        symbol = np.zeros_like(sine)
        symbol[1:] = -self.compliance[1:] / (4 * sine[1:] ** 2)
        return np.fft.irfft(symbol, self.num_points)

    def patch_sums(self, patches: Patches) -> Array64:
        """Z'GZ for Z = 1 on each patch, shape (M, M): the sums of G(a - b) over a in one patch, b in another."""
        ends = np.concatenate([patches.first, patches.last + 1])
        lags = np.abs(ends[:, None] - ends)
        sums = self._second_sum[np.where(lags < self.num_points, lags, lags - self.num_points)]
        m = patches.count
        return np.asarray(sums[m:, :m] + sums[:m, m:] - sums[:m, :m] - sums[m:, m:])

    def factor(self, order: int) -> Array64:
        """`inverse_cholesky` of G, at least that large."""
        if self._factor.shape[0] < order:
            self._factor = inverse_cholesky(self.response, min(64 * -(-order // 64), self.num_points // 2))
        return self._factor

    def symbols(self, length: int) -> tuple[Array64, Array64]:
        """Spectra of K and G restricted to lags up to length/2, for convolutions of that length (N: unrestricted)."""
        if length not in self._symbols:
            if length == self.num_points:
                self._symbols[length] = self._stiffness, self.compliance
            else:
                half = np.arange(length // 2 + 1)
                self._symbols[length] = (
                    np.fft.hfft(self._rigidity[half], length)[: half.size],
                    np.fft.hfft(self.response[half], length)[: half.size],
                )
        return self._symbols[length]


class LongPatch:
    """Approximate inverse of G on a patch of m nodes, by short transforms."""

    def __init__(self, green: GreensFunction, size: int) -> None:
        self.size = size
        # twice the patch keeps the ends apart
        even = 2 * pyfftw.next_fast_len(size)
        self.length = min(even, green.num_points)
        self._rigidity, self._compliance = green.symbols(self.length)
        self.whole = size == green.num_points
        if not self.whole:
            x = np.stack([np.ones(size), np.linspace(-1, 1, size)])
            self._basis = self._convolve(self._rigidity, x)
            self._image = self._convolve(self._compliance, self._basis)
            self._inverse = np.linalg.inv(self._basis @ self._image.T)

    def _convolve(self, symbol: Array64, values: Array64) -> Array64:
        spectrum = np.fft.rfft(values, self.length)
        return np.asarray(np.fft.irfft(symbol * spectrum, self.length)[..., : self.size])

    def solve(self, residual: Array64) -> Array64:
        """About G_bb^-1 residual, shape (m,); symmetric and positive definite."""
        if self.whole:
            return self._convolve(self._rigidity, residual)
        coarse = self._inverse @ (self._basis @ residual)
        z = self._convolve(self._rigidity, residual - coarse @ self._image)
        return np.asarray(z + (coarse - self._inverse @ (self._image @ z)) @ self._basis)

    def flat_punch(self) -> Array64:
        """G_bb^-1 1, by a few steps of conjugate gradients."""
        x, r = np.zeros(self.size), np.ones(self.size)
        d, before = np.zeros(self.size), 1.0
        for _ in range(4):
            z = self.solve(r)
            rz = float(r @ z)
            d = z + rz / before * d
            before = rz
            image = self._convolve(self._compliance, d)
            step = rz / float(d @ image)
            x += step * d
            r -= step * image
            if np.abs(r).max() < 0.03:
                break
        return x


class PatchDeflation:
    """Preconditioner for one contact set; see the module's head."""

    def __init__(self, green: GreensFunction, patches: Patches, previous: "PatchDeflation | None" = None) -> None:
        """`previous`: of a similar set, whose coarse inverse is good enough if the patches are as many."""
        self.patches = patches
        self.transformed = 0  # points gone through short transforms
        self._long = {p: LongPatch(green, int(patches.size[p])) for p in np.flatnonzero(patches.size > LONGEST_DENSE)}
        self._blocks = list(self._dense_blocks(green))
        if patches.full:
            return
        self._punch = self._local(np.ones(patches.nodes.size))
        for p, long in self._long.items():
            self._punch[self._part(p)] = long.flat_punch()
        self._share = -(-patches.count // _unknowns(patches.num_points))
        self._unknown = patches.label // self._share
        loads = patches.sums(self._punch)
        self._loads = self._merge(loads)
        if previous and not previous.patches.full and previous.patches.count == patches.count:
            self._coarse_inverse = previous._coarse_inverse
        elif patches.count == 1:
            self._coarse_inverse = np.ones((1, 1))
        else:
            coarse = green.patch_sums(patches) * np.outer(loads / patches.size, loads / patches.size)
            np.fill_diagonal(coarse, loads)
            self._coarse_inverse = _inverse(self._merge(self._merge(coarse).T))
        self._constant = self._coarse_inverse @ self._loads

    def _merge(self, values: Array64) -> Array64:
        """Sums over the patches that share an unknown, along the first axis."""
        if self._share == 1:
            return values
        return np.add.reduceat(values, np.arange(0, values.shape[0], self._share), axis=0)

    def _part(self, patch: int) -> slice:
        start = self.patches.offset[patch]
        return slice(start, start + self.patches.size[patch])

    def _dense_blocks(self, green: GreensFunction):  # type: ignore[no-untyped-def]
        """(factor, compact indices, mask) of the patches of similar size, both of shape (patches, width)."""
        size, offset = self.patches.size, self.patches.offset
        widths = np.where(size > LONGEST_DENSE, 0, np.maximum(8, 2 ** np.ceil(np.log2(size)).astype(np.int64)))
        for width in np.unique(widths[widths > 0]):
            chosen = np.flatnonzero(widths == width)
            width = int(size[chosen].max())
            mask = np.arange(width) < size[chosen, None]
            # outside of a patch: the slot behind the last contact node
            index = np.where(mask, offset[chosen, None] + np.arange(width), self.patches.nodes.size)
            yield green.factor(width)[:width, :width], index, mask

    def _local(self, residual: Array64) -> Array64:
        """Patch by patch G_bb^-1 residual, in compact order."""
        padded = np.append(residual, 0.0)
        z = np.zeros_like(padded)
        for factor, index, mask in self._blocks:
            z[index] = ((padded[index] @ factor.T) * mask) @ factor * mask
        for p, long in self._long.items():
            z[self._part(p)] = long.solve(residual[self._part(p)])
            self.transformed += long.length
        return z[:-1]

    def _sums(self, values: Array64) -> Array64:
        """Sums over the patches of each unknown."""
        return self._merge(self.patches.sums(values))

    def apply(self, residual: Array64) -> Array64:
        """Preconditioned residual, both on the contact nodes in compact order; its sum is 0."""
        if self.patches.full:
            return self._local(residual)
        moments = self._sums(self._punch * residual)
        z = self._local(residual - (moments / self._loads)[self._unknown])
        coarse = self._coarse_inverse @ moments
        coarse -= self._constant * (self._loads @ coarse) / (self._loads @ self._constant)
        coarse -= self._sums(z) / self._loads
        return np.asarray(z + coarse[self._unknown] * self._punch)


def _unknowns(num_points: int) -> int:
    """Coarse unknowns whose dense inverse costs about as much as a transform pair of that length."""
    return max(16, int(8 * num_points ** (1 / 3)))


def _inverse(coarse: Array64) -> Array64:
    """Inverse of the coarse matrix; of its diagonal should patches so close that they touch have spoilt it."""
    try:
        np.linalg.cholesky(coarse)
        return np.asarray(np.linalg.inv(coarse))
    except np.linalg.LinAlgError:
        return np.diag(1 / np.diag(coarse))
