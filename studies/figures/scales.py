"""Words of figures for lengths, pressures and layers, in the units of the figures."""

import math
from collections.abc import Collection, Mapping
from typing import Any

from ..terminal.units import UNITS
from .style import layer, typeset
from .units import Shown, shown_units


def told(units: tuple[Shown, ...]) -> str:
    """Dimensionless quantities and their divisors; empty where there are none. units: as `shown_units` gives them."""
    along, _, pressures = units
    over = [f"lengths over the period {sign(along)}"] * (not along.unit)
    over += [f"pressures over {sign(pressures)}"] * (not pressures.unit)
    return f"Dimensionless: {', '.join(over)}." * bool(over)


def of(what: Shown) -> str:
    """The end of an axis label, after the name of a quantity."""
    return f" ({shown(what.unit)})" if what.unit else f"/{sign(what)}"


def sign(what: Shown) -> str:
    """The divisor of a quantity, in a formula if it has a sign."""
    return {"L": "$L$", "E*": "$E^*$"}.get(what.over, what.over)


def of_scene(results: Mapping[str, Any]) -> dict[str, Any]:
    """The scene of some results, by the names of `Scene.to_dict`."""
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
    """The elastic half-space below a coating, in words; empty for a layer on a rigid base. but: names left out."""
    modulus, told = results.get("scene.base_modulus"), []
    if modulus is not None and not {"base_modulus", "contact_modulus"} & set(but):
        told.append(f"$E_2^*={typeset(float(modulus) / float(results['scene.contact_modulus']))}\\,E^*$")
    if modulus is not None and "base_poisson_ratio" not in but:
        told.append(f"$\\nu_2={float(results['scene.base_poisson_ratio']):g}$")
    return f"base: {', '.join(told)}" if told else ""


def shown(unit: str) -> str:
    """A unit as a figure writes it."""
    return {"um": "\u00b5m", "angstrom": "\u00c5"}.get(unit, unit)
