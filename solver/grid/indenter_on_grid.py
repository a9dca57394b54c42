"""An indenter on one grid: its heights, its slopes, its lowest point."""

from functools import cached_property

import numpy as np

from .. import checks
from ..arrays import Array64
from ..indenters import Indenter
from .cached import MOST_POINTS, cached, read_only


class IndenterOnGrid:
    """An indenter on a grid of `num_points` in the period L [length]; heights and slopes are made when asked for."""

    def __init__(self, indenter: Indenter, num_points: int, period: float) -> None:
        self.of, self.num_points, self._period = indenter, num_points, period
        """`of`: the indenter on any grid."""
        self.shortest_wave = indenter.shortest_wave(num_points)
        """How many of the shortest wave fit into the period, 0 for a smooth profile without one."""
        self.exponent = indenter.power_law[0] if indenter.power_law else None
        """n of a power profile; None for any other shape."""

    @cached_property
    def profile(self) -> Array64:
        """Heights above the lowest point, shape (N,) [L], read-only. Raises `ValueError` for wrong heights."""
        what = f"profile of indenter {self.of.name}"
        allowed = f"allowed: {self.num_points} finite floating-point heights, the lowest 0, in units of the period"
        with checks.own_code(what, allowed, self.of):
            heights = np.asarray(self.of.profile(self.num_points, self._period))
        if heights.shape != (self.num_points,) or heights.dtype.kind != "f":
            raise ValueError(f"{what} is of type {heights.dtype} and shape {heights.shape}; {allowed}")
        lowest, highest = float(heights.min()), float(heights.max())
        if not abs(lowest) <= 1e-9 * highest < np.inf:
            raise ValueError(f"{what} is from {lowest:.3g} to {highest:.3g}; {allowed}")
        return read_only(heights.astype(np.float64, copy=False))

    @cached_property
    def squared_slope(self) -> Array64:
        """h'^2, shape (N,), read-only (dimensionless)."""
        return read_only(self.of.slope(self.num_points, self._period) ** 2)

    @cached_property
    def squared_slope_doubt(self) -> Array64 | None:
        """The largest error of `squared_slope` at the nodes, of its shape, read-only; None where there is none."""
        doubt = self.of.squared_slope_doubt(self.num_points, self._period)
        return None if doubt is None else read_only(doubt)

    def rest(self) -> None:
        """Give back the slopes on a large grid; they are made anew when they are needed."""
        for name in ("squared_slope", "squared_slope_doubt") if self.num_points > MOST_POINTS else ():
            self.__dict__.pop(name, None)


@cached
def indenter_on_grid(indenter: Indenter, num_points: int, period: float) -> IndenterOnGrid:
    """An indenter on a grid of `num_points` in the period L [length]."""
    return IndenterOnGrid(indenter, num_points, period)
