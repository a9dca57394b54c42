"""The layer's response on one grid: K of its waves, and in real space G = 1/K without the mean mode, the displacement
around one loaded node.
"""

from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array64
from ..transforms.plain import irfft
from .cached import MOST_POINTS
from .split import Split, inverse, make_split

_STIFF = 2.0  # K of the longest wave over the least K, up to which K is short-ranged


class LayerResponse:
    """K and G of one grid; G is made from K when it is asked for."""

    def __init__(self, stiffness: Array64, num_points: int, unit: float = 1.0) -> None:
        """stiffness: K(q_k), shape (N//2 + 1,) [K]; 0 for the mean mode. num_points: N; unit: [K] over E*/L, a power of
        two for a layer, whose largest K is from 1 to below 2 (dimensionless).
        """
        self.stiffness, self.num_points, self.unit = stiffness, num_points, unit
        self.made: dict[Any, Any] = {}
        """What methods have made from K, by name, and use again."""

    @cached_property
    def compliance(self) -> Array64:
        """G(q_k) = 1/K(q_k), 0 for the mean mode; shape (N//2 + 1,) [1/K]."""
        return inverse(self.stiffness)

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

    @cached_property
    def whole(self) -> Array64:
        """G in real space, shape (N,) [1/K]."""
        return irfft(self.compliance, self.num_points)

    def head(self, count: int) -> Array64:
        """G on the nodes 0 to count - 1 [1/K]. Where it has two parts it is made of them, with their error, and on
        N//2 + 1 nodes at most.
        """
        return self.split.response(count) if self.split else self.whole[:count]

    @cached_property
    def second_sum(self) -> Array64:
        """T with T(k+1) - 2 T(k) + T(k-1) = G(k), shape (N,), with the error of the two parts where there are any."""
        if self.split:
            return self.split.second_sum()
        sums = irfft(self.compliance, self.num_points)
        np.cumsum(sums, out=sums)
        sums -= sums.mean()  # so that the second sum is periodic, too
        sums[1:] = np.cumsum(sums[:-1])
        sums[0] = 0
        return sums

    def rest(self) -> None:
        """Give back what holds a value for each node of a large grid."""
        for name in ("compliance", "whole", "second_sum") if self.num_points > MOST_POINTS else ():
            self.__dict__.pop(name, None)
