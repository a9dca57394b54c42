"""In which units the figure of a solution is drawn; where there are none it is said that numbers are dimensionless."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from ..files.solution_files import StoredSolution
from ..scans.preparation import mirrored
from ..scans.units import UNITS
from .style import kind, layer, typeset
from .units import Shown, shown_units


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
    """The mean pressure in words; empty where neither its unit nor E* is known."""
    told: str
    """What is dimensionless, and by what it was divided."""
    mirrored: bool
    """Whether the second half of the period is the mirror image of a scan."""


def scales(solution: StoredSolution) -> Scales:
    """The scales of a stored solution: the units of its scan, or the period; pressures over E*, or over their mean."""
    about = of_scene(solution.results)
    along, up, pressures = shown_units(about)
    dimensionless = ["lengths over the period $L$"] * (not along.unit)
    dimensionless += [f"pressures over {sign(pressures)}"] * (not pressures.unit)
    return Scales(
        period=float(about["period"]),
        x=1 / along.factor,
        z=1 / up.factor,
        pressure=1 / pressures.factor,
        x_label="position $x$" + _of(along),
        x_unit=shown(along.unit) or "$L$",
        z_label="height" + _of(up),
        pressure_label="pressure" + _of(pressures),
        told=f"Dimensionless: {', '.join(dimensionless)}." * bool(dimensionless),
        thickness=", ".join(filter(None, (kind(str(about.get("layer", "bonded"))), thickness(about)))),
        base=base(solution.results),
        load=load(about),
        mirrored=mirrored(about),
    )


def _of(what: Shown) -> str:
    """What stands after the name of a quantity at an axis."""
    return f" ({shown(what.unit)})" if what.unit else f"/{sign(what)}"


def sign(what: Shown) -> str:
    """What a quantity is divided by, in a formula if it has a sign."""
    return {"L": "$L$", "E*": "$E^*$"}.get(what.over, what.over)


def of_scene(results: Mapping[str, Any]) -> dict[str, Any]:
    """What results say of their scene, by the names of `Scene.to_dict`."""
    return {name.removeprefix("scene."): value for name, value in results.items() if name.startswith("scene.")}


def load(about: Mapping[str, Any]) -> str:
    """The mean pressure as people write it, in its unit or over E*; empty where neither is known.

    about: the scene, as `Scene.to_dict` describes it.
    """
    (*_, pressures), pressure = shown_units(about), float(about["pressure"])
    unit = {"E*": "\\,E^*$", "": f"$ {pressures.unit}"}.get(pressures.over)
    return f"$p={typeset(pressure * pressures.factor)}{unit}" if unit and math.isfinite(pressure) else ""


def thickness(about: Mapping[str, Any]) -> str:
    """A layer's thickness as people write it: in the user's unit, in one that suits it, or over the period.

    about: the scene, as `Scene.to_dict` describes it.
    """
    size, (along, *_) = float(about["thickness"]), shown_units(about)
    if math.isinf(size) or not along.unit:
        return layer(size * along.factor)
    size, unit = size * along.factor, along.unit
    if unit != about["profile_length_unit"] and unit in UNITS:
        size *= UNITS[unit]
        unit = next((one for one in ("m", "mm", "um", "nm") if size >= UNITS[one]), "nm")
        size /= UNITS[unit]
    return f"$d={typeset(size)}$ {shown(unit)}"


def base(results: Mapping[str, Any], but: Collection[str] = ()) -> str:
    """The elastic half-space below a coating, in words; empty for a layer on a rigid base. but: what is left out."""
    modulus, told = results.get("scene.base_modulus"), []
    if modulus is not None and not {"base_modulus", "contact_modulus"} & set(but):
        told.append(f"$E_2^*={typeset(float(modulus) / float(results['scene.contact_modulus']))}\\,E^*$")
    if modulus is not None and "base_poisson_ratio" not in but:
        told.append(f"$\\nu_2={float(results['scene.base_poisson_ratio']):g}$")
    return f"base: {', '.join(told)}" if told else ""


def shown(unit: str) -> str:
    """A unit as a figure writes it."""
    return {"um": "\u00b5m", "angstrom": "\u00c5"}.get(unit, unit)
