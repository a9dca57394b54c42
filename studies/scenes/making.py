"""From the options of a command line to a scene."""

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass
from typing import Any

from linecontact.solver import INDENTERS, LAYERS, MeasuredIndenter, Scene, TabulatedLayer
from linecontact.solver.units import PRESSURES, SCENE
from linecontact.solver.units import unit as unit_named

from ..scans import reading
from ..terminal.options import PRESSURE, one_of, options_of, told
from ..terminal.units import UNITS, Own, pressure_unit, read
from . import kinds, stiffness_file

Given = Mapping[str, Mapping[str, Any]]
"""The options of the layer and of the profiles that are given, by the titles of `kinds` and by name."""


@dataclass(frozen=True)
class Options:
    """The options of every command that takes a scene."""

    profile: str = one_of(INDENTERS, next(iter(INDENTERS)))
    """Indenter; each one and its options are described below."""
    layer: str = one_of(LAYERS, next(iter(LAYERS)))
    """Layer; each one and its options are described below."""
    pressure: float | None = None
    """Mean external pressure p >= 0 [pressure]; default 0.002, but beside a file or a unit it must be given."""
    period: float | None = None
    """Period L > 0 [length]; default 1; not for a file, whose scan is the period, or half of it."""
    pressure_unit: str | None = one_of(PRESSURES, None)
    """Unit of pressures and moduli that are numbers alone. Without it all have their own, like 0.1MPa, or none."""


def make_scene(options: Any, given: Given) -> Scene:
    """The scene that options describe: those of `Options`, with num_points, precision and perhaps approach.

    Raises `ValueError`.
    """
    unit, pressures = own_units(options, given)
    profile = _made("profile", options, given, (unit, pressures))
    own = {name: getattr(options, name, None) for name in (*LOADS, "period", "num_points")}
    more: dict[str, Any] = {}
    if isinstance(profile, reading.Options):
        indenter, period, num_points = reading.read(profile)
        unit = unit._replace(unit=indenter.description["profile_length_unit"])
        if unit.unit in UNITS and profile.scene_units and "length_unit" not in given[_SCAN]:
            raise ValueError("length_unit is missing; allowed: the unit of the scene, where one of the file is known")
        own |= {"period": None, "num_points": None}
        more = {"period": period, "num_points": num_points}
    else:
        indenter = profile
    layer = _made("layer", options, given, (unit, pressures))
    if isinstance(profile, reading.Options) or pressures.unit:
        _check_scales(options, given)
    if isinstance(layer, stiffness_file.Options):
        for needed, of in ((unit, "1/q"), (pressures, "K times length")):
            if not needed.said:
                option = f"--{needed.of}-unit"
                raise ValueError(f"stiffness_file is {layer.stiffness_file}; allowed: with {option}, the unit of {of}")
        layer = stiffness_file.read(layer, unit.unit)
    more |= {n: _number(n, value, (unit, pressures)) for n, value in own.items() if value is not None}
    more |= {"pressure_unit": pressures.unit or None}
    scene = Scene(layer=layer, indenter=indenter, precision=options.precision, **more)
    if isinstance(layer, TabulatedLayer) and layer.wave_numbers[0] > math.pi * scene.num_points / scene.period:
        raise ValueError(
            f"stiffnesses begin at q = {layer.wave_numbers[0]:.4g}, beyond all waves of this scene; allowed: a table "
            "that holds some of them, in its unit of length"
        )
    return scene


_SCAN = kinds.title("profile", MeasuredIndenter.name)
"""The title of a scan's own options."""

LOADS = ("pressure", "approach")
"""The options of which one tells the load."""


def _check_scales(options: Any, given: Given) -> None:
    """Raise `ValueError` where numbers with units would meet a load or modulus that nobody gave."""
    own = given[kinds.title("layer", options.layer)]
    known = {"contact_modulus", "youngs_modulus"} & own.keys()
    modulus = options_of(kinds.classes("layer")[options.layer]).get("contact_modulus")
    needed = modulus is not None and modulus.default is not None and not known
    unloaded = all(getattr(options, name, None) is None for name in LOADS)
    alternative = " (or approach)" * hasattr(options, "approach")
    either = " (or youngs_modulus)" * ("youngs_modulus" in options_of(kinds.classes("layer")[options.layer]))
    missing = [f"contact_modulus{either}"] * needed + [f"pressure{alternative}"] * unloaded
    if missing:
        names = f"{' and '.join(missing)} {'are' if len(missing) > 1 else 'is'} missing"
        raise ValueError(
            f"{names}; allowed: where lengths or pressures have units, modulus and load must be given, too"
        )


def own_units(options: Any, given: Given) -> tuple[Own, Own]:
    """The units of the scene's lengths and pressures, as far as the options tell them before a scan is read.

    That of the pressures is the one that they all have, or of the first of them that has one.
    """
    told = given[_SCAN]
    if options.profile != MeasuredIndenter.name:
        length = Own("")
    elif told.get("scene_units") and "length_unit" not in told:
        length = Own(SCENE)
    else:
        length = Own(told.get("length_unit", "m"), "length_unit" in told)
    if said := getattr(options, "pressure_unit", None):
        return length, Own(said, of="pressure")
    texts = [options.pressure, *(value for group in given.values() for value in group.values())]
    first = next(filter(None, (pressure_unit(text) for text in texts if isinstance(text, str))), "")
    return length, Own(first, not first, "pressure")


def _number(name: str, value: Any, units: tuple[Own, Own], dimension: str | None = None) -> Any:
    """The value of an option, in the scene's unit if it is a length or a pressure. Raises `ValueError`."""
    known = unit_named(name) if dimension is None else dimension
    own = next((own for own in units if own.of == known), None)
    if own is None or (own.said and not isinstance(value, str)):
        return value
    return read(name, value if isinstance(value, str) else repr(value).removesuffix(".0"), own, _ALLOWED[own.of])


_ALLOWED = {"length": "a number", "pressure": PRESSURE}


def _made(what: str, options: Any, given: Given, units: tuple[Own, Own]) -> Any:
    """The layer or the profile that the option `what` chooses, with its own options.

    units: of the scene's lengths and of its pressures.

    Raises `ValueError` if one of them is missing, and for those of another kind.
    """
    chosen = getattr(options, what)
    classes = kinds.classes(what)
    own = options_of(classes[chosen])
    for other in classes:
        for name, value in given[kinds.title(what, other)].items():
            if name not in own and not hasattr(options, name):
                takers = " or ".join(one for one, taker in classes.items() if name in options_of(taker))
                raise ValueError(f"{told(name, value)}; allowed: only with --{what} {takers}, not {chosen}")
    values = given[kinds.title(what, chosen)]
    for name, option in own.items():
        if option.default is MISSING and name not in values:
            raise ValueError(f"{name} is missing; allowed: {option.allowed}, with --{what} {chosen}")
    if missing := getattr(classes[chosen], "__abstractmethods__", ()):
        raise ValueError(f"{what} {chosen} lacks {', '.join(sorted(missing))}; allowed: one that offers what it must")
    return classes[chosen](
        **{
            name: value if own[name].refused else _number(name, value, units, own[name].dimension)
            for name, value in values.items()
        }
    )
