"""The families of scenes, and their exact results: collocation, or rough surfaces on a finer grid."""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from linecontact.solver import Layer, PowerIndenter, RoughIndenter, Scene, Status, solve
from linecontact.solver.arrays import Array64
from linecontact.solver.reference import collocation
from linecontact.solver.reference.collocation import Asperity

from ..runner.tasks import Record

FAMILIES = {
    "Hertz, half-space": (False, math.inf),
    "Hertz, d = 0.01 L": (False, 0.01),
    "rough, half-space": (True, math.inf),
    "rough, d = 0.01 L": (True, 0.01),
}
"""Whether rough, and the layer's thickness over the period, by name."""

COARSEST_ROUGH = 12
"""log2 of the points that hold the rough surface, with four points to its shortest wave."""

_SHIFTS = (1.0, 1.03, 1.07, 1.11, 1.13)
_SEEDS = (0, 1, 2)
_FINEST_SAMPLED = 2**20

MEASURES = ("area", "area_counted", "kappa", "peak", "field")
"""Quantities with errors; area and kappa between sub-grid edges; field: of the pressure, rms error over its rms."""

_NODES, _RESOLUTION = 320, 80.0  # twice those that reach 1e-10


@dataclass(frozen=True)
class Exact:
    """The numbers that count as exact; all dimensionless, L = E* = 1."""

    contact_area: float
    """a_r."""
    kappa: float
    """kappa."""
    peak_pressure: float
    """Largest contact pressure."""
    pressure: Callable[[int], Array64]
    """From a number of points N to the contact pressure, shape (N,)."""
    error: float
    """Relative error that is left in the contact area."""

    def errors(self, area_counted: float, area: float, kappa: float, peak: float, pressure: Array64) -> Record:
        """Relative errors, absolute values, by the names of `MEASURES`; pressure: field, shape (N,)."""
        truth = self.pressure(pressure.size)
        values = {
            "area": area / self.contact_area - 1,
            "area_counted": area_counted / self.contact_area - 1,
            "kappa": kappa / self.kappa - 1,
            "peak": peak / self.peak_pressure - 1,
            "field": math.sqrt(float(np.mean((pressure - truth) ** 2) / np.mean(truth**2))),
        }
        return {name: abs(value) for name, value in values.items()}


def is_rough(family: str) -> bool:
    """Whether the surface is rough."""
    return FAMILIES[family][0]


def variants(family: str) -> range:
    """Numbers of a family's variants: slightly different loads, or surfaces.

    With several of them, an edge that happens to lie next to a node makes no choice look better than it is.
    """
    return range(len(_SEEDS if is_rough(family) else _SHIFTS))


def make_scene(family: str, log2_points: int, precision: str = "float64", variant: int = 0) -> Scene:
    """A scene of a family."""
    rough, thickness = FAMILIES[family]
    indenter = RoughIndenter(0.8, _SEEDS[variant], 1 / 8, 1 / 128) if rough else PowerIndenter()
    load = 1e-2 if rough else 2e-3 * _SHIFTS[variant]
    return Scene(Layer(thickness), indenter, load, num_points=2**log2_points, precision=precision)


def asperity(family: str, variant: int, num_nodes: int, resolution: float) -> Asperity:
    """A smooth family's scene by collocation; arguments as for `collocation.solve_layer`."""
    scene = make_scene(family, 8, variant=variant)
    return collocation.solve_layer(scene.layer, scene.pressure, 2.0, 1.0, num_nodes, resolution)


@functools.cache
def exact(family: str, variant: int, reference: int) -> Exact:
    """The exact solution of a family's scene.

    reference: log2 of the points of the grid that stands in for it where collocation is not possible, solved to a
    certified residual of 1e-8.
    """
    if not is_rough(family):
        found = asperity(family, variant, _NODES, _RESOLUTION)

        @functools.cache
        def sampled(num_points: int) -> Array64:
            return sample(found, num_points)

        return Exact(found.contact_area, found.kappa, found.peak_pressure, sampled, 0.0)
    solution = solve(make_scene(family, reference, variant=variant), tolerance=1e-8)
    if solution.status is not Status.CONVERGED:
        raise RuntimeError(f"the reference on 2^{reference} points is not certified: {solution.status}")
    o = solution.observables
    field = solution.contact_pressure[:: max(1, 2**reference // _FINEST_SAMPLED)].copy()

    def thinned(num_points: int) -> Array64:
        return field[:: field.size // num_points]

    error = o.contact_area_error / o.contact_area_subgrid
    return Exact(o.contact_area_subgrid, o.kappa_subgrid, o.peak_pressure, thinned, error)


def sample(found: Asperity, num_points: int) -> Array64:
    """Collocation's contact pressure on a grid, shape (N,)."""
    return found.pressure_at((np.arange(num_points) / num_points - 0.5) / found.half_width)
