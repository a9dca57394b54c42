"""Pareto fronts of seconds against errors, which values of the choices are on none, and the gain by each."""

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from ..files.study_files import StudyFile
from .families import FAMILIES

Run = dict[str, Any]

NEAR = 1.1
"""Factor in time and error within which a choice is on a front, and errors are no different."""

AXES = ("method", "precision", "tolerance.asked", "nested", "threads", "counted")
"""The axes of choice; 'counted' is how the contact area is measured."""

FRONTS = {
    "a_r": ("area", "area_counted"),
    "pressure field": ("field",),
}
"""Errors that compete with each other. Those of kappa go with a_r's; the peak's change sign from grid to grid."""

FIGURES = dict(zip(("", "-field"), FRONTS, strict=True))
"""Which of the fronts a figure shows, by the ending of its name."""

ENSEMBLES_FIGURE = "-ensembles"
"""Ending of the name of the figure of ensembles and of estimated errors."""


class Point(NamedTuple):
    """A run with one of its errors."""

    seconds: float
    """Time in all [s]."""
    error: float
    """Relative error."""
    counted: bool
    """Whether it is that of the area by counting nodes."""
    run: Run
    """The run's record."""

    def value(self, axis: str) -> Any:
        """The run's choice on an axis."""
        return self.counted if axis == "counted" else self.run[axis]


def runs_of(study: StudyFile, kind: str, family: str | None = None) -> list[Run]:
    """The runs of one kind of task, and of one family or of all."""
    return [run for run in study.runs if run["kind"] == kind and family in (None, run["family"])]


def points(runs: Iterable[Run], what: str) -> list[Point]:
    """Every certified run with each of its errors, as far as it has them. what: one of `FRONTS`."""
    return [
        Point(run["seconds.total"], error, name == "area_counted", run)
        for run in runs
        for name in FRONTS[what]
        if run["status"] == "converged" and (error := run.get(f"error.{name}", math.nan)) >= 0
    ]


def front(candidates: Iterable[Point]) -> list[Point]:
    """The Pareto front, fastest first: each point has a smaller error than all faster ones, by more than `NEAR`."""
    best: list[Point] = []
    for point in sorted(candidates, key=lambda p: (p.seconds, p.error)):
        if not best or point.error * NEAR < best[-1].error:
            best.append(point)
    return best


def over_front(point: Point, best: Sequence[Point]) -> float:
    """The time of a point over the front's at its error; NaN beyond the front's least error."""
    return max((point.seconds / p.seconds for p in best if p.error <= NEAR * point.error), default=math.nan)


def distance(point: Point, best: Sequence[Point]) -> float:
    """The factor in time and error within which a point comes near the front; 1 for a point on it, or better."""
    return max(1.0, min(max(point.seconds / p.seconds, point.error / max(p.error, 1e-300)) for p in best))


class Worth(NamedTuple):
    """The gain by a value of an axis, one thing that can be chosen."""

    axis: str
    """One of `AXES`."""
    value: Any
    """The value."""
    distance: float
    """Least distance of its points from any front, see `distance`."""
    where: str
    """Front and family of that least distance, in words."""
    near: list[Point]
    """Its points on the fronts of the contact area."""
    loss: float
    """How many times as long the same areas take without it, at most; inf where nothing else gets there."""
    lost: Point
    """The point at which it takes that long."""

    @property
    def never(self) -> bool:
        """Whether the value is on no front."""
        return self.distance > NEAR


def worth(study: StudyFile) -> list[Worth]:
    """The gain by every value of every axis, on the fronts of the choices by hand."""
    rated: list[tuple[float, str, Point]] = []
    areas: list[tuple[list[Point], list[Point]]] = []
    for family in FAMILIES:
        for what in FRONTS:
            found = points(runs_of(study, "choice", family), what)
            best = front(found)
            rated += [(distance(point, best), what, point) for point in found]
            areas += [(found, best)] * (what == "a_r")
    result = []
    for axis in AXES:
        for value in dict.fromkeys(point.value(axis) for *_, point in rated):
            own = [r for r in rated if r[2].value(axis) == value and (axis != "counted" or r[1] == "a_r")]
            least, what, closest = min(own, key=lambda r: r[0])
            near = [point for far, measure, point in own if measure == "a_r" and far <= NEAR]
            loss = max((_loss(axis, value, *area) for area in areas if area[0]), key=lambda pair: pair[0])
            result.append(Worth(axis, value, least, f"{what}, {closest.run['family']}", near, *loss))
    return result


def _loss(axis: str, value: Any, found: Sequence[Point], best: Sequence[Point]) -> tuple[float, Point]:
    """The largest factor in time that doing without a value costs, and where; inf where nothing else gets there."""
    others = front(point for point in found if point.value(axis) != value)
    losses = [(1.0, best[0])]
    for point in best:
        if point.value(axis) == value:
            there = [p.seconds / point.seconds for p in others if p.error <= NEAR * point.error]
            losses.append((min(there, default=math.inf), point))
    return max(losses, key=lambda pair: pair[0])
