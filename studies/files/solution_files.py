"""Files of single solutions.

A solution file holds the datasets x, profile, displacement and contact_pressure, the columns of the contact patches as
datasets of the group `patches`, and everything that the command line's JSON holds as attributes (nested names joined by
dots).
"""

import os
from collections.abc import Mapping
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from linecontact.solver import Solution, checks
from linecontact.solver.display import row, sentence
from linecontact.solver.grid.patch_table import PatchTable
from linecontact.solver.units import named, shown
from linecontact.solver.value import Value
from numpy.typing import NDArray

from .hdf5 import column_of_numbers, new_file, open_file, scalar
from .records import flatten, renamed, unit
from .writing import StoreError, as_path, check_target, write_bytes

if TYPE_CHECKING:
    import h5py

Name = str | os.PathLike[str]

KIND = "solution"
_ENDINGS = (".h5", ".hdf5")
_PATCHES = "patches"
FIELDS = ("x", "profile", "displacement", "contact_pressure")
"""Names of the fields, which have a value for each grid point."""
_OTHER_UNITS = {"nodes": "-", "load": "pressure times length", "peak_pressure": "pressure"}
_PATCH_UNITS = {field.name: _OTHER_UNITS.get(field.name, "length") for field in fields(PatchTable)}
"""Of the columns of the contact patches."""


@dataclass(frozen=True)
class StoredSolution(Value):
    """The contents of a solution file."""

    x: NDArray[np.float64]
    """Grid, shape (N,) [length]."""
    profile: NDArray[np.float64]
    """Heights of the indenter above its lowest point, shape (N,) [length]."""
    displacement: NDArray[np.float64]
    """u, shape (N,) [length]."""
    contact_pressure: NDArray[np.float64]
    """sigma, shape (N,) [pressure]."""
    results: dict[str, Any]
    """Everything else, by the names of the command line's JSON joined by dots, like 'certificate.penetration'."""
    patches: PatchTable | None = None
    """The contact patches; None where an earlier version has written the file, without them."""

    @property
    def warnings(self) -> dict[str, str]:
        """Its warnings: texts, by the kinds of `Solution.warnings`."""
        told = {name: str(text) for name, text in self.results.items() if name.startswith("warnings.")}
        return {name.removeprefix("warnings."): text for name, text in told.items()}

    def __repr__(self) -> str:
        names = ("status", "contact_area_subgrid", "contact_area_error", "num_patches", "scene.thickness")
        own = named(self.results, "scene.")
        rows = [row(name, self.results[name], own) for name in names if name in self.results]
        title = f"{type(self).__name__}: fields of {self.x.size} points, and {len(self.results)} results"
        return "\n  ".join(
            [sentence(title, rows), *(f"warning, {kind}: {text}" for kind, text in self.warnings.items())]
        )


def save(solution: Solution, path: Name, overwrite: bool = False) -> None:
    """Write a solution to an HDF5 file, .h5 or .hdf5, which appears under its name only when it is complete.

    overwrite: whether an existing file may be replaced. Raises `ValueError` for a file that cannot be written.
    """
    if not isinstance(solution, Solution):
        raise checks.refusal("solution", solution, "a Solution")
    file = as_path("path", path)
    check_file(file, overwrite)
    save_solution(file, solution)


def check_file(path: Path, overwrite: bool) -> None:
    """Raise `StoreError` before any work if `path` cannot become a new file of a solution."""
    check_target(path, overwrite)
    if path.suffix.lower() not in _ENDINGS:
        raise StoreError(f"file {path} would hold HDF5; allowed: a name that ends in {' or '.join(_ENDINGS)}")


def load(path: Name) -> StoredSolution:
    """Read a file that `save` or the command line has written, as a `StoredSolution`: the arrays `x`, `profile`,
    `displacement` and `contact_pressure`, the table `patches`, and all other numbers by name in `results`.

    Raises `ValueError` for any other file.
    """
    path = as_path("path", path)
    with open_file(path) as file:
        if (kind := str(file.attrs["kind"])) != KIND:
            raise StoreError(f"file {path} holds a study, {kind}; allowed: a solution's file")
        arrays = {name: column_of_numbers(file[name]) for name in FIELDS}
        if len({values.size for values in arrays.values()}) > 1 or arrays["x"].size < 2:
            raise ValueError("its fields are of different lengths, or shorter than 2")
        results = renamed({scalar(name): scalar(value) for name, value in file.attrs.items()})
        return StoredSolution(**arrays, results=results, patches=_patches(file))


def _patches(file: "h5py.File") -> PatchTable | None:
    """The contact patches in a solution's file, None where it has none. Raises `ValueError`."""
    if _PATCHES not in file:
        return None
    columns = {name: column_of_numbers(file[_PATCHES][name]) for name in _PATCH_UNITS}
    if len({values.size for values in columns.values()}) > 1:
        raise ValueError("the columns of its contact patches are of different lengths")
    return PatchTable(**columns)


def patches_head(names: Mapping[str, str]) -> str:
    """The first line of the table of contact patches. names: of the scene's units."""
    return ",".join(f"{name} [{shown(unit, names)}]" for name, unit in _PATCH_UNITS.items())


def save_patches(path: Name, solution: Solution) -> None:
    """Write the table of contact patches as CSV, with a line of names and units first."""
    head = patches_head(solution.scene.units)
    lines = (",".join(f"{value:.12g}" for value in row) for row in zip(*astuple(solution.patches), strict=True))
    write_bytes(Path(path), ["\n".join([head, *lines, ""]).encode()])


def stored(solution: Solution) -> StoredSolution:
    """The contents of a file of the solution."""
    arrays = (solution.scene.x, solution.scene.profile, solution.displacement, solution.contact_pressure)
    return StoredSolution(*arrays, results=flatten(solution.to_dict()), patches=solution.patches)


def save_solution(path: Path, solution: Solution) -> None:
    """Write one solution; an existing file is replaced."""
    kept = stored(solution)
    with new_file(path) as file:
        file.attrs["kind"] = KIND
        for name, value in kept.results.items():
            file.attrs[name] = value
        for name in FIELDS:
            dataset = file.create_dataset(name, data=getattr(kept, name))
            dataset.attrs["unit"] = unit(name)
        patches = file.create_group(_PATCHES)
        for name, of in _PATCH_UNITS.items():
            dataset = patches.create_dataset(name, data=getattr(kept.patches, name))
            dataset.attrs["unit"] = of
