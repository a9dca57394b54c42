"""Tables of numbers in text files: any encoding, separator and decimal sign, with a header above."""

import itertools
import math
import re
from collections import Counter
from collections.abc import Sequence, Set
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.display import counted

from . import header

Decimal = Literal["point", "comma"]
MAX_TEXT = 2**25  # bytes of a text file

_SAMPLE = 200  # lines at the end of the table, which tell how it is written
_BETWEEN = "'\u2019\u00a0\u202f"  # thousands, besides the other decimal sign
_NUMBER = r"[-+]?(?=\d|{0}\d)(?:[1-9]\d{{0,2}}(?:[{1}]\d{{3}})+|\d*)(?:{0}{2})?(?:[eE][-+]?\d+)?|[-+]?inf"
_NUMBERS = {
    "point": re.compile(_NUMBER.format(r"\.", "," + _BETWEEN, r"\d*")),
    "comma": re.compile(_NUMBER.format(",", "." + _BETWEEN, r"\d+")),
}
_PLAIN = {"point": str.maketrans("", "", "," + _BETWEEN), "comma": str.maketrans(",", ".", "." + _BETWEEN)}
# cells that stand for a missing value: nothing, stars, hyphens, NaN, N/A and the like
_MISSING = re.compile(r"\W*|[-+]?(?:1\.)?#?(?:nan|qnan|ind)|n\.?/?a\.?|#\w+/?\w*!?|null|none|missing|invalid|bad", re.I)
_TORN = re.compile(r"(?=.*\d)(?=.*[,;\s])[-+\d.,;\s]*")  # digits and separators: parted in another way
_FIGURE = r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?\"?"
_LIKE_ROW = re.compile(rf"[\s\"]*{_FIGURE}(?:[\s\";,]+{_FIGURE}(?![\w:/.-])|\s*$)")  # two numbers and more, or one
_MINUS = str.maketrans("\u2212\u2013", "--")  # as it is printed
_NAMES = {";": "semicolons", "\t": "tabs", ",": "commas", None: "spaces"}


class Table(NamedTuple):
    """A table of numbers, and the header above it: all columns of a file, or those of x and z, or z alone."""

    values: Array64  # shape (rows, columns); NaN for missing ones, inf for text
    origin: str  # how they were found, in words
    numeric: Sequence[int]  # columns that hold numbers
    head: header.Header  # with a label for each column, empty ones, too
    line: int = 0  # of the first row in a text; 0 elsewhere
    texts: Sequence[str] = ()  # of the rows, or of the first one, shortened

    @property
    def labels(self) -> dict[str, header.Label]:
        """Those of 'x', if it is there, and 'z', once they are chosen."""
        return dict(zip("xz"[-len(self.head.labels) :], self.head.labels, strict=True))

    def row(self, i: int) -> str:
        """Where the row with index i stands."""
        return f"line {self.line + i}" if self.line else f"row {i + 1}"


class _Writing(NamedTuple):
    """How the rows of a table are written."""

    delimiter: str | None  # None for spaces
    decimal: str
    numeric: Sequence[int] = ()  # columns of numbers
    columns: int = 0  # how many, others too
    share: float = 0.0  # of the cells, that are numbers or missing
    signs: Set[str] = frozenset()  # characters of the numbers

    def number(self, cell: str) -> float:
        """The number in a cell, NaN for a missing one, inf for anything else."""
        if self.decimal == "point" and "_" not in cell:  # most are plain
            try:
                return float(cell)
            except ValueError:
                pass
        if _NUMBERS[self.decimal].fullmatch(cell):
            return float(cell.translate(_PLAIN[self.decimal]))
        return math.nan if _MISSING.fullmatch(cell) else math.inf

    def row(self, line: str) -> list[float]:
        """The numbers in the numeric columns of a line; empty if the line has not the columns of the table."""
        cells = header.cells(line, self.delimiter)
        more = filter(None, cells[self.columns :])
        torn = any(self.delimiter is not None or self.number(cell) != math.inf for cell in more)
        if torn or len(cells) <= self.numeric[-1] or not line.strip():
            return []
        return [self.number(cells[i]) for i in self.numeric]

    def counted(self, lines: Sequence[str]) -> "_Writing":
        """The same with the columns that it finds in some lines; without numeric ones if it tears numbers apart."""
        split = [header.cells(line, self.delimiter) for line in lines]
        count = Counter(map(len, split)).most_common(1)[0][0] if split else 0
        numeric, found, signs = [], 0, set[str]()
        for i, column in enumerate(zip(*(cells for cells in split if len(cells) == count), strict=True)):
            values = {cell: self.number(cell) for cell in column}
            known = sum(values[cell] != math.inf for cell in column)
            numbers = [cell for cell, value in values.items() if math.isfinite(value)]
            if numbers and 2 * known >= len(column):
                numeric.append(i)
                found += known
                signs.update(*numbers)
            elif any(map(_TORN.fullmatch, column)):
                return self
        return _Writing(self.delimiter, self.decimal, numeric, count, found / max(1, count * len(split)), signs)

    def told(self) -> str:
        """The same in words."""
        between = f"{_NAMES[self.delimiter]} between columns" if self.columns > 1 else "one column"
        return f"{between}, decimal commas" if self.decimal == "comma" else between


