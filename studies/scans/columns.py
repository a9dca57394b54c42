"""Positions and heights in a file: text, .npy, HDF5 datasets, and the formats of instruments."""

import importlib.util
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.display import counted
from linecontact.solver.scene import MAX_POINTS

from ..files import confined
from .header import Label
from .text import Decimal, Table, read_text
from .units import UNITS, unit_of

MAX_REFINEMENT = 16  # grid points over values in the file
MAX_VALUES = MAX_POINTS // MAX_REFINEMENT  # numbers in a file: enough for the largest grid
LARGEST = 1e100  # number in a file, and its inverse the smallest range: squares are taken

_TEXT, _HDF5 = (".csv", ".txt", ".dat", ".asc", ".tsv"), (".h5", ".hdf5")
"""How the names of such files end."""


@dataclass(frozen=True)
class Columns:
    """What a file holds, as it stands there."""

    x: Array64 | None
    """Positions, shape (number of values,); None if the file has none."""
    z: Array64
    """Heights or gaps, shape (number of values,)."""
    origin: str
    """Where they came from, in words."""
    x_units: dict[str, str]
    """Units that the file names for x, each with where it does; an empty unit is no length."""
    z_units: dict[str, str]
    """The same for z."""
    is_depth: bool = False
    """Whether the file calls the heights depths."""
    unread: str = ""
    """A line that may be labels but is not taken for them, see `header.like_labels`."""
    line: int = 0
    """Line of the first value in a text; 0 elsewhere."""


def load(path: Path, dataset: str | None, columns: str | None, decimal: Decimal | None) -> Columns:
    """The columns of a profile file, chosen by the ending of its name. Raises `ValueError`, and what reading raises.

    dataset: name of the one to read in an HDF5 file, None for the only one. columns: numbers of those of x and z, or
    of z alone, from 1; None for those that the file makes clear. decimal: the decimal sign of a text.
    """
    suffix = path.suffix.lower()
    if dataset is not None and suffix not in _HDF5:
        raise ValueError(f"profile_dataset is {dataset}; allowed: none, {path} is not .h5")
    is_text = suffix in _TEXT
    if decimal is not None and not is_text:
        raise ValueError(f"decimal is {decimal}; allowed: none, {path} is not {', '.join(_TEXT[:-1])} or {_TEXT[-1]}")
    if is_text:
        table = read_text(path, shown_name(path), decimal)
    elif suffix in _HDF5:
        table = _read_hdf5(path, dataset)
    elif suffix == ".npy":
        table = _read_npy(path)
    else:
        return _finite(path, _read_scan(path, columns))
    return _finite(path, _choose(path, table, columns))


def shown_name(path: Path) -> str:
    """The file's name for records: they are UTF-8, which not all names are."""
    return os.fsencode(path.name).decode("utf-8", "backslashreplace")


def _read_npy(path: Path) -> Table:
    try:
        # a map takes no memory for what a header only claims
        with np.errstate(over="raise"):
            array = np.lib.format.open_memmap(path, mode="r")
    except Exception:  # of the tokenizer, for instance
        raise ValueError(f"profile_file {path} is damaged or not a plain array; allowed: real numbers") from None
    return Table(_numbers(path, array), f"array of {shown_name(path)}")


def _read_hdf5(path: Path, dataset: str | None) -> Table:
    try:
        found, unit = confined.read_dataset(path, MAX_VALUES, dataset)
    except confined.BrokenError as error:
        raise ValueError(f"profile_file {path} is damaged or not HDF5: {error}; allowed: HDF5") from None
    where = f"the dataset's attribute, {unit!r}"
    stated = [(axis, unit_of(unit) or "", where) for axis in "xz"] if unit else []
    return Table(_numbers(path, found), f"dataset {dataset or 'only one'} of {shown_name(path)}", (), stated)


