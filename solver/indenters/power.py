"""One asperity, a power of the distance: the published study's sharp, Hertzian and blunt indenters."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .. import checks
from ..arrays import Array64
from ..calibration import FITTED
from ..reference.gradient_equation import STEEPEST
from .indenter import Indenter


@dataclass(frozen=True)
class PowerIndenter(Indenter):
    """Power profile h = (R/n) |x/R|^n, centred in the period.

    Raises `ValueError`.
    """

    exponent: float = 2.0
    """n > 1: 1.5 sharp, 2 Hertz, 4 blunt (dimensionless)."""
    radius: float = 1.0
    """R > 0 [length]; for n = 2 the radius of curvature."""

    name: ClassVar[str] = "power"
    knows_lowest: ClassVar[bool] = True  # a node stands there

    def __post_init__(self) -> None:
        checks.assign(
            self,
            exponent=checks.real("exponent", self.exponent, "1 < n <= 100", 1, 100),
            radius=checks.real("radius", self.radius, "a finite length > 0", 0),
        )

    def profile(self, num_points: int, period: float) -> Array64:
        distance = self._distance(num_points)
        return np.asarray(distance / self.exponent * self._steepness(distance, period))

    def slope(self, num_points: int, period: float) -> Array64:
        """Slopes, see `Indenter`; 0 at the lowest point."""
        slope = self._steepness(self._distance(num_points), period)
        np.negative(slope[: num_points // 2], out=slope[: num_points // 2])
        return slope

    def squared_slope_between(self, left: Array64, right: Array64, num_points: int, period: float) -> Array64:
        """See `Indenter`: x h'^2/(2n - 1), from the tip on."""
        ends = np.stack([left, right]) - num_points // 2
        periods = np.round(ends / num_points)

        def from_tip(at: Array64) -> Array64:
            return at * self._steepness(np.abs(at) / num_points, period) ** 2 / (2 * self.exponent - 1)

        whole = 2 * from_tip(np.array([num_points / 2]))
        return np.asarray(np.diff(from_tip(ends - periods * num_points) + periods * whole, axis=0)[0])

    def shortest_wave(self, num_points: int) -> int:
        """0: the profile is smooth, see `Indenter`."""
        return 0

    def ratios(self, period: float) -> dict[str, float]:
        return {"radius/period": self.radius / period}

    @property
    def power_law(self) -> tuple[float, float] | None:
        return self.exponent, self.radius

    def end_error(self, width: float) -> float:
        """See `Indenter`. The sum over nodes of |x|^n is off at its tip by a power n + 1 of the spacing, which moves an
        end by C (2/width)^n spacings, by half a spacing at most. For n > 2 it is one over the fifth power of the nodes
        in which the slope at the ends becomes e times as large, and a spacing at most.
        """
        n = self.exponent
        if n < 2:
            return min(float(FITTED.of_tip * (2 - n) ** 2 * (2 / width) ** n), 0.5)
        return min((2 * (n - 1) / width) ** 5, 1.0) if n > 2 else 0.0

    def _steepness(self, distance: Array64, period: float) -> Array64:
        """|h'| = (x/R)^(n-1) at x/L; steeper than `STEEPEST` makes no difference, but overflows."""
        with np.errstate(over="ignore", under="ignore"):
            slope = distance * (period / self.radius)
            slope **= self.exponent - 1
        return np.minimum(slope, STEEPEST, out=slope)

    @staticmethod
    def _distance(num_points: int) -> Array64:
        """Distance from the lowest point [L], shape (num_points,)."""
        return np.asarray(np.abs(np.arange(num_points) - num_points // 2) / num_points)
