"""Where the values of the nodes stand in a field: all of them in order, or half of them on an even scene.

Even here means h_i = h_(N-1-i): the axes of symmetry lie between nodes, as in a scan joined to its mirror image. The
half y_j, j = 0 ... n-1, n = N/2, has a cosine transform (DCT-II)

    Y_k = sum_j 2 y_j cos(pi k (2j+1)/N),

which an operator with the even symbol g_k multiplies. FFTW's own cosine transforms take as long as the real transform
of all N values, so Y is never made: packed as v = (y_0, y_2, y_4, ..., y_5, y_3, y_1) the half has a real transform V_k
with Y_k - i Y_(n-k) = 2 exp(-i theta) V_k, theta = pi k/N (J. Makhoul, IEEE Trans. ASSP 28, 27 (1980)), and

    V_k <- a V_k + b exp(2 i theta) conj(V_k),   a, b = (g_k +- g_(n-k))/2.

The fields stay packed; contact nodes, patches and their preconditioner are those of the whole.
"""

from collections.abc import Callable

import numpy as np

from ...arrays import Array, Array64, Indices
from ...grid.problem import Problem
from ...transforms.planned import Transforms

_EVEN_FROM = 2**13
"""Points; on smaller grids the reordering takes as long as half a transform."""
_FAR = 1e30  # height of the padding, which never touches
_FIRST_LOOK = 1024  # nodes that tell of most scenes that they are not even


class Whole:
    """Every node in its order; what the active set needs to know of its fields."""

    def __init__(self, num_points: int) -> None:
        self.num_points = self.length = num_points
        """N, and the number of values in a field, which is the length of its transforms."""

    def places(self, nodes: Indices) -> Indices:
        """Where these nodes have their values, of the same shape."""
        return nodes

    def nodes_at(self, places: Indices) -> Indices:
        """All nodes that have their values at these places, shape (number of nodes,)."""
        return places

    def heights(self, height: Array64, field: Array) -> Array:
        """Heights of all nodes, shape (N,), in the order and of the length and type of a field; its padding never
        touches. The same array where that is possible.
        """
        if field.shape == height.shape and field.dtype == height.dtype:
            return height
        found = np.full_like(field, _FAR)
        found[: self.num_points] = height
        return found

    def get(self, field: Array) -> Array:
        """The values of all nodes, shape (N,)."""
        return field[: self.num_points]

    def symmetric(self, values: Array64) -> Array64:
        """Values of all nodes, shape (N,), with the symmetry that the storage relies on."""
        return values

    def with_images(self, nodes: Indices) -> Indices:
        """Nodes in ascending order, together with their mirror images where the storage relies on symmetry."""
        return nodes

    def mirrored(self, nodes: Indices) -> Indices | None:
        """For each contact node the index in `nodes` of its mirror image, of their shape; None without symmetry."""
        return None

    def multiplication(self, symbol: Array64, transforms: Transforms, target: Array) -> Callable[[], None]:
        """A function without arguments that multiplies by a symbol, shape (N//2 + 1,), and normalises, between the
        transforms of a field to this target.
        """
        return transforms.multiplication(symbol, target)


class Half(Whole):
    """The left half of an even scene, packed as the module's head has it."""

    def __init__(self, num_points: int) -> None:
        super().__init__(num_points)
        self.length = num_points // 2

    def places(self, nodes: Indices) -> Indices:
        left = np.minimum(nodes, self.num_points - 1 - nodes)
        return np.where(left & 1, self.length - 1 - (left >> 1), left >> 1)

    def nodes_at(self, places: Indices) -> Indices:
        left = np.minimum(2 * places, 2 * (self.length - places) - 1)
        return np.concatenate([left, self.num_points - 1 - left])

    def heights(self, height: Array64, field: Array) -> Array:
        found = np.full_like(field, _FAR)
        self._even(found)[:], self._odd(found)[:] = height[: self.length : 2], height[1 : self.length : 2]
        return found

    def get(self, field: Array) -> Array:
        found = np.empty(self.num_points, field.dtype)
        left = found[: self.length]
        left[::2], left[1::2] = self._even(field), self._odd(field)
        found[self.length :] = left[::-1]
        return found

    def _even(self, field: Array) -> Array:
        """The values y_0, y_2, ... of the left half in a field."""
        return field[: self.length - self.length // 2]

    def _odd(self, field: Array) -> Array:
        """The values y_1, y_3, ..."""
        return field[self.length - self.length // 2 : self.length][::-1]

    def symmetric(self, values: Array64) -> Array64:
        return np.asarray((values + values[::-1]) / 2)

    def with_images(self, nodes: Indices) -> Indices:
        return np.union1d(nodes, self.num_points - 1 - nodes)

    def mirrored(self, nodes: Indices) -> Indices | None:
        order = np.argsort(nodes, kind="stable")
        return order[np.searchsorted(nodes, self.num_points - 1 - nodes, sorter=order)]

    def multiplication(self, symbol: Array64, transforms: Transforms, target: Array) -> Callable[[], None]:
        n = self.length
        k = np.arange(n // 2 + 1)
        mean, difference = (symbol[k] + symbol[n - k]) / 2, (symbol[k] - symbol[n - k]) / 2
        turned = difference * np.exp(2j * np.pi * k / self.num_points)
        return transforms.multiplication(mean, target, turned)


def is_even(height: Array64, most: float = 0.0, reach: float = np.inf) -> bool:
    """Whether h_i = h_(N-1-i) for all heights h, shape (N,) [u], but for a difference of `most` [u]; N a multiple of 4.

    reach: heights beyond it never touch and do not matter [u].
    """
    if height.size % 4:
        return False
    half = height.size // 2
    for count in (min(_FIRST_LOOK, half), half):
        left, right = (np.minimum(side[:count], reach) for side in (height, height[::-1]))
        if not np.abs(left - right).max() <= most:
            return False
    return True


def choose(problem: Problem, tolerance: float) -> Whole:
    """Half of the nodes where the scene is even and large enough for that to pay.

    The certificate is for the scene as it is. A difference of heights acts as a force of at most twice its size, since
    K <= 2 in the problem's units, and must be small beside the tolerance.
    """
    even = problem.num_points >= _EVEN_FROM and is_even(problem.height, 0.1 * tolerance, problem.reach)
    if not even:
        return Whole(problem.num_points)
    made = problem.rigidity.made
    if "half" not in made:
        made["half"] = Half(problem.num_points)
    half: Half = made["half"]
    return half
