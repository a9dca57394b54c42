"""Positions and heights in a file: text, .npy, HDF5 datasets, and the formats of instruments."""

import importlib.util
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.display import counted
from linecontact.solver.scene import MAX_POINTS

from ..files import confined
from ..terminal.units import UNITS, unit_of
from .header import Header, Label
from .text import Decimal, Table, read_text

MAX_REFINEMENT = 16  # grid points over values in the file
MAX_VALUES = MAX_POINTS // MAX_REFINEMENT  # numbers in a file: enough for the largest grid
LARGEST = 1e100  # number in a file, and its inverse the smallest range: squares are taken

_TEXT, _HDF5 = (".csv", ".txt", ".dat", ".asc", ".tsv"), (".h5", ".hdf5")
"""How the names of such files end."""
_KINDS = {"x": "positions", "z": "heights"}


@dataclass(frozen=True)
class Columns:
    """What a file holds, as it stands there."""

    x: Array64 | None
    """Positions, shape (number of values,); None if the file has none."""
    z: Array64
    """Heights or gaps, shape (number of values,); NaN where they are missing."""
    origin: str
    """Where they came from, in words."""
    labels: dict[str, Label]
    """Labels of 'x' and 'z', of those that have one."""
    head: Header = field(default_factory=Header)
    line: int = 0
    """Line of the first value in a text; 0 elsewhere."""

    @property
    def axes(self) -> str:
        return "z" if self.x is None else "xz"

    @property
    def depth(self) -> str:
        """Words of the file that call the heights depths; empty without any."""
        label = self.labels.get("z")
        return label.text if label and label.is_depth else self.head.depth()

    def row(self, i: int) -> str:
        """Where the value with index i stands."""
        return f"line {self.line + i}" if self.line else f"row {i + 1}"


def load(path: Path, dataset: str | None, columns: str | None, decimal: Decimal | None) -> Columns:
    """The columns of a profile file, chosen by the ending of its name. Raises `ValueError`, and what reading raises.

    dataset: name of the one to read in an HDF5 file, None for the only one. columns: numbers of those of x and z, or
    of z alone, from 1; None for those that the file makes clear. decimal: the decimal sign of a text.
    """
    suffix, name = path.suffix.lower(), shown_name(path)
    if dataset is not None and suffix not in _HDF5:
        raise ValueError(f"profile_dataset is {dataset}; allowed: none, {path} is not .h5")
    if decimal is not None and suffix not in _TEXT:
        raise ValueError(f"decimal is {decimal}; allowed: none, {path} is not {', '.join(_TEXT[:-1])} or {_TEXT[-1]}")
    if suffix in _TEXT:
        return _choose(path, read_text(path, name, decimal), columns)
    if suffix == ".npy":
        return _choose(path, _table(path, _mapped(path), f"array of {name}"), columns)
    try:
        if suffix in _HDF5:
            values, unit, said = confined.read_dataset(path, MAX_VALUES, dataset)
            found = _choose(path, _table(path, values, f"dataset {dataset or 'only one'} of {name}"), columns)
            return replace(found, labels=dict.fromkeys(found.axes, Label(said, unit)))
        if importlib.util.find_spec("SurfaceTopography") is None:
            known = f"{', '.join((*_TEXT, '.npy', *_HDF5))}, and with `pip install SurfaceTopography` the formats that"
            raise ValueError(f"profile_file is {path}; allowed: {known} SurfaceTopography reads")
        if columns is not None:
            raise ValueError(f"columns is {columns}; allowed: none, {path} is an instrument's format")
        (x, z), unit, _ = confined.read_scan(path, MAX_VALUES)
    except confined.BrokenError as error:
        kind = "HDF5" if suffix in _HDF5 else "of a format that SurfaceTopography reads"
        raise ValueError(f"profile_file {path} is damaged or not {kind}: {error}; allowed: files that are") from None
    return Columns(x, z, f"{name} by SurfaceTopography", dict.fromkeys("xz", Label("its format", unit)) if unit else {})


def shown_name(path: Path) -> str:
    """The file's name for records: they are UTF-8, which not all names are."""
    return os.fsencode(path.name).decode("utf-8", "backslashreplace")


def _mapped(path: Path) -> Any:
    """The array of an .npy file: a map takes no memory for a shape that a header only claims. Raises `ValueError`."""
    try:
        with np.errstate(over="raise"):
            return np.lib.format.open_memmap(path, mode="r")
    except Exception:  # of the tokenizer, for instance
        raise ValueError(f"profile_file {path} is damaged or not a plain array; allowed: real numbers") from None


