"""What a scene needs for the accuracy asked: the smallest sufficient model, and the cheapest grid.

The accuracy is that of the contact area a_r, relative. A quarter of it goes to the model, the rest to grid and
iteration. What is decided beforehand costs well under a millisecond; the grid is found by climbing from coarse to fine
until the estimated error is small enough.

Half-space. Its stiffness differs from the layer's by a share e, the largest |f(q_k d) - 1|, at the longest waves. The
area then changes by about e, like the load would, but near full contact by up to (2/pi) sqrt(e) (a sinusoidal indenter,
`closed_forms.westergaard_area`): sqrt(e) is claimed. And e is small beside the tolerance, because the certificate stays
the layer's.
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
from .models import LEAST_EDGE
from .nested import FACTOR, Level, grids, measure_level, prolong
from .observables import contact_edges
from .patches import Patches
from .relaxation import Progress, Status, relax
from .run import COARSE_SLACK, COARSE_TOLERANCE
from .scene import Layer, Scene
from .solution import Choice
from .stiffness import layer_factor

Array64 = NDArray[np.float64]

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
    most = min((_MODEL_SHARE * accuracy) ** 2, 0.1 * residual(accuracy))
    layer, choices = _half_space(scene, most)
    thickness, nu, power = scene.layer.thickness / scene.period, scene.layer.poisson_ratio, scene.indenter
    half_width, models = 0.5, []
    if isinstance(power, PowerIndenter):
        load = scene.pressure / scene.layer.contact_modulus
        half_width = collocation.guessed_half_width(load, power.exponent, power.radius / scene.period, thickness, nu)
    elif isinstance(power, RoughIndenter):
        # twice the half-space's a_r = 1.75 p*; a layer's is smaller
        half_width = min(0.5, 1.75 * scene.pressure / scene.layer.contact_modulus / power.rms_gradient)
    if nu < 0.5 and LEAST_EDGE * thickness < 2 * half_width * accuracy:
        models.append("winkler")
    longest = _LONG_ASPERITY if accuracy > _FINE else _LONGEST_ASPERITY
    if isinstance(power, PowerIndenter) and half_width < min(0.49, longest * thickness):
        models.append("asperity")
    return Plan(tuple(models), layer, choices)


def residual(accuracy: float) -> float:
    """The tolerance on the free residual that goes with an accuracy."""
    return min(max(0.2 * accuracy, 1e-10), COARSE_TOLERANCE)


def _half_space(scene: Scene, most: float) -> tuple[Layer, tuple[Choice, ...]]:
    """The half-space instead of a layer whose stiffness is that, but for a share of `most`."""
    layer = scene.layer
    if math.isinf(layer.thickness):
        return layer, ()
    waves = 2 * np.pi * np.arange(1.0, 9.0) * (layer.thickness / scene.period)
    difference = float(np.abs(layer_factor(waves, layer.poisson_ratio) - 1).max())
    reason = f"a half-space's stiffness differs by a share of up to {difference:.1g}"
    if difference > most:
        return layer, (Choice("layer", "as it is", reason),)
    return replace(layer, thickness=math.inf), (Choice("layer", "half-space", reason, math.sqrt(difference)),)


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
    sizes = grids(scene.num_points)
    if len(sizes) == 1 and sizes[0] >= FACTOR * 16:  # without a coarser one there is no telling how wrong it is
        sizes.insert(0, 2 * round(sizes[0] / FACTOR / 2))
    for size in sizes:
        state = make(size)
        state.slack = COARSE_SLACK
        if start:
            state.start_from_pressure(prolong(scene, *start, size))
        status = relax(state, max_iterations, progress)
        pairs += state.transform_pairs * size
        start = state.contact_pressure, *contact_edges(scene, state.contact_pressure)
        levels.append(measure_level(scene, *start[1:], state))
        error = _error(levels, start[2])
        if status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        if size > above and resolves(scene, size, budget) and error <= budget:
            break
    state.slack, state.frozen = 0.0, False
    iterations = sum(level.iterations for level in levels)
    return Climb(state, levels, error, iterations, pairs / size)


def resolves(scene: Scene, num_points: int, accuracy: float) -> bool:
    """Whether a grid of that many points holds the surface, measured heights but for half the accuracy."""
    indenter = scene.indenter
    if isinstance(indenter, MeasuredIndenter) and num_points < scene.num_points:
        return indenter.omitted(num_points) <= accuracy / 2
    return not isinstance(indenter, RoughIndenter) or 2 * indenter.shortest < num_points


def _error(levels: list[Level], ends: Edges) -> float:
    if len(levels) < 2:
        return math.inf
    area, before = (level.contact_area_subgrid for level in (levels[-1], levels[-2]))
    edges = math.sqrt(float(ends.error @ ends.error)) / levels[-1].num_points
    return (abs(area - before) / (FACTOR - 1) + edges) / area if area else math.inf
