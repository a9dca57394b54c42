"""Units of length, in the spellings that instruments and people use."""

import unicodedata
from collections.abc import Mapping
from typing import Any, Literal

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
    **dict.fromkeys(("\u03bcm", "micron", "microns", "\u03bc"), "um"),
    **dict.fromkeys(("\u00e5", "angstroms", "\u00e5ngstr\u00f6m", "\u00e5ngstrom", "angstr\u00f6m"), "angstrom"),
    **dict.fromkeys(("in", "inches", '"'), "inch"),
}
_SHORT = {"m", "in", '"', "\u03bc", "\u00e5"}
"""Units only where a unit is expected: elsewhere they are words, or letters."""


def axis_units(about: Mapping[str, Any]) -> tuple[str, str, str] | None:
    """Units of the scene's lengths, of positions and of heights; None where they are not known.

    about: what travels with a scan's results, see `MeasuredIndenter.description`.
    """
    own = str(about.get("profile_length_unit"))
    if own not in UNITS:
        return None
    x, z = (unit if (unit := str(about.get(f"profile_{axis}_unit"))) in UNITS else own for axis in "xz")
    return own, x, z


def plain(text: str) -> str:
    """Text whose letters have one form each: micro signs, Angstrom signs, and what was decoded once too little."""
    return unicodedata.normalize("NFKC", text.replace("\u00c2\u00b5", "\u00b5")).strip()


def unit_of(word: str, *, expected: bool = True) -> str | None:
    """The unit that a word stands for; None if it is none.

    expected: whether a unit must stand there, as in brackets; elsewhere `m` and `in` are no units.
    """
    word = plain(word).strip(".").lower()
    return None if not expected and word in _SHORT else _SPELLINGS.get(word)
