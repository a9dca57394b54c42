"""Units of length and pressure, in the spellings that instruments and people use."""

import math
import re
import unicodedata
from decimal import Decimal
from typing import Literal, NamedTuple

from linecontact.solver.units import PRESSURES, SCENE

from .text import IN_RANGE, number, pointed

Unit = Literal["m", "cm", "mm", "um", "nm", "pm", "angstrom", "inch"]

UNITS: dict[str, float] = {
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "nm": 1e-9,
    "pm": 1e-12,
    "angstrom": 1e-10,
    "inch": 0.0254,
}
"""Units of length in metres."""

_PREFIXES = {"": "m", "centi": "cm", "milli": "mm", "micro": "um", "mikro": "um", "nano": "nm", "pico": "pm"}

_SPELLINGS = {
    **{unit: unit for unit in UNITS},
    **{f"{prefix}met{end}": unit for prefix, unit in _PREFIXES.items() for end in ("er", "re", "ers", "res")},
    **dict.fromkeys(("\u03bcm", "micron", "microns", "mikron", "\u03bc", "\u043c\u043a\u043c"), "um"),
    **{"\u043d\u043c": "nm", "\u043c\u043c": "mm"},
    **dict.fromkeys(("\u00e5", "angstroms", "\u00e5ngstr\u00f6m", "\u00e5ngstrom", "angstr\u00f6m"), "angstrom"),
    **dict.fromkeys(("in", "inches", '"'), "inch"),
}
_PRESSURE_SPELLINGS = {**{unit: unit for unit in PRESSURES}, "N/m2": "Pa", "N/mm2": "MPa"}
_LARGE = {"Mm", "Pm"}
"""Not millimetres and picometres: the capital letter makes them 10^6 and 10^15 m."""
_SHORT = {"m", "in", '"', "\u03bc", "\u00e5"}
"""Units only where a unit is expected: elsewhere they are words, or letters."""


_NUMBER_AND_UNIT = re.compile(r"(.*?[\d.])\s*((?!e[-+]?\d)(?:[^\W\d_]|\").*)", re.I)
_LINE_LOAD = re.compile(r"[kmM]?N/(?:m|mm|um)")
_SIZES = {"length": UNITS, "pressure": PRESSURES}


class Own(NamedTuple):
    """A scene's own unit of length, or of pressure."""

    unit: str
    """One that is known; any other text where there is none."""
    said: bool = True
    """Whether the user chose it, so that lengths or pressures may be numbers alone."""
    of: str = "length"
    """The quantity: 'length' or 'pressure'."""


def pressure_unit(text: str) -> str | None:
    """The unit of pressure behind a number; None if there is none."""
    parted = _NUMBER_AND_UNIT.fullmatch(text.strip())
    return _PRESSURE_SPELLINGS.get(plain(parted[2]).replace("^", "")) if parted else None


def read(name: str, text: str, own: Own | None, allowed: str = "a number") -> float:
    """A number as it is written on the command line, like 0.1 or 2^18, or a length or a pressure with its unit.

    name: of the option, for messages. own: the unit of the scene's lengths or pressures; None: it has none. allowed:
        the message for a text that is no number. Raises `ValueError`.
    """
    text = text.strip()
    parted = _NUMBER_AND_UNIT.fullmatch(text) if own else None
    digits, written = parted.groups() if parted else (text, "")
    own = own or Own("")
    sizes = _SIZES[own.of]
    known = unit_of(written) if own.of == "length" else pressure_unit(text)
    if own.of == "pressure" and _LINE_LOAD.fullmatch(written):
        raise ValueError(f"{name} is {text!r}, a load F' per length; allowed: the mean pressure p = F'/L, L the period")
    try:
        value = number(digits)
        if written and not known:
            raise ValueError("of no known unit")
    except OverflowError:
        raise ValueError(f"{name} is {text!r}; allowed: {IN_RANGE}") from None
    except ValueError:
        more = ", or a length with its unit, like 50um" * (own.unit in UNITS)
        better = pointed(digits, written) if known or not written else ""
        raise ValueError(f"{name} is {text!r}; allowed: {better or allowed + more}") from None
    if known and own.unit not in sizes:
        hint = f", unless --{own.of}-unit names one" * (own.unit == SCENE or own.of == "pressure")
        raise ValueError(f"{name} is {text!r}; allowed: a number alone, the {own.of}s of this scene have no unit{hint}")
    if not (own.said or known or value == 0 or not math.isfinite(value)):
        like = f"{text}{own.unit}" if own.of == "length" else "0.1MPa, because another one has a unit"
        hint = f"with its unit, like {like}, or --{own.of}-unit, that of all {own.of}s of this scene"
        raise ValueError(f"{name} is {text!r}; allowed: {hint}")
    found = _converted(value, sizes[known], sizes[own.unit]) if known else value
    if (math.isinf(found) and not math.isinf(value)) or (found == 0 and value != 0):
        raise ValueError(f"{name} is {text!r}; allowed: {IN_RANGE}, in {own.unit}")
    return found


def _converted(value: float, unit: float, own: float) -> float:
    """A number in another unit, from the digits that it is written in: 200 um are 0.0002 m and not 1e-20 less."""
    return float(Decimal(repr(value)) * Decimal(repr(unit)) / Decimal(repr(own)))


def plain(text: str) -> str:
    """Text whose letters have one form each: micro signs, Angstrom signs, and text decoded once too little."""
    return unicodedata.normalize("NFKC", text.replace("\u00c2\u00b5", "\u00b5")).strip()


def unit_of(word: str, *, expected: bool = True) -> str | None:
    """The unit that a word stands for; None if it is none.

    expected: whether a unit must stand there, as in brackets; elsewhere `m` and `in` are no units.
    """
    word = plain(word).strip(".")
    if word in _LARGE:
        return None
    word = word.lower()
    if not expected and word in _SHORT:
        return None
    bare = "".join(c for c in unicodedata.normalize("NFKD", word) if not unicodedata.combining(c))  # "nanomètre"
    return _SPELLINGS.get(word) or _SPELLINGS.get(bare)
