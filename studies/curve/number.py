"""The number of a scene that a curve varies: its name, its values, and scenes with one of them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from typing import Any, Literal

import numpy as np
from linecontact.solver import Scene
from linecontact.solver.grid.layer_on_grid import half_spectrum
from linecontact.solver.strategy.grids import check_memory
from linecontact.solver.strategy.to_approach import check_approach

Spacing = Literal["auto", "log", "linear", "area"]

_DECADE = 10.0  # ratio of the ends from which values are spaced evenly in their logarithm
MOST = 2**14
"""Values of a curve."""


def numbers(scene: Scene) -> dict[str, float]:
    """The numbers of a scene that can be varied, by the names of their options."""
    found = {"pressure": scene.pressure, "approach": math.nan, "num_points": scene.num_points} | dict(_own(scene.layer))
    if scene.indenter.given_points is None:  # a scan has its own
        found |= {"period": scene.period} | dict(_own(scene.indenter))
    return found


def _own(part: Any) -> Iterator[tuple[str, float]]:
    for entry in fields(part):
        value = getattr(part, entry.name)
        if isinstance(value, int | float) and not isinstance(value, bool):
            yield entry.name, value


def check(scene: Scene, name: str, values: Sequence[float], accuracy: float | None) -> int:
    """Points of the largest grid, 0 for a power profile to an accuracy, which needs hardly any. Raises `ValueError` for
    a value that makes no scene, and for the largest if that has no solution, or if memory cannot hold its grid.
    """
    for value in values:
        if whole(scene, name) and not (math.isfinite(value) and value == int(value)):
            raise ValueError(f"{name} is {value:g}; allowed: an integer")
        put(scene, name, value)
    largest = put(scene, name, max(values))
    needed = 0 if accuracy and scene.indenter.power_law else largest.num_points
    check_memory(needed)
    check_approach(largest)
    half_spectrum(largest.layer, largest.num_points, largest.period)  # a table may lack waves
    return needed


def put(scene: Scene, name: str, value: float) -> Scene:
    """The scene with another value of one of its `numbers`. Raises `ValueError`."""
    if name == "num_points":
        return scene.on_grid(int(value))
    for part in ("layer", "indenter"):
        owner: Any = getattr(scene, part)
        own = dict(_own(owner))
        if name in own:
            number = int(value) if isinstance(own[name], int) else value
            return replace(scene, **{part: replace(owner, **{name: number})})
    other = {"pressure": {"approach": None}, "approach": {"pressure": math.nan}}.get(name, {})
    return replace(scene, **{name: value}, **other)  # type: ignore[arg-type]


def whole(scene: Scene, name: str) -> bool:
    """Whether a number is an integer."""
    return isinstance(numbers(scene)[name], int)


def repeated(values: Sequence[float]) -> int | None:
    """The place, from 0, of the first value that stands at an earlier place, too; None if there is none."""
    seen = set[float]()
    for place, value in enumerate(values):
        if value in seen:
            return place
        seen.add(value)
    return None


def spaced(first: float, last: float, count: int, spacing: Spacing, integers: bool) -> tuple[float, ...]:
    """Values from the first to the last, evenly spaced in their logarithm or as they are. Raises `ValueError`.

    spacing: 'auto' is the logarithm from a decade on. integers: whether the values are rounded, and none comes twice.
    """
    low, high = min(first, last), max(first, last)
    if not (math.isfinite(low) and math.isfinite(high)):
        raise ValueError(f"to is {last:g}, and from {first:g}; allowed: finite numbers; --values takes inf")
    if low == high:
        raise ValueError(f"to is {last:g}, and from {first:g}; allowed: two numbers that differ; --values takes one")
    if integers and not (low == int(low) and high == int(high)):
        raise ValueError(f"to is {last:g}, and from {first:g}; allowed: integers")
    if spacing == "log" and not low > 0:
        raise ValueError(f"from is {first:g}, and to {last:g}; allowed: numbers > 0, with --spacing log")
    if spacing == "auto":
        spacing = "log" if low > 0 and high >= _DECADE * low else "linear"
    values = np.geomspace(first, last, count) if spacing == "log" else np.linspace(first, last, count)
    shown = np.round(values) if integers else [f"{value:.12g}" for value in values]
    return tuple(dict.fromkeys(map(float, shown)))
