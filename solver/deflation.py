"""The preconditioner of the active set: every patch inverted on its own, the patches' loads solved together.

Unknown is the contact pressure on the contact nodes C; the operator is G_CC, G = 1/K without the mean mode.

Local part. G is a Toeplitz matrix, so all patches share one inverse Cholesky factor, whose leading m x m block serves a
patch of m nodes (`inverse_cholesky`). Patches too long for that use K restricted to the patch, by a short transform.
K_bb >= G_bb^-1, and K_bb G_bb has the spectrum 1 but for one outlier per edge (3 to 11 on the half-space); both are
deflated with K_bb 1 and K_bb x, which leaves 1 to 1.4.

Coarse part (deflation). One unknown per patch: the load of its flat punch, G_bb^-1 1. The entries of Z'GZ need no
transform: the sum of the Green's function over two patches is a four-term difference of its second running sum
(`GreensFunction.patch_sums`), scaled to the punches' loads. With more patches than `_unknowns` allows, neighbours share
an unknown.

The parts are kept apart: the local part carries no load, the coarse one makes the loads' sum zero. So the correction
leaves the total load as it is, and a constant in the residual (the rigid approach) has no effect.
"""

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .fftw import pyfftw
from .patches import Array64, Indices, Patches

LONGEST_DENSE = 256  # nodes; the factor of longer patches costs more than short transforms

