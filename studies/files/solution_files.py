"""Files of single solutions.

A solution file holds the datasets x, profile, displacement and contact_pressure, and everything that the command line's
JSON holds as attributes (nested names joined by dots).
"""

from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver import Solution
from numpy.typing import NDArray

from .hdf5 import column_of_numbers, new_file, open_file, scalar
from .records import flatten, renamed, unit

KIND = "solution"
_FIELDS = ("x", "profile", "displacement", "contact_pressure")


def save_solution(path: Path, solution: Solution) -> None:
    """Write one solution; an existing file is replaced."""
    fields = (solution.scene.x, solution.scene.profile, solution.displacement, solution.contact_pressure)
    with new_file(path) as file:
        file.attrs["kind"] = KIND
        for name, value in flatten(solution.to_dict()).items():
            file.attrs[name] = value
        for name, values in zip(_FIELDS, fields, strict=True):
            dataset = file.create_dataset(name, data=values)
            dataset.attrs["unit"] = unit(name)


def load_solution(path: Path) -> tuple[dict[str, NDArray[np.float64]], dict[str, Any]]:
    """Fields, shape (N,) each, N >= 2, and attributes of a solution file. Raises like `hdf5.open_file`."""
    with open_file(path) as file:
        fields = {name: column_of_numbers(file[name]) for name in _FIELDS}
        if len({values.size for values in fields.values()}) > 1 or fields["x"].size < 2:
            raise ValueError("its fields are of different lengths, or shorter than 2")
        return fields, renamed({name: scalar(value) for name, value in file.attrs.items()})
