"""The layer's response in two parts, G = near + far; docs/architecture.md says for which use.

`near` is short-ranged. `far` is smooth, and known by its values on a grid of one point for each block of nodes: between
them stands a cardinal B-spline. Two splits, with theta = q s for the width s of the split:

    near(q) = c (2/q) erf(theta)          where G(q) = 2c/q as far as `far` reaches, like on a half-space
    near(q) = G(q) (1 - exp(-theta^2))    where G is regular at q = 0, like on thin layers

What is left out is known: `far` beyond what the spline carries, and `near` beyond its range (`Split.error`).
"""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..arrays import Array64
from ..transforms.plain import irfft

_NEGLECTED = 1e-5
"""Of either part, over the largest value of `near` (dimensionless)."""

_WIDTH = 6
"""Of the spline [blocks], its order: with far waves no shorter than four blocks it errs by 1e-7 to 5e-7 of `near`."""

_RING = 2**13  # nodes, at least, of the ring on which the near part is made, unless the grid is smaller
_FEWEST = 2**16  # points of the smallest grid on which that pays
_BLOCK = 32  # nodes, at most; a quarter of that at least
_LARGEST_ERROR = 0.2
"""Error of the split over the smallest G(q): beyond, on thin and nearly incompressible layers, the packed operator is
not positive, and conjugate gradients find no way down. Of two splits below, that of shorter range is taken."""


