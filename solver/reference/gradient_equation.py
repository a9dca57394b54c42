"""The equation of one asperity's contact pressure on a layer of any thickness, for one half-width, and its solution.

In |x| < a the slope of the surface is prescribed, int D(x-s) sigma(s) ds = h'(x), and for period P

    D(x) = (2/(E* P)) cot(pi x/P) + sum_k w_k sin(q_k x),   w_k = (2/P) q_k [1/K(q_k) - 2/(E* q_k)],  q_k = 2 pi k/P

the half-space's periodic Cauchy kernel and the layer's part, a sum that converges like exp(-2 q d) for a homogeneous
layer of thickness d on any base. With x = a t and sigma = sqrt(1-t^2) phi(t), Gauss-Chebyshev quadrature of the second
kind (F. Erdogan and G. D. Gupta, Q. Appl. Math. 29, 525 (1972)) turns it into a linear system of spectral accuracy. For
even profiles only t > 0 is kept.

On a rigid base a layer's interaction decays exponentially in x/d, so P may be shorter than the scene's period as long
as the images stay out of reach; that bounds the number of modes for thin layers. Units here: L = E* = 1.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array64
from ..layers import ElasticLayer
from ..layers.layer import HALF_SPACE_FROM
from .closed_forms import kappa_from_area, kappa_half_space

_MOST_VALUES = 6e7  # in one matrix: half a GiB
STEEPEST: float = math.cbrt(np.finfo(np.float64).max)
"""Slopes of profiles are cut off here, before their squares overflow (dimensionless)."""
_DECAY = 2 * HALF_SPACE_FROM  # exp(-(pi/2) 50) < 1e-34: distance in units of d beyond which a layer does not interact


@dataclass(frozen=True)
class Asperity:
    """Exact solution for one centred power profile, in units L = E* = 1."""

    half_width: float
    """a."""
    contact_area: float
    """a_r = 2a."""
    load: float
    """Mean pressure p."""
    peak_pressure: float
    """The largest sigma."""
    approach: float
    """Rigid approach since first touch, see `Observables`."""
    kappa: float
    """a_r/p*, p* the load over the rms slope in the contact."""
    kappa_ratio: float
    """kappa over that of the half-space."""
    t: Array64
    """Nodes t_j in (0, 1) of the right half of the contact, x = a t, shape (M,)."""
    pressure: Array64
    """sigma(a t_j), shape (M,)."""
    waves: Array64
    """b_k of sigma(a cos theta) = sum_k b_k sin(k theta), k = 1, 3, 5, ..., shape (M,)."""

    def pressure_at(self, t: Array64) -> Array64:
        """sigma(a t), shape of `t`; 0 for |t| >= 1."""
        inside = np.abs(t) < 1
        theta = np.arccos(np.abs(t[inside]))
        pressure = np.zeros(t.shape)
        pressure[inside] = np.sin(np.outer(theta, 2 * np.arange(self.waves.size) + 1)) @ self.waves
        return pressure


class System:
    """The solved linear system for one half-width; `load` is cheap, `asperity` adds numbers for a final answer.

    layer: with E* = 1 and its thickness in units of L. num_nodes: at least so many on both halves of the contact, and
    `resolution` times sqrt(a/d) on each.
    """

    def __init__(
        self, half_width: float, exponent: float, radius: float, layer: ElasticLayer, num_nodes: int, resolution: float
    ) -> None:
        a, thickness = half_width, layer.thickness
        n = max(num_nodes, 2 * round(resolution * math.sqrt(a / thickness)))
        period = min(1.0, 2 * a + _DECAY * thickness) if layer.foundation_modulus(1.0) else 1.0
        count = HALF_SPACE_FROM / thickness * period / (2 * np.pi)
        if n * max(n, count) > _MOST_VALUES:
            why = f"for a half-width of {a:.3g} collocation would need {n} nodes and {count:.0f} modes"
            raise ValueError(f"thickness is {thickness!r}; allowed: more, {why}")
        self.half_width, self.num_nodes, self._period = half_width, n, period
        self._exponent, self._radius, self._layer = exponent, radius, layer
        j = np.arange(1.0, n // 2 + 1)
        self._theta = j * np.pi / (n + 1)
        t, x = np.cos(self._theta), np.cos((2 * j - 1) * np.pi / (2 * n + 2))
        self._weights = np.pi / (n + 1) * np.sin(self._theta) ** 2
        z = np.pi * a / period
        kernel = 2 * a / period * (1 / np.tan(z * (x[:, None] - t)) + 1 / np.tan(z * (x[:, None] + t)))
        waves = np.arange(1.0, math.ceil(count) + 1)  # none for the half-space
        self._q = q = 2 * np.pi / period * waves
        self._compliance = period / layer.stiffness(2 * np.pi * waves, period) - 2 / q  # beyond the half-space's
        if q.size:
            sines, cosines = np.sin(np.outer(a * x, q)), np.cos(np.outer(a * t, q))
            kernel += 4 * a / period * (sines * (q * self._compliance)) @ cosines.T
        with np.errstate(over="ignore"):
            slope = np.minimum((a * x / radius) ** (exponent - 1), STEEPEST)
        self._phi = np.asarray(np.linalg.solve(kernel * self._weights, slope), dtype=np.float64)
        self.load = 2 * a * float(self._weights @ self._phi)
        """Line load over E* L."""

    def asperity(self) -> Asperity:
        a, n, period, load, t = self.half_width, self.num_nodes, self._period, self.load, np.cos(self._theta)
        pressure = np.sin(self._theta) * self._phi
        k = np.arange(1, n + 1, 2)  # sigma = sum_k b_k sin(k theta), k odd
        b = 4 / (n + 1) * np.sin(np.outer(k, self._theta)) @ pressure
        # displacement at x = 0 by the Green's function; the half-space's logarithm integrated in closed form
        smooth = -2 / np.pi * np.log(2 * np.sin(np.pi * a / period * t) / t)
        smooth += 2 / period * np.cos(np.outer(a * t, self._q)) @ self._compliance
        approach = 2 * a * float((self._weights * self._phi) @ smooth) - 2 / np.pi * a * float(b @ _log_moments(k))
        foundation = self._layer.foundation_modulus(1.0)
        kappa = kappa_from_area(self._exponent, 2 * a, self._radius, load)
        return Asperity(
            half_width=a,
            contact_area=2 * a,
            load=load,
            peak_pressure=_largest(np.sin(np.outer(np.linspace(0, np.pi / 2, 4 * n + 1), k)) @ b),
            approach=approach + (load / period / foundation if foundation else 0.0),
            kappa=kappa,
            kappa_ratio=kappa / kappa_half_space(self._exponent),
            t=t,
            pressure=pressure,
            waves=b,
        )


def _largest(samples: Array64) -> float:
    """Largest value of a smooth function from even samples, the last one in its middle: of a parabola through three."""
    at = int(np.argmax(samples))
    if not 0 < at < samples.size - 1:
        return float(samples[at])
    before, largest, after = samples[at - 1 : at + 2]
    curvature = before - 2 * largest + after
    return float(largest - (after - before) ** 2 / (8 * curvature)) if curvature < 0 else float(largest)


def _log_moments(k: NDArray[np.int_]) -> Array64:
    """int_0^pi sin(k theta) sin(theta) ln|cos(theta)| dtheta for odd k."""

    def cosine_moment(m: NDArray[np.int_]) -> Array64:
        return np.where(m == 0, -np.pi * np.log(2.0), -np.pi / np.maximum(m, 1) * np.cos(m * np.pi / 2))

    return np.asarray((cosine_moment(k - 1) - cosine_moment(k + 1)) / 2)
