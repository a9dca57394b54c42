"""What follows from the layer's response on one grid: inverse factors, sums over patches, and short convolutions.

G is a Toeplitz matrix, so all patches of a contact share one inverse Cholesky factor, and sums of G over two patches
are differences of its second running sum. Convolutions over a few nodes go by short transforms.
"""

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from ...arrays import Array64, Indices
from ...grid.response import LayerResponse
from ...transforms.pair import Pair
from ...transforms.plain import hfft, irfft


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


_LITTLE_LONGER = 1.125  # least length of a ring for K, over that of the run
_SAMPLE, _STIFF = 200, 2.0  # modes that tell, and times the least K, up to which the longest wave is not stiff
_SHORT = 16  # times shorter than the grid are rings whose symbols are kept for the next solve


class Tables:
    """What follows from G and K of one grid, the same for every solve there."""

    def __init__(self, response: LayerResponse) -> None:
        """response: G of the grid."""
        self.response, self.num_points = response, response.num_points
        self._factor = self._stiffness_factor = np.zeros((0, 0))
        self._rings: dict[tuple[str, int], Array64] = {}

    @cached_property
    def stiffness_decays(self) -> bool:
        """Whether K in real space is short-ranged; not where its longest waves are the stiffest."""
        stiffness = self.response.stiffness
        some = np.geomspace(1, stiffness.size - 1, _SAMPLE).astype(np.int64)
        return bool(stiffness[1] <= _STIFF * stiffness[some].min())

    def factor(self, order: int) -> Array64:
        """`inverse_cholesky` of G [1/K], shape (m, m) with m >= order; kept for the next call."""
        factor = self._factor  # another thread may put a smaller one there meanwhile
        if factor.shape[0] < order:
            order = min(64 * -(-order // 64), self.num_points - 1)
            self._factor = factor = inverse_cholesky(self.response.head(order), order)
        return factor

    def stiffness_factor(self, order: int) -> Array64:
        """`inverse_cholesky` of K in real space [1/K^(1/2)]; kept for the next call."""
        factor = self._stiffness_factor
        if factor.shape[0] < order:
            column = irfft(self.response.stiffness, self.num_points)
            self._stiffness_factor = factor = inverse_cholesky(column, min(64 * -(-order // 64), self.num_points - 1))
        return factor

    def rigidity_on(self, length: int) -> Array64:
        """K on a ring of that many nodes, shape (length//2 + 1,): at the ring's wave numbers, since its tails decay."""
        stiffness = self.response.stiffness
        if length == self.num_points:
            return stiffness

        def make() -> Array64:
            at = np.arange(length // 2 + 1) * (self.num_points / length)
            below = np.minimum(at.astype(np.int64), stiffness.size - 2)
            rise = stiffness[below + 1] - stiffness[below]
            return np.asarray(stiffness[below] + (at - below) * rise)

        return self._of_ring("rigidity", length, make)

    def compliance_on(self, length: int) -> Array64:
        """G on a ring of that many nodes, of the same shape: as it is in real space up to half of the ring."""
        if length == self.num_points:
            return self.response.compliance
        count = length // 2 + 1
        return self._of_ring("compliance", length, lambda: hfft(self.response.head(count), length)[:count])

    def _of_ring(self, name: str, length: int, make: Callable[[], Array64]) -> Array64:
        """Kept for the next solve where it is short."""
        found = self._rings.get((name, length))
        if found is None:
            found = make()
            if length <= self.num_points // _SHORT:
                self._rings[name, length] = found
        return found


class GreensFunction:
    """Real-space G and K of one grid of N points, with the short transforms of one solve."""

    def __init__(self, tables: Tables) -> None:
        self.tables, self.num_points = tables, tables.num_points
        self._convolutions: dict[int, Convolution] = {}

    def solve(self, nodes: Indices, height: Array64, load: float = 1.0) -> Array64 | None:
        """The pressure on some nodes, not all, whose gap h + G sigma is one constant, shape (M,) [p]; None where
        rounding or too little memory makes that impossible.

        nodes: shape (M,); height: h there [u]; load: the pressure's mean over N [p].
        """
        try:
            matrix = np.take(self.tables.response.whole, nodes[:, None] - nodes, mode="wrap")
            punch, shape = np.linalg.solve(matrix, np.stack([np.ones(nodes.size), height], axis=1)).T
        except (np.linalg.LinAlgError, MemoryError):
            return None
        with np.errstate(all="ignore"):
            pressure = (load * self.num_points + shape.sum()) / punch.sum() * punch - shape
        return pressure if np.isfinite(pressure).all() else None

    @property
    def transformed(self) -> int:
        """Points gone through short transforms so far."""
        return sum(c.count * c.length for c in self._convolutions.values())

    def convolution(self, length: int) -> "Convolution":
        """K and G on a ring of that many nodes; for N, those of the grid."""
        if length not in self._convolutions:
            self._convolutions[length] = Convolution(self.tables, length)
        return self._convolutions[length]

    def around(self, size: int) -> "Convolution":
        """The convolution for a run of so many nodes, on a ring of at least twice as many, which keeps its ends apart,
        or of all; runs of similar size share one.
        """
        step = _step(size)
        return self.convolution(min(2 * step * -(-size // step), self.num_points))

    def along(self, size: int) -> "Convolution":
        """The convolution with K for a run of so many nodes: on a ring that is an eighth to three eighths longer, where
        little of K reaches around it.
        """
        if not self.tables.stiffness_decays:
            return self.around(size)
        step = _step(size)
        return self.convolution(min(step * math.ceil(_LITTLE_LONGER * size / step), self.num_points))


def _step(size: int) -> int:
    """Of the lengths of rings for runs of so many nodes, four to eight times as many."""
    return 1 << (size.bit_length() - 3)


def patch_sums(second_sum: Array64, first: Indices, last: Indices) -> Array64:
    """Z'GZ for Z = 1 on each of M runs of nodes: the sums of G(a - b) over a in one run and b in another.

    second_sum: of G, see `LayerResponse`; first, last: end nodes, shape (..., M). Returns shape (..., M, M).
    """
    start, stop = first, last + 1

    def differences(a: Indices, b: Indices) -> Array64:
        return np.take(second_sum, a[..., :, None] - b[..., None, :], mode="wrap")

    across = differences(stop, start)
    return np.asarray(across + np.swapaxes(across, -1, -2) - differences(start, start) - differences(stop, stop))


class Convolution:
    """Short transforms of one length, for values on a patch that is no longer."""

    def __init__(self, tables: Tables, length: int) -> None:
        self._tables, self.length = tables, length
        self._pair = Pair(length)
        self.count = 0

    @cached_property
    def rigidity(self) -> Array64:
        """K, shape (length//2 + 1,)."""
        return self._tables.rigidity_on(self.length)

    @cached_property
    def compliance(self) -> Array64:
        """G, of the same shape."""
        return self._tables.compliance_on(self.length)

    @cached_property
    def inverse_rigidity(self) -> Array64:
        """1/K; modes softer than half of the longest wave, the mean one above all, count as that stiff."""
        least = self.rigidity[1] / 2
        return np.asarray(1 / np.maximum(self.rigidity, least))

    def __call__(self, symbol: Array64, values: Array64) -> Array64:
        """Circular convolution of zero-padded values with a symbol, shape (length//2 + 1,), at the values' nodes."""
        pair = self._pair
        pair.real[: values.size] = values
        pair.real[values.size :] = 0
        pair.forward()
        pair.modes *= symbol
        pair.inverse()
        self.count += 1
        return np.asarray(pair.real[: values.size] / self.length)
