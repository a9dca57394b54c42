"""Tables of numbers in text files as instruments write them: any encoding, separator, decimal sign and header."""

import codecs
import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.display import counted

from .header import Label, is_downwards, labels, like_labels, stated_units

Decimal = Literal["point", "comma"]

MAX_TEXT = 2**25
"""Bytes of a text file."""

_MAX_LINE = 1000  # characters of a line of numbers
_MAX_HEADER = 1000  # lines before them
_SAMPLE = 200  # lines of the table, that tell how it is written
_AROUND = ' \t"'  # what may stand around a number
_COMMA = re.compile(r"[-+]?(?:\d+,?\d*|,\d+)(?:[eE][-+]?\d+)?")
_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(?:,\d{3})+")
_NAMES = {";": "semicolons", "\t": "tabs", ",": "commas", None: "spaces"}


@dataclass(frozen=True)
class Writing:
    """How the numbers of a line are written."""

    delimiter: str | None
    """What parts columns; None for spaces."""
    decimal: Decimal
    """The decimal sign."""

    def cells(self, line: str) -> list[str]:
        """The cells of a line, without empty ones at its end."""
        cells = [cell.strip(_AROUND) for cell in line.split(self.delimiter)] if len(line) <= _MAX_LINE else []
        while cells and not cells[-1]:
            cells.pop()
        return cells

    def numbers(self, line: str) -> int:
        """How many numbers a line consists of; 0 if there is anything else."""
        cells = self.cells(line)
        return len(cells) if all(map(self._is_number, cells)) else 0

    def _is_number(self, cell: str) -> bool:
        if self.decimal == "comma":
            return bool(_COMMA.fullmatch(cell))
        try:
            float(cell)
        except ValueError:
            return False
        return True

    def plain(self, line: str) -> str:
        """The line with decimal points and without empty cells at its end, for NumPy."""
        line = line.replace('"', " ").rstrip(f"{self.delimiter or ''}{_AROUND}")
        return line.replace(",", ".") if self.decimal == "comma" else line

    def told(self, count: int) -> str:
        """The same in words, for that many columns."""
        between = f"{_NAMES[self.delimiter]} between columns" if count > 1 else "one column"
        return f"{between}, decimal commas" if self.decimal == "comma" else between


@dataclass(frozen=True)
class Table:
    """A table of numbers, and what its file says of it."""

    values: Array64
    """The numbers, shape (rows, columns)."""
    origin: str
    """How they were found, in words."""
    labels: Sequence[Label] = ()
    """What is written above each column; empty if there is nothing."""
    stated: Sequence[tuple[str, str, str]] = ()
    """Units that the file names elsewhere, see `header.stated_units`."""
    is_downwards: bool = False
    """Whether the header says that heights may grow into the valleys."""
    unread: str = ""
    """A line that may be labels but is not taken for them, see `header.like_labels`."""
    line: int = 0
    """That of the first row in a text; 0 elsewhere."""


