"""Models that are smaller than the scene: a lone asperity without a grid, and the Winkler foundation.

Both give fields on the scene's grid and observables whose errors are their own.

A layer much thinner than its contacts are wide is a Winkler foundation, K = k_W at all wave numbers, and needs no
transform: sigma = k_W (level - h) where that is positive. What it leaves out is the layer's edge, which lies c(nu) d
further out (`closed_forms.edge_shift`).
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from . import collocation
from .closed_forms import edge_shift, kappa_from_area
from .edges import Edges
from .indenters import PowerIndenter, RoughIndenter
from .observables import Observables, observe, subgrid_measures
from .patches import Patches
from .problem import Problem, foundation_level
from .scene import Layer, Scene
from .stiffness import foundation_modulus, stiffness

Array64 = NDArray[np.float64]


@dataclass(frozen=True)
class Modelled:
    """scene: on the fields' grid; displacement [length], contact_pressure [pressure], contact: shape (N,).

    error: of a_r, relative; least: the part of it that no finer grid takes away.
    """

    scene: Scene
    displacement: Array64
    contact_pressure: Array64
    contact: NDArray[np.bool_]
    observables: Observables
    error: float
    least: float = 0.0


def asperity(scene: Scene, layer: Layer, accuracy: float) -> Modelled:
    """One power profile by collocation; its observables come from no grid, the fields are sampled.

    layer: to solve with, the scene's or a half-space that is as good. Raises `ValueError` where collocation does not
    get there.
    """
    power, length, modulus = scene.indenter, scene.period, scene.layer.contact_modulus
    assert isinstance(power, PowerIndenter)
    found, error = collocation.solve_to_accuracy(
        scene.pressure / modulus,
        power.exponent,
        power.radius / length,
        layer.thickness / length,
        layer.poisson_ratio,
        accuracy,
    )
    centred = np.arange(scene.num_points) / scene.num_points - 0.5
    pressure = modulus * found.pressure_at(centred / found.half_width)
    problem = Problem.from_scene(scene)
    displacement = problem.displacement_under(pressure / scene.pressure) * problem.length_unit
    displacement = np.where(pressure > 0, scene.profile, displacement)
    observables = _with_area(scene, observe(scene, displacement, pressure, pressure > 0), found.contact_area, error)
    approach = length * found.approach
    if layer is not scene.layer:  # the mean compression of the layer that there is
        rigid = foundation_modulus(scene.layer.thickness / length, scene.layer.poisson_ratio)
        approach += length * scene.pressure / modulus / rigid
    observables = replace(observables, peak_pressure=modulus * found.peak_pressure, approach=approach)
    return Modelled(scene, displacement, pressure, pressure > 0, observables, error)


def _with_area(scene: Scene, observables: Observables, area: float, error: float) -> Observables:
    """Observables of a power profile whose contact area is known otherwise; error: relative."""
    power = scene.indenter
    assert isinstance(power, PowerIndenter)
    n, radius, load = power.exponent, power.radius / scene.period, scene.pressure / scene.layer.contact_modulus
    kappa = kappa_from_area(n, area, radius, load)
    return replace(
        observables,
        contact_area_subgrid=area,
        contact_area_error=error * area,
        rms_gradient_subgrid=kappa / area * load,
        kappa_subgrid=kappa,
        kappa_error=n * error * kappa,
        num_counted_patches=0,
    )


def winkler_half_width(scene: Scene) -> float:
    """Half-width of a power profile on the layer's Winkler foundation, in units of L; `inf` where there is none."""
    power, layer = scene.indenter, scene.layer
    assert isinstance(power, PowerIndenter)
    modulus = foundation_modulus(layer.thickness / scene.period, layer.poisson_ratio)
    if not 0 < modulus < math.inf:
        return math.inf
    n, load = power.exponent, scene.pressure / layer.contact_modulus
    return float((load * (n + 1) / (2 * modulus) * (power.radius / scene.period) ** (n - 1)) ** (1 / (n + 1)))


def winkler(scene: Scene) -> Modelled:
    """The scene on a Winkler foundation, nu < 1/2."""
    problem = foundation(scene)
    height, n, modulus = problem.height, scene.num_points, float(problem.stiffness[1])
    level = foundation_level(height, modulus)
    displacement = np.minimum(height, level)
    pressure = np.maximum(modulus * (level - height), 0.0)
    contact = pressure > 0
    scaled = pressure * scene.pressure
    observables = observe(scene, np.where(contact, scene.profile, displacement * problem.length_unit), scaled, contact)
    patches = Patches.of(contact)
    ends = _crossings(patches, level - height)
    area, gradient, kappa, sensitivity = subgrid_measures(
        scene, patches, ends, scene.indenter.slope(n, scene.period) ** 2
    )
    coarse = foundation_level(height[::2], modulus)
    rough = Patches.of(height[::2] < coarse)
    change = abs(2 * float(_crossings(rough, coarse - height[::2]).width.sum()) / n - area)
    shift = max(0.2, abs(edge_shift(scene.layer.poisson_ratio))) * scene.layer.thickness / scene.period
    least = 3 * shift * patches.count / area + _stiffening(scene)
    error = least + change / area
    observables = replace(
        observables,
        contact_area_subgrid=area,
        contact_area_error=error * area,
        rms_gradient_subgrid=gradient,
        kappa_subgrid=kappa,
        kappa_error=sensitivity * error * area,
        num_counted_patches=0,
    )
    if isinstance(scene.indenter, PowerIndenter) and not patches.full:
        area = 2 * winkler_half_width(scene)
        error = least = 3 * shift / area
        observables = _with_area(scene, observables, area, error)
    return Modelled(scene, displacement * problem.length_unit, scaled, contact, observables, error, least)


def foundation(scene: Scene) -> Problem:
    """The discrete problem with K = k_W."""
    problem = Problem.from_scene(scene)
    modulus = foundation_modulus(scene.layer.thickness / scene.period, scene.layer.poisson_ratio)
    return replace(problem, stiffness=np.append(0.0, np.full(problem.stiffness.size - 1, modulus)))


def _crossings(patches: Patches, depth: Array64) -> Edges:
    """Where the depth, positive on the patches' nodes, crosses 0, between the last node and the next."""
    none = np.zeros(patches.count)
    if patches.full:
        half = np.full(1, 0.5)
        return Edges(patches.first - half, patches.last + half, none, none > 0)

    def beyond(node: NDArray[np.int64], step: int) -> Array64:
        here, there = depth[node % depth.size], depth[(node + step) % depth.size]
        return np.asarray(here / (here - there))

    return Edges(patches.first - beyond(patches.first, -1), patches.last + beyond(patches.last, 1), none, none > 0)


def _stiffening(scene: Scene) -> float:
    """By how much the layer's stiffness for the profile's shortest wave differs from its foundation's, relative."""
    if isinstance(scene.indenter, PowerIndenter):
        return 0.0  # smooth
    shortest = scene.indenter.shortest if isinstance(scene.indenter, RoughIndenter) else scene.num_points // 2
    thickness, nu = scene.layer.thickness / scene.period, scene.layer.poisson_ratio
    return abs(float(stiffness(2 * shortest, thickness, nu)[-1] / foundation_modulus(thickness, nu) - 1))
