"""From the options of a command line to a scene."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass
from typing import Any

from linecontact.solver import INDENTERS, LAYERS, MeasuredIndenter, Scene

from ..scans import reading
from ..scans.units import read
from ..terminal.options import one_of, options_of, told
from . import kinds, stiffness_file

Given = Mapping[str, Mapping[str, Any]]
"""The options of the layer and of the profiles that are given, by the titles of `kinds` and by name."""


@dataclass(frozen=True)
class Options:
    """What every command that takes a scene can be asked for."""

    profile: str = one_of(INDENTERS, next(iter(INDENTERS)))
    """Indenter; what each one is, and takes, is told below."""
    layer: str = one_of(LAYERS, next(iter(LAYERS)))
    """Layer; what each one is, and takes, is told below."""
    pressure: float | None = None
    """Mean external pressure p >= 0 [pressure]; default 0.002, but for a file it must be given."""
    period: float | None = None
    """Period L > 0 [length]; default 1; not for a file, whose scan is the period, or half of it."""


def make_scene(options: Any, given: Given) -> Scene:
    """The scene that options describe: those of `Options`, with num_points, precision and perhaps approach.

    Raises `ValueError`.
    """
    measured = options.profile == MeasuredIndenter.name
    profile = _made("profile", options, given, _unit_of_scan(given) if measured else "")
    unit, own = "", {name: getattr(options, name, None) for name in (*LOADS, "period", "num_points")}
    more: dict[str, Any] = {}
    if isinstance(profile, reading.Options):
        indenter, period, num_points = reading.read(profile)
        unit = indenter.description["profile_length_unit"]
        _check_scales(options, given)
        own |= {"period": None, "num_points": None}
        more = {"period": period, "num_points": num_points}
    else:
        indenter = profile
    layer = _made("layer", options, given, unit)
    if isinstance(layer, stiffness_file.Options):
        layer = stiffness_file.read(layer)
    more |= {name: _number(name, value, unit) for name, value in own.items() if value is not None}
    return Scene(layer=layer, indenter=indenter, precision=options.precision, **more)


LOADS = ("pressure", "approach")
"""The options of which one tells the load."""


def _check_scales(options: Any, given: Given) -> None:
    """Raise `ValueError` where a file, whose lengths have units, would meet a load or modulus that nobody gave."""
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
        raise ValueError(f"{names}; allowed: with a file, whose lengths have units, both must be given, in one unit")


def _unit_of_scan(given: Given) -> str:
    """The unit of a scan's own length, if it is given one; empty where that is the scene's, whatever it is."""
    told = given[kinds.title("profile", MeasuredIndenter.name)]
    return "" if told.get("scene_units") else str(told.get("length_unit", reading.Options.length_unit))


def _number(name: str, value: Any, unit: str) -> Any:
    """The value of an option that is a number; a length with its unit in the scene's. Raises `ValueError`."""
    return read(name, value, True, unit) if isinstance(value, str) else value


def _made(what: str, options: Any, given: Given, unit: str) -> Any:
    """The layer or the profile that the option `what` chooses, with its own options.

    unit: the scene's unit of length; empty where that is not known.

    Raises `ValueError` if one of them is missing, and for those of another kind, unless they have their default.
    """
    chosen = getattr(options, what)
    classes = kinds.classes(what)
    own = options_of(classes[chosen])
    for other, kind in classes.items():
        defaults = {name: option.default for name, option in options_of(kind).items()}
        for name, value in given[kinds.title(what, other)].items():
            if name not in own and not hasattr(options, name) and value != defaults[name]:
                takers = " or ".join(one for one, taker in classes.items() if name in options_of(taker))
                raise ValueError(f"{told(name, value)}; allowed: only with --{what} {takers}, not {chosen}")
    values = given[kinds.title(what, chosen)]
    for name, option in own.items():
        if option.default is MISSING and name not in values:
            raise ValueError(f"{name} is missing; allowed: {option.allowed}, with --{what} {chosen}")
    if missing := getattr(classes[chosen], "__abstractmethods__", ()):
        raise ValueError(f"{what} {chosen} lacks {', '.join(sorted(missing))}; allowed: one that offers what it must")
    return classes[chosen](
        **{name: _number(name, value, unit) if own[name].length else value for name, value in values.items()}
    )
