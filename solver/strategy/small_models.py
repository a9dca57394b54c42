"""Models that are smaller than the scene: a power profile's one contact, by collocation or on the Winkler foundation,
and no contact at all.

They give observables with errors of their own, without a grid; the fields are sampled. Collocation knows all of them,
except the pressure at the tip of a profile sharper than a parabola, the foundation contact area and kappa alone.

A layer much thinner than its contact is wide is a Winkler foundation, K = k_W at all wave numbers: sigma = k_W (level -
h) where that is positive. It leaves out the layer's edge, which lies c(nu) d further out (`ElasticLayer.edge_shift`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Array64
from ..endings import Status
from ..grid.contact import contact_edges
from ..grid.errors import DEFAULT_QUANTITY
from ..grid.observables import Observables, observe
from ..grid.patch_table import PatchTable
from ..grid.problem import Problem
from ..layers import Layer
from ..reference import collocation
from ..reference.closed_forms import foundation_half_width, guessed_half_width, kappa_from_area, kappa_half_space
from ..scene import Scene
from ..solution import Choice, Solution
from .finish import make_solution
from .run import Run

_LEAST_EDGE, _TIMES_SHIFT = 0.6, 3.0
"""Error of the foundation's two edges together: this share of the thickness, or so many times the edge shift
if that is more (dimensionless)."""

_LONG_ASPERITY = 100.0  # half-width over thickness above which collocation takes longer than a grid
_FIELD_POINTS = 2**12  # of sampled fields, whose contact has at least the square root of it
_FULL = 0.98  # contact areas above are not those of one asperity any more


@dataclass(frozen=True)
class _Contact:
    """One contact as a model finds it."""

    area: float
    """a_r."""
    peak_pressure: float
    """The largest sigma [E*]."""
    approach: float
    """Rigid approach since first touch [L]."""
    errors: dict[str, float]
    """Relative, by the names in `QUANTITIES`; `inf`: not known."""
    pressure_at: Callable[[Array64], Array64]
    """sigma at places x/a, shape of these [any unit]; 0 outside of the contact."""
    choice: Choice
    """Why by this model."""


def decide(scene: Scene, accuracy: float, of: str = DEFAULT_QUANTITY) -> str | None:
    """The name in `MODELS` of the one worth trying before the grid, before anything is solved."""
    layer, power = scene.layer, scene.indenter.power_law
    if not power:
        return None
    founded = 0 < _foundation_area(scene) < _FULL and layer.edge_shift is not None
    if founded and _on_foundation(scene, accuracy, of).errors[of] <= accuracy:
        return "winkler-foundation"
    if layer.bonded is None or (power[0] < 2 and of == "peak-pressure"):
        return None
    half_width = guessed_half_width(scene.reduced_load, power[0], power[1] / scene.period, layer, scene.period)
    return "collocation" if half_width < min(_FULL / 2, _LONG_ASPERITY * layer.thickness / scene.period) else None


def by_small_model(run: Run, accuracy: float, of: str) -> Solution | None:
    """The solution by the model that `decide` names; None where none will do."""
    scene, name = run.scene, decide(run.scene, accuracy, of)
    if not name:
        return None
    try:
        found = MODELS[name](scene, accuracy, of)
    except ValueError as error:
        run.choices.append(Choice(name, "no", str(error)))
        return None
    n = _FIELD_POINTS
    while n * found.area < math.sqrt(_FIELD_POINTS) and n < scene.num_points:
        n *= 2
    n = min(n, scene.num_points)
    scene = replace(scene, num_points=n)
    problem = Problem.from_scene(scene)
    pressure = found.pressure_at((np.arange(n) - n // 2) / n / (found.area / 2))
    pressure /= pressure.mean()  # the sampled load is off by the sampling
    displacement = problem.to_length(problem.displacement_under(pressure), pressure > 0)
    pressure *= scene.pressure
    observables, patches = _measured(scene, found, int(np.count_nonzero(pressure)))
    run.choices += [found.choice, Choice("grid", f"{n} points", "for the fields only, which are sampled")]
    if name == "collocation" and math.isinf(found.errors["peak-pressure"]):
        tip = "rough: too low at a tip sharper than a parabola"
        run.choices.append(Choice("peak pressure", "by collocation", tip))
    run.status = Status.CONVERGED
    return make_solution(run, scene, name, (displacement, pressure, pressure > 0), observables, patches)


def without_contact(run: Run) -> Solution:
    """The solution of a scene in which nothing touches: the surface flat, away from the indenter's lowest point.

    Without load their distance may be any, and is 0. p* and kappa are NaN.
    """
    scene = run.scene
    approach, first = scene.approach or 0.0, scene.first_node
    unseen = 1 / scene.num_points if approach > 0 else 0.0
    if scene.approach is not None:
        unit = scene.length_unit
        why = f"for the approach of {approach:g} [{unit}]: up to {first:g} [{unit}] no node touches"
        run.choices.append(Choice("pressure", "0", why))
        scene = replace(scene, approach=None, pressure=0.0)
    n = scene.num_points
    fields = np.full(n, approach - first), np.zeros(n), np.zeros(n, dtype=bool)
    found, patches = observe(contact_edges(Problem.from_scene(scene), fields[1], fields[0]), fields[0])
    unknown = ("reduced_pressure", "kappa", "kappa_subgrid", "kappa_error", "kappa_edges_error")
    known: dict[str, Any] = dict.fromkeys(unknown, math.nan) | {
        "contact_area_error": unseen,
        "contact_area_edges_error": unseen,
        "peak_pressure_sampling": 0.0,
        "peak_pressure_error": math.inf if unseen else 0.0,
        "approach": approach,
        "approach_error": 0.0,
        "kappa_ratio": None if found.kappa_ratio is None else math.nan,
    }
    run.status, run.config = Status.CONVERGED, replace(run.config, device="cpu")
    return make_solution(run, scene, "no contact", fields, replace(found, **known), patches)


def _measured(scene: Scene, found: _Contact, nodes: int) -> tuple[Observables, PatchTable]:
    """Observables and the patch of a contact, which has some nodes of a scene's grid."""
    power = scene.indenter.power_law
    assert power
    load, period, area = scene.reduced_load, scene.period, found.area
    kappa = kappa_from_area(power[0], area, power[1] / period, load)
    gradient = kappa / area * load
    approach, peak = period * found.approach, scene.layer.contact_modulus * found.peak_pressure
    area_error, kappa_error = found.errors["contact-area"] * area, found.errors["kappa"] * kappa
    observables = Observables(
        contact_area=area,
        contact_area_subgrid=area,
        contact_area_error=area_error,
        contact_area_edges_error=area_error,
        rms_gradient_contact=gradient,
        rms_gradient_subgrid=gradient,
        reduced_pressure=load / gradient,
        reduced_thickness=scene.layer.thickness / (area * period),
        kappa=kappa,
        kappa_subgrid=kappa,
        kappa_error=kappa_error,
        kappa_edges_error=kappa_error,
        kappa_ratio=kappa / kappa_half_space(power[0]),
        num_patches=1,
        num_unresolved_patches=0,
        num_patches_by_load=0,
        unseen_gap_area=0.0,
        peak_pressure=peak,
        peak_pressure_sampling=0.0,
        peak_pressure_error=found.errors["peak-pressure"] * peak,
        approach=approach,
        approach_error=found.errors["approach"] * abs(approach),
        approach_sampling=0.0,
        mean_gap=float(scene.profile.mean()) - approach + scene.pressure / (scene.foundation_modulus or math.inf),
    )
    middle = scene.num_points // 2 / scene.num_points
    ends = ((middle + place) * period for place in (-area / 2, area / 2))
    table = np.array([*ends, area * period, nodes, scene.pressure * period, peak], dtype=np.float64)
    return observables, PatchTable(*table[:, None])


