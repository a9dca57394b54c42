"""A layer's stiffness from a file: two columns, wave number and K."""

import math
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from linecontact.solver import TabulatedLayer
from linecontact.solver.display import counted

from ..terminal.text import is_refusal
from ..terminal.units import UNITS, plain, unit_of

_MOST_BYTES = 2**24
_SPEAKS = re.compile(r"\W*(?:(q|k|wave\s?numbers?|stiffness)|(?:length\s)?units?)\b(.*)", re.I)
"""Part of a comment that speaks of q or K, or of units."""
_OVER_LENGTH = re.compile(
    r"(?:(?:\b1|[^\W\d]|[)\]])\s*/\s*|\bper\s+)([^\W\d]+)(?!\w|\s*\^)"
    r"|([^\W\d]+)(?:\s*(?:\^|\*\*)\s*[({]?\s*)?[-\N{MINUS SIGN}]\s*1\b"
)
"""A unit of length there, in 1/um, MPa/mm, m^-1 or per um."""


@dataclass(frozen=True)
class Options:
    """A layer whose stiffness K(q) is read from a file, for instance a graded one."""

    stiffness_file: Path
    """Text of two columns, parted by spaces or commas, with eight rows or more: q [1/length] in increasing order, K(q)
    [pressure/length], in the scene's units. Text after # is a comment; beside a scan it must name no other units."""
    contact_modulus: float | None = None
    """E* [pressure] of p* and kappa; default: 2 K/q of the last row."""


def read(options: Options, length_unit: str) -> TabulatedLayer:
    """The layer. length_unit: that of the scene's lengths. Raises `ValueError` for a file that is none, for one that
    names another unit, and like `TabulatedLayer`.
    """
    path = options.stiffness_file
    what = f"stiffness_file is {path}"
    if not os.path.isfile(path):  # Path's own raises for some names
        raise ValueError(f"{what}, which is not a file; allowed: an existing file, with two columns, q and K(q)")
    if path.stat().st_size > _MOST_BYTES:
        raise ValueError(f"{what}, of {path.stat().st_size} bytes; allowed: up to {_MOST_BYTES}")
    try:
        written = path.read_text(encoding="utf-8-sig").splitlines()
        lines = [line.replace(",", " ") for line in written]
        if all(not line.partition("#")[0].strip() for line in lines):
            raise ValueError("it has no rows")
        rows = np.loadtxt(lines, ndmin=2)
        comments = [line for line in map(plain, written) if "#" in line]
    except (OSError, UnicodeDecodeError, ValueError) as error:
        said = str(error).splitlines()[0]
        raise ValueError(
            f"{what}, which cannot be read ({said}); allowed: text of two columns, q and K(q), with # before a header"
        ) from None
    if rows.shape[1] != 2:
        raise ValueError(f"{what}, of {counted(rows.shape[1], 'column')}; allowed: two, q and K(q)")
    _check_units(what, comments, length_unit)
    modulus = math.nan if options.contact_modulus is None else options.contact_modulus
    try:
        return TabulatedLayer(tuple(rows[:, 0].tolist()), tuple(rows[:, 1].tolist()), modulus, path.name)
    except ValueError as error:
        if not is_refusal(error):
            raise
        raise ValueError(f"{what}, whose {error}") from None


def _check_units(what: str, comments: Sequence[str], own: str) -> None:
    """Raise `ValueError` where a comment names another unit of length than the scene's, if that is known."""
    for line in comments if own in UNITS else ():
        for word in _words_of_units(line.partition("#")[2]):
            unit = unit_of(word)
            if unit and unit != own:
                raise ValueError(
                    f"{what}, whose line {line.strip()[:60]!r} names {unit}, and the scene's lengths are in {own}; "
                    f"allowed: q in 1/{own} and K in the scene's pressure over {own}, or another length_unit"
                )


def _words_of_units(comment: str) -> Iterator[str]:
    """Words of a comment that may be units of the lengths in q and K."""
    for part in re.split(r"[,;]|\band\b", comment):
        if found := _SPEAKS.fullmatch(part):
            of_q_or_k, said = found.groups()
            if of_q_or_k:
                yield from (one or other for one, other in _OVER_LENGTH.findall(said))
            else:
                yield from re.findall(r"[^\W\d]+", said)