def _table(path: Path, found: Any, origin: str) -> Table:
    """A table of real numbers, shape (rows, columns)."""
    found = np.asarray(found)
    if found.dtype.kind not in "fiu":
        raise ValueError(f"profile_file {path} holds {str(found.dtype)[:40]}; allowed: real numbers")
    if found.size > MAX_VALUES:
        raise ValueError(f"profile_file {path} holds {found.size} numbers; allowed: up to {MAX_VALUES}")
    if found.ndim not in (1, 2) or 0 in found.shape:
        raise ValueError(f"profile_file {path} has the shape {found.shape}; allowed: columns of numbers")
    with np.errstate(over="ignore"):  # of a longer type: infinite, and refused as such
        values = np.asarray(found.astype(np.float64).reshape(len(found), -1))
    return Table(values, origin, range(values.shape[1]))


def _choose(path: Path, table: Table, columns: str | None) -> Columns:
    """The columns of x and z that are asked for, or that the file makes clear. Raises `ValueError` for any other."""
    labels = table.head.labels or [Label("")] * table.values.shape[1]
    places = _places(path, table, labels) if columns is None else _asked(columns, table, labels)
    for place in places.values():
        if place in table.odd:
            seen = f"{table.odd[place]} has no number in column {place + 1}"
            raise ValueError(f"profile_file {path}, {seen}; allowed: numbers, or with missing empty cells, NaN, ***")
    x, z = places.get("x"), places["z"]
    shown = ", no positions" if x is None else f", x from column {x + 1}"
    shown = "" if table.values.shape[1] == len(places) and z == len(places) - 1 else f"{shown}, z from column {z + 1}"
    named = {axis: labels[place] for axis, place in places.items() if labels[place].text}
    chosen = None if x is None else table.values[:, x]
    return Columns(chosen, table.values[:, z], table.origin + shown, named, table.head, table.line)


def _asked(columns: str, table: Table, labels: Sequence[Label]) -> dict[str, int]:
    """The places of x and z from the user's "2,3", or "3" for heights alone."""
    numbers = [int(word) - 1 if word.strip().isdecimal() and len(word) < 9 else -1 for word in columns.split(",")]
    if len(numbers) > 2 or len(set(numbers)) < len(numbers) or not set(numbers) <= set(table.numeric):
        count, listed = table.values.shape[1], ", ".join(str(i + 1) for i in table.numeric)
        allowed = f"numbers from 1 to {count}" if len(table.numeric) == count else f"{listed}, the columns of numbers"
        raise ValueError(f"columns is {columns!r}; allowed: {allowed}, those of x and z like 1,2, or of z alone")
    places = dict(zip("xz"[-len(numbers) :], numbers, strict=True))
    if labels[places["z"]].role == "x" or ("x" in places and labels[places["x"]].role == "z"):
        texts = ", ".join(repr(label.text) for label in labels)
        raise ValueError(
            f"columns is {columns!r}, but the labels are {texts}; allowed: x and z as the labels have them"
        )
    return places


def _places(path: Path, table: Table, labels: Sequence[Label]) -> dict[str, int]:
    """The places of x and z, as the labels of the columns have them, or their usual order."""
    numeric = list(table.numeric)
    first, last, roles = numeric[0], numeric[-1], [labels[i].role for i in numeric]
    without = [labels[i] for i in sorted({*range(len(labels))} - {*numeric})]
    second = len(numeric) > 2 and any(re.match(r"y\b", label.text.lower()) for label in labels)
    if len(numeric) == 1 and roles[0] not in ("x", "index") and "x" not in [label.role for label in without]:
        return {"z": first}
    if roles.count("x") == roles.count("z") == 1 and not second:
        return {axis: numeric[roles.index(axis)] for axis in "xz"}
    if len(numeric) == 2 and roles[0] != "z" and roles[1] not in ("x", "index"):
        return {"z": last} if roles[0] == "index" else {"x": first, "z": last}
    texts = f" labelled {', '.join(repr(labels[i].text) for i in numeric[:8])}" if table.head.labels else ""
    texts += "".join(f", none below {label.text!r}" for label in without[:8] if label.text)
    row = ", ".join(f"{value:g}" for value in table.values[0, numeric[:8]])
    raise ValueError(
        f"columns is missing: {path} has {counted(len(numeric), 'column')} of numbers{texts}, the first row {row}; "
        "allowed: the numbers of those of x and z like 1,2, or of z alone"
    )