def _collocated(scene: Scene, accuracy: float, of: str) -> _Contact:
    """By collocation, on a bonded layer. Raises `ValueError` where that does not get there."""
    power, bonded, period = scene.indenter.power_law, scene.layer.bonded, scene.period
    assert power
    assert bonded
    layer, shape = Layer(bonded[0] / period, bonded[1]), (power[0], power[1] / period)
    found, known = collocation.solve_to_accuracy(layer, scene.reduced_load, *shape, accuracy / 2, of.replace("-", "_"))
    errors = {name.replace("_", "-"): error for name, error in known.items()}
    if power[0] < 2:
        errors["peak-pressure"] = math.inf
    reason = "a power profile is one asperity; error: from the change by the last doubling of the nodes"
    choice = Choice("model", "collocation", reason, errors[of])
    return _Contact(found.contact_area, found.peak_pressure, found.approach, errors, found.pressure_at, choice)


def _on_foundation(scene: Scene, accuracy: float, of: str) -> _Contact:
    """On the Winkler foundation of a compressible layer, as accurate as that is."""
    layer, power, area = scene.layer, scene.indenter.power_law, _foundation_area(scene)
    assert power
    peak = (power[0] + 1) / power[0] * scene.reduced_load / area
    edges = max(_LEAST_EDGE * layer.thickness, _TIMES_SHIFT * abs(layer.edge_shift or 0.0)) / scene.period
    errors = {"contact-area": edges / area, "kappa": power[0] * edges / area}
    errors |= {"peak-pressure": math.inf, "approach": math.inf}
    approach = peak / layer.foundation_modulus(scene.period)
    choice = Choice("model", "Winkler foundation", "the layer's edges are narrow", errors[of])
    return _Contact(area, peak, approach, errors, lambda t: np.maximum(1 - np.abs(t) ** power[0], 0.0), choice)


def _foundation_area(scene: Scene) -> float:
    """a_r of a power profile on the Winkler foundation; 0 on an incompressible layer, `inf` on a half-space."""
    power = scene.indenter.power_law
    assert power
    modulus = scene.layer.foundation_modulus(scene.period)
    return 2 * foundation_half_width(scene.reduced_load, power[0], power[1] / scene.period, modulus)


MODELS: dict[str, Callable[[Scene, float, str], _Contact]] = {
    "winkler-foundation": _on_foundation,
    "collocation": _collocated,
}
"""By name, for an accuracy of one of `QUANTITIES`; for scenes with a power profile."""
