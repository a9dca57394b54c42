"""Models that are smaller than the scene: a lone asperity without a grid, and the Winkler foundation.

Both give fields on the scene's grid and observables whose errors are their own.

A layer much thinner than its contacts are wide is a Winkler foundation, K = k_W at all wave numbers, and needs no
transform: sigma = k_W (level - h) where that is positive. What it leaves out is the layer's edge, which lies c(nu) d
further out (`ElasticLayer.edge_shift`).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array64, Indices, Mask
from ..grid.edges import Edges
from ..grid.observables import Observables, foundation_modulus, observe, subgrid_measures
from ..grid.patch_table import PatchTable, patch_table
from ..grid.patches import Patches
from ..grid.problem import Problem, Stiffness, foundation_level, squared_slope
from ..layers import ElasticLayer
from ..reference import collocation
from ..reference.closed_forms import foundation_half_width, kappa_from_area, kappa_half_space
from ..scene import Scene

FIELD_POINTS = 2**12
"""Points for the sampled fields of a model without a grid, if that puts enough of them into the contact."""

LEAST_EDGE, _TIMES_SHIFT = 0.6, 3.0
"""What the foundation's two edges may be off by together: this share of the thickness, or so many times the edge shift
if that is more (dimensionless)."""

_FIELD_NODES = 64  # in the contact, for fields that are sampled
_FULL = 0.98  # contact areas above are not those of one asperity any more


@dataclass(frozen=True)
class Modelled:
    """What a smaller model gave."""

    scene: Scene
    """On the grid of the fields."""
    displacement: Array64
    """u, shape (N,) [length]."""
    contact_pressure: Array64
    """sigma, shape (N,) [pressure]."""
    contact: Mask
    """Nodes in contact, shape (N,)."""
    observables: Observables
    """What is measured, with the errors of the model."""
    patches: PatchTable
    """The contact patches."""
    error: float
    """Estimated relative error: by collocation of what the accuracy is asked of, of a foundation that of a_r."""
    problem: Problem | None = None
    """What was solved on that grid; None where the fields are sampled."""


def asperity(scene: Scene, layer: ElasticLayer, accuracy: float, of: str) -> Modelled:
    """One power profile by collocation; its observables come from no grid, the fields are sampled.

    layer: to solve with, the scene's or a half-space that is as good. accuracy: relative, of one of
    `collocation.MEASURED`. Raises `ValueError` where collocation does not get there.
    """
    power, bonded, length, modulus = scene.indenter.power_law, layer.bonded, scene.period, scene.layer.contact_modulus
    assert power is not None
    assert bonded is not None
    shape = power[0], power[1] / length, bonded[0] / length, bonded[1]
    found, errors = collocation.solve_to_accuracy(scene.reduced_load, *shape, accuracy, of)
    scene = _field_scene(scene, found.contact_area)
    n = scene.num_points
    pressure = found.pressure_at((np.arange(n) - n // 2) / n / found.half_width)
    pressure *= scene.pressure / pressure.mean()  # the sampled load is off by the sampling
    problem = Problem.from_scene(scene)
    displacement = problem.displacement_under(pressure / scene.pressure) * problem.length_unit
    profile = scene.profile
    displacement = np.where(pressure > 0, profile, np.minimum(displacement, profile))
    approach = length * found.approach
    if layer is not scene.layer:  # the mean compression of the layer that there is
        approach += length * scene.pressure / modulus / scene.layer.foundation_modulus(length)
    observables, _ = observe(scene, profile, displacement, pressure, pressure > 0)
    observables = _with_area(scene, observables, found.contact_area, errors["contact_area"], errors["kappa"])
    peak = modulus * found.peak_pressure
    patches = _one_patch(scene, found.contact_area, int((pressure > 0).sum()), peak)
    observables = replace(
        observables,
        peak_pressure=peak,
        peak_pressure_sampling=0.0,
        peak_pressure_error=errors["peak_pressure"] * peak if power[0] >= 2 else math.inf,
        approach=approach,
        approach_error=errors["approach"] * length * abs(found.approach),
        mean_gap=float(profile.mean()) - approach + scene.pressure / (foundation_modulus(scene) or math.inf),
    )
    return Modelled(scene, displacement, pressure, pressure > 0, observables, patches, errors[of])


def _one_patch(scene: Scene, area: float, nodes: int, peak: float) -> PatchTable:
    """The patch of a power profile whose contact area is known without a grid; peak: the largest pressure."""
    middle, half, load = scene.num_points // 2 / scene.num_points, area / 2, scene.pressure * scene.period
    ends = ((middle + place) * scene.period for place in (-half, half))
    return PatchTable(*(np.array([float(value)]) for value in (*ends, area * scene.period, nodes, load, peak)))


def _field_scene(scene: Scene, area: float) -> Scene:
    """The scene on a grid for sampled fields: as coarse as `FIELD_POINTS`, or with `_FIELD_NODES` in the contact."""
    num_points = FIELD_POINTS
    while num_points * area < _FIELD_NODES and num_points < scene.num_points:
        num_points *= 2
    return replace(scene, num_points=min(num_points, scene.num_points))


def _with_area(
    scene: Scene, observables: Observables, area: float, area_error: float, kappa_error: float
) -> Observables:
    """Observables of a power profile whose contact area is known without a grid; errors: relative, of the model."""
    power = scene.indenter.power_law
    assert power
    n, radius, load = power[0], power[1] / scene.period, scene.reduced_load
    kappa = kappa_from_area(n, area, radius, load)
    gradient = kappa / area * load
    return replace(
        observables,
        contact_area=area,
        contact_area_subgrid=area,
        contact_area_error=area_error * area,
        contact_area_edges_error=area_error * area,
        rms_gradient_contact=gradient,
        rms_gradient_subgrid=gradient,
        reduced_pressure=load / gradient,
        reduced_thickness=scene.layer.thickness / (area * scene.period),
        kappa=kappa,
        kappa_subgrid=kappa,
        kappa_error=kappa_error * kappa,
        kappa_edges_error=kappa_error * kappa,
        kappa_ratio=kappa / kappa_half_space(n),
        num_patches=1,
        num_counted_patches=0,
        num_patches_by_load=0,
        unseen_gap_area=0.0,
    )


def winkler(scene: Scene) -> Modelled:
    """The scene on a Winkler foundation, for a compressible layer.

    A power profile's area needs no grid, and its fields are sampled.
    """
    foundation, area = scene.layer.foundation_modulus(scene.period), math.inf
    if power := scene.indenter.power_law:
        area = 2 * foundation_half_width(scene.reduced_load, power[0], power[1] / scene.period, foundation)
    sampled = area < _FULL
    scene = _field_scene(scene, area) if sampled else scene
    problem = _foundation(scene)
    modulus, height = float(problem.stiffness[1]), problem.height
    level = foundation_level(height, modulus)
    if sampled and power:  # k_W mean(level - h) = 1
        level = (power[0] + 1) / (power[0] * modulus * area)
    depth = level - height
    pressure, contact = modulus * np.maximum(depth, 0.0) * scene.pressure, depth > 0
    if sampled:
        pressure *= scene.pressure / pressure.mean()  # the sampled load is off by the sampling
    profile = scene.profile
    displacement = np.where(contact, profile, np.minimum(level * problem.length_unit, profile))
    observables, _ = observe(scene, profile, displacement, pressure, contact)
    if sampled:
        assert power
        error = _edges(scene) / area
        observables = _with_area(scene, observables, area, error, power[0] * error)
        peak, approach = modulus * level * scene.pressure, level * problem.length_unit
        observables = replace(observables, peak_pressure=peak, approach=approach)
        patches = _one_patch(scene, area, int(contact.sum()), peak)
    else:
        runs = Patches.of(contact)
        ends = _crossings(runs, depth)
        patches = patch_table(runs, ends, pressure, scene.period)
        observables, change = _measured(scene, observables, runs, ends, height, modulus)
        area = observables.contact_area_subgrid
        unknown = _edges(scene) * observables.num_patches + observables.unseen_gap_area
        error = unknown / area + change + _stiffening(scene) if area else math.inf
        kappa_error = 2 * error * observables.kappa_subgrid
        observables = replace(
            observables,
            contact_area_error=error * area,
            contact_area_edges_error=error * area,
            kappa_error=kappa_error,
            kappa_edges_error=kappa_error,
        )
    return Modelled(scene, displacement, pressure, contact, observables, patches, error, None if sampled else problem)


def _edges(scene: Scene) -> float:
    """What the two edges of a contact on the foundation may be off by together [L]."""
    layer = scene.layer
    assert layer.edge_shift is not None
    return max(LEAST_EDGE * layer.thickness, _TIMES_SHIFT * abs(layer.edge_shift)) / scene.period


def _measured(
    scene: Scene, observables: Observables, patches: Patches, ends: Edges, height: Array64, modulus: float
) -> tuple[Observables, float]:
    """Area and kappa between the places where the depth is 0; the area's relative change on half of the points."""
    squared = squared_slope(scene.indenter, scene.num_points, scene.period)
    area, gradient, kappa, _ = subgrid_measures(scene, patches, ends, squared)
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
        num_patches_by_load=0,
    )
    return found, change


