"""The units in which figures and pages show lengths and pressures: the user's own, else those of a scan, else none."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from linecontact.solver.units import PRESSURES

from ..terminal.units import UNITS

_DEFAULT = "m"  # of a scan's scene, where nobody has asked for a unit
_UNKNOWN = "own unit"  # of a scan whose unit nobody has told


@dataclass(frozen=True)
class Shown:
    """How quantities of a scene are shown."""

    factor: float
    """Their factor."""
    unit: str
    """Their unit then; empty where they are dimensionless."""
    over: str = ""
    """Their divisor then."""

    @property
    def symbol(self) -> str:
        """The divisor after their symbol, or the unit in brackets."""
        return f" [{self.unit}]" if self.unit else f"/{self.over}"


def shown_units(about: Mapping[str, Any]) -> tuple[Shown, Shown, Shown]:
    """How lengths along the surface, heights and pressures are shown.

    about: the scene, as `Scene.to_dict` describes it.
    """
    own, modulus = about.get("profile_length_unit"), about.get("contact_modulus")
    if about.get("pressure_unit") in PRESSURES:
        pressures = Shown(1.0, about["pressure_unit"])
    else:  # not every layer names its modulus
        pressures = Shown(1 / (float(modulus or about["pressure"]) or 1.0), "", "E*" if modulus else "their mean")
    if own is None:
        return (Shown(1 / float(about["period"]), "", "L"),) * 2 + (pressures,)
    if own not in UNITS:
        return (Shown(1.0, _UNKNOWN),) * 2 + (pressures,)
    of_file = (str(about.get(f"profile_{axis}_unit")) for axis in "xz")
    x, z = (own if own != _DEFAULT or unit not in UNITS else unit for unit in of_file)
    return Shown(UNITS[own] / UNITS[x], x), Shown(UNITS[own] / UNITS[z], z), pressures
