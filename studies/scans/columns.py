"""Positions and heights in a file: text, .npy, HDF5 datasets, and the formats of instruments."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver.display import counted
from linecontact.solver.scene import MAX_POINTS

from ..files import confined
from ..terminal.text import shown_name
from ..terminal.units import UNITS, unit_of
from .header import Header, Label
from .text import Decimal, Table, read_text

MAX_REFINEMENT = 16  # grid points over values in the file
MAX_VALUES = MAX_POINTS // MAX_REFINEMENT  # numbers in a file: enough for the largest grid
LARGEST = 1e100  # number in a file, and its inverse the smallest range: squares are taken
_TEXT, _HDF5 = (".csv", ".txt", ".dat", ".asc", ".tsv"), (".h5", ".hdf5")  # as the names of such files end
_KINDS = {"x": "positions", "z": "heights"}


def load(path: Path, dataset: str | None, columns: str | None, decimal: Decimal | None) -> Table:
    """The columns of x and z, or of z alone, of a profile file. Raises `ValueError`, and the errors of reading.

    dataset: name of the one to read in an HDF5 file, None for the only one. columns: numbers of those of x and z, or
    of z alone, from 1; None for those that the file makes clear. decimal: the decimal sign of a text.
    """
    suffix, name, known = path.suffix.lower(), shown_name(path), (*_TEXT, ".npy", *_HDF5)
    fits = {"profile_dataset": (dataset, _HDF5), "decimal": (decimal, _TEXT), "columns": (columns, known)}
    for option, (value, of) in fits.items():
        if value is not None and suffix not in of:
            raise ValueError(f"{option} is {value}; allowed: none, the file is not {', '.join(of)}")
    if suffix in _TEXT:
        return _choose(read_text(path, name, decimal), columns)
    if suffix == ".npy":
        try:
            with np.errstate(over="raise"):
                array = np.lib.format.open_memmap(path, mode="r")  # takes no memory for a shape that is only claimed
        except Exception:  # of the tokenizer, for instance
            raise ValueError("it is damaged, or not a plain array; allowed: real numbers") from None
        return _choose(_table(array, f"array of {name}"), columns)
    try:
        if suffix in _HDF5:
            values, unit, said = confined.read_dataset(path, MAX_VALUES, dataset)
            return _choose(_table(values, f"dataset {dataset or 'only one'} of {name}"), columns, Label(said, unit))
        values, unit, _ = confined.read_scan(path, MAX_VALUES)
        return _choose(_table(values.T, f"{name} by SurfaceTopography"), None, Label("its format" * bool(unit), unit))
    except confined.BrokenError as error:
        allowed = f"{', '.join(known)}, and with `pip install SurfaceTopography` the formats that it reads"
        raise ValueError(f"it is damaged, or of no known kind: {error}; allowed: {allowed}") from None


def _table(found: Any, origin: str) -> Table:
    """A table of real numbers, shape (rows, columns)."""
    if found.dtype.kind not in "fiu" or found.ndim not in (1, 2) or 0 in found.shape or found.size > MAX_VALUES:
        seen = f"it holds {str(found.dtype)[:40]} of shape {found.shape}, {found.size} numbers"
        raise ValueError(f"{seen}; allowed: columns of real numbers, up to {MAX_VALUES}")
    with np.errstate(over="ignore"):  # of a longer type: infinite, and refused as such
        values = np.asarray(found.astype(np.float64).reshape(len(found), -1))
    first = ", ".join(map("{:g}".format, values[0, :8]))
    return Table(values, origin, range(values.shape[1]), Header([Label("")] * values.shape[1]), texts=[first])


def _choose(table: Table, columns: str | None, label: Label | None = None) -> Table:
    """The columns of x and z that are asked for, or clear, with a label of their own or the table's."""
    places = _places(table) if columns is None else _asked(columns, table)
    at = list(places.values())
    shown = "".join(f", {axis} from column {place + 1}" for axis, place in places.items())
    head = table.head._replace(labels=[label or table.head.labels[place] for place in at])
    return table._replace(values=table.values[:, at], origin=table.origin + shown, numeric=range(len(at)), head=head)


def _asked(columns: str, table: Table) -> dict[str, int]:
    """The places of x and z from the user's "2,3", or "3" for heights alone."""
    labels = table.head.labels
    numbers = [int(word) - 1 if word.strip().isdecimal() and len(word) < 9 else -1 for word in columns.split(",")]
    if len(numbers) > 2 or len(set(numbers)) < len(numbers) or not set(numbers) <= set(table.numeric):
        allowed = f"{', '.join(str(i + 1) for i in table.numeric[:8])}, the columns of numbers"
        raise ValueError(f"columns is {columns!r}; allowed: {allowed}, those of x and z like 1,2, or of z alone")
    places = dict(zip("xz"[-len(numbers) :], numbers, strict=True))
    if labels[places["z"]].role == "x" or ("x" in places and labels[places["x"]].role == "z"):
        texts = ", ".join(repr(labels[i].text) for i in numbers)
        raise ValueError(f"columns is {columns!r}, labelled {texts}; allowed: x and z as the labels have them")
    return places