def read_text(path: Path, name: str, decimal: Decimal | None) -> Table:
    """The table at the end of a text file, from the first line on that is a row like the last ones.

    name: of the file, for records; decimal: the decimal sign, None for the one that is found. Raises `ValueError`.
    """
    lines = _decoded(path).replace("\r\r\n", "\n").translate(_MINUS).splitlines()
    while lines and not lines[-1].strip(" \t,;"):
        lines.pop()
    writing, unclear = _find(lines, decimal)
    rows = [writing.row(line) for line in lines]
    first = next((i for i, row in enumerate(rows) if math.inf not in row and any(map(math.isfinite, row))), 0)
    while first and (row := rows[first - 1]):  # also rows that miss all values, but no rule below the labels
        missing = math.inf not in row and re.search(r"[^\W\d_]|\*\*", lines[first - 1])
        if not missing and not any(map(math.isfinite, row)):
            break
        first -= 1
    begin = lines[first].strip()[:40]
    for i, pair in enumerate(itertools.pairwise(lines[:first])):
        if all(map(_LIKE_ROW.match, pair)):
            seen = f"line {i + 1}: {pair[0].strip()[:40]!r} is not written as the rows from line {first + 1} on are"
            raise ValueError(f"{seen}; allowed: one table ({writing.told()}), below its header")
    head = header.read(lines[:first], writing.delimiter, writing.columns, writing.numeric[-1] + 1)
    parted = all(head.labels[i].text for i in writing.numeric) and any(label.bracket for label in head.labels)
    if unclear and not (writing.delimiter == "," and parted):
        seen = f"in {begin!r}, commas may be decimal signs"
        raise ValueError(f"decimal is missing: {seen}; allowed: comma, or point, also for commas between whole numbers")
    if [] in rows[first:]:
        i = rows.index([], first)
        text = lines[i].strip()[:40]
        seen = f": {text!r} is not {counted(writing.columns, 'cell')}" if text else " is empty"
        allowed = f"rows like {begin!r} in line {first + 1} to the end ({writing.told()})"
        raise ValueError(f"line {i + 1}{seen}; allowed: {allowed}")
    values = np.full((len(lines) - first, writing.columns), np.nan)
    values[:, list(writing.numeric)] = rows[first:]
    origin = f"numbers of {name}, {writing.told()}, {counted(first, 'line')} of header"
    return Table(values, origin, writing.numeric, head, first + 1, [line.strip()[:40] for line in lines[first:]])


def _decoded(path: Path) -> str:
    """The text of a file: UTF-8, UTF-16 with its mark, else Latin-1."""
    if path.stat().st_size > MAX_TEXT:
        raise ValueError(f"the text is too long; allowed: {MAX_TEXT} bytes, or .npy or .h5")
    content = path.read_bytes()
    try:
        return content.decode("utf-16" if content.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _find(lines: Sequence[str], decimal: Decimal | None) -> tuple[_Writing, bool]:
    """How the table at the end is written, and whether its commas may be decimal signs or not. Raises `ValueError`."""
    last = [line for line in lines[-_SAMPLE:] if line.strip()]
    quoted = any('"' in line for line in last)
    ways = [_Writing(delimiter, sign).counted(last) for sign in _NUMBERS for delimiter in _NAMES]
    ways = [way for way in ways if way.numeric and (quoted or (way.delimiter, way.decimal) != (",", "comma"))]
    best = max(ways, key=lambda way: (way.share, way.decimal == decimal, way.columns), default=None)
    if best is None or decimal not in (None, best.decimal):
        signs = f" with decimal {decimal}s" if decimal else ""
        seen = f"no table of numbers{signs}; the last line is {''.join(lines[-1:]).strip()[:40]!r}"
        allowed = "rows to the end, parted by commas, semicolons, tabs, spaces; decimal commas between commas in quotes"
        raise ValueError(f"{seen}; allowed: {allowed}")
    others = any(way.share == best.share and (way.decimal, way.columns) != (best.decimal, best.columns) for way in ways)
    whole = best.delimiter == "," and best.decimal == "point" and "." not in best.signs
    return best, decimal is None and (whole or (others and ("," in best.signs or best.delimiter == ",")))
