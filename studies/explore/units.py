"""Lengths on the axes: in the units of a scan where they are known, over the period elsewhere."""

from dataclasses import dataclass

from linecontact.solver import Scene

from ..scans.units import UNITS, axis_units


@dataclass(frozen=True)
class Lengths:
    """How lengths along one axis are shown."""

    factor: float
    """What a length of the scene is multiplied by."""
    symbol: str
    """What stands after the symbol of a length: a divisor, or a unit in brackets."""


def lengths(scene: Scene) -> tuple[Lengths, Lengths]:
    """How lengths are shown along the surface, and how heights are."""
    units = axis_units(scene.indenter.to_dict())
    if units is None:
        return (Lengths(1 / scene.period, "/L"),) * 2
    own, along, up = units
    return Lengths(UNITS[own] / UNITS[along], f" [{along}]"), Lengths(UNITS[own] / UNITS[up], f" [{up}]")
