"""From the options of a command line to a scene."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass
from typing import Any

from linecontact.solver import INDENTERS, LAYERS, Scene

from ..scans import reading
from ..terminal.options import one_of, options_of
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
    profile = _made("profile", options, given)
    if isinstance(profile, reading.Options):
        indenter, period, num_points = reading.read(profile)
        _check_scales(options, given)
        more: dict[str, Any] = {"period": period, "num_points": num_points}
    else:
        indenter = profile
        more = {name: getattr(options, name) for name in ("period", "num_points") if getattr(options, name) is not None}
    layer = _made("layer", options, given)
    if isinstance(layer, stiffness_file.Options):
        layer = stiffness_file.read(layer)
    more |= {name: getattr(options, name) for name in LOADS if getattr(options, name, None) is not None}
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


def _made(what: str, options: Any, given: Given) -> Any:
    """The layer or the profile that the option `what` chooses, with its own options.

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
                raise ValueError(f"{name} is {value}; allowed: only with --{what} {takers}, not {chosen}")
    values = given[kinds.title(what, chosen)]
    for name, option in own.items():
        if option.default is MISSING and name not in values:
            raise ValueError(f"{name} is missing; allowed: {option.allowed}, with --{what} {chosen}")
    if missing := getattr(classes[chosen], "__abstractmethods__", ()):
        raise ValueError(f"{what} {chosen} lacks {', '.join(sorted(missing))}; allowed: one that offers what it must")
    return classes[chosen](**values)