def _foundation(scene: Scene) -> Problem:
    """The discrete problem with K = k_W."""
    problem = Problem.from_scene(scene)
    modulus = scene.layer.foundation_modulus(scene.period) / problem.stiffness_unit
    values = np.append(0.0, np.full(problem.stiffness.size - 1, modulus))
    return replace(problem, rigidity=Stiffness(values, problem.num_points, problem.stiffness_unit))


def _crossings(patches: Patches, depth: Array64) -> Edges:
    """Where the depth, positive on the patches' nodes, crosses 0, between the last node and the next."""
    exact, none = np.zeros((2, patches.count)), np.zeros(patches.count, dtype=bool)
    if patches.full:
        half = np.full(1, 0.5)
        return Edges(patches.first - half, patches.last + half, exact, none, none, none)

    def beyond(node: Indices, step: int) -> Array64:
        here, there = depth[node % depth.size], depth[(node + step) % depth.size]
        return np.asarray(here / (here - there))

    left, right = patches.first - beyond(patches.first, -1), patches.last + beyond(patches.last, 1)
    return Edges(left, right, exact, none, none, none)


def _stiffening(scene: Scene) -> float:
    """By how much the layer's stiffness for the profile's shortest wave differs from its foundation's, relative."""
    shortest, layer = scene.indenter.shortest_wave(scene.num_points), scene.layer
    if not shortest:
        return 0.0  # smooth
    stiffness = layer.stiffness(np.array([2 * np.pi * shortest]), scene.period)
    return abs(float(stiffness[0] / layer.foundation_modulus(scene.period) - 1))
