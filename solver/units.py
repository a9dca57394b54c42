"""Units of the quantities in scenes and results, by their names."""

from collections.abc import Mapping
from typing import Any

SCENE = "the scene's"
"""The unit of length that the scene is in, where nobody has said which one it is."""

_UNITS = {
    "x": "length",
    "displacement": "length",
    "contact_pressure": "pressure",
    "thickness": "length",
    "radius": "length",
    "period": "length",
    "approach": "length",
    "mean_gap": "length",
    "contact_width": "length",
    "peak_pressure": "pressure",
    "peak_pressure_error": "pressure",
    "peak_pressure_sampling": "pressure",
    "approach_error": "length",
    "pressure": "pressure",
    "contact_modulus": "pressure",
    "youngs_modulus": "pressure",
    "base_modulus": "pressure",
    "contact_stiffness": "pressure/length",
    "profile_scan_length": "length",
    "profile_spacing": "length",
    "profile_rms_height": "length",
}
"""Units by the last part of a name; 'seconds.*' is in seconds, 'bytes.*' in bytes, everything else dimensionless."""


def unit(name: str) -> str:
    """Unit of a quantity: 'length', 'pressure', 's', 'byte', or '1' for what is dimensionless."""
    if name == "profile":  # the heights; scene.profile is the indenter's name
        return "length"
    if name.startswith("bytes."):
        return "byte"
    return "s" if "seconds." in name else _UNITS.get(name.rsplit(".", 1)[-1], "1")


def declare(units: Mapping[str, str]) -> None:
    """Say in which units the numbers of a layer or an indenter of one's own are.

    units: 'length', 'pressure' or 'pressure/length' by the name of the number. Raises `ValueError` for another unit,
    and for one that the same name does not have elsewhere.
    """
    for name, one in units.items():
        if one not in _UNITS.values():
            raise ValueError(f"units of {name} is {one!r}; allowed: {', '.join(sorted(set(_UNITS.values())))}")
        if _UNITS.setdefault(name, one) != one:
            raise ValueError(f"units of {name} is {one!r}; allowed: {_UNITS[name]}, which it is elsewhere")


def length_unit(about: Mapping[str, Any], prefix: str = "") -> str:
    """The unit of length of what is described by these names; 'length' where nobody has said which one it is.

    about: of an indenter, or of results, where `prefix` stands before the indenter's names.
    """
    known = str(about.get(f"{prefix}profile_length_unit", SCENE))
    return "length" if known == SCENE else known
