"""Lengths on the axes: over the period where nothing has a unit, and in the units of a scan."""

from dataclasses import dataclass

from linecontact.solver import Scene
from linecontact.solver.units import SCENE

from ..scans.units import UNITS


@dataclass(frozen=True)
class Lengths:
    """How lengths along one axis are shown."""

    factor: float
    """What a length of the scene is multiplied by."""
    symbol: str
    """What stands after the symbol of a length: a divisor, or a unit in brackets."""


def lengths(scene: Scene) -> tuple[Lengths, Lengths]:
    """How lengths are shown along the surface, and how heights are."""
    about = scene.indenter.to_dict()
    own = about.get("profile_length_unit")
    if own is None:
        return (Lengths(1 / scene.period, "/L"),) * 2
    heights = about["profile_z_unit"]
    return _in(about.get("profile_x_unit", own), own), _in(heights, own)


def _in(unit: str, own: str) -> Lengths:
    """A unit of the scan; own: the scene's."""
    if SCENE in (unit, own):
        return Lengths(1.0, " [length]")
    return Lengths(UNITS[own] / UNITS[unit], f" [{unit}]")
