"""Models that are smaller than the scene: a lone asperity without a grid, and the Winkler foundation.

Both give fields on a grid and observables with errors of their own: the foundation of contact area and kappa alone,
collocation of all, except the pressure at the tip of a profile sharper than a parabola.

A layer much thinner than its contacts are wide is a Winkler foundation, K = k_W at all wave numbers, and needs no
transform: sigma = k_W (level - h) where that is positive. What it leaves out is the layer's edge, which lies c(nu) d
further out (`ElasticLayer.edge_shift`).
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..arrays import Array64, Indices
from ..endings import Status
from ..grid.certificate import certify
from ..grid.edges import Edges
from ..grid.observables import Observables, foundation_modulus, observe, subgrid_measures
from ..grid.patch_table import PatchTable, patch_table
from ..grid.patches import Patches
from ..grid.problem import Problem, foundation_level
from ..grid.response import LayerResponse
from ..reference import collocation
from ..reference.closed_forms import foundation_half_width, kappa_from_area, kappa_half_space
from ..scene import Scene
from ..solution import Choice, Solution
from .errors import DEFAULT_QUANTITY, QUANTITIES, sensitivity
from .report import make_solution
from .run import Run

_LEAST_EDGE, _TIMES_SHIFT = 0.6, 3.0
"""What the foundation's two edges may be off by together: this share of the thickness, or so many times the edge shift
if that is more (dimensionless)."""

_LONG_ASPERITY = 100.0  # half-width over thickness above which collocation takes longer than a grid
_FIELD_POINTS = 2**12  # of sampled fields, whose contact has at least the square root of it
_FULL = 0.98  # contact areas above are not those of one asperity any more


def decide(scene: Scene, accuracy: float, of: str = DEFAULT_QUANTITY) -> tuple[str, ...]:
    """The models worth trying before the grid, from what is known without solving anything: a choice from `MODELS`."""
    layer, power, models = scene.layer, scene.indenter.power_law, []
    thickness = layer.thickness / scene.period
    half_width = scene.indenter.guessed_half_width(scene.reduced_load, layer, scene.period)
    thin = _LEAST_EDGE * thickness < 2 * half_width * accuracy and layer.foundation_modulus(scene.period) < math.inf
    if thin and layer.edge_shift is not None and QUANTITIES[of].of_area:
        models.append("winkler")
    known = power and (power[0] >= 2 or of != "peak-pressure")
    if known and layer.bonded and half_width < min(_FULL / 2, _LONG_ASPERITY * thickness):
        models.append("asperity")
    return tuple(models)


def asperity(run: Run, accuracy: float, of: str) -> Solution | None:
    """One power profile by collocation; its observables come from no grid, the fields are sampled.

    None where collocation does not get there.
    """
    scene = run.scene
    power, bonded, length, modulus = (
        scene.indenter.power_law,
        scene.layer.bonded,
        scene.period,
        scene.layer.contact_modulus,
    )
    assert power is not None
    assert bonded is not None
    shape, quantity = (power[0], power[1] / length, bonded[0] / length, bonded[1]), of.replace("-", "_")
    try:
        found, errors = collocation.solve_to_accuracy(scene.reduced_load, *shape, accuracy / 2, quantity)
    except ValueError as error:
        run.choices.append(Choice("collocation", "no", str(error)))
        return None
    scene = _field_scene(scene, found.contact_area)
    n, problem, profile = scene.num_points, Problem.from_scene(scene), scene.profile
    pressure = found.pressure_at((np.arange(n) - n // 2) / n / found.half_width)
    pressure /= pressure.mean()  # the sampled load is off by the sampling
    displacement = problem.displacement_under(pressure) * problem.length_unit
    displacement = np.where(pressure > 0, profile, np.minimum(displacement, profile))
    pressure *= scene.pressure
    approach, peak = length * found.approach, modulus * found.peak_pressure
    area_errors = errors["contact_area"], errors["kappa"]
    observables, patches = _of_power_law(scene, displacement, pressure, found.contact_area, area_errors, peak, approach)
    observables = replace(
        observables,
        peak_pressure_sampling=0.0,
        peak_pressure_error=errors["peak_pressure"] * peak if power[0] >= 2 else math.inf,
        approach_error=errors["approach"] * abs(approach),
        mean_gap=float(profile.mean()) - approach + scene.pressure / (foundation_modulus(scene) or math.inf),
    )
    reason = "a power profile is one asperity; error: from the change by the last doubling of the nodes"
    run.choices += [
        Choice("model", "collocation", reason, errors[quantity]),
        Choice("grid", f"{n} points", "for the fields only, which are sampled"),
    ]
    if power[0] < 2:
        tip = "rough: too low at a tip sharper than a parabola"
        run.choices.append(Choice("peak pressure", "by collocation", tip))
    run.status = Status.CONVERGED
    return make_solution(run, scene, "collocation", displacement, pressure, pressure > 0, observables, patches)


def _field_scene(scene: Scene, area: float) -> Scene:
    """The scene on a grid for sampled fields, no finer than its own."""
    num_points = _FIELD_POINTS
    while num_points * area < math.sqrt(_FIELD_POINTS) and num_points < scene.num_points:
        num_points *= 2
    return replace(scene, num_points=min(num_points, scene.num_points))


def _of_power_law(
    scene: Scene,
    displacement: Array64,
    pressure: Array64,
    area: float,
    errors: tuple[float, float],
    peak: float,
    approach: float,
) -> tuple[Observables, PatchTable]:
    """Observables and the patch of a power profile whose contact area is known without a grid.

    displacement, pressure: sampled, shape (N,) [length], [pressure]; errors: of area and kappa, relative, of the model;
    peak: the largest pressure.
    """
    power = scene.indenter.power_law
    assert power
    observables, _ = observe(scene, scene.profile, displacement, pressure, pressure > 0)
    load, period = scene.reduced_load, scene.period
    kappa = kappa_from_area(power[0], area, power[1] / period, load)
    gradient = kappa / area * load
    observables = replace(
        observables,
        contact_area=area,
        contact_area_subgrid=area,
        contact_area_error=errors[0] * area,
        contact_area_edges_error=errors[0] * area,
        rms_gradient_contact=gradient,
        rms_gradient_subgrid=gradient,
        reduced_pressure=load / gradient,
        reduced_thickness=scene.layer.thickness / (area * period),
        kappa=kappa,
        kappa_subgrid=kappa,
        kappa_error=errors[1] * kappa,
        kappa_edges_error=errors[1] * kappa,
        kappa_ratio=kappa / kappa_half_space(power[0]),
        num_patches=1,
        num_counted_patches=0,
        num_patches_by_load=0,
        unseen_gap_area=0.0,
        peak_pressure=peak,
        approach=approach,
    )
    middle, nodes = scene.num_points // 2 / scene.num_points, np.count_nonzero(pressure)
    ends = ((middle + place) * period for place in (-area / 2, area / 2))
    table = np.array([*ends, area * period, nodes, scene.pressure * period, peak], dtype=np.float64)
    return observables, PatchTable(*table[:, None])


def winkler(run: Run, accuracy: float, of: str) -> Solution | None:
    """The scene on a Winkler foundation, for a compressible layer; None where that is not accurate enough.

    A power profile's area needs no grid, and its fields are sampled. On the grid the answer is certified with the
    foundation's stiffness.
    """
    scene, quantity = run.scene, QUANTITIES[of]
    foundation, area = scene.layer.foundation_modulus(scene.period), math.inf
    if power := scene.indenter.power_law:
        area = 2 * foundation_half_width(scene.reduced_load, power[0], power[1] / scene.period, foundation)
    sampled = area < _FULL
    scene = _field_scene(scene, area) if sampled else scene
    problem, profile, certificate = _foundation(scene), scene.profile, None
    modulus, height = float(problem.stiffness[1]), problem.height
    level = foundation_level(height, modulus)
    if sampled and power:  # k_W mean(level - h) = 1
        level = (power[0] + 1) / (power[0] * modulus * area)
    depth = level - height
    pressure, contact = modulus * np.maximum(depth, 0.0) * scene.pressure, depth > 0
    displacement = np.where(contact, profile, np.minimum(level * problem.length_unit, profile))
    if sampled and power:
        pressure *= scene.pressure / pressure.mean()  # the sampled load is off by the sampling
        errors, peak = (_edges(scene) / area, power[0] * _edges(scene) / area), modulus * level * scene.pressure
        approach = level * problem.length_unit
        observables, patches = _of_power_law(scene, displacement, pressure, area, errors, peak, approach)
    else:
        runs = Patches.of(contact)
        ends = _crossings(runs, depth)
        patches = patch_table(runs, ends, pressure, scene.period)
        observables, _ = observe(scene, profile, displacement, pressure, contact)
        observables = _measured(scene, observables, runs, ends, height, modulus)
        certificate = certify(problem, np.where(contact, height, displacement / problem.length_unit))[0]
    value, error = abs(getattr(observables, quantity.value)), getattr(observables, quantity.error)
    if not error <= accuracy * value:
        share = error / value if value else math.inf
        off = f"its {of.replace('-', ' ')} would be off by a share of {share:.1g}"
        run.choices.append(Choice("Winkler foundation", "no", off))
        return None
    error = sensitivity(quantity, scene) * observables.contact_area_error / observables.contact_area_subgrid
    run.choices += [
        Choice("model", "Winkler foundation", "the layer's edges are narrow", error),
        Choice("grid", f"{scene.num_points} points", "no transform is needed"),
    ]
    run.status, name = Status.CONVERGED, "winkler-foundation"
    return make_solution(run, scene, name, displacement, pressure, contact, observables, patches, certificate)


MODELS: dict[str, Callable[[Run, float, str], Solution | None]] = {"winkler": winkler, "asperity": asperity}
"""By name: tried in this order before the grid, with the accuracy asked for, and of which of `QUANTITIES`."""


def _edges(scene: Scene) -> float:
    """What the two edges of a contact on the foundation may be off by together [L]."""
    layer = scene.layer
    return max(_LEAST_EDGE * layer.thickness, _TIMES_SHIFT * abs(layer.edge_shift or 0.0)) / scene.period


def _measured(
    scene: Scene, observables: Observables, patches: Patches, ends: Edges, height: Array64, modulus: float
) -> Observables:
    """Area and kappa between the places where the depth is 0; errors by edges, gaps and a grid of half the points."""
    area, gradient, kappa, _ = subgrid_measures(scene, patches, ends)
    error, layer, shortest = math.inf, scene.layer, scene.indenter.shortest_wave(scene.num_points)
    stiffening = 0.0  # for the profile's shortest wave, relative
    if shortest:
        stiffness = layer.stiffness(np.array([2 * np.pi * shortest]), scene.period)
        stiffening = abs(float(stiffness[0] / layer.foundation_modulus(scene.period) - 1))
    if area:
        halves = ((half, foundation_level(half, modulus) - half) for half in (height[::2], height[1::2]))
        widths = [float(_crossings(Patches.of(below > 0), below).width.sum()) / half.size for half, below in halves]
        unknown = _edges(scene) * observables.num_patches + observables.unseen_gap_area
        error = unknown / area + max(abs(width / area - 1) for width in widths) + stiffening
    return replace(
        observables,
        contact_area_subgrid=area,
        rms_gradient_subgrid=gradient,
        kappa_subgrid=kappa,
        num_counted_patches=0,
        num_patches_by_load=0,
        contact_area_error=error * area,
        contact_area_edges_error=error * area,
        kappa_error=2 * error * kappa,
        kappa_edges_error=2 * error * kappa,
    )


def _foundation(scene: Scene) -> Problem:
    """The discrete problem with K = k_W."""
    problem = Problem.from_scene(scene)
    modulus = scene.layer.foundation_modulus(scene.period) / problem.stiffness_unit
    values = np.append(0.0, np.full(problem.stiffness.size - 1, modulus))
    return replace(problem, rigidity=LayerResponse(values, problem.num_points, problem.stiffness_unit))


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
