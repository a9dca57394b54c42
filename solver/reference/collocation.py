"""One asperity on a layer of any thickness, solved without a grid: the oracle for every error of the grid methods.

In |x| < a the slope of the surface is prescribed, int D(x-s) sigma(s) ds = h'(x), and for period P

    D(x) = (2/(E* P)) cot(pi x/P) + sum_k w_k sin(q_k x),   w_k = (2/P) q_k [1/K(q_k) - 2/(E* q_k)],  q_k = 2 pi k/P

the half-space's periodic Cauchy kernel and the layer's part, a sum that converges like exp(-2 q d) for a homogeneous
layer of thickness d on any base. With x = a t and
sigma = sqrt(1-t^2) phi(t), Gauss-Chebyshev quadrature of the second kind (F. Erdogan and G. D. Gupta, Q. Appl. Math.
29, 525 (1972)) turns it into a linear system of spectral accuracy. For even profiles only t > 0 is kept.

On a rigid base a layer's interaction decays exponentially in x/d, so P may be shorter than the scene's period as long
as the images stay out of reach; that bounds the number of modes for thin layers. Units here: L = E* = 1.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import checks
from ..arrays import Array64
from ..layers import ElasticLayer, Layer
from ..layers.bonded import edge_shift
from .closed_forms import (
    guessed_half_width,
    kappa_from_area,
    kappa_half_space,
    lone_half_width,
    thin_layer_kappa_ratio,
)

_DECAY = 60.0  # exp(-(pi/2) 60) < 1e-40: distance in units of d beyond which a layer does not interact
RESOLUTION = 40.0
"""Nodes over sqrt(a/d), each half: resolves the edge layers of width d to 1e-10, next to nu = 1/2 and under blunt
indenters on the thinnest layers that fit in memory to 1e-4.
"""

MOST_NODES = 2048
"""Of `solve_to_accuracy`: half a second."""

MEASURED = {"contact_area": 0.4, "kappa": 0.4, "peak_pressure": 1.0, "approach": 1.0}
"""What `solve_to_accuracy` estimates the error of, and which share of the change by the last doubling of the nodes that
is (dimensionless). In 160 random scenes it was at most 0.24, 0.24, 2 (1 in 97 of 100) and 0.6 of it; for exponents
that approach 1 the first two approach 1/3."""

_MOST_STEPS = 40  # of the search for a load; ten are many where the edge layers are resolved
_MOST_VALUES = 6e7  # in one matrix: half a GiB
STEEPEST = 1e100
"""Slopes of profiles are cut off here, before they overflow (dimensionless)."""
_TENSION = 1e-6  # over the peak pressure; where more pulls the contact is not one patch
_MODES = 22.0  # exp(-2 * 22) < 1e-19: largest q d of the layer's sum


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
    reduced_thickness: float
    """d/a_r."""
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


@dataclass(frozen=True)
class _System:
    """The solved linear system for one half-width; `load` is cheap, `asperity` adds what only a final answer needs."""

    half_width: float
    """a."""
    exponent: float
    """n of the power profile."""
    radius: float
    """R of the power profile."""
    layer: ElasticLayer
    """The layer, with E* = 1 and its thickness in units of L."""
    num_nodes: int
    """Gauss-Chebyshev nodes on both halves of the contact."""
    period: float
    """P, the distance of the images that are kept; at most 1."""
    theta: Array64
    """Angles of the nodes, t = cos(theta), shape (M,)."""
    weights: Array64
    """Weights of the quadrature, shape (M,)."""
    phi: Array64
    """The solution, sigma = sqrt(1 - t^2) phi, shape (M,)."""
    modes: tuple[Array64, Array64]
    """Wave numbers and the layer's extra compliance, see `_layer_modes`."""

    @classmethod
    def solve(
        cls,
        half_width: float,
        exponent: float,
        radius: float,
        layer: ElasticLayer,
        num_nodes: int,
        resolution: float,
    ) -> "_System":
        a, thickness = half_width, layer.thickness
        num_nodes = max(num_nodes, 2 * round(resolution * math.sqrt(a / thickness)))
        period = min(1.0, 2 * a + _DECAY * thickness) if layer.foundation_modulus(1.0) else 1.0
        count = _MODES / thickness * period / (2 * np.pi)
        if num_nodes * max(num_nodes, count) > _MOST_VALUES:
            raise ValueError(
                f"thickness is {thickness!r}; allowed: more, for a half-width of {a:.3g} collocation would need "
                f"{num_nodes} nodes and {count:.0f} modes"
            )
        j = np.arange(1.0, num_nodes // 2 + 1)
        theta = j * np.pi / (num_nodes + 1)
        t = np.cos(theta)
        x = np.cos((2 * j - 1) * np.pi / (2 * num_nodes + 2))
        weights = np.pi / (num_nodes + 1) * np.sin(theta) ** 2
        z = np.pi * a / period
        kernel = 2 * a / period * (1 / np.tan(z * (x[:, None] - t)) + 1 / np.tan(z * (x[:, None] + t)))
        q, compliance = modes = _layer_modes(period, layer)
        if q.size:
            sines, cosines = np.sin(np.outer(a * x, q)), np.cos(np.outer(a * t, q))
            kernel += 4 * a / period * (sines * (q * compliance)) @ cosines.T
        with np.errstate(over="ignore"):
            slope = np.minimum((a * x / radius) ** (exponent - 1), STEEPEST)
        phi = np.asarray(np.linalg.solve(kernel * weights, slope), dtype=np.float64)
        return cls(a, exponent, radius, layer, num_nodes, period, theta, weights, phi, modes)

    @property
    def load(self) -> float:
        """Line load over E* L."""
        return 2 * self.half_width * float(self.weights @ self.phi)

    def asperity(self) -> Asperity:
        """Peak pressure, approach and the rest."""
        a, n, t, load = self.half_width, self.num_nodes, np.cos(self.theta), self.load
        k = np.arange(1, n + 1, 2)  # sigma = sum_k b_k sin(k theta), k odd
        b = 4 / (n + 1) * np.sin(np.outer(k, self.theta)) @ (np.sin(self.theta) * self.phi)
        peak = _largest(np.sin(np.outer(np.linspace(0, np.pi / 2, 4 * n + 1), k)) @ b)
        # displacement at x = 0 by the Green's function; the half-space's logarithm integrated in closed form
        q, compliance = self.modes
        smooth = -2 / np.pi * np.log(2 * np.sin(np.pi * a / self.period * t) / t)
        smooth += 2 / self.period * np.cos(np.outer(a * t, q)) @ compliance
        approach = 2 * a * float((self.weights * self.phi) @ smooth) - 2 / np.pi * a * float(b @ _log_moments(k))
        foundation = self.layer.foundation_modulus(1.0)
        approach += load / self.period / foundation if foundation else 0.0
        kappa = kappa_from_area(self.exponent, 2 * a, self.radius, load)
        return Asperity(
            half_width=a,
            contact_area=2 * a,
            load=load,
            peak_pressure=peak,
            approach=approach,
            kappa=kappa,
            kappa_ratio=kappa / kappa_half_space(self.exponent),
            reduced_thickness=self.layer.thickness / (2 * a),
            t=t,
            pressure=np.sin(self.theta) * self.phi,
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


def solve_load(
    load: float,
    exponent: float,
    radius: float,
    thickness: float,
    poisson_ratio: float,
    num_nodes: int = 160,
    resolution: float = RESOLUTION,
) -> Asperity:
    """The asperity under the mean pressure `load` (units of E*), lengths in units of L.

    num_nodes: Gauss-Chebyshev nodes, even; 160 reach 12 digits for even exponents. Thin layers need about sqrt(a/d)
    times more and get them, see `RESOLUTION`. Raises `ValueError`, also beyond 0.98 of full contact.
    """
    layer = Layer(thickness, poisson_ratio)
    _check(load, exponent, radius, num_nodes)
    guess = guessed_half_width(load, exponent, radius, thickness, poisson_ratio)
    return solve_layer(layer, load, exponent, radius, num_nodes, resolution, guess)


def solve_layer(
    layer: ElasticLayer,
    load: float,
    exponent: float,
    radius: float,
    num_nodes: int = 160,
    resolution: float = RESOLUTION,
    guess: float | None = None,
) -> Asperity:
    """As `solve_load` for any layer whose K(q) approaches E* q/2 like exp(-2 q d), with E* = 1, lengths in units of L.

    guess: half-width to begin the search with, by default that on a half-space. Raises `ValueError`, also where the
    contact would have to pull, because it splits, as it may on a coating much stiffer than its base.
    """
    _check(load, exponent, radius, num_nodes)
    guess = lone_half_width(load, exponent, radius, 1.0) if guess is None else guess

    def system(a: float) -> _System:
        return _System.solve(a, exponent, radius, layer, num_nodes, resolution)

    found = _match(system, load, exponent, min(guess, 0.4)).asperity()
    lowest = float(found.pressure.min())
    if lowest < -_TENSION * found.peak_pressure:
        tension = f"there is tension of {-lowest / found.peak_pressure:.2g} of the peak pressure in the contact"
        allowed = "one under which the contact does not split, or more num_nodes"
        raise ValueError(f"load is {load!r}; allowed: {allowed}: {tension}")
    return found


def solve_to_accuracy(
    load: float,
    exponent: float,
    radius: float,
    thickness: float,
    poisson_ratio: float,
    accuracy: float,
    of: str = "contact_area",
) -> tuple[Asperity, dict[str, float]]:
    """As `solve_load`, and the relative errors of `MEASURED`, estimated, that of `of` at most `accuracy`.

    Raises `ValueError` where `MOST_NODES` are too few.
    """
    _check(load, exponent, radius, 16)
    layer = Layer(thickness, poisson_ratio)
    num_nodes, resolution, error = 16, 10.0, math.inf
    guess = guessed_half_width(load, exponent, radius, thickness, poisson_ratio)
    coarser: Asperity | None = None
    while num_nodes <= MOST_NODES:

        def system(a: float, num_nodes: int = num_nodes, resolution: float = resolution) -> _System:
            return _System.solve(a, exponent, radius, layer, num_nodes, resolution)

        found = _match(system, load, exponent, guess)
        asperity = found.asperity()
        if coarser:
            errors = {name: _error(asperity, coarser, name) for name in MEASURED}
            error = errors[of]
            if error <= accuracy:
                return asperity, errors
        guess, num_nodes, resolution, coarser = found.half_width, 2 * found.num_nodes, 0.0, asperity
    raise ValueError(f"accuracy is {accuracy!r}; allowed: more than {error:.1g}, by collocation at {MOST_NODES} nodes")


def _error(asperity: Asperity, coarser: Asperity, name: str) -> float:
    """Relative error, estimated from the change since half as many nodes; at least what rounding leaves."""
    value: float = getattr(asperity, name)
    return max(MEASURED[name] * float(abs(value - getattr(coarser, name)) / abs(value)), 1e-12)


def solve_reduced_thickness(
    load: float, exponent: float, radius: float, reduced_thickness: float, poisson_ratio: float, num_nodes: int = 160
) -> tuple[float, Asperity]:
    """The thickness d (units of L) at which d/a_r has the given value under `load`, and its solution."""
    _check(load, exponent, radius, num_nodes)
    checks.real("reduced_thickness", reduced_thickness, "a finite number > 0", 0)

    def system(a: float) -> _System:
        layer = Layer(2 * a * reduced_thickness, poisson_ratio)
        return _System.solve(a, exponent, radius, layer, num_nodes, RESOLUTION)

    thin = thin_layer_kappa_ratio(exponent, poisson_ratio, reduced_thickness, max(0.0, edge_shift(poisson_ratio)))
    guess = lone_half_width(load, exponent, radius, 1 / (1 + 1 / thin))
    asperity = _match(system, load, exponent, guess).asperity()
    return reduced_thickness * asperity.contact_area, asperity


def _check(load: float, exponent: float, radius: float, num_nodes: int) -> None:
    checks.real("load", load, "a finite number > 0", 0)
    checks.real("exponent", exponent, "1 < n <= 100", 1, 100)
    checks.real("radius", radius, "a finite number > 0", 0)
    checks.integer("num_nodes", num_nodes, "an even integer from 4 to 10000", 4, 10_000, 2)


def _match(system: Callable[[float], _System], load: float, exponent: float, guess: float) -> _System:
    """Root of load(a) = `load` by secants in log-log, where it is nearly a power law; bisection as a safeguard."""
    low, high = math.log(guess) - 100, math.log(0.49)
    target = math.log(load)
    y, slope = min(math.log(guess), math.log(0.45)), exponent + 1.0
    previous: tuple[float, float] | None = None
    for _ in range(_MOST_STEPS):
        best = system(math.exp(y))
        error = math.log(best.load) - target if best.load > 0 else math.inf
        if abs(error) < 1e-13:
            return best
        low, high = (low, y) if error > 0 else (y, high)
        if math.isinf(error):
            y = (low + high) / 2
            continue
        if previous and y != previous[0]:
            slope = (error - previous[1]) / (y - previous[0])
        previous = (y, error)
        step = y - error / slope if slope > 0 else math.nan
        new = step if low < step < high else (low + high) / 2
        if abs(new - y) < 4e-16 * abs(y):
            break
        y = new
    if y > math.log(0.489):
        raise ValueError(
            f"load is {load!r}; allowed: below {best.load:.6g}, where the contact fills 0.98 of the period"
        )
    if not abs(error) < 1e-9:
        raise ValueError(f"num_nodes is {best.num_nodes}; allowed: more, the edge layers are not resolved")
    return best


def _layer_modes(period: float, layer: ElasticLayer) -> tuple[Array64, Array64]:
    """Wave numbers q_k and the layer's extra compliance 1/K - 2/q_k, shape (M,) each; empty for the half-space."""
    count = math.ceil(_MODES / layer.thickness * period / (2 * np.pi))
    q = 2 * np.pi / period * np.arange(1.0, count + 1)
    k = layer.stiffness(2 * np.pi * np.arange(1.0, count + 1), period) / period
    return q, 1 / k - 2 / q


def _log_moments(k: NDArray[np.int_]) -> Array64:
    """int_0^pi sin(k theta) sin(theta) ln|cos(theta)| dtheta for odd k."""

    def cosine_moment(m: NDArray[np.int_]) -> Array64:
        return np.where(m == 0, -np.pi * np.log(2.0), -np.pi / np.maximum(m, 1) * np.cos(m * np.pi / 2))

    return np.asarray((cosine_moment(k - 1) - cosine_moment(k + 1)) / 2)