def _read_scan(path: Path, columns: str | None) -> Columns:
    """An instrument's format, through SurfaceTopography."""
    if importlib.util.find_spec("SurfaceTopography") is None:
        raise ValueError(
            f"profile_file is {path}; allowed: {', '.join((*_TEXT, '.npy', *_HDF5))}, and with `pip install "
            "SurfaceTopography` the formats that SurfaceTopography reads"
        )
    if columns is not None:
        raise ValueError(f"columns is {columns}; allowed: none, {path} is an instrument's format")
    try:
        (x, z), unit = confined.read_scan(path, MAX_VALUES)
    except confined.BrokenError as error:
        raise ValueError(
            f"profile_file {path} cannot be read by SurfaceTopography: {error}; allowed: a format that it knows"
        ) from None
    named = {unit_of(unit) or "": f"its format, {unit!r}"} if unit else {}
    return Columns(x, z, f"{shown_name(path)} by SurfaceTopography", named, named)


def _numbers(path: Path, table: Any) -> Array64:
    """A table of real numbers, shape (rows, columns)."""
    table = np.asarray(table)
    if table.dtype.kind not in "fiu":
        raise ValueError(f"profile_file {path} holds {str(table.dtype)[:40]}; allowed: real numbers")
    if table.size > MAX_VALUES:
        raise ValueError(f"profile_file {path} holds {table.size} numbers; allowed: up to {MAX_VALUES}")
    if table.ndim not in (1, 2) or 0 in table.shape:
        raise ValueError(f"profile_file {path} has the shape {table.shape}; allowed: columns of numbers")
    with np.errstate(over="ignore"):  # of a longer type: infinite, and refused as such
        table = table.astype(np.float64)
    return np.asarray(table.reshape(len(table), -1))


def _choose(path: Path, table: Table, columns: str | None) -> Columns:
    """The columns of x and z that are asked for, or that the file makes clear. Raises `ValueError` for any other."""
    values = _numbers(path, table.values)
    count = values.shape[1]
    x, z = _places(path, values, table.labels) if columns is None else _asked(columns, count, table.labels)
    labels = dict(enumerate(table.labels))
    usual = (x, z) == ((None, 0) if count == 1 else (0, 1)) and count < 3
    positions = "no positions" if x is None else f"x from column {x + 1}"
    shown = "" if usual else f", {positions}, z from column {z + 1}"
    return Columns(
        None if x is None else values[:, x],
        values[:, z],
        table.origin + shown,
        _named(labels.get(-1 if x is None else x), table, "x"),
        _named(labels.get(z), table, "z"),
        table.is_downwards or (bool(table.labels) and table.labels[z].role == "depth"),
        table.unread,
        table.line,
    )


def _asked(columns: str, count: int, labels: Sequence[Label]) -> tuple[int | None, int]:
    """The places of x and z from the user's "2,3", or "3" for heights alone."""
    numbers = [int(word) if word.strip().isdecimal() else 0 for word in columns.split(",")]
    if len(numbers) > 2 or len(set(numbers)) < len(numbers) or not all(0 < number <= count for number in numbers):
        raise ValueError(
            f"columns is {columns!r}; allowed: numbers from 1 to {count}, those of x and z like 1,2, or of z alone"
        )
    x, z = (numbers[0] - 1 if len(numbers) == 2 else None), numbers[-1] - 1
    if labels and (labels[z].role == "x" or (x is not None and labels[x].role in ("z", "depth"))):
        texts = ", ".join(repr(label.text) for label in labels)
        raise ValueError(
            f"columns is {columns!r}, but the labels are {texts}; allowed: x and z as the labels have them"
        )
    return x, z


def _places(path: Path, values: Array64, labels: Sequence[Label]) -> tuple[int | None, int]:
    """The places of x and z, as the labels of the columns have them, or their usual order."""
    count = values.shape[1]
    roles = [label.role for label in labels] or [""] * count
    along, up = ([i for i, role in enumerate(roles) if role in wanted] for wanted in (("x",), ("z", "depth")))
    if count == 1:
        return None, 0
    second = any(re.match(r"y\b", label.text.lower()) for label in labels) and count > 2
    if len(along) == len(up) == 1 and not second:
        return along[0], up[0]
    if count == 2 and roles[0] == "index" and roles[1] != "x":
        return None, 1
    if count == 2 and roles[0] in ("", "x") and roles[1] not in ("x", "index"):
        return 0, 1
    texts = f" labelled {', '.join(repr(label.text) for label in labels)}" if labels else ""
    row = ", ".join(f"{value:g}" for value in values[0, :8])
    raise ValueError(
        f"columns is missing: {path} has {count} columns of numbers{texts}, the first row {row}; allowed: the numbers "
        "of those of x and z like 1,2, or of z alone"
    )


