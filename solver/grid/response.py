"""The layer's response in real space, G = 1/K without the mean mode: the displacement around one loaded node."""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ..arrays import Array64
from ..transforms.plain import irfft
from .kept import MOST_POINTS
from .split import Split, inverse, make_split

_HEAD = 1024  # values next to the node, which stay when the second sum takes the place of all


class LayerResponse:
    """G of one grid. Arrays in real space are kept, and read-only; on large grids one of N values at a time."""

    def __init__(self, stiffness: Array64, num_points: int) -> None:
        """stiffness: K(q_k), shape (N//2 + 1,) [K]; num_points: N."""
        self.stiffness, self.num_points = stiffness, num_points
        self._large = num_points > MOST_POINTS
        self._kept: dict[str, Array64] = {}

    def _known(self, name: str, make: Callable[[], Array64]) -> Array64:
        """What is kept by that name; made, and kept, if it is not."""
        found = self._kept.get(name)
        if found is None:
            found = self._kept[name] = make()
            found.flags.writeable = False
        return found

    @property
    def compliance(self) -> Array64:
        """G(q_k) = 1/K(q_k), 0 for the mean mode; shape (N//2 + 1,)."""

        def make() -> Array64:
            return inverse(self.stiffness)

        return make() if self._large else self._known("compliance", make)

    @cached_property
    def split(self) -> Split | None:
        """Its two parts, see `make_split`."""
        return make_split(self.stiffness, self.num_points)

    @property
    def whole(self) -> Array64:
        """G in real space, shape (N,) [1/K]."""

        def make() -> Array64:
            if self._large:
                self._kept.pop("second sum", None)
            return irfft(self.compliance, self.num_points)

        return self._known("whole", make)

    def head(self, count: int) -> Array64:
        """G on the nodes 0 to count - 1 [1/K]. Where it has two parts it is made of them, with their error, and on
        N//2 + 1 nodes at most.
        """
        if self.split:
            return self.split.response(count)
        held = self._kept.get("head", np.zeros(0))
        return (held if count <= held.size else self.whole)[:count]

    @property
    def second_sum(self) -> Array64:
        """T with T(k+1) - 2 T(k) + T(k-1) = G(k), shape (N,), with the error of the two parts where there are any."""
        return self._known("second sum", self._sum_twice)

    def _sum_twice(self) -> Array64:
        if self.split:
            if self._large:
                self._kept.pop("whole", None)
            return self.split.second_sum()
        whole = self.whole
        if self._large:
            self._known("head", whole[:_HEAD].copy)
            self._kept.pop("whole", None)
        first = np.cumsum(whole)
        del whole
        first -= first.mean()  # so that the second sum is periodic, too
        first[1:] = np.cumsum(first[:-1])
        first[0] = 0
        return first

    def rest(self) -> None:
        """Give back what holds a value for each node of a large grid."""
        if self._large:
            self._kept.clear()
