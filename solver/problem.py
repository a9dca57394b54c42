"""The discrete, dimensionless problem behind a scene.

Lengths along x are in units of the period L, pressures in units of the mean external pressure p, displacements and
heights in units of p L/E*. Then only the shape of h and the stiffness remain: u <= h, K u + sigma = 1, sigma >= 0,
sigma (h - u) = 0. Scaling h, p, E* or L consistently leaves the numbers of this problem as they are.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .scene import Scene
from .stiffness import stiffness

Array64 = NDArray[np.float64]


@dataclass(frozen=True)
class Problem:
    """stiffness: K(q_k), shape (N//2 + 1,) [E*/L]; height: h, shape (N,) [p L/E*]; length_unit: p L/E* [length]."""

    stiffness: Array64
    height: Array64
    length_unit: float

    @classmethod
    def from_scene(cls, scene: Scene, num_points: int | None = None) -> "Problem":
        """Discretise a scene on its own grid, or on another one of `num_points`."""
        n = num_points or scene.num_points
        reduced_load = scene.pressure / scene.layer.contact_modulus
        return cls(
            stiffness=stiffness(n, scene.layer.thickness / scene.period, scene.layer.poisson_ratio),
            height=scene.indenter.profile(n, scene.period) / reduced_load,
            length_unit=reduced_load * scene.period,
        )

    @property
    def num_points(self) -> int:
        return self.height.size

    def net_force(self, displacement: Array64) -> Array64:
        """r = 1 - K u, shape (N,) [p], of a displacement [p L/E*]."""
        return np.asarray(1 - np.fft.irfft(self.stiffness * np.fft.rfft(displacement), self.num_points))

    def displacement_under(self, pressure: Array64) -> Array64:
        """The displacement u <= h, shape (N,) [p L/E*], under a contact pressure [p]; on the wall where that acts."""
        modes = np.fft.rfft(pressure)
        modes[0] = 0
        modes[1:] /= self.stiffness[1:]
        gap = self.height + np.fft.irfft(modes, self.num_points)
        gap -= (pressure @ gap) / pressure.sum()
        return np.where(pressure > 0, self.height, self.height - np.maximum(gap, 0.0))


def foundation_level(height: Array64, modulus: float) -> float:
    """The level at which a Winkler foundation carries the mean pressure: modulus mean(max(level - h, 0)) = 1."""
    ordered, count = np.sort(height), np.arange(1, height.size + 1)
    lead = np.cumsum(ordered)
    load = modulus * (count * ordered - lead) / height.size
    inside = min(max(1, int(np.searchsorted(load, 1.0))), height.size)
    return float((height.size / modulus + lead[inside - 1]) / inside)


def rounding_floor(stiffness: Array64, displacement: Array64, precision: str) -> float:
    """The rms free residual over p that rounding leaves in a displacement, shape (N,) [p L/E*] (dimensionless).

    A relative rounding error eps in u comes back as force, times the rms of K; so it grows with K_max and N. Measured
    in float32 on 150 scenes, 2^10 to 2^18 points: FIRE stagnates at 0.1 to 2 of eps rms(K) rms(u), mostly at a half;
    the active set there or below.
    """
    k, u = stiffness[1:], displacement
    return 0.5 * float(np.finfo(precision).eps) * math.sqrt(float(k @ k) / k.size * float(u @ u) / u.size)
