"""The layer's response in real space, G = 1/K without the mean mode: the displacement around one loaded node."""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ..arrays import Array64
from ..transforms.plain import irfft
from .kept import MOST_POINTS
from .split import Split, inverse, make_split

_STIFF = 2.0  # K of the longest wave over the least K, up to which K is short-ranged


class LayerResponse:
    """G of one grid. Arrays in real space are kept, and read-only."""

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
        """G(q_k) = 1/K(q_k), 0 for the mean mode; shape (N//2 + 1,). Not kept on large grids."""
        return inverse(self.stiffness) if self._large else self._known("compliance", lambda: inverse(self.stiffness))

    @cached_property
    def split(self) -> Split | None:
        """Its two parts, see `make_split`."""
        return make_split(self.stiffness, self.num_points)

    @cached_property
    def stiffness_decays(self) -> bool:
        """Whether K in real space is short-ranged; not where its longest waves are the stiffest, as on thin
        incompressible layers.
        """
        return bool(self.stiffness[1] <= _STIFF * self.stiffness[1:].min())

    @property
    def whole(self) -> Array64:
        """G in real space, shape (N,) [1/K]."""
        return self._known("whole", lambda: irfft(self.compliance, self.num_points))

    def head(self, count: int) -> Array64:
        """G on the nodes 0 to count - 1 [1/K]. Where it has two parts it is made of them, with their error, and on
        N//2 + 1 nodes at most.
        """
        return self.split.response(count) if self.split else self.whole[:count]

    @property
    def second_sum(self) -> Array64:
        """T with T(k+1) - 2 T(k) + T(k-1) = G(k), shape (N,), with the error of the two parts where there are any."""

        def make() -> Array64:
            if self.split:
                return self.split.second_sum()
            sums = irfft(self.compliance, self.num_points)
            np.cumsum(sums, out=sums)
            sums -= sums.mean()  # so that the second sum is periodic, too
            sums[1:] = np.cumsum(sums[:-1])
            sums[0] = 0
            return sums

        return self._known("second sum", make)

    def rest(self) -> None:
        """Give back what holds a value for each node of a large grid."""
        if self._large:
            self._kept.clear()