def _named(label: Label | None, table: Table, axis: str) -> dict[str, str]:
    """The units that the label of a column and the rest of the file name for it, with where."""
    named = {unit: f"the line {line[:60]!r}" for of, unit, line in table.stated if of == axis}
    if label and (label.unit or label.unknown):
        if not label.unit or named.keys() == {""}:  # a line on something else than lengths
            named = {}
        named[label.unit] = f"the label {label.text!r}"
    return named


def units(
    path: Path, named: dict[str, dict[str, str]], given: dict[str, str | None], unknown: str | None, unread: str
) -> dict[str, str]:
    """The unit of each axis, 'x' and 'z'.

    named: units that the file names, for each axis; given: the user's. unknown: that of numbers for which no unit is
    known, if the user says so; unread: a line that is not taken for labels. Raises `ValueError` where a unit is not
    known, or the file contradicts the user.
    """
    found, missing = {}, []
    for axis, places in named.items():
        own, known = given[axis], next(iter(places)) if len(places) == 1 else ""
        if own and known and own != known:
            seen = f"{path} names {known} ({places[known]})"
            raise ValueError(f"{axis}_unit is {own}, but {seen}; allowed: {known}, or none")
        if own or known:
            found[axis] = own or known
        elif places:
            seen = " and ".join(f"{unit or 'no unit of length'} ({where})" for unit, where in places.items())
            raise ValueError(f"{axis}_unit is missing: {path} names {seen}; allowed: {', '.join(UNITS)}")
        elif unknown:
            found[axis] = unknown
        else:
            missing.append(axis)
    if missing:
        names = " and ".join(f"{axis}_unit" for axis in missing)
        what = " and ".join({"x": "positions", "z": "heights"}[axis] for axis in missing)
        what += f" (its line {unread[:60]!r} is not understood as labels)" if unread else ""
        raise ValueError(
            f"{names} {'are' if len(missing) > 1 else 'is'} missing: {path} names no unit of its {what}; allowed: "
            f"{', '.join(UNITS)}; or scene_units, if its numbers are in the scene's own unit"
        )
    return found


def _finite(path: Path, found: Columns) -> Columns:
    """The same. Raises `ValueError` for numbers that are not finite, or too large."""
    for name, values in (("x", found.x), ("height", found.z)):
        if values is None:
            continue
        bad = np.flatnonzero(~(np.abs(values) <= LARGEST))
        if bad.size:
            row = f"line {found.line + bad[0]}" if found.line else f"row {bad[0] + 1}"
            missing = "fill values that are missing"  # without them a scan without positions would be shorter
            if found.x is not None:
                missing = f"you may delete {row.split()[0]}s whose value is missing"
            raise ValueError(
                f"profile_file {path}, {row}: {name} is {values[bad[0]]}; allowed: finite numbers up to {LARGEST:g} in "
                f"size; {missing} ({bad.size} of {values.size})"
            )
    return found


def check_values(path: Path, x: Array64 | None, z: Array64) -> None:
    """Raise `ValueError` for columns that are no profile: too short, constant, or going back in x."""
    if z.size < 16:
        raise ValueError(f"profile_file {path} holds {counted(z.size, 'value')}; allowed: at least 16")
    for name, values in (("x", x), ("height", z)):
        if values is not None and 0 < np.ptp(values) < 1 / LARGEST:
            reason = f"{name} ranges over {np.ptp(values)}; allowed: {1 / LARGEST:g} and more"
            raise ValueError(f"profile_file {path}: {reason}")
    if np.ptp(z) == 0:
        raise ValueError(f"profile_file {path}: every height is {z[0]}; allowed: a profile that is not constant")
    if x is not None:
        bad = np.flatnonzero(np.diff(x) <= 0)
        if bad.size:
            raise ValueError(
                f"profile_file {path}: x goes from {x[bad[0]]} to {x[bad[0] + 1]} at value {bad[0] + 2}; allowed: "
                "positions that go on in one direction; columns, like 2,1, says which they are, and with those of z "
                "alone scan_length takes their place"
            )
