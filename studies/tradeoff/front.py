"""Pareto fronts of seconds against errors, and which values of what can be chosen are on none."""

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from .. import store
from .families import FAMILIES

Run = dict[str, Any]

NEAR = 1.1
"""Factor in time and error within which a choice is on a front, and errors are no different."""

AXES = ("method", "precision", "tolerance.asked", "nested", "threads", "counted")
"""What can be chosen; 'counted' is how the contact area is measured."""

FRONTS = {
    "a_r": ("area", "area_counted"),
    "kappa": ("kappa",),
    "peak pressure": ("peak",),
    "pressure field": ("field",),
}
"""Errors that compete with each other."""


class Point(NamedTuple):
    """A run with one of its errors (relative)."""

    seconds: float
    error: float
    counted: bool
    run: Run

    def value(self, axis: str) -> Any:
        """Of what was chosen."""
        return self.counted if axis == "counted" else self.run[axis]


def runs_of(study: store.StudyFile, kind: str, family: str | None = None) -> list[Run]:
    """Of one kind of task, and family."""
    return [run for run in study.runs if run["kind"] == kind and family in (None, run["family"])]


def points(runs: Iterable[Run], what: str) -> list[Point]:
    """Every certified run with each of its errors, as far as it has them; what: of `FRONTS`."""
    return [
        Point(run["seconds.total"], error, name == "area_counted", run)
        for run in runs
        for name in FRONTS[what]
        if run["status"] == "converged" and (error := run.get(f"error.{name}", math.nan)) >= 0
    ]


def front(candidates: Iterable[Point]) -> list[Point]:
    """Fastest first, each with a smaller error than all that are faster; errors within `NEAR` are one."""
    best: list[Point] = []
    for point in sorted(candidates, key=lambda p: (p.seconds, p.error)):
        if not best or point.error * NEAR < best[-1].error:
            best.append(point)
    return best


def over_front(point: Point, best: Sequence[Point]) -> float:
    """Its time over the front's at its error; nan beyond the front's least error."""
    return max((point.seconds / p.seconds for p in best if p.error <= NEAR * point.error), default=math.nan)


def distance(point: Point, best: Sequence[Point]) -> float:
    """Factor, in time and error, within which it comes of some point of the front; 1 is on it, or better."""
    return max(1.0, min(max(point.seconds / p.seconds, point.error / max(p.error, 1e-300)) for p in best))


class Worth(NamedTuple):
    """A value of an axis: its least distance from any front, where, and its points on those of the contact area."""

    axis: str
    value: Any
    distance: float
    where: str
    near: list[Point]

    @property
    def never(self) -> bool:
        """On no front."""
        return self.distance > NEAR


def worth(study: store.StudyFile) -> list[Worth]:
    """Every value of every axis of the choices by hand, on the fronts of those."""
    rated: list[tuple[float, str, str, Point]] = []
    for family in FAMILIES:
        runs = runs_of(study, "choice", family)
        for what in FRONTS:
            found = points(runs, what)
            best = front(found)
            rated += [(distance(point, best), family, what, point) for point in found]
    result = []
    for axis in AXES:
        for value in dict.fromkeys(point.value(axis) for *_, point in rated):
            own = [r for r in rated if r[3].value(axis) == value and (axis != "counted" or r[2] == "a_r")]
            least, family, what, _ = min(own, key=lambda r: r[0])
            near = [point for far, _, measure, point in own if measure == "a_r" and far <= NEAR]
            result.append(Worth(axis, value, least, f"{what}, {family}", near))
    return result