_FEW_PATCHES = 8  # do not make the dense factor worth its while
_EXACT_SHARE = 16  # patches of one unknown whose mutual influence is summed up, patch by patch


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
    """Real-space G and K of one grid of N points. stiffness: K(q_k), shape (N//2 + 1,) [K]."""

    def __init__(self, stiffness: Array64, num_points: int) -> None:
        self._stiffness, self.num_points = stiffness, num_points
        self._factor = np.zeros((0, 0))
        self._convolutions: dict[int, Convolution] = {}

    @cached_property
    def compliance(self) -> Array64:
        """G(q_k) = 1/K(q_k), 0 for the mean mode; shape (N//2 + 1,)."""
        return np.append(0.0, 1 / self._stiffness[1:])

    @cached_property
    def response(self) -> Array64:
        """G in real space, shape (N,): displacement around a node of unit pressure."""
        return np.fft.irfft(self.compliance, self.num_points)

    @cached_property
    def _second_sum(self) -> Array64:
        """T with T(k+1) - 2 T(k) + T(k-1) = G(k), shape (N,)."""
        sine = np.sin(np.pi * np.arange(self.num_points // 2 + 1) / self.num_points)
        symbol = np.zeros_like(sine)
        symbol[1:] = -self.compliance[1:] / (4 * sine[1:] ** 2)
        return np.fft.irfft(symbol, self.num_points)

    def patch_sums(self, first: Indices, last: Indices) -> Array64:
        """Z'GZ for Z = 1 on each of M runs of nodes: the sums of G(a - b) over a in one run and b in another.

        first, last: end nodes, shape (..., M). Returns shape (..., M, M).
        """
        start, stop = first, last + 1

        def second_sum(a: Indices, b: Indices) -> Array64:
            return np.take(self._second_sum, a[..., :, None] - b[..., None, :], mode="wrap")

        across = second_sum(stop, start)
        return np.asarray(across + np.swapaxes(across, -1, -2) - second_sum(start, start) - second_sum(stop, stop))

    @property
    def transformed(self) -> int:
        """Points gone through short transforms so far."""
        return sum(c.count * c.length for c in self._convolutions.values())

    def factor(self, order: int) -> Array64:
        """`inverse_cholesky` of G [1/K], shape (m, m) with m >= order; kept for the next call."""
        if self._factor.shape[0] < order:
            self._factor = inverse_cholesky(self.response, min(64 * -(-order // 64), self.num_points - 1))
        return self._factor

    def convolution(self, length: int) -> "Convolution":
        """K and G on a ring of that many nodes; unrestricted for N."""
        if length not in self._convolutions:
            if length == self.num_points:
                rigidity, compliance = self._stiffness, self.compliance
            else:
                modes = np.arange(length // 2 + 1)
                # K at the ring's wave numbers: its tails decay, and a preconditioner may be off; G as it is
                rigidity = np.interp(
                    modes * (self.num_points / length), np.arange(self._stiffness.size), self._stiffness
                )
                compliance = np.fft.hfft(self.response[modes], length)[: modes.size]
            self._convolutions[length] = Convolution(rigidity, compliance, length)
        return self._convolutions[length]


class Convolution:
    """Short transforms of one length, for values on a patch of at most half of it."""

    def __init__(self, rigidity: Array64, compliance: Array64, length: int) -> None:
        self.rigidity, self.compliance, self.length = rigidity, compliance, length
        self._real = pyfftw.zeros_aligned(self.length)
        self._modes = pyfftw.zeros_aligned(rigidity.size, dtype=np.complex128)
        self._forward = pyfftw.FFTW(self._real, self._modes, flags=["FFTW_ESTIMATE"])
        self._inverse = pyfftw.FFTW(self._modes, self._real, direction="FFTW_BACKWARD", flags=["FFTW_ESTIMATE"])
        self.count = 0

    def __call__(self, symbol: Array64, values: Array64) -> Array64:
        """Circular convolution of zero-padded values with a symbol, shape (length//2 + 1,), at the values' nodes."""
        self._real[: values.size] = values
        self._real[values.size :] = 0
        self._forward.execute()
        self._modes *= symbol
        self._inverse.execute()
        self.count += 1
        return np.asarray(self._real[: values.size] / self.length)


class LongPatch:
    """Approximate inverse of G on a patch of m nodes, by short transforms."""

    def __init__(self, green: GreensFunction, size: int) -> None:
        self.size = size
        # twice the patch keeps its ends apart
        self._convolve = convolve = green.convolution(min(2 * pyfftw.next_fast_len(size), green.num_points))
        self.whole = size == green.num_points
        if not self.whole:
            self._basis = np.stack([convolve(convolve.rigidity, x) for x in (np.ones(size), np.linspace(-1, 1, size))])
            self._image = np.stack([convolve(convolve.compliance, z) for z in self._basis])
            self._inverse = np.linalg.inv(self._basis @ self._image.T)

    def solve(self, residual: Array64) -> Array64:
        """About G_bb^-1 residual, shape (m,); symmetric and positive definite."""
        convolve = self._convolve
        if self.whole:
            return convolve(convolve.rigidity, residual)
        coarse = self._inverse @ (self._basis @ residual)
        z = convolve(convolve.rigidity, residual - coarse @ self._image)
        return np.asarray(z + (coarse - self._inverse @ (self._image @ z)) @ self._basis)

    def flat_punch(self) -> Array64:
        """About G_bb^-1 1, by a few steps of conjugate gradients."""
        x, r = np.zeros(self.size), np.ones(self.size)
        d, before = np.zeros(self.size), 1.0
        for _ in range(4):
            z = self.solve(r)
            rz = float(r @ z)
            d = z + rz / before * d
            before = rz
            image = self._convolve(self._convolve.compliance, d)
            step = rz / float(d @ image)
            x += step * d
            r -= step * image
            if np.abs(r).max() < 0.03:
                break
        return x


class PatchDeflation:
    """Preconditioner for one contact set; see the module's head."""

    def __init__(self, green: GreensFunction, patches: Patches, previous: "PatchDeflation | None" = None) -> None:
        """`previous`: of a similar set, whose coarse inverse serves again if the patches are as many."""
        self.patches, self._green = patches, green
        dense = 0 if patches.full else LONGEST_DENSE if patches.count > _FEW_PATCHES else LONGEST_DENSE // 4
        self._long = {p: LongPatch(green, int(patches.size[p])) for p in _indices(patches.size > dense)}
        self._blocks = list(self._dense_blocks())
        self._build, self._borders, self._factor = 0, np.zeros(0), np.ones((1, 1))
        if patches.full:
            return
        self._punch = self._local(np.ones(patches.nodes.size))
        for p, long in self._long.items():
            if patches.count > 1:  # the only patch keeps its load anyway
                self._punch[self._part(p)] = long.flat_punch()
        loads = patches.sums(self._punch)
        if previous and patches.count == previous._build:
            self._build, self._borders, self._factor = previous._build, previous._borders, previous._factor
        elif patches.count > 1:
            self._couple(loads)
        unknown = np.searchsorted(self._borders, patches.first, side="right")
        self._unknown = unknown[patches.label]
        self._loads = np.bincount(unknown, weights=loads, minlength=len(self._factor))
        self._constant = self._factor.T @ (self._factor @ self._loads)

    def _couple(self, loads: Array64) -> None:
        """The coarse inverse, and the borders between its unknowns in the gaps between patches."""
        patches = self.patches
        share = -(-patches.count // _unknowns(patches.num_points))
        starts = np.arange(0, patches.count, share)
        # each row the patches of one unknown; the last row is filled up with patches without load
        member = starts[:, None] + np.arange(share)
        there = member < patches.count
        member = np.minimum(member, patches.count - 1)
        load = np.where(there, loads[member], 0.0)
        # between unknowns: as if the load were spread from the first to the last of the patches
        first, last, total = patches.first[starts], patches.last[member[:, -1]], load.sum(axis=1)
        density = total / (last - first + 1)
        coarse = self._green.patch_sums(first, last) * np.outer(density, density)
        if share <= _EXACT_SHARE:
            shape = load / patches.size[member]
            within = self._green.patch_sums(patches.first[member], patches.last[member])
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

    def _part(self, patch: int) -> slice:
        start = self.patches.offset[patch]
        return slice(start, start + self.patches.size[patch])

    def _dense_blocks(self) -> Iterator[tuple[Array64, Indices, NDArray[np.bool_]]]:
        """(factor, compact indices, mask) of the patches of similar size, both of shape (patches, width)."""
        size, offset = self.patches.size, self.patches.offset
        widths = np.where(
            np.isin(np.arange(size.size), list(self._long)),
            0,
            np.maximum(8, 2 ** np.ceil(np.log2(size)).astype(np.int64)),
        )
        for width in np.unique(widths[widths > 0]):
            chosen = np.flatnonzero(widths == width)
            width = int(size[chosen].max())
            mask = np.arange(width) < size[chosen, None]
            # outside of a patch: the slot behind the last contact node
            index = np.where(mask, offset[chosen, None] + np.arange(width), self.patches.nodes.size)
            yield self._green.factor(width)[:width, :width], index, mask

    def _local(self, residual: Array64) -> Array64:
        """Patch by patch G_bb^-1 residual, in compact order."""
        padded = np.append(residual, 0.0)
        z = np.zeros_like(padded)
        for factor, index, mask in self._blocks:
            z[index] = ((padded[index] @ factor.T) * mask) @ factor * mask
        for p, long in self._long.items():
            z[self._part(p)] = long.solve(residual[self._part(p)])
        return z[:-1]

    def _sums(self, values: Array64) -> Array64:
        """Sums over the patches of each unknown."""
        return np.bincount(self._unknown, values, len(self._factor)).astype(np.float64)

    def apply(self, residual: Array64) -> Array64:
        """Preconditioned residual (a pressure), both shape (contact nodes,) in compact order; its sum is 0."""
        if self.patches.full:
            return self._local(residual)
        loads = np.maximum(self._loads, 1e-300)  # 0 where an unknown has lost its patches
        moments = self._sums(self._punch * residual)
        z = self._local(residual - (moments / loads)[self._unknown])
        coarse = self._factor.T @ (self._factor @ moments)
        coarse -= self._constant * (self._loads @ coarse) / (self._loads @ self._constant)
        coarse -= self._sums(z) / loads
        return np.asarray(z + coarse[self._unknown] * self._punch)


def _indices(chosen: NDArray[np.bool_]) -> list[int]:
    return [int(p) for p in np.flatnonzero(chosen)]


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