def read_text(path: Path, name: str, decimal: Decimal | None) -> Table:
    """The table in a text file. It begins where two lines in a row hold nothing but numbers, and as many of them.

    name: of the file, for records; decimal: the decimal sign, None for the one that is found. Raises `ValueError`.
    """
    lines = _decoded(path).replace("\r\r\n", "\n").replace("\u2212", "-").splitlines()  # a minus as it is printed
    while lines and not lines[-1].strip(" \t,;"):
        lines.pop()
    found = _find(path, lines, decimal)
    writing, first, count = found.writing, found.first, found.count
    if writing.delimiter == "," and decimal is None and _are_decimal_too(lines, found):
        row = lines[first].strip()[:40]
        raise ValueError(
            f"profile_file {path}, line {first + 1}: commas seem to stand for decimal points and between columns, too, "
            f"in {row!r}; allowed: semicolons or tabs between columns, or, for integers, --decimal point"
        )
    for i in range(first, len(lines)):
        if not lines[i].strip():  # what is before may be a header of numbers
            after = next((line.strip() for line in lines[i:] if line.strip()), "")
            behind = "" if writing.numbers(after) == count else f", and {after[:40]!r} stands behind the table"
            raise ValueError(f"profile_file {path}, line {i + 1} is empty{behind}; allowed: rows of numbers to the end")
    if writing.decimal == "comma" and any("." in line for line in lines[first:]):
        i = next(i for i in range(first, len(lines)) if "." in lines[i])
        raise ValueError(
            f"profile_file {path}, line {i + 1}: {lines[i].strip()[:40]!r} has a point; allowed: decimal commas, as in "
            "other lines, and nothing that parts thousands"
        )
    try:
        values = np.loadtxt(map(writing.plain, lines[first:]), delimiter=writing.delimiter, ndmin=2, comments=None)
    except ValueError as error:
        for i in range(first, len(lines)):
            if writing.numbers(lines[i]) != count:
                raise ValueError(_not_a_row(path, lines, i, writing, count)) from None
        # what float() reads and NumPy does not, like 1_0
        raise ValueError(f"profile_file {path}: {error}; allowed: plain numbers") from None
    head = lines[:first]
    cells = writing.cells(head[-1]) if head else []
    if len(cells) == count and any(writing.numbers(cell) for cell in cells if cell):
        raise ValueError(
            f"profile_file {path}, line {first}: {head[-1].strip()[:40]!r} looks like a row of the table below; "
            f"allowed: {counted(count, 'number')} there, or an empty line between header and table"
        )
    origin = f"numbers of {name}, {writing.told(count)}, {counted(first, 'line')} of header"
    labelled = labels(head, writing.delimiter, count)
    unread = "" if labelled else like_labels(head, writing.delimiter, count)
    return Table(values, origin, labelled, tuple(stated_units(head)), is_downwards(head), unread, first + 1)


