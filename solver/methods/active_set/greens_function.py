"""Parts of the layer's response on one grid for `preconditioner`: inverse factors, sums over patches, convolutions."""

import math
from functools import cached_property

import numpy as np

from ...arrays import Array64, Indices
from ...grid.layer_on_grid import LayerOnGrid
from ...transforms.plain import irfft, pair


def inverse_cholesky(column: Array64) -> Array64:
    """Lower triangular R with (R_m)' R_m = T_m^-1 for every leading block T_m of a Toeplitz matrix T.

    column: first column of the symmetric positive definite T. Levinson-Durbin recursion.
    """
    order = column.size
    factor = np.zeros((order, order))
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


SMALL = 256
"""Nodes up to which dense matrices take less time than transforms, in elimination and for single runs."""
HARD = 2048
"""Unknowns up to which a stiff coating's equations are solved by elimination: they are hard to iterate on."""


class GreensFunction:
    """Real-space G and K of one grid of N points, with its short transforms; for one solve at a time."""

    def __init__(self, layer: LayerOnGrid) -> None:
        self.layer, self.num_points = layer, layer.num_points
        self._factors: dict[bool, Array64] = {}
        self._convolutions: dict[int, Convolution] = {}

    def begin(self) -> None:
        """Serve another solve, with the rings that the last one took."""
        self._convolutions = {length: ring for length, ring in self._convolutions.items() if ring.count}
        for ring in self._convolutions.values():
            ring.count = 0

    def factor(self, order: int, of_stiffness: bool = False) -> Array64:
        """`inverse_cholesky` of G [K^(1/2)] or K [1/K^(1/2)], shape (m, m) with m >= order; kept for the next call."""
        known = self._factors.get(of_stiffness)
        if known is None or len(known) < order:
            order, whole = min(64 * -(-order // 64), self.num_points - 1), self.layer.stiffness
            column = irfft(whole, self.num_points)[:order] if of_stiffness else self.layer.head(order)
            known = self._factors[of_stiffness] = inverse_cholesky(column)
        return known

    def solve(self, nodes: Indices, height: Array64, load: float = 1.0) -> Array64 | None:
        """The pressure on some nodes, not all, whose gap h + G sigma is one constant, shape (M,) [p]; None where
        rounding or too little memory makes that impossible.

        nodes: shape (M,); height: h there [u]; load: the pressure's mean over N [p].
        """
        try:
            matrix = np.take(self.layer.whole, nodes[:, None] - nodes, mode="wrap")
            punch, shape = np.linalg.solve(matrix, np.stack([np.ones(nodes.size), height], axis=1)).T
        except (np.linalg.LinAlgError, MemoryError):
            return None
        with np.errstate(all="ignore"):
            pressure = (load * self.num_points + shape.sum()) / punch.sum() * punch - shape
        return pressure if np.isfinite(pressure).all() else None

    @property
    def transformed(self) -> int:
        """Points gone through short transforms in this solve."""
        return sum(c.count * c.length for c in self._convolutions.values())

    def convolution(self, length: int) -> "Convolution":
        """K and G on a ring of that many nodes; for N, those of the grid."""
        if length not in self._convolutions:
            self._convolutions[length] = Convolution(self.layer, length)
        return self._convolutions[length]

    def ring(self, size: int) -> "Convolution":
        """The convolution for a run of so many nodes, on a ring of at least twice as many, which keeps its ends apart,
        or of all; runs of similar size share one.
        """
        step = 2 << (size.bit_length() - 3)  # four to eight lengths to an octave
        return self.convolution(min(step * math.ceil(2 * size / step), self.num_points))


def patch_sums(second_sum: Array64, first: Indices, last: Indices) -> Array64:
    """Z'GZ for Z = 1 on each of M runs of nodes: the sums of G(a - b) over a in one run and b in another.

    second_sum: of G, see `LayerOnGrid`; first, last: end nodes, shape (..., M). Returns shape (..., M, M).
    """
    start, stop = first, last + 1

    def differences(a: Indices, b: Indices) -> Array64:
        return np.take(second_sum, a[..., :, None] - b[..., None, :], mode="wrap")

    across = differences(stop, start)
    return np.asarray(across + np.swapaxes(across, -1, -2) - differences(start, start) - differences(stop, stop))


class Convolution:
    """Short transforms of one length, for values on a patch that is no longer."""

    def __init__(self, layer: LayerOnGrid, length: int) -> None:
        self._layer, self.length = layer, length
        self.count = 0
        """Of the transforms there and back, in the present solve."""

    @cached_property
    def stiffness(self) -> Array64:
        """K at the ring's wave numbers, since its tails decay; shape (length//2 + 1,)."""
        stiffness, count = self._layer.stiffness, self.length // 2 + 1
        if count == stiffness.size:
            return stiffness
        at = np.linspace(0, stiffness.size - 1, count)
        below = np.minimum(at.astype(np.intp), stiffness.size - 2)
        return np.asarray(stiffness[below] + (at - below) * (stiffness[below + 1] - stiffness[below]))

    @cached_property
    def compliance(self) -> Array64:
        """G as it is in real space up to half of the ring, of the same shape."""
        if self.length == self._layer.num_points:
            return self._layer.compliance
        count = self.length // 2 + 1
        return irfft(self._layer.head(count) * self.length, self.length)[:count]

    @cached_property
    def inverse_stiffness(self) -> Array64:
        """1/K; modes softer than half of the longest wave, the mean one above all, count as that stiff."""
        least = self.stiffness[1] / 2
        return np.asarray(1 / np.maximum(self.stiffness, least))

    def __call__(self, symbol: Array64, values: Array64) -> Array64:
        """Circular convolution of zero-padded values with a symbol, shape (length//2 + 1,), at the values' nodes."""
        ring = pair(self.length)
        ring.real[: values.size] = values
        ring.real[values.size :] = 0
        ring.filter(symbol)
        self.count += 1
        return np.asarray(ring.real[: values.size] / self.length)
