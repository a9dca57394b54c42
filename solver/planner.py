"""What a scene needs for the accuracy asked: the smallest sufficient model, and the cheapest grid.

The accuracy is that of the contact area a_r, relative. A quarter of it goes to the model, the rest to grid and
iteration. What is decided beforehand costs well under a millisecond; the grid is found by climbing from coarse to fine
until the estimated error is small enough.

Half-space. Replacing K by K (1 + e) at fixed load changes the area by no more than e, because K (1 + e) at p is K at
p/(1 + e) and a_r grows at most like p; e is the largest |f(q_k d) - 1|, at the longest wave. Claimed is 2 e.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from . import collocation
from .active_set import ActiveSet
from .edges import Edges
from .indenters import MeasuredIndenter, PowerIndenter, RoughIndenter
from .models import winkler_half_width
from .nested import FACTOR, Level, grids, measure_level, prolong
from .observables import contact_edges
from .patches import Patches
from .relaxation import Progress, Status, relax
from .run import COARSE_SLACK
from .scene import Layer, Scene
from .solution import Choice
from .stiffness import layer_factor

Array64 = NDArray[np.float64]

FIELD_POINTS = 2**12
"""Most points for the sampled fields of a model without a grid."""

_LONG_ASPERITY = 100.0  # half-widths over thicknesses: beyond, collocation takes longer than a grid,
_LONGEST_ASPERITY, _FINE = 600.0, 1e-5  # which may not know the area so finely
_MODEL_SHARE = 0.25


@dataclass(frozen=True)
class Plan:
    """models: 'asperity', 'winkler', to try before the grid; layer: to solve with; choices: made so far."""

    models: tuple[str, ...]
    layer: Layer
    choices: tuple[Choice, ...]


def decide(scene: Scene, accuracy: float) -> Plan:
    """The models worth trying, from what is known without solving anything."""
    layer, choices = _half_space(scene, _MODEL_SHARE * accuracy)
    models = []
    if _foundation_may_do(scene, accuracy):
        models.append("winkler")
    if isinstance(scene.indenter, PowerIndenter):
        longest = _LONG_ASPERITY if accuracy > _FINE else _LONGEST_ASPERITY
        if _asperity_half_width(scene) < min(0.49, longest * scene.layer.thickness / scene.period):
            models.append("asperity")
    return Plan(tuple(models), layer, choices)


def _half_space(scene: Scene, budget: float) -> tuple[Layer, tuple[Choice, ...]]:
    """The half-space instead of the layer, where that makes no difference."""
    layer = scene.layer
    if math.isinf(layer.thickness):
        return layer, ()
    waves = 2 * np.pi * np.arange(1.0, 9.0) * (layer.thickness / scene.period)
    difference = 2 * float(np.abs(layer_factor(waves, layer.poisson_ratio) - 1).max())
    reason = f"a half-space is softer or stiffer by at most {difference / 2:.1g}"
    if difference > budget:
        return layer, (Choice("layer", "as it is", reason),)
    return replace(layer, thickness=math.inf), (Choice("layer", "half-space", reason, difference),)


def _foundation_may_do(scene: Scene, budget: float) -> bool:
    """Whether the Winkler foundation can be good enough: surely not where the layer's edges are too wide."""
    thickness = scene.layer.thickness / scene.period
    if scene.layer.poisson_ratio == 0.5 or not 0.6 * thickness < budget:
        return False
    return not isinstance(scene.indenter, PowerIndenter) or 0.6 * thickness < budget * 2 * winkler_half_width(scene)


def _asperity_half_width(scene: Scene) -> float:
    """Half-width of a power profile in units of L: the half-space's or the foundation's, whichever is less."""
    power = scene.indenter
    assert isinstance(power, PowerIndenter)
    guess = collocation.lone_half_width(
        scene.pressure / scene.layer.contact_modulus, power.exponent, power.radius / scene.period
    )
    return min(guess, winkler_half_width(scene))


def on_grid(scene: Scene, num_points: int) -> Scene:
    """The same scene on another grid; measured heights are resampled by their Fourier modes."""
    if num_points == scene.num_points:
        return scene
    indenter = scene.indenter
    if isinstance(indenter, MeasuredIndenter):
        heights = indenter.profile(num_points, scene.period) * scene.period
        indenter = MeasuredIndenter(heights, indenter.description)
    return replace(scene, indenter=indenter, num_points=num_points)


@dataclass
class Climb:
    """The active set on ever finer grids. state: on the last one; error: estimate for its a_r, relative."""

    state: ActiveSet
    levels: list[Level]
    error: float
    iterations: int
    pairs: float  # of the last grid's length, on all of them
    status: Status


def climb(
    scene: Scene,
    budget: float,
    make: Callable[[int], ActiveSet],
    progress: Progress | None,
    max_iterations: int,
    above: int = 0,
) -> Climb:
    """From coarse to fine until the estimated relative error of a_r is below the budget, or the grid is the scene's.

    make: the method on a grid of that many points; above: number of points that is known to be too few.
    """
    levels: list[Level] = []
    start: tuple[Array64, Patches, Edges] | None = None
    pairs = 0.0
    for size in grids(scene.num_points):
        state = make(size)
        state.slack = COARSE_SLACK
        if start:
            state.start_from_pressure(prolong(scene, *start, size))
        status = relax(state, max_iterations, progress)
        pairs += state.transform_pairs * size
        start = state.contact_pressure, *contact_edges(scene, state.contact_pressure)
        levels.append(measure_level(scene, *start[1:], state))
        error = _error(levels, start[2])
        good = size > above and resolves(scene, size) and error <= budget
        if good or status is Status.INTERRUPTED:
            break
    state.slack, state.frozen = 0.0, False
    iterations = sum(level.iterations for level in levels)
    return Climb(state, levels, error, iterations, pairs / size, status)


def resolves(scene: Scene, num_points: int) -> bool:
    """Whether a grid of that many points holds the surface; measured heights tell by the change from grid to grid."""
    return not isinstance(scene.indenter, RoughIndenter) or scene.indenter.shortest < num_points // 2


def _error(levels: list[Level], ends: Edges) -> float:
    if len(levels) < 2:
        return math.inf
    area, before = (level.contact_area_subgrid for level in (levels[-1], levels[-2]))
    edges = math.sqrt(float(ends.error @ ends.error)) / levels[-1].num_points
    return (abs(area - before) / (FACTOR - 1) + edges) / area if area else math.inf
