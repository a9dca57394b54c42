"""A profile that is given point by point, for instance a measured scan."""

import math
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Literal, Self

import numpy as np

from .. import checks, display
from ..arrays import Array64, Modes
from ..transforms.plain import irfft, rfft
from ..units import named
from .indenter import Indenter

_KINKS = 32  # nodes at most that kinks are looked for at; one in so many


@dataclass(frozen=True)
class MeasuredIndenter(Indenter):
    """Heights given point by point, one for each grid point of the scene, periodic as they stand.

    convention, which must be named: "heights" of a surface, whose peaks touch first, as a scan has them; or "gap", the
    distance h of the indenter from the layer at first touch, whose lowest points touch first. It is kept as the gap.
    Coarser grids take the Fourier modes that they hold. Slopes are differences, see `Indenter`. Raises `ValueError`.
    """

    heights: Array64
    """Heights, shape (N,) [length], in the user's unit; kept shifted so that the lowest is 0."""
    measured_points: int | None = None
    """Values in the period that were measured, where the heights were made from fewer or more; None: all heights."""
    description: dict[str, Any] = field(default_factory=dict, hash=False)
    """Their origin, flat and JSON-ready; it travels with every result."""
    given_period: float | None = None
    """The period that they belong to [length], and no other; None: any."""
    convention: InitVar[Literal["heights", "gap"]] = field(kw_only=True)
    """Whether `heights` are given as those of a surface; `replace` must name it, too."""

    name: ClassVar[str] = "file"
    _remade: ClassVar[dict[str, Any]] = {"convention": "gap"}

    def __post_init__(self, convention: str) -> None:
        allowed = "at least 4 finite real numbers, not all equal"
        heights = checks.array("heights", self.heights, allowed, 4)
        bad = np.flatnonzero(~np.isfinite(heights))
        if bad.size:
            raise ValueError(f"heights[{bad[0]}] is {heights[bad[0]]}; allowed: {allowed}")
        checks.choice("convention", convention, ("heights", "gap"))
        if not isinstance(self.description, dict):
            raise checks.refusal("description", self.description, "a dictionary of names and values")
        heights = heights.max() - heights if convention == "heights" else heights - heights.min()
        if not 0 < heights.max() < math.inf:
            raise ValueError(f"heights are constant or too far apart; allowed: {allowed}")
        if self.measured_points is not None:
            checks.integer("measured_points", self.measured_points, "an integer from 4 to 2^60", 4, 2**60)
        if self.given_period is not None:
            allowed = "a finite length > 0, or None"
            checks.assign(self, given_period=checks.real("given_period", self.given_period, allowed, 0))
        heights.flags.writeable = False
        checks.assign(self, heights=heights)

    def __repr__(self) -> str:
        height = display.row("profile", float(self.heights.max()), named(self.description))
        origin = self.description.get("profile_file")
        told = f"{self.heights.size} heights, 0 to {height.value}{display.bracketed(height.unit)}"
        return f"{type(self).__name__}: {told}" + (f", from {display.row('', origin).value}" if origin else "")

    @cached_property
    def _modes(self) -> Modes:
        return np.asarray(rfft(self.heights) / self.heights.size)

    def profile(self, num_points: int, period: float) -> Array64:
        if num_points == self.heights.size:
            return self.heights / period
        modes = np.zeros(num_points // 2 + 1, dtype=np.complex128)
        held = (min(num_points, self.heights.size) + 1) // 2  # without the Nyquist mode
        modes[:held] = self._modes[:held]
        heights = irfft(modes, num_points) * num_points
        return np.asarray(heights - heights.min()) / period

    def shortest_wave(self, num_points: int) -> int:
        """The shortest wave that the values and the grid hold, see `Indenter`."""
        return min(num_points, self.heights.size, self.measured_points or self.heights.size) // 2

    @cached_property
    def kinked(self) -> bool:
        """Whether a few nodes hold more than half of the squares of how second differences differ from those around."""
        bend = np.roll(self.heights, -1) - 2 * self.heights + np.roll(self.heights, 1)
        unlike = np.sort((bend - (np.roll(bend, 2) + np.roll(bend, -2)) / 2) ** 2)
        few = unlike[bend.size - min(_KINKS, bend.size // _KINKS) :]
        return bool(2 * few.sum() > unlike.sum())

    def omitted(self, num_points: int) -> float:
        if num_points >= max(self.heights.size, self.measured_points or 0):
            return 0.0
        if num_points >= self.heights.size:
            return 1.0  # the shorter waves of the values are not known any more
        power = (np.arange(self._modes.size) * np.abs(self._modes)) ** 2
        return float(power[(num_points + 1) // 2 :].sum() / power.sum())

    @property
    def given_points(self) -> int | None:
        return self.heights.size

    @property
    def doubts(self) -> str:
        """Those in its description, see `Indenter`."""
        return str(self.description.get("profile_doubts", ""))

    def on_grid(self, num_points: int, period: float) -> Self:
        """Resampled by Fourier modes, see `Indenter`."""
        if num_points == self.heights.size:
            return self
        measured = self.measured_points or self.heights.size
        heights = self.profile(num_points, period) * period
        return replace(self, heights=heights, measured_points=measured, **self._remade)

    def in_units(self, length: float, pressure: float = 1.0) -> Self:
        period = None if self.given_period is None else self.given_period * length
        return replace(self, heights=self.heights * length, given_period=period, **self._remade)

    def ratios(self, period: float) -> dict[str, float]:
        return {"largest height/period": float(self.heights.max()) / period}

    def check(self, num_points: int) -> None:
        if num_points != self.heights.size:
            raise ValueError(f"num_points is {num_points}; allowed: {self.heights.size}, the number of heights")

    def to_dict(self) -> dict[str, Any]:
        return {"profile": self.name} | self.description