class Split:
    """The two parts of G on one grid. stiffness: K(q_k), shape (N//2 + 1,); block: nodes of a block, a divisor of N.

    range: nodes beyond which `near` is neglected; largest: value of `near`'s symbol [1/K]; error: what is neglected,
    over that.
    """

    def __init__(self, stiffness: Array64, num_points: int, block: int) -> None:
        self.num_points, self.block, self.num_blocks = num_points, block, num_points // block
        shortest = math.pi / (2 * block)  # wave number of the shortest far wave, q in units of 1/spacing
        # the shortest that goes into N and has enough nodes
        ring = num_points // next(d for d in range(max(1, num_points // _RING), 0, -1) if num_points % d == 0)
        q = 2 * np.pi * np.arange(ring // 2 + 1) / ring
        symbol = inverse(stiffness[:: num_points // ring])
        count = num_points // (4 * block) + 1
        far_q, far_symbol = 2 * np.pi * np.arange(count) / num_points, inverse(stiffness[:count])
        found = []
        for split in (_of_half_space, _of_layer):
            near = split(q, symbol, shortest)
            left = np.abs(symbol - near)[q > shortest]
            values = irfft(near, ring)[: ring // 2 + 1]
            # pairs: the end of the spectrum leaves a tail of changing sign, which no smooth pressure feels
            pairs, largest = np.append(values[:-1] + values[1:], 0.0), float(near.max())
            beyond = np.cumsum(np.abs(pairs[::-1]))[::-1] / largest
            reach = int(np.searchsorted(-beyond, -_NEGLECTED))
            error = float(left.max(initial=0.0) + 2 * np.abs(values[reach + 1 :]).sum()) / largest
            far = far_symbol - split(far_q, far_symbol, shortest)
            over_smallest = error * largest * float(stiffness.max())
            found.append((max(over_smallest, _LARGEST_ERROR), reach, error, largest, values, far))
        worst, self.range, self.error, self.largest, values, far = min(found, key=lambda one: one[:2])
        self.usable = worst <= _LARGEST_ERROR
        """Whether the packed operator is positive."""
        self.near = values[: self.range + 1]
        """Of `near` in real space, for the distances from 0 to the range."""
        self._far, self._spline = far, np.sinc(np.arange(count) / self.num_blocks) ** _WIDTH
        self.far = np.zeros(self.num_blocks // 2 + 1)
        """Symbol of `far` between spreading and gathering, for one transform there and back."""
        self.far[:count] = far / self._spline**2 / num_points
        self.columns = np.arange(1 - _WIDTH // 2, 1 + _WIDTH // 2)
        """Blocks that a block spreads to, as steps."""
        self.weights = _splines(np.arange(block) / block)
        """Share of each of them by the node in the block, shape (block, columns)."""

    def response(self, count: int) -> Array64:
        """G in real space, as the two parts have it, on the nodes 0 to count - 1, at most N//2 + 1 [1/K]."""
        found = self._smooth(self._far, count)
        found[: self.near.size] += self.near[:count]
        return found

    def second_sum(self) -> Array64:
        """T with T(k+1) - 2 T(k) + T(k-1) = G(k), as the two parts have it, shape (N,).

        The load of `near` goes into the smooth part as a Gaussian; what is left of `near` has a short second sum.
        """
        width, load = _width(math.pi / (2 * self.block)), 2 * self.near.sum() - self.near[0]
        q = 2 * np.pi * np.arange(self._far.size) / self.num_points
        smooth = self._far + load * np.exp(-((q * width) ** 2))
        smooth[1:] /= -4 * np.sin(q[1:] / 2) ** 2
        smooth[0] = 0
        found = self._smooth(smooth, self.num_points)
        reach = min(max(int(8 * width), self.near.size), self.num_points // 2)
        rest = load / (-2 * math.sqrt(math.pi) * width) * np.exp(-((np.arange(reach) / (2 * width)) ** 2))
        rest[: self.near.size] += self.near
        rest = np.cumsum(np.cumsum(rest[:0:-1]))[::-1]  # over j > k the sum of (j - k) rest(j)
        found[: rest.size] += rest
        found[1 - rest.size :] += rest[:0:-1]
        return found

    def _smooth(self, symbol: Array64, count: int) -> Array64:
        """A smooth function with a symbol, on the nodes 0 to count - 1."""
        shares = irfft(symbol / self._spline / self.block, self.num_blocks)
        at = np.arange(self.columns[0], -(-count // self.block) + self.columns[-1])
        shares = np.take(shares, at, mode="wrap")
        return (sliding_window_view(shares, _WIDTH) @ self.weights.T).ravel()[:count]


def _width(shortest: float) -> float:
    """Of a Gaussian exp(-(q s)^2) that is negligible beyond a wave number."""
    return math.sqrt(-math.log(_NEGLECTED)) / shortest


def _of_half_space(q: Array64, symbol: Array64, shortest: float) -> Array64:
    width = 0.95 * _width(shortest)
    near = np.full_like(q, 2 * width / math.sqrt(math.pi))
    near[1:] = np.vectorize(math.erf)(q[1:] * width) / q[1:]
    return np.asarray(symbol[-1] * q[-1] * near)


def _of_layer(q: Array64, symbol: Array64, shortest: float) -> Array64:
    width = _width(shortest)
    return np.asarray(symbol * -np.expm1(-((q * width) ** 2)))


def _splines(x: Array64) -> Array64:
    """The cardinal B-splines that stand on the columns at x [blocks], 0 <= x < 1; shape (x.size, columns).

    By the recursion over their order n: sums of positive terms, which keep rounding small.
    """
    found = np.ones((x.size, 1))
    for n in range(2, _WIDTH + 1):
        before = np.pad(found, ((0, 0), (1, 1)))
        above = np.arange(1, n + 1) - x[:, None]
        found = ((n - above) * before[:, :-1] + above * before[:, 1:]) / (n - 1)
    return found


def inverse(stiffness: Array64) -> Array64:
    """G = 1/K, 0 for the mean mode, which is the first one; of the same shape."""
    return np.append(0.0, 1 / stiffness[1:])


def make_split(stiffness: Array64, num_points: int) -> Split | None:
    """The split of G for a grid; None where the grid is too small, no block suits it, or the split errs too much."""
    block = next((b for b in range(_BLOCK, _BLOCK // 4 - 1, -1) if num_points % b == 0), None)
    if block is None or num_points < _FEWEST:
        return None
    split = Split(stiffness, num_points, block)
    return split if split.usable else None
