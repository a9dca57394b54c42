"""In which units the figure of a solution is drawn: those of the scan, where it has brought some; else it is said that
numbers are dimensionless.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from ..files.solution_files import StoredSolution
from ..scans.preparation import mirrored
from ..scans.units import UNITS, axis_units
from .style import kind, layer, typeset


@dataclass(frozen=True)
class Scales:
    """What the numbers of a stored solution are divided by, and what the axes are called then."""

    period: float
    """L, as it is stored."""
    x: float
    """The unit of positions."""
    z: float
    """The unit of heights."""
    pressure: float
    """The unit of pressures."""
    x_label: str
    """The axis of positions."""
    x_unit: str
    """What that unit is called."""
    z_label: str
    """The axis of heights."""
    pressure_label: str
    """The axis of pressures."""
    thickness: str
    """The layer's thickness in words, with the kind of the layer unless it is bonded."""
    base: str
    """The half-space below a coating; empty for a layer on a rigid base."""
    load: str
    """The mean pressure over E*; empty where E* is not known."""
    told: str
    """What is dimensionless, and by what it was divided."""
    mirrored: bool
    """Whether the second half of the period is the mirror image of a scan."""


def scales(solution: StoredSolution) -> Scales:
    """The scales of a stored solution: the units of its scan, or the period; pressures over E*, or over their mean."""
    results = solution.results
    period, pressure = float(results["scene.period"]), float(results["scene.pressure"])
    about = {name.removeprefix("scene."): value for name, value in results.items()}
    units = axis_units(about)
    x = z = period
    along, up, distance = "position $x/L$", "height/$L$", "$L$"
    if units:
        own, along_unit, up_unit = units
        x, z = (UNITS[unit] / UNITS[own] for unit in (along_unit, up_unit))
        along, distance = f"position $x$ ({shown(along_unit)})", shown(along_unit)
        up = f"height ({shown(up_unit)})"
    modulus = results.get("scene.contact_modulus")  # not every layer names one
    over = "$E^*$" if modulus else "their mean"
    lengths = "" if units else "lengths over the period $L$, "
    thickness = float(results["scene.thickness"])
    size = thickness_in(thickness, units[0]) if units else layer(thickness / period)
    return Scales(
        period=period,
        x=x,
        z=z,
        pressure=float(modulus) if modulus else pressure,
        x_label=along,
        x_unit=distance,
        z_label=up,
        pressure_label="pressure/$E^*$" if modulus else "pressure / mean",
        told=f"Dimensionless: {lengths}pressures over {over}.",
        thickness=", ".join(filter(None, (kind(str(results.get("scene.layer", "bonded"))), size))),
        base=base(results),
        load=f"$p={typeset(pressure / float(modulus))}\\,E^*$" if modulus else "",
        mirrored=mirrored(about),
    )


def thickness_in(thickness: float, unit: str) -> str:
    """A layer's thickness, in that unit, as people write it."""
    if math.isinf(thickness):
        return layer(thickness)
    size = thickness * UNITS[unit]
    best = next((one for one in ("m", "mm", "um", "nm") if size >= UNITS[one]), "nm") if unit != "inch" else unit
    return f"$d={typeset(size / UNITS[best])}$ {shown(best)}"


def base(results: Mapping[str, Any], but: Collection[str] = ()) -> str:
    """The elastic half-space below a coating, in words; empty for a layer on a rigid base. but: what is left out."""
    modulus, told = results.get("scene.base_modulus"), []
    if modulus is not None and not {"base_modulus", "contact_modulus"} & set(but):
        told.append(f"$E_2^*={typeset(float(modulus) / float(results['scene.contact_modulus']))}\\,E^*$")
    if modulus is not None and "base_poisson_ratio" not in but:
        told.append(f"$\\nu_2={float(results['scene.base_poisson_ratio']):g}$")
    return f"base: {', '.join(told)}" if told else ""


def shown(unit: str) -> str:
    """A unit of length as a figure writes it."""
    return {"um": "\u00b5m", "angstrom": "\u00c5"}.get(unit, unit)
