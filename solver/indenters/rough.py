"""Randomly rough surfaces of the published study."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from .. import checks
from ..arrays import Array64, Modes
from ..transforms.plain import irfft
from .indenter import Indenter

_FINE = np.linspace(-0.5, 0.5, 257)  # places beside a node [grid spacings]
_THROUGH_FIVE = np.vander(_FINE, 5) @ np.linalg.inv(np.vander(np.arange(-2.0, 3), 5))  # to values there from five nodes


@dataclass(frozen=True)
class RoughIndenter(Indenter):
    """Self-affine random roughness with independent uniform phases.

        h(q) ~ sqrt(C(q)) exp(2 pi i xi_q),  C(q) ~ [1 + (q/q_r)^2]^-(1/2+H)  for 0 < q <= q_s, 0 beyond,

    scaled to the rms gradient asked for. The phases are drawn mode by mode from the longest wave on, so one seed is one
    surface on every grid that resolves it.

    Raises `ValueError`.
    """

    hurst: float = 0.8
    """Hurst exponent, 0 < H <= 1 (dimensionless)."""
    seed: int = 0
    """Integer from 0 to 2^63 - 1: one seed is one surface, on every grid that resolves it."""
    roll_off_ratio: float = 1 / 8
    """lambda_r/L <= 1, the wavelength up to which the surface is self-affine (dimensionless)."""
    cut_off_ratio: float = 1 / 512
    """lambda_s/lambda_r <= 1, lambda_s the shortest wavelength (dimensionless)."""
    rms_gradient: float = 1.0
    """Rms gradient of h over the period, > 0 (dimensionless)."""

    name: ClassVar[str] = "rough"
    knows_lowest: ClassVar[bool] = True

    def __post_init__(self) -> None:
        checks.assign(self, hurst=checks.real("hurst", self.hurst, "0 < H <= 1", 0, 1))
        checks.assign(self, seed=checks.integer("seed", self.seed, "an integer from 0 to 2^63 - 1", 0, 2**63 - 1))
        for name in ("roll_off_ratio", "cut_off_ratio"):
            checks.assign(self, **{name: checks.real(name, getattr(self, name), "1e-9 < ratio <= 1", 1e-9, 1)})
        gradient = checks.real("rms_gradient", self.rms_gradient, "a finite number > 0", 0)
        checks.assign(self, rms_gradient=gradient)

    def shortest_wave(self, num_points: int) -> int:
        """k_s, see `Indenter`; the same on every grid."""
        return math.floor((1 + 1e-9) / self.roll_off_ratio / self.cut_off_ratio)

    @cached_property
    def _waves(self) -> Modes:
        """Fourier coefficients of h/L for k = 1 to k_s, shape (k_s,)."""
        shortest = self.shortest_wave(0)
        k = np.arange(1, shortest + 1)
        amplitude = (1 + (k * self.roll_off_ratio) ** 2) ** (-(0.5 + self.hurst) / 2)
        amplitude *= self.rms_gradient / math.sqrt(2 * float(np.sum((2 * np.pi * k * amplitude) ** 2)))
        phases = np.random.default_rng(self.seed).random(shortest)
        return np.asarray(amplitude * np.exp(2j * np.pi * phases), dtype=np.complex128)

    def _modes(self, num_points: int) -> Modes:
        """Fourier coefficients of h/L that a grid of N points holds, times N, from the mean mode to the shortest."""
        held = min(self._waves.size, (num_points - 1) // 2)  # the Nyquist mode has no phase
        return np.append(0.0, self._waves[:held]) * num_points

    def profile(self, num_points: int, period: float) -> Array64:
        heights = irfft(self._modes(num_points), num_points)
        heights -= heights.min()
        return np.asarray(heights)

    def depth_between_nodes(self, heights: Array64) -> float:
        """See `Indenter`. Between the nodes it is the polynomial of fourth order through the five nearest ones: with 32
        points to the shortest wave this leaves some 1/3000 of the error of the lowest node, with 4 about an eighth.
        """
        at, count = int(np.argmin(heights)), heights.size
        lowest = float(heights[at])
        deepest = float(heights[at - 1] - 2 * lowest + heights[(at + 1) % count]) / 4
        near = np.flatnonzero(heights <= lowest + deepest)
        nodes = heights[(near + np.arange(-2, 3)[:, None]) % count] - lowest
        left, middle, right = nodes[1:4]
        between = _THROUGH_FIVE @ nodes[:, (middle <= left) & (middle <= right) & (left + right > 2 * middle)]
        return min(abs(float(between.min(initial=0.0))), deepest)

    def slope(self, num_points: int, period: float) -> Array64:
        """Slopes, see `Indenter`, by the exact derivative of every mode."""
        modes = self._modes(num_points)
        return irfft(2j * np.pi * np.arange(modes.size) * modes, num_points)

    def ratios(self, period: float) -> dict[str, float]:
        return {"rms_gradient": self.rms_gradient}

    def check(self, num_points: int) -> None:
        if not 2 * self.shortest_wave(num_points) < num_points:
            spacing = 1 / num_points / self.roll_off_ratio / self.cut_off_ratio
            raise ValueError(
                f"num_points is {num_points}, which does not resolve the surface: lambda_r/L is "
                f"{self.roll_off_ratio:.4g} (roll_off_ratio), lambda_s/lambda_r is {self.cut_off_ratio:.4g} "
                f"(cut_off_ratio) and dx/lambda_s is {spacing:.4g}; allowed: dx/lambda_s < 1/2 (1/64 and less for "
                "a converged area), by more points or larger ratios"
            )