def _places(table: Table) -> dict[str, int]:
    """The places of x and z, as the labels of the columns have them, or their usual order."""
    labels, numeric = table.head.labels, list(table.numeric)
    first, last, roles = numeric[0], numeric[-1], [labels[i].role for i in numeric]
    without = [labels[i] for i in sorted({*range(len(labels))} - {*numeric})]
    empty = [label.text for label in without if label.role == "z"]
    if empty and "z" not in roles:
        raise ValueError(f"no numbers below {empty[0]!r} in {table.texts[0]!r}; allowed: heights, or other columns")
    second = len(numeric) > 2 and any(re.match(r"y\b", label.text.lower()) for label in labels)
    known = all(labels[i].role or labels[i].asks for i in numeric)
    if len(numeric) == 1 and known and roles[0] not in ("x", "index") and "x" not in [label.role for label in without]:
        return {"z": first}
    if roles.count("x") == roles.count("z") == 1 and not second:
        return {axis: numeric[roles.index(axis)] for axis in "xz"}
    if known and len(numeric) == 2 and roles[0] != "z" and roles[1] not in ("x", "index"):
        return {"z": last} if roles[0] == "index" else {"x": first, "z": last}
    texts = f" labelled {', '.join(repr(labels[i].text) for i in numeric[:8])}" * any(label.text for label in labels)
    texts += "".join(f", none below {label.text!r}" for label in without[:8] if label.text)
    seen = f"the file has {counted(len(numeric), 'column')} of numbers{texts}, the first row {table.texts[0]}"
    raise ValueError(f"columns is missing: {seen}; allowed: the numbers of those of x and z like 1,2, or of z alone")


def units(found: Table, given: dict[str, str | None], unknown: str | None) -> dict[str, str]:
    """The unit of each axis, 'x' and 'z', or 'z' alone; given: the user's; unknown: for numbers of no known unit.

    Raises `ValueError` where a unit is not known, or a word of the file contradicts the user or its own labels.
    """
    units = dict[str, str]()
    for axis, label in found.labels.items():
        known, own = unit_of(label.bracket), given[axis]
        if label.no_length:
            seen = f"the {_KINDS[axis]}, {label.text!r}, are no lengths for {label.no_length!r}"
            raise ValueError(f"{seen}; allowed: columns of lengths, or other labels if they are")
        if own and (stated := known or label.bare) and own != stated:
            seen = f"the file names {stated} ({label.text!r})"
            raise ValueError(f"{axis}_unit is {own}, but {seen}; allowed: {stated}, or none")
        if unit := known or own or unknown:
            units[axis] = unit
    for line, said, other in found.head.said():
        role = Label(line).role
        expected = [units[role]] if role in units else list(dict.fromkeys(units.values()))
        if other or (said and len(units) == len(found.labels) and said != expected):
            of = ", ".join(f"{axis} in {unit}" for axis, unit in units.items())
            reason = f"contradicts {of}; allowed: the file's units, or a file without that line if it is about others"
            if other:
                reason = "is no length; allowed: columns of lengths, labelled like 'x [um]', parted as the rows are"
            raise ValueError(f"its line {line[:60]!r} names {other or ' and '.join(said)!r}, which {reason}")
    if missing := [axis for axis in found.labels if axis not in units]:
        names, kinds = (" and ".join(of(axis) for axis in missing) for of in ("{}_unit".format, _KINDS.__getitem__))
        labels = ", ".join(filter(None, (found.labels[axis].text for axis in missing)))
        line = next((line for line, said, _ in found.head.said() if said), labels)
        why = f" (its line {line[:60]!r} is not understood: labels are like 'x [um]', parted as the rows are)"
        seen = f"the file names no unit of its {kinds}{why if line else ''}"
        allowed = f"{', '.join(UNITS)}; or scene_units, if its numbers are in the scene's own unit"
        raise ValueError(f"{names} {'are' if missing[1:] else 'is'} missing: {seen}; allowed: {allowed}")
    return units


def check_values(found: Table) -> None:
    """Raise `ValueError` for columns that are no profile: infinite, constant, or positions that go back."""
    for name, values in zip(("height", "x"), found.values.T[::-1], strict=False):
        if not (there := np.flatnonzero(~np.isnan(values))).size:
            continue
        if (bad := there[np.abs(values[there]) > LARGEST]).size:
            seen = f"{name} is {values[bad[0]]}".replace("is inf", "is text or inf")
            allowed = f"finite numbers up to {LARGEST:g} in size ({bad.size} of {values.size} are not)"
            where = f"{found.row(bad[0])}: {seen}" + (f" in {found.texts[bad[0]]!r}" if found.line else "")
            raise ValueError(f"{where}; allowed: {allowed}, or with missing empty cells, NaN, ***")
        low, high, steps = values[there].min(), values[there].max(), np.diff(values[there])
        if high - low < 1 / LARGEST:
            raise ValueError(f"{name} ranges from {low} to {high}; allowed: a range of at least {1 / LARGEST:g}")
        if name == "x" and (back := np.flatnonzero(steps * np.median(steps) <= 0)).size:
            before, at = there[back[0] :][:2]
            seen = f"{found.row(at)}: x goes from {values[before]} to {values[at]}"
            more = "columns, like 2,1, says which they are, and with those of z alone scan_length takes their place"
            raise ValueError(f"{seen}; allowed: positions that go on in one direction; {more}")
