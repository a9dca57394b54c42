"""Indenters: heights h >= 0 above the lowest point, on any grid.

Heights come in units of the period L, so that a shape has no unit of its own. `profile(n, L)` on a grid coarser than
the scene's is the same surface with the modes that this grid cannot hold left out (nested grids need that).
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from . import checks

Array64 = NDArray[np.float64]

STEEPEST = 1e100
"""Slopes are cut off here, before they overflow (dimensionless)."""


class Indenter(Protocol):
    """What a scene needs to know of its indenter."""

    name: ClassVar[str]

    def profile(self, num_points: int, period: float) -> Array64:
        """Heights h(x_i) over the period, shape (num_points,), in units of the period; the lowest is 0."""

    def slope(self, num_points: int, period: float) -> Array64:
        """Slopes h'(x_i), shape (num_points,), dimensionless."""

    def ratios(self, period: float) -> dict[str, float]:
        """The dimensionless numbers that scale the heights, by name."""

    def check(self, num_points: int) -> None:
        """Raise `ValueError` if a grid of that many points cannot hold the surface."""

    def to_dict(self) -> dict[str, Any]:
        """Flat, JSON-ready description under the command line's names."""


@dataclass(frozen=True)
class PowerIndenter:
    """Power profile h = (R/n) |x/R|^n, centred in the period: n = 1.5 sharp, 2 Hertz, 4 blunt.

    exponent: n > 1 [-].
    radius: R > 0 [length]; for n = 2 the radius of curvature.

    Raises `ValueError`.
    """

    exponent: float = 2.0
    radius: float = 1.0
    name: ClassVar[str] = "power"

    def __post_init__(self) -> None:
        checks.assign(self, "exponent", checks.real("exponent", self.exponent, "1 < n <= 100", 1, 100))
        checks.assign(self, "radius", checks.real("radius", self.radius, "a finite length > 0", 0))

    def profile(self, num_points: int, period: float) -> Array64:
        """Heights, see `Indenter`."""
        distance = self._distance(num_points)
        return distance / self.exponent * self._steepness(distance, period)

    def slope(self, num_points: int, period: float) -> Array64:
        """Slopes, see `Indenter`; 0 at the lowest point."""
        centre = np.arange(num_points) - num_points // 2
        return np.sign(centre) * self._steepness(self._distance(num_points), period)

    def check(self, num_points: int) -> None:
        """Any grid holds it."""

    def to_dict(self) -> dict[str, Any]:
        """Description, see `Indenter`."""
        return {"profile": self.name, "exponent": self.exponent, "radius": self.radius}

    def ratios(self, period: float) -> dict[str, float]:
        """See `Indenter`."""
        return {"radius/period": self.radius / period}

    def _steepness(self, distance: Array64, period: float) -> Array64:
        """|h'| = (x/R)^(n-1) at x/L; steeper than `STEEPEST` makes no difference, but overflows."""
        with np.errstate(over="ignore", under="ignore"):
            slope = (distance * (period / self.radius)) ** (self.exponent - 1)
        return np.asarray(np.minimum(slope, STEEPEST))

    @staticmethod
    def _distance(num_points: int) -> Array64:
        return np.abs(np.arange(num_points) - num_points // 2) / num_points


@dataclass(frozen=True)
class RoughIndenter:
    """Self-affine random roughness with independent uniform phases:

        h(q) ~ sqrt(C(q)) exp(2 pi i xi_q),  C(q) ~ [1 + (q/q_r)^2]^-(1/2+H)  for 0 < q <= q_s, 0 beyond,

    scaled to the rms gradient asked. The phases are drawn mode by mode from the longest wave on, so one seed is one
    surface on every grid that resolves it.

    hurst: H, 0 < H <= 1 [-]; seed: integer >= 0.
    roll_off_ratio: lambda_r/L <= 1 [-]; cut_off_ratio: lambda_s/lambda_r <= 1 [-].
    rms_gradient: of h over the period, > 0 [-].

    Raises `ValueError`.
    """

    hurst: float = 0.8
    seed: int = 0
    roll_off_ratio: float = 1 / 8
    cut_off_ratio: float = 1 / 512
    rms_gradient: float = 1.0
    name: ClassVar[str] = "rough"

    def __post_init__(self) -> None:
        checks.assign(self, "hurst", checks.real("hurst", self.hurst, "0 < H <= 1", 0, 1))
        checks.assign(self, "seed", checks.integer("seed", self.seed, "an integer from 0 to 2^63 - 1", 0, 2**63 - 1))
        for name in ("roll_off_ratio", "cut_off_ratio"):
            checks.assign(self, name, checks.real(name, getattr(self, name), "1e-9 < ratio <= 1", 1e-9, 1))
        gradient = checks.real("rms_gradient", self.rms_gradient, "a finite number > 0", 0)
        checks.assign(self, "rms_gradient", gradient)

    @property
    def shortest(self) -> int:
        """Number k_s of the shortest wave in the period."""
        return math.floor((1 + 1e-9) / self.roll_off_ratio / self.cut_off_ratio)

    @cached_property
    def _waves(self) -> NDArray[np.complex128]:
        """Fourier coefficients of h/L for k = 1 to k_s, shape (k_s,)."""
        k = np.arange(1, self.shortest + 1)
        amplitude = (1 + (k * self.roll_off_ratio) ** 2) ** (-(0.5 + self.hurst) / 2)
        amplitude *= self.rms_gradient / math.sqrt(2 * float(np.sum((2 * np.pi * k * amplitude) ** 2)))
        phases = np.random.default_rng(self.seed).random(self.shortest)
        return np.asarray(amplitude * np.exp(2j * np.pi * phases), dtype=np.complex128)

    def _modes(self, num_points: int) -> NDArray[np.complex128]:
        """Half spectrum of h/L that a grid holds, shape (num_points//2 + 1,)."""
        half = np.zeros(num_points // 2 + 1, dtype=np.complex128)
        held = min(self.shortest, (num_points - 1) // 2)  # the Nyquist mode has no phase
        half[1 : held + 1] = self._waves[:held]
        return half

    def profile(self, num_points: int, period: float) -> Array64:
        """Heights, see `Indenter`."""
        heights = np.fft.irfft(self._modes(num_points), num_points) * num_points
        heights -= heights.min()
        return np.asarray(heights)

    def slope(self, num_points: int, period: float) -> Array64:
        """Slopes, see `Indenter`, by the exact derivative of every mode."""
        wave_numbers = 2 * np.pi * np.arange(num_points // 2 + 1)
        return np.asarray(np.fft.irfft(1j * wave_numbers * self._modes(num_points), num_points) * num_points)

    def ratios(self, period: float) -> dict[str, float]:
        """See `Indenter`."""
        return {"rms_gradient": self.rms_gradient}

    def check(self, num_points: int) -> None:
        """See `Indenter`."""
        if not 2 * self.shortest < num_points:
            spacing = 1 / num_points / self.roll_off_ratio / self.cut_off_ratio
            raise ValueError(
                f"num_points is {num_points}, which does not resolve the surface: lambda_r/L is "
                f"{self.roll_off_ratio:.4g} (roll_off_ratio), lambda_s/lambda_r is {self.cut_off_ratio:.4g} "
                f"(cut_off_ratio) and dx/lambda_s is {spacing:.4g}; allowed: dx/lambda_s < 1/2 (1/64 and less for "
                "a converged area), by more points or larger ratios"
            )

    def to_dict(self) -> dict[str, Any]:
        """Description, see `Indenter`."""
        names = ("hurst", "seed", "roll_off_ratio", "cut_off_ratio", "rms_gradient")
        return {"profile": self.name} | {name: getattr(self, name) for name in names}


@dataclass(frozen=True, eq=False)
class MeasuredIndenter:
    """Heights given point by point, one per grid point of the scene, periodic as they stand.

    heights: shape (N,) [length]; kept shifted so that the lowest is 0. The user's unit of length.
    description: what is known of their origin, flat and JSON-ready; it travels with every result.

    Coarser grids take the Fourier modes that they hold. The slope is the central difference. Raises `ValueError`.
    """

    heights: Array64
    description: dict[str, Any] = field(default_factory=dict)
    name: ClassVar[str] = "file"

    def __post_init__(self) -> None:
        allowed = "allowed: at least 4 finite real numbers, not all equal"
        try:
            if np.ma.is_masked(self.heights):
                raise ValueError("masked")
            heights = np.array(self.heights, dtype=np.float64)
        except (TypeError, ValueError):
            raise ValueError(f"heights are masked or not an array of numbers; {allowed}") from None
        if heights.ndim != 1 or heights.size < 4:
            raise ValueError(f"heights have shape {heights.shape}; {allowed}")
        bad = np.flatnonzero(~np.isfinite(heights))
        if bad.size:
            raise ValueError(f"heights[{bad[0]}] is {heights[bad[0]]}; {allowed}")
        heights -= heights.min()
        if not 0 < heights.max() < math.inf:
            raise ValueError(f"heights are constant or too far apart; {allowed}")
        heights.flags.writeable = False
        checks.assign(self, "heights", heights)

    @cached_property
    def _modes(self) -> NDArray[np.complex128]:
        return np.asarray(np.fft.rfft(self.heights) / self.heights.size)

    def profile(self, num_points: int, period: float) -> Array64:
        """Heights, see `Indenter`."""
        if num_points == self.heights.size:
            return self.heights / period
        modes = np.zeros(num_points // 2 + 1, dtype=np.complex128)
        held = (min(num_points, self.heights.size) + 1) // 2  # without the Nyquist mode
        modes[:held] = self._modes[:held]
        heights = np.fft.irfft(modes, num_points) * num_points
        return np.asarray(heights - heights.min()) / period

    def omitted(self, num_points: int) -> float:
        """Share of the mean square slope in waves that a grid of that many points leaves out (dimensionless)."""
        power = (np.arange(self._modes.size) * np.abs(self._modes)) ** 2
        return float(power[(num_points + 1) // 2 :].sum() / power.sum())

    def slope(self, num_points: int, period: float) -> Array64:
        """Slopes, see `Indenter`, by central differences."""
        h = self.profile(num_points, period)
        return (np.roll(h, -1) - np.roll(h, 1)) * (num_points / 2)

    def ratios(self, period: float) -> dict[str, float]:
        """See `Indenter`."""
        return {"largest height/period": float(self.heights.max()) / period}

    def check(self, num_points: int) -> None:
        """See `Indenter`."""
        if num_points != self.heights.size:
            raise ValueError(f"num_points is {num_points}; allowed: {self.heights.size}, the number of heights")

    def to_dict(self) -> dict[str, Any]:
        """Description, see `Indenter`."""
        return {"profile": self.name} | self.description
