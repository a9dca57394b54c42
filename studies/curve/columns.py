"""A curve in Python: columns for a table of pandas, or to draw."""

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

import numpy as np
from linecontact.solver import Observables, Scene, checks
from linecontact.solver.grid.errors import DEFAULT_QUANTITY, check_accuracy
from numpy.typing import NDArray

from . import number
from .tasks import point


def curve(
    scene: Scene,
    over: str,
    values: Iterable[float],
    *,
    accuracy: float | None = None,
    accuracy_of: str = DEFAULT_QUANTITY,
) -> dict[str, NDArray[Any]]:
    """Solve a scene for several values of one of its numbers, one after the other.

    over: the number, like 'pressure', 'approach', 'thickness', 'poisson_ratio' or 'seed'. values: in its own unit, one
        at least. accuracy, accuracy_of: as in `linecontact.solve`.

    Returns columns by name, each of shape (number of values,): 'value', 'status', 'contact_stiffness'
    [pressure/length], and every field of `Observables` with its unit; NaN where a solution has none. Raises
    `ValueError`, for a value that makes no scene, and for a grid that does not fit into memory, before anything is
    solved.
    """
    if not isinstance(scene, Scene):
        raise checks.refusal("scene", scene, "a Scene")
    checks.choice("over", over, tuple(number.numbers(scene)))
    allowed = "numbers, one or more"
    if not isinstance(values, Iterable) or isinstance(values, str):
        raise checks.refusal("values", values, allowed)
    numbers = [checks.real("values", value, allowed, infinite=True) for value in values]
    if not numbers:
        raise ValueError(f"values are none; allowed: {allowed}")
    number.check(scene, over, numbers, accuracy)
    check_accuracy(accuracy, accuracy_of)
    records = [point(number.put(scene, over, value), accuracy, accuracy_of) for value in numbers]
    names = ("contact_stiffness", *(field.name for field in fields(Observables)))
    found = {name: np.array([float(record.get(name, "nan")) for record in records]) for name in names}
    return {"value": np.array(numbers), "status": np.array([record["status"] for record in records])} | found
