"""A stored file as one table for pandas or a spreadsheet: comma-separated values as RFC 4180 has them, in UTF-8.

The first line names the columns, those of numbers with their units in brackets, '-' for dimensionless ones. Numbers
have all their digits, and those that are not finite are nan, inf and -inf.
"""

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver.units import named, shown
from numpy.typing import NDArray

from .hdf5 import file_kind
from .records import unit
from .solution_files import FIELDS, KIND, load
from .study_files import load_study
from .writing import StoreError

_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")
"""A spreadsheet takes a text that begins with one of these for a formula; it takes an apostrophe before it for text."""

_BLOCK = 2**14  # rows that are written at a time

Columns = dict[str, Sequence[Any] | NDArray[np.float64]]


def table(path: Path) -> Iterator[bytes]:
    """The table of a stored file, part by part: of a study a line for each run, of a solution one for each grid point.

    Raises like `hdf5.open_file`, and `StoreError` for a study without a run; both before the first part.
    """
    columns = _fields(path) if file_kind(path) == KIND else _runs(path)
    return _written(columns)


def _fields(path: Path) -> Columns:
    """The fields of a solution by their headings."""
    solution = load(path)
    names = named(solution.results, "scene.")
    return {_heading(name, names): getattr(solution, name) for name in FIELDS}


def _runs(path: Path) -> Columns:
    """The numbers and texts of the runs of a study, by headings."""
    study = load_study(path)
    if not study.runs:
        raise StoreError(f"file {path} holds no finished run yet; allowed: a study with at least one")
    columns = {name: [run[name] for run in study.runs] for name in study.runs[0]}
    texts = {name for name, values in columns.items() if any(isinstance(value, str) for value in values)}
    first, *others = (named(run, "scene.") for run in study.runs)
    names = first if all(one == first for one in others) else named({})
    return {name if name in texts else _heading(name, names): values for name, values in columns.items()}


def _heading(name: str, names: Mapping[str, str]) -> str:
    return f"{name} [{shown(unit(name), names)}]"


def _written(columns: Columns) -> Iterator[bytes]:
    yield _lines([list(columns)])
    for start in range(0, len(next(iter(columns.values()))), _BLOCK):
        block = (column[start : start + _BLOCK] for column in columns.values())
        yield _lines(zip(*(part.tolist() if isinstance(part, np.ndarray) else part for part in block), strict=True))


def _lines(rows: Iterable[Iterable[Any]]) -> bytes:
    text = io.StringIO(newline="")
    csv.writer(text).writerows([_cell(value) for value in row] for row in rows)
    return text.getvalue().encode("utf-8", "replace")


def _cell(value: Any) -> Any:
    """A value as it is written: a text that a spreadsheet would compute gets an apostrophe."""
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value