def units(path: Path, found: Columns, given: dict[str, str | None], unknown: str | None) -> dict[str, str]:
    """The unit of each axis, 'x' and 'z'; of 'z' alone without positions.

    given: the user's. unknown: that of numbers for which no unit is known, if the user says so. Raises `ValueError`
    where a unit is not known, or a word of the file contradicts the user or its own labels.
    """
    units = dict[str, str]()
    for axis in found.axes:
        label, own = found.labels.get(axis, Label("")), given[axis]
        known = unit_of(label.bracket)
        if label.no_length:
            kind = f"the {_KINDS[axis]}, {label.text!r}, are no lengths for {label.no_length!r}"
            raise ValueError(f"profile_file {path}: {kind}; allowed: columns of lengths, or other labels if they are")
        if own and (stated := known or label.bare) and own != stated:
            seen = f"{path} names {stated} ({label.text!r})"
            raise ValueError(f"{axis}_unit is {own}, but {seen}; allowed: {stated}, or none")
        if unit := known or own or unknown:
            units[axis] = unit
    _check_rest(path, found, units)
    if missing := [axis for axis in found.axes if axis not in units]:
        said = [label.text for label in found.labels.values() if label.bare or not label.bracket]
        _, line, _ = next(found.head.units(), ("", ", ".join(said), ""))
        seen = f" (its line {line[:60]!r} is not understood: labels are like 'x [um]', parted as the rows are)"
        names, kinds = (" and ".join(of(axis) for axis in missing) for of in ("{}_unit".format, _KINDS.__getitem__))
        allowed = f"{', '.join(UNITS)}; or scene_units, if its numbers are in the scene's own unit"
        many = "are" if len(missing) > 1 else "is"
        kinds += seen * bool(line)
        raise ValueError(f"{names} {many} missing: {path} names no unit of its {kinds}; allowed: {allowed}")
    return units


def _check_rest(path: Path, found: Columns, units: dict[str, str]) -> None:
    """Raise `ValueError` for lines of the header that contradict units that are known, or name other quantities."""
    word, line = found.head.no_length()
    reason = "which is no length; allowed: columns of lengths, labelled like 'x [um]', parted as the rows are"
    if not word and len(units) == len(found.axes):
        said, known = list(found.head.units()), list(units.values())
        of_line = {line: {unit for unit, one, _ in said if one == line} for _, line, _ in said}
        turned = len(set(known)) > 1 and list(dict.fromkeys(unit for unit, *_ in said)) == known[::-1]
        for word, line, role in said:  # a unit without an axis is that of all, unless its line names two
            if turned or (word != units[role] if role in units else len(of_line[line]) == 1 and {word} != set(known)):
                break
            if word not in known:
                break
        else:
            word, line = "", ""
        reason = f"which contradicts {', '.join(f'{axis} in {unit}' for axis, unit in units.items())}; allowed: the "
        reason += "file's units, or a file without that line if it speaks of something else"
    if word:
        raise ValueError(f"profile_file {path}: its line {line[:60]!r} names {word!r}, {reason}")


def check_values(path: Path, found: Columns) -> None:
    """Raise `ValueError` for columns that are no profile: infinite, constant, or positions that go back."""
    x, z = found.x, found.z
    for name, values in (("x", x), ("height", z)):
        if values is None or np.isnan(values).all():
            continue
        size = np.abs(values)
        if (bad := np.flatnonzero(size > LARGEST)).size:
            allowed = f"finite numbers up to {LARGEST:g} in size ({bad.size} of {values.size} are not)"
            seen = f"{found.row(bad[0])}: {name} is {values[bad[0]]}"
            raise ValueError(f"profile_file {path}, {seen}; allowed: {allowed}")
        if 0 < np.nanmax(values) - np.nanmin(values) < 1 / LARGEST:
            raise ValueError(f"profile_file {path}: {name} ranges over less than allowed: {1 / LARGEST:g}")
    if np.nanmin(z, initial=np.inf) == np.nanmax(z, initial=-np.inf):
        raise ValueError(
            f"profile_file {path}: every height is {np.nanmax(z)}; allowed: a profile that is not constant"
        )
    known = np.zeros(0, dtype=np.int64) if x is None else np.flatnonzero(~np.isnan(x))
    if x is not None and known.size > 1 and (back := np.diff(x[known]) * np.diff(x[known[:2]]) <= 0).any():
        at = known[int(back.argmax()) + 1]
        raise ValueError(
            f"profile_file {path}, {found.row(at)}: x goes from {x[known[int(back.argmax())]]} to {x[at]}; allowed: "
            "positions that go on in one direction; columns, like 2,1, says which they are, and with those of z alone "
            "scan_length takes their place"
        )
