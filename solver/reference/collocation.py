"""One asperity on a layer of any thickness, solved without a grid: errors of grid methods are measured by it.

The half-width is searched for at which the solution of `gradient_equation` carries the load. Units here: L = E* = 1.
"""

import math
from collections.abc import Callable

from .. import checks
from ..layers import ElasticLayer, Layer
from .closed_forms import guessed_half_width, lone_half_width, thin_layer_kappa_ratio
from .gradient_equation import Asperity as Asperity
from .gradient_equation import System

RESOLUTION = 40.0
"""Nodes over sqrt(a/d), each half: resolves the edge layers of width d to 1e-10, next to nu = 1/2 and under blunt
indenters on the thinnest layers that fit in memory to 1e-4.
"""

MOST_NODES = 2048
"""Of `solve_to_accuracy`: half a second."""

MEASURED = ("contact_area", "kappa", "peak_pressure", "approach")
"""The quantities whose errors `solve_to_accuracy` estimates."""

_TENSION = 1e-6  # over the peak pressure; where more pulls the contact is not one patch


def solve_layer(
    layer: ElasticLayer,
    load: float,
    exponent: float,
    radius: float,
    num_nodes: int = 160,
    resolution: float = RESOLUTION,
) -> Asperity:
    """The asperity under the mean pressure `load` on any layer whose K(q) approaches E* q/2 like exp(-2 q d), with
    E* = 1, lengths in units of L.

    num_nodes: Gauss-Chebyshev nodes, even; 160 reach 12 digits for even exponents; for n = 1.5 and 3 the approach has 4
    and 6. Thin layers need about sqrt(a/d) times more and get them, see `RESOLUTION`. Raises `ValueError`, also beyond
    0.98 of full contact, and where the contact would have to pull, because it splits, as it may on a coating much
    stiffer than its base.
    """
    found = _first_match(layer, load, exponent, radius, num_nodes, resolution).asperity()
    lowest = float(found.pressure.min())
    if lowest < -_TENSION * found.peak_pressure:
        tension = f"there is tension of {-lowest / found.peak_pressure:.2g} of the peak pressure in the contact"
        allowed = "one under which the contact does not split, or more num_nodes"
        raise ValueError(f"load is {load!r}; allowed: {allowed}: {tension}")
    return found


def solve_to_accuracy(
    layer: ElasticLayer, load: float, exponent: float, radius: float, accuracy: float, of: str = "contact_area"
) -> tuple[Asperity, dict[str, float]]:
    """As `solve_layer`, without its look for tension, and the estimated relative errors of `MEASURED`, that of `of` at
    most `accuracy`.

    Raises `ValueError` where `MOST_NODES` are too few.
    """
    system = _first_match(layer, load, exponent, radius, 32, 10.0)
    found, error = system.asperity(), math.inf
    while 2 * system.num_nodes <= MOST_NODES:
        system = _match(load, exponent, radius, lambda _: layer, system.half_width, 2 * system.num_nodes, 0.0)
        coarser, found = found, system.asperity()
        errors = {name: _error(coarser, found, exponent, name) for name in MEASURED}
        error = errors[of]
        if error <= accuracy:
            return found, errors
    raise ValueError(f"accuracy is {accuracy!r}; allowed: more than {error:.1g}, by collocation at {MOST_NODES} nodes")


def _error(coarser: Asperity, finer: Asperity, exponent: float, name: str) -> float:
    """Relative error of the finer result, at least that of rounding: from the change by the last doubling, and a
    cautious order of convergence. Area and kappa converge with about the power n + 1 of the nodes or faster, approaches
    with n, and peak pressures at tips with n - 1.
    """
    of_area = name in ("contact_area", "kappa")
    order = min(exponent, 2.0) if of_area else min(exponent - 1, 1.0) if name == "peak_pressure" else 1.0
    change = abs(float(getattr(coarser, name)) / float(getattr(finer, name)) - 1)
    return max(change / (2**order - 1), 1e-12)


def solve_reduced_thickness(
    load: float, exponent: float, radius: float, reduced_thickness: float, poisson_ratio: float, num_nodes: int = 160
) -> tuple[float, Asperity]:
    """The thickness d (units of L) at which d/a_r has the given value under `load`, and its solution."""
    _check(load, exponent, radius, num_nodes)
    checks.real("reduced_thickness", reduced_thickness, "a finite number > 0", 0)
    thin = thin_layer_kappa_ratio(exponent, poisson_ratio, reduced_thickness)
    guess = lone_half_width(load, exponent, radius, 1 / (1 + 1 / thin))

    def layer(a: float) -> Layer:
        return Layer(2 * a * reduced_thickness, poisson_ratio)

    asperity = _match(load, exponent, radius, layer, guess, num_nodes, RESOLUTION).asperity()
    return reduced_thickness * asperity.contact_area, asperity


def _check(load: float, exponent: float, radius: float, num_nodes: int) -> None:
    checks.real("load", load, "a finite number > 0", 0)
    checks.real("exponent", exponent, "1 < n <= 100", 1, 100)
    checks.real("radius", radius, "a finite number > 0", 0)
    checks.integer("num_nodes", num_nodes, "an even integer from 4 to 10000", 4, 10_000, 2)


def _first_match(
    layer: ElasticLayer, load: float, exponent: float, radius: float, num_nodes: int, resolution: float
) -> System:
    """As `_match`, from a closed form's half-width; where the layer has none, from that on a half-space."""
    _check(load, exponent, radius, num_nodes)
    shape = load, exponent, radius
    guess = guessed_half_width(*shape, layer) if layer.bonded else lone_half_width(*shape)
    return _match(load, exponent, radius, lambda _: layer, guess, num_nodes, resolution)


def _match(
    load: float,
    exponent: float,
    radius: float,
    layer: Callable[[float], ElasticLayer],
    guess: float,
    num_nodes: int,
    resolution: float,
) -> System:
    """Root of load(a) = `load` by secants in log-log, where it is nearly a power law; bisection as a safeguard.

    layer: by the half-width.
    """
    low, high = math.log(guess) - 100, math.log(0.49)
    y, slope, before = min(math.log(guess), math.log(0.45)), exponent + 1.0, (math.nan, math.nan)
    while True:
        a = math.exp(y)
        best = System(a, exponent, radius, layer(a), num_nodes, resolution)
        error = math.log(best.load / load) if best.load > 0 else math.inf
        if abs(error) < 1e-13:
            return best
        low, high = (low, y) if error > 0 else (y, high)
        if math.isfinite(before[1]):
            slope = (error - before[1]) / (y - before[0])
        step, before = y - error / slope if slope else math.nan, (y, error)
        new = step if low < step < high else (low + high) / 2
        if abs(new - y) < 4e-16 * abs(y):
            break
        y = new
    if y > math.log(0.489):
        raise checks.refusal("load", load, f"below {best.load:.6g}, where the contact fills 0.98 of the period")
    if not abs(error) < 1e-9:
        raise ValueError(f"num_nodes is {best.num_nodes}; allowed: more, the edge layers are not resolved")
    return best
