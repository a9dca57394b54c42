"""The discrete, dimensionless problem behind a scene.

The elastic pressure of mode k of the displacement, u(x) = sum_k u_k exp(i q_k x) with q_k = 2 pi k/L, is K(q_k) u_k.
All transforms of `transforms` agree with it up to the factor 1/N on the way back. Only k = 0 ... N/2 are kept (half
spectrum). The mean mode has K = 0: the mean pressure is p by force balance, so area and pressure do not
depend on the layer's mean compression, which `observables` adds to the approach.

Lengths along x are in units of the period L, pressures in units of the mean external pressure p, displacements and
heights in a unit of p L/E* over the stiffest mode, K_max L/E*, rounded down to a power of two. Then only the shapes of
h and K remain, and K <= 2: u <= h, K u + sigma = 1, sigma >= 0, sigma (h - u) = 0. Scaling h, p, E* or L consistently
leaves the numbers of this problem as they are, and no layer is so thin or unit so large that they overflow.

Heights are cut off where nothing ever touches. Without its mean, |u| is at most sum_k 1/K(q_k), over all modes but the
mean one; u <= 0 where h = 0, and u = h >= 0 somewhere: so |u| <= 2 sum_k 1/K(q_k) < `LayerOnGrid.reach`.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Array64, Mask
from ..scene import Scene
from ..transforms.plain import irfft, rfft
from .indenter_on_grid import IndenterOnGrid, indenter_on_grid
from .layer_on_grid import LayerOnGrid, layer_on_grid

_FAR = 1e6  # times the reach


@dataclass(frozen=True)
class Problem:
    """The discrete problem. Docstrings call its units of stiffness, displacement and pressure [K], [u] and [p]."""

    scene: Scene
    """Of any grid."""
    layer: LayerOnGrid
    """The layer on this grid."""
    indenter: IndenterOnGrid
    """The indenter on this grid."""
    height: Array64
    """h(x_i), shape (N,) [`length_unit`]."""
    length_unit: float
    """The unit [u] of heights and displacements [length]."""

    @classmethod
    def from_scene(cls, scene: Scene, num_points: int | None = None) -> "Problem":
        """Discretise a scene on its own or another grid. Raises `ValueError` for bad heights, or as `half_spectrum`."""
        n = num_points or scene.num_points
        indenter = indenter_on_grid(scene.indenter, n, scene.period)
        layer = layer_on_grid(scene.layer, n, scene.period)
        unit = (scene.reduced_load if scene.pressure > 0 else 1.0) / layer.unit  # without a load any unit will do
        with np.errstate(over="ignore"):
            height = indenter.profile / unit
        return cls(
            scene=scene,
            layer=layer,
            indenter=indenter,
            height=np.minimum(height, _FAR * layer.reach, out=height),
            length_unit=unit * scene.period,
        )

    @cached_property
    def profile(self) -> Array64:
        """Heights above the lowest point, shape (N,) [length]."""
        profile, period = self.indenter.profile, self.scene.period
        return profile if period == 1 else period * profile

    @property
    def full_contact_pressure(self) -> float:
        """The smallest mean pressure under which all nodes of the grid touch, max(K h) [pressure]."""
        held = irfft(self.stiffness * rfft(self.indenter.profile), self.num_points)
        return float(held.max()) * self.layer.unit * self.scene.layer.contact_modulus

    def to_length(self, displacement: Array64, contact: Mask) -> Array64:
        """A displacement u <= h, shape (N,) [u], as [length], in place; exactly on the wall at the contact nodes."""
        displacement *= self.length_unit
        np.minimum(displacement, self.profile, out=displacement)  # units round
        displacement[contact] = self.profile[contact]
        return displacement

    @property
    def stiffness(self) -> Array64:
        """K(q_k), shape (N//2 + 1,) [K]."""
        return self.layer.stiffness

    @property
    def num_points(self) -> int:
        return self.height.size

    def net_force(self, displacement: Array64) -> Array64:
        """r = 1 - K u, shape (N,) [p], of a displacement [u]."""
        return np.asarray(1 - irfft(self.stiffness * rfft(displacement), self.num_points))

    def wall_pressure(self, displacement: Array64) -> Array64:
        """sigma >= 0 where a displacement, shape (N,) [u], touches the wall, 0 elsewhere; shape (N,) [p]."""
        return np.where(displacement >= self.height, np.maximum(self.net_force(displacement), 0.0), 0.0)

    def displacement_under(self, pressure: Array64) -> Array64:
        """The displacement u <= h, shape (N,) [u], under a contact pressure [p]; on the wall where that acts.

        Without any, as a coarser grid may leave it, 0: a layer at rest.
        """
        if not pressure.any():
            return np.zeros(self.num_points)
        return np.where(pressure > 0, self.height, np.minimum(self.height, self.surface_under(pressure)))

    def surface_under(self, pressure: Array64) -> Array64:
        """The displacement, shape (N,) [u], that a contact pressure [p] other than 0 causes, as high as the wall is on
        the average where it acts; in between it may be beyond the wall.
        """
        modes = rfft(pressure)
        modes[0] = 0
        modes[1:] /= self.stiffness[1:]
        response = irfft(modes, self.num_points)
        level = float(pressure @ (self.height + response)) / float(pressure.sum())
        return level - response


def foundation_level(height: Array64, modulus: float) -> float:
    """How deep a Winkler foundation is pressed by the mean pressure: modulus mean(max(level - h, 0)) = 1 [height].

    height: h, shape (N,) [any unit]; modulus: of the foundation [p over that unit].
    """
    ordered, count = np.sort(height), np.arange(1, height.size + 1)
    lead = np.cumsum(ordered)
    load = modulus * (count * ordered - lead) / height.size
    inside = min(max(1, int(np.searchsorted(load, 1.0))), height.size)
    return float((height.size / modulus + lead[inside - 1]) / inside)


def foundation_pressure(problem: Problem) -> Array64:
    """Where to start: the pressure, shape (N,) [p], on a foundation between the longest and the stiffest wave."""
    modulus = math.sqrt(float(problem.stiffness[1]) * float(problem.stiffness.max()))
    return modulus * np.maximum(foundation_level(problem.height, modulus) - problem.height, 0.0)


def rounding_floor(stiffness: Array64, displacement: Array64, precision: str) -> float:
    """The rms equilibrium residual over p that rounding leaves in a displacement, shape (N,) [u] (dimensionless).

    A relative rounding error eps in u comes back as force, times the rms of K; so it grows with K_max and N. Measured
    in float32 on 150 scenes, 2^10 to 2^18 points: FIRE stagnates at 0.1 to 2 of eps rms(K) rms(u), mostly at a half;
    the active set there or below.
    """
    k, u = stiffness[1:], displacement
    return 0.5 * float(np.finfo(precision).eps) * math.sqrt(float(k @ k) / k.size * float(u @ u) / u.size)
