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
from .closed_forms import edge_shift, foundation_half_width, kappa_from_area, kappa_half_space
from .edges import Edges
from .indenters import PowerIndenter, RoughIndenter
from .observables import Observables, observe, subgrid_measures
from .patches import Patches
from .problem import Problem, foundation_level
from .scene import Layer, Scene
from .stiffness import foundation_modulus, stiffness

Array64 = NDArray[np.float64]

FIELD_POINTS = 2**12
"""Points for the sampled fields of a model without a grid, if that puts enough of them into the contact."""

LEAST_EDGE = 0.6
"""What the foundation's edges may be off by together, over the thickness, at least; else three times c(nu)."""

_FIELD_NODES = 64


@dataclass(frozen=True)
class Modelled:
    """scene: on the fields' grid; displacement [length], contact_pressure [pressure], contact: shape (N,).

    error: of a_r, relative; problem: what was solved on that grid, None where the fields are sampled.
    """

    scene: Scene
    displacement: Array64
    contact_pressure: Array64
    contact: NDArray[np.bool_]
    observables: Observables
    error: float
    problem: Problem | None = None


def asperity(scene: Scene, layer: Layer, accuracy: float) -> Modelled:
    """One power profile by collocation; its observables come from no grid, the fields are sampled.

    layer: to solve with, the scene's or a half-space that is as good. Raises `ValueError` where collocation does not
    get there.
    """
    power, length, modulus = scene.indenter, scene.period, scene.layer.contact_modulus
    assert isinstance(power, PowerIndenter)
    shape = power.exponent, power.radius / length, layer.thickness / length, layer.poisson_ratio
    found, error = collocation.solve_to_accuracy(scene.pressure / modulus, *shape, accuracy)
    scene = _field_scene(scene, found.contact_area)
    n = scene.num_points
    pressure = found.pressure_at((np.arange(n) - n // 2) / n / found.half_width)
    pressure *= scene.pressure / pressure.mean()  # the sampled load is off by the sampling
    problem = Problem.from_scene(scene)
    displacement = problem.displacement_under(pressure / scene.pressure) * problem.length_unit
    displacement = np.where(pressure > 0, scene.profile, np.minimum(displacement, scene.profile))
    approach = length * found.approach
    if layer is not scene.layer:  # the mean compression of the layer that there is
        approach += length * scene.pressure / modulus / _modulus(scene)
    observables = _with_area(scene, observe(scene, displacement, pressure, pressure > 0), found.contact_area, error)
    observables = replace(observables, peak_pressure=modulus * found.peak_pressure, approach=approach)
    return Modelled(scene, displacement, pressure, pressure > 0, observables, error)


def _field_scene(scene: Scene, area: float) -> Scene:
    """The scene on a grid for sampled fields: as coarse as `FIELD_POINTS`, or with `_FIELD_NODES` in the contact."""
    num_points = FIELD_POINTS
    while num_points * area < _FIELD_NODES and num_points < scene.num_points:
        num_points *= 2
    return replace(scene, num_points=min(num_points, scene.num_points))


def _with_area(scene: Scene, observables: Observables, area: float, error: float) -> Observables:
    """Observables of a power profile whose contact area is known without a grid; error: relative."""
    power = scene.indenter
    assert isinstance(power, PowerIndenter)
    n, radius, load = power.exponent, power.radius / scene.period, scene.pressure / scene.layer.contact_modulus
    kappa = kappa_from_area(n, area, radius, load)
    gradient = kappa / area * load
    return replace(
        observables,
        contact_area=area,
        contact_area_subgrid=area,
        contact_area_error=error * area,
        rms_gradient_contact=gradient,
        rms_gradient_subgrid=gradient,
        reduced_pressure=load / gradient,
        reduced_thickness=scene.layer.thickness / (area * scene.period),
        kappa=kappa,
        kappa_subgrid=kappa,
        kappa_error=n * error * kappa,
        kappa_ratio=kappa / kappa_half_space(n),
        num_patches=1,
        num_counted_patches=0,
    )


def winkler(scene: Scene) -> Modelled:
    """The scene on a Winkler foundation, nu < 1/2. A power profile's area needs no grid, its fields are sampled."""
    area = math.inf
    if isinstance(power := scene.indenter, PowerIndenter):
        load, radius = scene.pressure / scene.layer.contact_modulus, power.radius / scene.period
        area = 2 * foundation_half_width(load, power.exponent, radius, _modulus(scene))
    sampled = area < 0.98
    scene = _field_scene(scene, area) if sampled else scene
    problem = _foundation(scene)
    modulus, height = float(problem.stiffness[1]), problem.height
    if sampled and isinstance(power, PowerIndenter):  # k_W mean(level - h) = 1
        level = (power.exponent + 1) / (power.exponent * modulus * area)
    else:
        level = foundation_level(height, modulus)
    depth = level - height
    pressure, contact = modulus * np.maximum(depth, 0.0) * scene.pressure, depth > 0
    if sampled:
        pressure *= scene.pressure / pressure.mean()  # the sampled load is off by the sampling
    displacement = np.where(contact, scene.profile, np.minimum(level * problem.length_unit, scene.profile))
    observables = observe(scene, displacement, pressure, contact)
    edges = 3 * max(LEAST_EDGE / 3, abs(edge_shift(scene.layer.poisson_ratio))) * scene.layer.thickness / scene.period
    if sampled:
        error = edges / area
        observables = _with_area(scene, observables, area, error)
        peak, approach = modulus * level * scene.pressure, level * problem.length_unit
        observables = replace(observables, peak_pressure=peak, approach=approach)
    else:
        observables, change = _measured(scene, observables, height, depth, modulus)
        area = observables.contact_area_subgrid
        error = edges * observables.num_patches / area + change + _stiffening(scene) if area else math.inf
        slack = 2 * error * observables.kappa_subgrid
        observables = replace(observables, contact_area_error=error * area, kappa_error=slack)
    return Modelled(scene, displacement, pressure, contact, observables, error, None if sampled else problem)


def _measured(
    scene: Scene, observables: Observables, height: Array64, depth: Array64, modulus: float
) -> tuple[Observables, float]:
    """Area and kappa between the places where the depth is 0; the area's relative change on half of the points."""
    patches, slope = Patches.of(depth > 0), scene.indenter.slope(scene.num_points, scene.period)
    area, gradient, kappa, _ = subgrid_measures(scene, patches, _crossings(patches, depth), slope**2)
    change = 0.0
    for half in (height[::2], height[1::2]):
        below = foundation_level(half, modulus) - half
        width = float(_crossings(Patches.of(below > 0), below).width.sum())
        change = max(change, abs(width / half.size / area - 1)) if area else math.inf
    found = replace(
        observables,
        contact_area_subgrid=area,
        rms_gradient_subgrid=gradient,
        kappa_subgrid=kappa,
        num_counted_patches=0,
    )
    return found, change


def _foundation(scene: Scene) -> Problem:
    """The discrete problem with K = k_W."""
    problem = Problem.from_scene(scene)
    modulus = _modulus(scene) / problem.stiffness_unit
    return replace(problem, stiffness=np.append(0.0, np.full(problem.stiffness.size - 1, modulus)))


def _modulus(scene: Scene) -> float:
    """k_W [E*/L]."""
    return foundation_modulus(scene.layer.thickness / scene.period, scene.layer.poisson_ratio)


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
