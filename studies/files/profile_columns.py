"""Profile files as columns of numbers: .npy, text, HDF5 datasets, and the formats of instruments."""

import importlib.util
import itertools
import os
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from linecontact.solver.scene import MAX_POINTS
from numpy.typing import NDArray

from . import confined

Array64 = NDArray[np.float64]

MAX_REFINEMENT = 16  # grid points over values in the file
MAX_VALUES = MAX_POINTS // MAX_REFINEMENT  # numbers in a file: enough for the largest grid
MAX_TEXT = 2**25  # bytes of a text file
LARGEST = 1e100  # number in a file, and its inverse the smallest range: squares are taken
_MAX_LINE = 1000  # characters of a line of numbers
_MAX_HEADER = 1000  # lines before them

Unit = Literal["m", "mm", "um", "nm", "pm", "angstrom", "inch"]
UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "pm": 1e-12, "angstrom": 1e-10, "inch": 0.0254}
"""Units of length in metres."""


class Columns(NamedTuple):
    """What a profile file holds."""

    x: Array64 | None
    """Positions, shape (number of values,); None if the file has none."""
    z: Array64
    """Heights or gaps, shape (number of values,)."""
    origin: str
    """Where they came from, in words."""


def load(path: Path, dataset: str | None, given_unit: Unit | None, length_unit: Unit) -> Columns:
    """The columns of a profile file, chosen by the ending of its name. Raises `ValueError`, and what reading raises.

    dataset: name of the one to read in an HDF5 file, None for the only one. given_unit: unit of an axis that the user
    has given, which a file that names its own unit must not have. length_unit: the scene's unit of length.
    """
    suffix = path.suffix.lower()
    if dataset is not None and suffix not in (".h5", ".hdf5"):
        raise ValueError(f"profile_dataset is {dataset}; allowed: none, {path} is not .h5")
    if suffix in (".h5", ".hdf5"):
        return _columns(path, _read_hdf5(path, dataset), f"dataset {dataset or 'only one'} of {shown_name(path)}")
    if suffix == ".npy":
        try:
            # a map takes no memory for what a header only claims
            with np.errstate(over="raise"):
                array = np.lib.format.open_memmap(path, mode="r")
        except Exception:  # of the tokenizer, for instance
            raise ValueError(f"profile_file {path} is damaged or not a plain array; allowed: real numbers") from None
        return _columns(path, array, f"array of {shown_name(path)}")
    if suffix in (".csv", ".txt", ".dat", ".asc", ".tsv"):
        table, header = _read_text(path)
        return _columns(path, table, f"columns of {shown_name(path)}, {header} lines of header left out")
    return _read_scan(path, given_unit, length_unit)


def shown_name(path: Path) -> str:
    """The file's name for records: they are UTF-8, which not all names are."""
    return os.fsencode(path.name).decode("utf-8", "backslashreplace")


def _read_text(path: Path) -> tuple[Array64, int]:
    """The table in a text file, and the number of lines of header before it.

    The table begins where two lines in a row hold nothing but numbers, and as many of them.
    """
    with path.open("rb") as file:
        content = file.read(MAX_TEXT + 1)
    if len(content) > MAX_TEXT:
        raise ValueError(f"profile_file {path} is too long; allowed: {MAX_TEXT} bytes of text, or .npy or .h5")
    lines = content.decode("utf-8-sig", errors="replace").replace(",", " ").replace(";", " ").splitlines()
    counts = map(_numbers, lines[: _MAX_HEADER + 2])
    first, columns = next(((i, a) for i, (a, b) in enumerate(itertools.pairwise(counts)) if a and a == b), (None, 0))
    if first is None:
        allowed = f"one or two columns behind up to {_MAX_HEADER} lines of header"
        raise ValueError(f"profile_file {path} holds no table of numbers; allowed: {allowed}")
    if columns > 2:
        raise ValueError(f"profile_file {path} has {columns} columns of numbers; allowed: one or two")
    while not lines[-1].strip():
        lines.pop()
    for i in range(first, len(lines)):
        if not lines[i].strip():  # what is before may be a header of numbers
            raise ValueError(f"profile_file {path}, line {i + 1} is empty; allowed: none between numbers")
    try:
        return np.loadtxt(lines[first:], ndmin=2, comments=None), first
    except ValueError as error:
        for i in range(first, len(lines)):
            if _numbers(lines[i]) != columns:
                raise ValueError(
                    f"profile_file {path}, line {i + 1}: {lines[i].strip()[:40]!r} is not {columns} numbers"
                ) from None
        # what float() reads and NumPy does not, like 1_0
        raise ValueError(f"profile_file {path}: {error}; allowed: plain numbers") from None


