"""The active set on an even scene: fields and transforms of half the length.

Even here means h_i = h_(N-1-i): the axes lie between nodes, as in a scan joined to its mirror image. The half y_j, j =
0 ... n-1, n = N/2, has a cosine transform (DCT-II)

    Y_k = sum_j 2 y_j cos(pi k (2j+1)/N),

which an operator with the even symbol g_k multiplies. FFTW's own cosine transforms take as long as the real transform
of all N values, so Y is never made: packed as v = (y_0, y_2, y_4, ..., y_5, y_3, y_1) the half has a real transform V_k
with Y_k - i Y_(n-k) = 2 exp(-i theta) V_k, theta = pi k/N (J. Makhoul, IEEE Trans. ASSP 28, 27 (1980)), and

    V_k <- a V_k + b exp(2 i theta) conj(V_k),   a, b = (g_k +- g_(n-k))/2.

The fields stay packed; contact nodes, patches and their preconditioner are those of the whole.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import Call, record
from .active_set import ActiveSet
from .patches import Indices
from .problem import Problem
from .transforms import Transforms

Array = NDArray[Any]
Array64 = NDArray[np.float64]


def is_even(height: Array64, reach: float = np.inf) -> bool:
    """Whether h_i = h_(N-1-i) but for rounding, N a multiple of 4; shape (N,). reach: heights beyond do not matter."""
    if height.size % 4:
        return False
    half = height.size // 2
    return bool(np.abs(height[:half] - height[: half - 1 : -1]).max() <= 1e-12 * min(np.ptp(height), reach))


class EvenActiveSet(ActiveSet):
    """`ActiveSet` with fields packed as above; the problem's height is even. transforms: of N/2 points."""

    pair_length = 0.5

    def __init__(self, problem: Problem, transforms: Transforms, tolerance: float, backend: str = "warp") -> None:
        half = np.arange(problem.num_points // 2)
        packed = np.where(half % 2 == 0, half // 2, half.size - 1 - half // 2)
        self._place = np.concatenate([packed, packed[::-1]])
        self._node = np.empty_like(half)
        self._node[packed] = half
        super().__init__(problem, transforms, tolerance, backend)

    def start_from_pressure(self, pressure: Array64) -> None:
        """As for `ActiveSet`, from the pressure's even part."""
        super().start_from_pressure((pressure + pressure[::-1]) / 2)

    def _take_set(self) -> None:
        self._contact |= self._contact[::-1]
        super()._take_set()
        order = np.empty(self._num_points, dtype=np.int64)
        order[self._nodes] = np.arange(self._nodes.size)
        self._mirrored = order[self._num_points - 1 - self._nodes]

    def _places(self, nodes: Indices) -> Indices:
        return self._place[nodes]

    def _nodes_at(self, places: Indices) -> Indices:
        left = self._node[places]
        return np.concatenate([left, self._num_points - 1 - left])

    def _put(self, field: Array, values: Array64) -> None:
        field[self._place] = values

    def _get(self, field: Array) -> Array:
        return np.asarray(field[self._place])

    def _precondition(self, residual: Array64) -> Array64:
        z = super()._precondition(residual)
        return np.asarray(z + z[self._mirrored]) / 2  # rounding would part the halves

    def _operator(self, transforms: Transforms, source: Array, target: Array) -> tuple[Callable[[], None], ...]:
        n = self._num_points // 2
        forward, inverse = transforms.forward(source), transforms.inverse(target)
        symbol = self._green.compliance / n
        k = np.arange(n // 2 + 1)
        straight, crossed = (transforms.buffer(n + 2) for _ in range(2))
        mean, difference = (symbol[k] + symbol[n - k]) / 2, (symbol[k] - symbol[n - k]) / 2
        turn = difference * np.exp(2j * np.pi * k / self._num_points)
        straight[: n + 2] = np.stack([mean + turn.real, mean - turn.real], axis=1).ravel()
        crossed[: n + 2] = np.repeat(turn.imag, 2)
        multiply = record(self.backend, [Call("mirror_multiply", (straight, crossed), (transforms.spectrum,))])
        return forward, multiply, inverse
