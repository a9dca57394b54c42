"""The discrete, dimensionless problem behind a scene.

Lengths along x are in units of the period L, pressures in units of the mean external pressure p, displacements and
heights in a unit of p L/E* over the stiffest mode, K_max L/E*, rounded down to a power of two. Then only the shapes of
h and K remain, and K <= 2: u <= h, K u + sigma = 1, sigma >= 0, sigma (h - u) = 0. Scaling h, p, E* or L consistently
leaves the numbers of this problem as they are, and no layer is so thin or unit so large that they overflow.

Heights are cut off where nothing ever touches. Without its mean, |u| is at most sum_k 1/K(q_k), over all modes but the
mean one; u <= 0 where h = 0, and u = h >= 0 somewhere: so |u| <= 2 sum_k 1/K(q_k) < `reach`.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .scene import Scene
from .stiffness import stiffness

Array64 = NDArray[np.float64]

_FAR = 1e6  # times the reach


@dataclass(frozen=True)
class Problem:
    """stiffness: K(q_k) in units of `stiffness_unit` [E*/L], shape (N//2 + 1,); height: h in units of `length_unit`
    [length], shape (N,). Docstrings call these units [K] and [u].
    """

    stiffness: Array64
    height: Array64
    stiffness_unit: float
    length_unit: float

    @classmethod
    def from_scene(cls, scene: Scene, num_points: int | None = None) -> "Problem":
        """Discretise a scene on its own grid, or on another one of `num_points`."""
        n = num_points or scene.num_points
        k = stiffness(n, scene.layer.thickness / scene.period, scene.layer.poisson_ratio)
        stiffness_unit = 2.0 ** math.floor(math.log2(k.max()))
        k /= stiffness_unit
        unit = scene.pressure / scene.layer.contact_modulus / stiffness_unit
        with np.errstate(over="ignore"):
            height = scene.indenter.profile(n, scene.period) / unit
        return cls(
            stiffness=k,
            height=np.minimum(height, _FAR * _reach(k, n), out=height),
            stiffness_unit=stiffness_unit,
            length_unit=unit * scene.period,
        )

    @property
    def num_points(self) -> int:
        return self.height.size

    @property
    def reach(self) -> float:
        """What |u| stays below in every solution [u]."""
        return _reach(self.stiffness, self.num_points)

    def net_force(self, displacement: Array64) -> Array64:
        """r = 1 - K u, shape (N,) [p], of a displacement [u]."""
        return np.asarray(1 - np.fft.irfft(self.stiffness * np.fft.rfft(displacement), self.num_points))

    def displacement_under(self, pressure: Array64) -> Array64:
        """The displacement u <= h, shape (N,) [u], under a contact pressure [p]; on the wall where that acts."""
        modes = np.fft.rfft(pressure)
        modes[0] = 0
        modes[1:] /= self.stiffness[1:]
        gap = self.height + np.fft.irfft(modes, self.num_points)
        gap -= (pressure @ gap) / pressure.sum()
        return np.where(pressure > 0, self.height, self.height - np.maximum(gap, 0.0))


def _reach(stiffness: Array64, num_points: int) -> float:
    return 2 * num_points / float(stiffness[1:].min())


def foundation_level(height: Array64, modulus: float) -> float:
    """The level at which a Winkler foundation carries the mean pressure: modulus mean(max(level - h, 0)) = 1."""
    ordered, count = np.sort(height), np.arange(1, height.size + 1)
    lead = np.cumsum(ordered)
    load = modulus * (count * ordered - lead) / height.size
    inside = min(max(1, int(np.searchsorted(load, 1.0))), height.size)
    return float((height.size / modulus + lead[inside - 1]) / inside)


def foundation_pressure(problem: Problem) -> Array64:
    """The pressure, shape (N,) [p], of a Winkler foundation as stiff as the layer's longest wave: where to start."""
    modulus = float(problem.stiffness[1])
    return modulus * np.maximum(foundation_level(problem.height, modulus) - problem.height, 0.0)


def rounding_floor(stiffness: Array64, displacement: Array64, precision: str) -> float:
    """The rms free residual over p that rounding leaves in a displacement, shape (N,) [u] (dimensionless).

    A relative rounding error eps in u comes back as force, times the rms of K; so it grows with K_max and N. Measured
    in float32 on 150 scenes, 2^10 to 2^18 points: FIRE stagnates at 0.1 to 2 of eps rms(K) rms(u), mostly at a half;
    the active set there or below.
    """
    k, u = stiffness[1:], displacement
    return 0.5 * float(np.finfo(precision).eps) * math.sqrt(float(k @ k) / k.size * float(u @ u) / u.size)