def _decoded(path: Path) -> str:
    """The text of a file: UTF-8, UTF-16 with or without its mark, else Latin-1."""
    with path.open("rb") as file:
        content = file.read(MAX_TEXT + 1)
    if len(content) > MAX_TEXT:
        raise ValueError(f"profile_file {path} is too long; allowed: {MAX_TEXT} bytes of text, or .npy or .h5")
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    start = content[:1000]
    for encoding, zeros in (("utf-16-le", start[1::2]), ("utf-16-be", start[0::2])):
        if zeros and zeros.count(0) > 0.8 * len(zeros) and not len(content) % 2:
            return content.decode(encoding, errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


@dataclass(frozen=True)
class _Found:
    """A table, as one way of writing numbers has it."""

    writing: Writing
    """The way."""
    first: int
    """Its first line."""
    count: int
    """Its columns."""
    run: int
    """Lines that are rows of it, as far as was looked."""


def _find(path: Path, lines: Sequence[str], decimal: Decimal | None) -> _Found:
    """Where the table is, and how it is written. Raises `ValueError` if that is not clear."""
    points = [Writing(delimiter, "point") for delimiter in (";", "\t", ",", None)]
    commas = [Writing(delimiter, "comma") for delimiter in (";", "\t", None)]
    ways = points + commas if decimal is None else commas if decimal == "comma" else points
    found = [table for table in (_table(lines, writing, decimal is None) for writing in ways) if table]
    if not found:
        signs = "" if decimal is None else f", with decimal {decimal}s"
        allowed = (
            f"columns of numbers behind up to {_MAX_HEADER} lines of header, line after line, a number in every cell, "
            "parted by commas, semicolons, tabs or spaces"
        )
        seen = f"; the last line is {lines[-1].strip()[:40]!r}" if lines else ""
        raise ValueError(f"profile_file {path} holds no table of numbers{signs}{seen}; allowed: {allowed}")
    longest = max(table.run for table in found)
    best, *others = [table for table in found if table.run == longest]
    labelled = next((one for one in found if one.writing.delimiter == "," and _after_labels(lines, one)), None)
    if labelled:  # as many labels between commas as numbers: these part columns
        if labelled.run < longest:  # written in another way, lines above it would be rows, too
            _check_rows(path, lines, labelled)
        return labelled
    unclear = any((other.first, other.count) != (best.first, best.count) for other in others)
    if unclear or (decimal is None and _may_be_thousands(best.writing, lines[best.first :])):
        raise ValueError(
            f"decimal is missing: in {lines[best.first].strip()[:40]!r}, line {best.first + 1} of {path}, the comma "
            "may be a decimal sign or not; allowed: comma, point"
        )
    return best


def _are_decimal_too(lines: Sequence[str], table: _Found) -> bool:
    """Whether the commas between the cells of a table of integers may be decimal signs, too: every other cell begins
    with zeros and its neighbours do not, or there is one label with a unit for two cells.
    """
    rows = [table.writing.cells(line) for line in lines[table.first : table.first + _SAMPLE]]
    rows = [row for row in rows if len(row) == table.count]
    if table.count % 2 or not all(re.fullmatch(r"[-+]?\d+", cell) for row in rows for cell in row):
        return False
    if _after_labels(lines, table):
        return False
    whole, fractions = ([cell for row in rows for cell in row[i::2]] for i in (0, 1))
    head = lines[: table.first]
    labelled = table.count > 2 and any(label.names_unit for label in labels(head, ",", table.count // 2))
    zeros = any(re.fullmatch(r"0\d+", cell) for cell in fractions)
    zeros &= not any(re.fullmatch(r"[-+]?0\d+", cell) for cell in whole)
    return (labelled or zeros) and not any(cell[0] in "+-" for cell in fractions)


def _after_labels(lines: Sequence[str], table: _Found) -> int:
    """The line after the last one above a table that labels its columns with units; 0 without one."""
    for end in range(table.first, 0, -1):
        if any(label.names_unit for label in labels(lines[:end], table.writing.delimiter, table.count)):
            return end
    return 0


def _check_rows(path: Path, lines: Sequence[str], table: _Found) -> None:
    """Whether all lines between the labels and a table are rows of it, or empty. Raises `ValueError`."""
    for i in range(_after_labels(lines, table), table.first):
        if lines[i].strip() and table.writing.numbers(lines[i]) != table.count:
            raise ValueError(_not_a_row(path, lines, i, table.writing, table.count))


def _not_a_row(path: Path, lines: Sequence[str], i: int, writing: Writing, count: int) -> str:
    numbers, cells = counted(count, "number"), lines[i].split(writing.delimiter)
    lacking = len(cells) == count and any(map(writing.numbers, cells))
    without = "; you may delete lines whose value is missing" * lacking
    return (
        f"profile_file {path}, line {i + 1}: {lines[i].strip()[:40]!r} is not {numbers}; allowed: {numbers} in every "
        f"line ({writing.told(count)}){without}"
    )


def _table(lines: Sequence[str], writing: Writing, with_sign: bool) -> _Found | None:
    """The table that begins where two lines in a row have as many numbers; None without one.

    with_sign: whether a table of decimal commas must show one.
    """
    counts = [writing.numbers(line) for line in lines[: _MAX_HEADER + _SAMPLE]]
    starts = (i for i, (a, b) in enumerate(itertools.pairwise(counts[: _MAX_HEADER + 2])) if a and a == b)
    first = next(starts, None)
    if first is None:
        return None
    count, rows = counts[first], counts[first : first + _SAMPLE]
    run = next((i for i, other in enumerate(rows) if other != count), len(rows))
    if with_sign and writing.decimal == "comma" and not any("," in line for line in lines[first : first + run]):
        return None
    return _Found(writing, first, count, run)


def _may_be_thousands(writing: Writing, lines: Sequence[str]) -> bool:
    """Whether all decimal commas could as well part thousands."""
    if writing.decimal == "point":
        return False
    with_comma = [cell for line in lines[:_SAMPLE] for cell in writing.cells(line) if "," in cell]
    return bool(with_comma) and all(map(_THOUSANDS.fullmatch, with_comma))
