"""Contact areas around a scene, over the load and over the thickness, found while nobody moves a slider."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from linecontact.solver import Indenter, Scene
from linecontact.solver.arrays import Array64

from .answers import answer
from .controls import Control

_COARSEST = 2**12
_MOST_OMITTED = 1e-3  # share of the mean square slope in waves that the grid of a curve leaves out
_POINTS = 13


@dataclass
class Curve:
    """Contact areas of the scenes along one slider, as far as they are known."""

    control: Control
    """The slider."""
    key: Scene | None = None
    """The common part of the points: a scene whose number on this slider says nothing."""
    num_points: int = 0
    """Grid points of the curve's scenes."""
    found: dict[float, tuple[float, float]] = field(default_factory=dict)
    """By the slider's number, divided by its scale: contact area a_r and its estimated error (dimensionless); NaN where
    there is none."""

    def copy(self) -> "Curve":
        """The points that are known now; the curve itself may go on on another thread."""
        return replace(self, found=dict(self.found))

    def aim(self, scene: Scene) -> None:
        """Keep the points if they surround this scene, and forget them otherwise."""
        common = _put(self.control, scene, 1.0)
        if common != self.key:
            self.key, self.num_points, self.found = common, grid(scene), {}

    def missing(self, scene: Scene, span: tuple[float, float]) -> list[float]:
        """Numbers without a point yet, those next to the scene first. span: of the slider's positions."""
        places = [*np.linspace(*span, _POINTS), *([span[1] + self.control.step] if self.control.endless else [])]
        own = self.control.position(own_value(self.control, scene), span[1])
        places.sort(key=lambda place: abs(place - own))
        values = (self.control.value(float(place), span[1]) for place in places)
        return [value for value in values if value not in self.found]

    def work(self, scene: Scene, span: tuple[float, float], dropped: Callable[[], bool]) -> Iterator[bool]:
        """Find the missing points; yields after every point, True after the last.

        span: of the slider's positions. Raises `answers.DroppedError` when it is dropped.
        """
        missing = self.missing(scene, span)
        for value in missing:

            def make(value: float = value) -> Scene:
                return _put(self.control, scene.on_grid(self.num_points), value)

            solution = answer(make, dropped).solution
            o = solution.observables if solution else None
            self.found[value] = (o.contact_area_subgrid, o.contact_area_error) if o else (math.nan, math.nan)
            yield value == missing[-1]

    def points(self) -> tuple[Array64, Array64, Array64]:
        """Numbers in increasing order, areas and their errors; shape (M,) each, dimensionless, without NaN."""
        known = sorted((value, *found) for value, found in self.found.items() if found[0] > 0)
        value, area, error = np.array(known).reshape(-1, 3).T
        return value, area, error

    @property
    def failed(self) -> int:
        """How many of the points have no converged answer."""
        return sum(not area > 0 for area, _ in self.found.values())


def own_value(control: Control, scene: Scene) -> float:
    """A scene's number on a slider, divided by its scale."""
    owner = scene if control.part == "scene" else scene.layer
    return float(getattr(owner, control.name)) / control.scale(scene)


def grid(scene: Scene) -> int:
    """Grid points for curves: a quarter or half of the scene's where that holds all waves of its indenter."""
    for num_points in (scene.num_points // 4, scene.num_points // 2):
        if num_points >= _COARSEST and _holds(scene.indenter, num_points):
            return num_points
    return scene.num_points


def _holds(indenter: Indenter, num_points: int) -> bool:
    if indenter.given_points is None:  # others are resampled
        try:
            indenter.check(num_points)
        except ValueError:
            return False
    return indenter.omitted(num_points) < _MOST_OMITTED


def _put(control: Control, scene: Scene, value: float) -> Scene:
    """The scene with another number, divided by the slider's scale, on it."""
    number = value * control.scale(scene)
    if control.part == "scene":
        return replace(scene, pressure=number)
    return replace(scene, layer=replace(scene.layer, **{control.name: number}))  # type: ignore[type-var]