def _numbers(line: str) -> int:
    """How many numbers a line consists of; 0 if there is anything else."""
    words = line.split() if len(line) <= _MAX_LINE else ["long"]
    try:
        for word in words:
            float(word)
    except ValueError:
        return 0
    return len(words)


def _read_hdf5(path: Path, dataset: str | None) -> Any:
    try:
        return confined.read_dataset(path, MAX_VALUES, dataset)
    except confined.BrokenError as error:
        raise ValueError(f"profile_file {path} is damaged or not HDF5: {error}; allowed: HDF5") from None


def _read_scan(path: Path, given: Unit | None, length_unit: Unit) -> Columns:
    """An instrument's format, through SurfaceTopography, in the scene's unit of length if it names its own."""
    if importlib.util.find_spec("SurfaceTopography") is None:
        raise ValueError(
            f"profile_file is {path}; allowed: .npy, .csv, .txt, .h5, and with `pip install linecontact[profiles]` the "
            "formats that SurfaceTopography reads"
        )
    try:
        (x, z), unit = confined.read_scan(path, MAX_VALUES)
    except confined.BrokenError as error:
        raise ValueError(
            f"profile_file {path} cannot be read by SurfaceTopography: {error}; allowed: a format that it knows"
        ) from None
    unit = unit.replace("µ", "u")
    if unit not in UNITS and unit:
        raise ValueError(f"profile_file {path} is in {unit}; allowed: {', '.join(UNITS)}")
    if unit and given:
        raise ValueError(f"x_unit or z_unit is {given}; allowed: none, {path} names its unit, {unit}")
    origin = f"{shown_name(path)} by SurfaceTopography, in {unit or 'no unit'}"
    scale = UNITS[unit] / UNITS[length_unit] if unit else 1.0
    return Columns(scale * x, scale * z, origin)


def _columns(path: Path, table: Any, origin: str) -> Columns:
    table = np.asarray(table)
    if table.dtype.kind not in "fiu":
        raise ValueError(f"profile_file {path} holds {str(table.dtype)[:40]}; allowed: real numbers")
    if table.size > MAX_VALUES:
        raise ValueError(f"profile_file {path} holds {table.size} numbers; allowed: up to {MAX_VALUES}")
    with np.errstate(over="ignore"):  # of a longer type: infinite, and refused as such
        table = table.astype(np.float64)
    if table.ndim == 2 and table.shape[1] == 1:
        table = table[:, 0]
    if table.ndim == 1:
        return Columns(None, table, origin)
    if table.ndim == 2 and table.shape[1] == 2:
        return Columns(table[:, 0], table[:, 1], origin)
    raise ValueError(f"profile_file {path} has the shape {table.shape}; allowed: one or two columns")


def check_values(path: Path, x: Array64 | None, z: Array64) -> None:
    """Raise `ValueError` for columns that are no profile: too short, too large, constant, or not increasing in x."""
    if z.size < 16:
        raise ValueError(f"profile_file {path} holds {z.size} values; allowed: at least 16")
    for name, values in (("x", x), ("height", z)):
        if values is None:
            continue
        bad = np.flatnonzero(~(np.abs(values) <= LARGEST))
        if bad.size:
            what = "too large" if np.isfinite(values[bad[0]]) else "not finite"
            allowed = f"finite numbers up to {LARGEST:g}"
            raise ValueError(f"profile_file {path}: {name} number {bad[0] + 1} is {what}; allowed: {allowed}")
        if 0 < np.ptp(values) < 1 / LARGEST:
            reason = f"{name} ranges over {np.ptp(values)}; allowed: {1 / LARGEST:g} and more"
            raise ValueError(f"profile_file {path}: {reason}")
    if np.ptp(z) == 0:
        raise ValueError(f"profile_file {path}: every height is {z[0]}; allowed: a profile that is not constant")
    if x is not None:
        bad = np.flatnonzero(np.diff(x) <= 0)
        if bad.size:
            raise ValueError(
                f"profile_file {path}: x goes from {x[bad[0]]} to {x[bad[0] + 1]} at value {bad[0] + 2}; allowed: "
                "increasing (in text a comma separates columns)"
            )
