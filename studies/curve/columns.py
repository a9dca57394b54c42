"""A curve in Python: columns for a table of pandas, or to draw."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from linecontact.solver import Scene, checks
from numpy.typing import NDArray

from . import number
from .tasks import point

_CERTIFICATE, _SCENE = "certificate.", "scene."


def curve(
    scene: Scene, over: str, values: Iterable[float], *, accuracy: float | None = None
) -> dict[str, NDArray[Any]]:
    """Solve a scene for several values of one of its numbers, one after the other.

    over: the number, like 'pressure', 'approach', 'thickness', 'poisson_ratio' or 'seed'. values: in its own unit, one
        at least. accuracy: as in `linecontact.solve`.

    Returns columns by name, each of shape (number of values,): 'value', 'status', 'contact_stiffness' and every number
    of `Observables` under its name there, which tells its unit; NaN where a value has none. Raises `ValueError`, for a
    value that makes no scene before anything is solved.
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is {scene!r}; allowed: a Scene")
    checks.choice("over", over, tuple(number.numbers(scene)))
    scenes = {float(value): number.put(scene, over, float(value)) for value in values}
    if not scenes:
        raise ValueError("values are empty; allowed: one number or more")
    records = [point(one, value, accuracy) for value, one in scenes.items()]
    names = [name for name in records[0] if name == "status" or _is_number(records[0][name])]
    names = [name for name in names if not name.startswith((_CERTIFICATE, _SCENE))]
    return {name: np.array([_cell(record.get(name, "nan"), name) for record in records]) for name in names}


def _is_number(value: Any) -> bool:
    return not isinstance(value, str) or value in checks.NOT_FINITE


def _cell(value: Any, name: str) -> Any:
    return value if name == "status" else float(value)
