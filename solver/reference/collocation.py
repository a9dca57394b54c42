"""One asperity on a layer of any thickness, solved without a grid: errors of grid methods are measured by it.

The half-width is searched for at which the solution of `gradient_equation` carries the load. Units here: L = E* = 1.
"""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from .. import checks
from ..layers import ElasticLayer, Layer
from ..layers.bonded import edge_shift
from .closed_forms import guessed_half_width, lone_half_width, thin_layer_kappa_ratio
from .gradient_equation import Asperity, System

__all__ = [
    "MEASURED",
    "MOST_NODES",
    "RESOLUTION",
    "Asperity",
    "solve_layer",
    "solve_load",
    "solve_reduced_thickness",
    "solve_to_accuracy",
]

RESOLUTION = 40.0
"""Nodes over sqrt(a/d), each half: resolves the edge layers of width d to 1e-10, next to nu = 1/2 and under blunt
indenters on the thinnest layers that fit in memory to 1e-4.
"""

MOST_NODES = 2048
"""Of `solve_to_accuracy`: half a second."""

MEASURED = {"contact_area": 0.4, "kappa": 0.4, "peak_pressure": 1.0, "approach": 1.0}
"""What `solve_to_accuracy` estimates the error of, and which share of the change by one doubling of the nodes that is
at most (dimensionless); more for peak pressures at tips, which converge with the power n - 1 of the nodes. In 160
random scenes it was at most 0.24 for the first two, 1/3 for exponents that approach 1, and 0.6 for the last."""

_OF_ORDER = ("contact_area", "kappa")  # in 250 random scenes the order of convergence told their errors to a tenth
_OVER_ORDER, _HIGHEST = 1.5, 64.0  # of what the order leaves, and the largest ratio of changes that is believed; unless
# n is even, ratios tend to 2^(n + 1), and a larger one is chance
_FEW = 64  # nodes, up to which a third resolution costs nothing

_MOST_STEPS = 40  # of the search for a load; ten are many where the edge layers are resolved
_TENSION = 1e-6  # over the peak pressure; where more pulls the contact is not one patch


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

    num_nodes: Gauss-Chebyshev nodes, even; 160 reach 12 digits for even exponents; for n = 1.5 and 3 the approach has 4
    and 6. Thin layers need about sqrt(a/d) times more and get them, see `RESOLUTION`. Raises `ValueError`,
    also beyond 0.98 of full contact.
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

    def system(a: float) -> System:
        return System.solve(a, exponent, radius, layer, num_nodes, resolution)

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
    num_nodes, resolution, error = 8, 10.0, math.inf
    guess = guessed_half_width(load, exponent, radius, thickness, poisson_ratio)
    results: list[Asperity] = []
    while num_nodes <= MOST_NODES:

        def system(a: float, num_nodes: int = num_nodes, resolution: float = resolution) -> System:
            return System.solve(a, exponent, radius, layer, num_nodes, resolution)

        found = _match(system, load, exponent, guess)
        results.append(found.asperity())
        if len(results) > 2 or (len(results) == 2 and found.num_nodes > _FEW):
            errors = {name: _error(results, exponent, name) for name in MEASURED}
            error = errors[of]
            if error <= accuracy:
                return results[-1], errors
        guess, num_nodes, resolution = found.half_width, 2 * found.num_nodes, 0.0
    raise ValueError(f"accuracy is {accuracy!r}; allowed: more than {error:.1g}, by collocation at {MOST_NODES} nodes")


def _error(results: Sequence[Asperity], exponent: float, name: str) -> float:
    """Relative error of the last result, estimated from the changes from one to the next, each with twice the nodes; at
    least what rounding leaves.
    """
    values = [float(getattr(asperity, name)) for asperity in results[-3:]]
    *before, change = (abs(finer - coarser) for coarser, finer in pairwise(values))
    share = MEASURED[name]
    if name == "peak_pressure":
        share = max(share, _OVER_ORDER / (2 ** (exponent - 1) - 1))
    if name in _OF_ORDER and before and before[0] > change > 0:
        highest = _HIGHEST if exponent % 2 == 0 else min(2 ** (exponent + 1), _HIGHEST)
        share = min(share, _OVER_ORDER / (min(before[0] / change, highest) - 1))
    return max(share * change / abs(values[-1]), 1e-12)


def solve_reduced_thickness(
    load: float, exponent: float, radius: float, reduced_thickness: float, poisson_ratio: float, num_nodes: int = 160
) -> tuple[float, Asperity]:
    """The thickness d (units of L) at which d/a_r has the given value under `load`, and its solution."""
    _check(load, exponent, radius, num_nodes)
    checks.real("reduced_thickness", reduced_thickness, "a finite number > 0", 0)

    def system(a: float) -> System:
        layer = Layer(2 * a * reduced_thickness, poisson_ratio)
        return System.solve(a, exponent, radius, layer, num_nodes, RESOLUTION)

    thin = thin_layer_kappa_ratio(exponent, poisson_ratio, reduced_thickness, max(0.0, edge_shift(poisson_ratio)))
    guess = lone_half_width(load, exponent, radius, 1 / (1 + 1 / thin))
    asperity = _match(system, load, exponent, guess).asperity()
    return reduced_thickness * asperity.contact_area, asperity


def _check(load: float, exponent: float, radius: float, num_nodes: int) -> None:
    checks.real("load", load, "a finite number > 0", 0)
    checks.real("exponent", exponent, "1 < n <= 100", 1, 100)
    checks.real("radius", radius, "a finite number > 0", 0)
    checks.integer("num_nodes", num_nodes, "an even integer from 4 to 10000", 4, 10_000, 2)


def _match(system: Callable[[float], System], load: float, exponent: float, guess: float) -> System:
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
