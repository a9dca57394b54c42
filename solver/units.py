"""Units of the quantities in scenes and results, by their names."""

import re
from collections.abc import Collection, Mapping
from typing import Any

from . import checks

SCENE = "the scene's"
"""The unit of length that the scene is in, where nobody has said which one it is."""

PRESSURES: dict[str, float] = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}
"""Units of pressure in pascals."""

_NAMES = {
    "length": "x displacement thickness radius period approach approach_error approach_sampling mean_gap contact_width "
    "profile_scan_length profile_spacing profile_rms_height",
    "pressure": "pressure contact_pressure peak_pressure peak_pressure_error peak_pressure_sampling contact_modulus "
    "youngs_modulus base_modulus base_youngs_modulus",
    "pressure/length": "contact_stiffness",
    "1": "exponent hurst seed cut_off_ratio roll_off_ratio rms_gradient poisson_ratio base_poisson_ratio num_points",
}
_UNITS = {name: unit for unit, names in _NAMES.items() for name in names.split()}
"""Units by the last part of a name; 'seconds.*' is in seconds, 'bytes.*' in bytes. Everything else is dimensionless but
the units that a layer or an indenter of one's own names; it must not give the names above another unit."""

_OWN: dict[str, str] = {}  # of layers and indenters that are not the program's


def unit(name: str) -> str:
    """Unit of a quantity: 'length', 'pressure', 's', 'byte', or '1' for a dimensionless one."""
    if name == "profile":  # the heights; scene.profile is the indenter's name
        return "length"
    if name.startswith("bytes."):
        return "byte"
    if "seconds." in name:
        return "s"
    last = name.rsplit(".", 1)[-1]
    return _UNITS.get(last) or _OWN.get(last, "1")


def declare(own: Mapping[str, str], fields: Collection[str]) -> None:
    """Note the units of fields of a layer or an indenter, by their names. fields: the names that there are.

    Raises `ValueError` for anything but a mapping, for a name that is no field, for an unknown unit, and for one
    that the name does not have elsewhere in the program.
    """
    if not isinstance(own, Mapping):
        raise checks.refusal("units", own, "units of fields by name, like {'width': 'length'}")
    for name, one in own.items():
        if name not in fields:
            raise ValueError(f"units names {name!r}; allowed: {', '.join(fields) or 'nothing, without fields'}")
        checks.choice(f"units of {name}", one, tuple(_NAMES)[:-1])
        if _UNITS.get(name, one) != one:
            known = _UNITS[name].replace("1", "none, it is dimensionless")
            raise ValueError(f"units of {name} is {one!r}; allowed: {known}, as elsewhere in the program")
    _OWN.update(own)


def named(about: Mapping[str, Any], prefix: str = "") -> dict[str, str]:
    """The units of 'length' and 'pressure' of a scene, these words themselves where nobody has said which.

    about: a scene's description, or results, where `prefix` stands before the scene's names.
    """
    said = {"length": about.get(f"{prefix}profile_length_unit"), "pressure": about.get(f"{prefix}pressure_unit")}
    return {word: word if unit in (None, SCENE) else str(unit) for word, unit in said.items()}


def shown(of: str, names: Mapping[str, str]) -> str:
    """A unit as `unit` tells it with the names of a scene's own, and '-' for a dimensionless quantity."""
    return re.sub("length|pressure", lambda found: names[found[0]], "-" if of == "1" else of)
