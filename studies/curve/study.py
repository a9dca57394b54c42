"""`linecontact curve`: contact area, kappa, approach and stiffness over the load, or over another number of a scene."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import MISSING, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from linecontact.solver import MeasuredIndenter, Scene, checks
from linecontact.solver.grid.errors import DEFAULT_QUANTITY, QUANTITIES, check_accuracy
from linecontact.solver.grid.problem import Problem
from linecontact.solver.strategy.grids import check_memory
from linecontact.solver.units import unit

from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..scenes import kinds, making, scan_table
from ..scenes.described import base_scene, described, shown
from ..scenes.making import Given
from ..terminal import console
from ..terminal.options import PRESSURE, one_of, options_of, text
from ..terminal.text import is_refusal
from ..terminal.units import Own, read
from . import even_areas, number
from .report import report
from .tasks import Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "curve"
_POINTS = 30
_SMALLEST_LOAD, _BEYOND = 1e-5, 1 + 1e-9  # over that of full contact: where a curve over the load begins and ends


@dataclass(frozen=True)
class Options(making.Options, study.Options):
    """Vary one number of a scene: area, kappa, approach and stiffness for every value; table, file and figure.

    For instance the area over the load, --over pressure, over the layer's thickness, --over thickness --from 0.001
    --to 1, or over ten random surfaces, --over seed --from 0 --to 9, with mean and standard error. Every point is
    solved and certified by itself. Run again after an interruption, it continues. `linecontact export` makes a CSV file
    of the result.
    """

    folder: Path | None = None
    """Where data and figures go; default: results/curve- and the number varied, like results/curve-thickness."""
    approach: float | None = None
    """Rigid approach since first touch [length], instead of the pressure; up to 0 nothing touches."""
    num_points: int | None = None
    """Grid points, at least 4, like 262144 or 2^18; default 2^18, for a file four or more to a value."""
    precision: ClassVar[str] = Scene.precision
    accuracy: float | None = None
    """Relative error wanted of every value, 1e-9 to 0.1 (dimensionless); num_points is then the most to use."""
    accuracy_of: str = one_of(QUANTITIES, DEFAULT_QUANTITY)
    """Quantity whose accuracy is asked for; area and kappa between sub-grid edges."""
    over: str = text("pressure, approach, period, num_points, or a number of the layer's or the indenter's", "pressure")
    """The number that is varied: pressure, approach, period, num_points, or one of the layer's or the indenter's own,
    like thickness, poisson_ratio, exponent, hurst or seed."""
    from_: str | None = text("a number", None)
    """First value, in the scene's unit or, with a scan, with its own, like 50um; default for the pressure: 1e-5 of that
    of full contact."""
    to: str | None = text("a number", None)
    """Last value; default for the pressure: that of full contact."""
    points: int | None = None
    """Number of values, 2 to 16384; of seeds every one, if they are fewer; default: 30."""
    spacing: number.Spacing = "auto"
    """Of the values: even in their logarithm, or linear; auto: the logarithm from a decade on, but for seeds; area:
    pressures at which the contact area rises evenly."""
    values: str | None = text("numbers separated by commas", None)
    """Values separated by commas, instead of --from and --to; inf is a half-space's thickness."""


def plan(options: Options, given: Given) -> Plan:
    """The tasks. Raises `ValueError`."""
    options = replace(options, over=options.over.replace("-", "_"))
    over, accuracy, of = options.over, options.accuracy, options.accuracy_of
    told: dict[str, Any] = {name: getattr(options, name) for name in _SCENE}
    _check_options(options, given, told)
    own, pressures = making.own_units(options, given)
    any_number = {of.of: 1.0 if of.said else f"1{of.unit}" for of in (own, pressures)}  # will do for what is varied
    if over in making.LOADS:
        told[over] = any_number[unit(over)]
    every = {title: dict(group) for title, group in given.items()}
    for what in ("layer", "profile"):
        kind = told[what]
        option = options_of(kinds.classes(what)[kind]).get(over) if kind in kinds.classes(what) else None
        if not option or option.type is Path:
            continue
        needed = over == "base_modulus" or (over == "contact_modulus" and (own.unit or pressures.unit))
        if option.default is MISSING or needed:
            every[kinds.title(what, kind)][over] = any_number.get(option.dimension, 1.0)
    description = described(told, every)
    scene = base_scene(description)
    _check_over(over, number.numbers(scene))
    varied = {"length": own._replace(unit=scene.length_unit), "pressure": pressures}.get(unit(over))
    values = _values(options, scene, varied)
    points = number.check(scene, over, values, accuracy)
    return Plan(
        kind=NAME,
        configuration={
            "scene": shown(description),
            "over": over,
            "values": values,
            "accuracy": accuracy,
            "accuracy_of": of,
        },
        runs=[Task(description, over, value, accuracy, of) for value in values],
        num_points=points,
    )


def _check_over(over: str, numbers: Collection[str]) -> None:
    """Raise `ValueError` for a number that the scene does not have, with the option that gives it one."""
    if over in numbers:
        return
    takers = [
        f"with --{what} {name}, or "
        for what in kinds.CHOICES
        for name, kind in kinds.classes(what).items()
        if (option := options_of(kind).get(over)) and option.type in (int, float) and option.default is not None
    ]
    raise ValueError(f"over is {over!r}; allowed: {''.join(takers)}{', '.join(numbers)}")


def _check_options(options: Options, given: Given, told: Mapping[str, Any]) -> None:
    """Raise `ValueError` for options that do not go together."""
    over = options.over
    if over in _YOUNGS:
        raise ValueError(f"over is {over!r}; allowed: {_YOUNGS[over]}, E/(1 - nu^2), which is proportional to it")
    known = {name: value for group in given.values() for name, value in group.items()} | dict(told)
    fixed = making.LOADS if over in making.LOADS else () if over in _NO_NUMBERS else (over,)
    for name in fixed:
        if known.get(name) is not None:
            raise ValueError(f"{name} is {known[name]}; allowed: none with --over {over}")
    for young, modulus in _YOUNGS.items():
        if over in (modulus, f"{young.removesuffix('youngs_modulus')}poisson_ratio") and known.get(young) is not None:
            why = f", which keeps E* = E/(1 - nu^2), not E; give {modulus}" * (over != modulus)
            raise ValueError(
                f"{young} is {str(known[young]).removesuffix('.0')}; allowed: none with --over {over}{why}"
            )
    check_accuracy(options.accuracy, options.accuracy_of)
    if options.accuracy is not None and (over in ("approach", "num_points") or options.approach is not None):
        what = "an approach" if over != "num_points" else "--over num_points"
        raise ValueError(f"accuracy is {options.accuracy:g}; allowed: none with {what}")
    if options.values is not None:
        for name, default in (("points", Options.points), ("spacing", Options.spacing)):
            if getattr(options, name) != default:
                raise ValueError(f"{name} is {getattr(options, name)}; allowed: none with --values")


_YOUNGS = {"youngs_modulus": "contact_modulus", "base_youngs_modulus": "base_modulus"}
"""The modulus E* that each E stands for."""

_NO_NUMBERS = ("profile", "layer", "precision", "accuracy", "accuracy_of")
"""Options of a scene that may not vary and are refused, whether they are given or not."""

_SCENE = (*_NO_NUMBERS, *making.LOADS, "period", "num_points", "pressure_unit")
"""All that make a scene."""


def _values(options: Options, scene: Scene, own: Own | None) -> tuple[float, ...]:
    ends = {"from": options.from_, "to": options.to}
    given = {name: text for name, text in ends.items() if text is not None}
    if options.values is not None:
        if given:
            name, text = next(iter(given.items()))
            raise ValueError(f"{name} is {text!r}; allowed: none with --values")
        texts = options.values.split(",")
        if len(texts) > number.MOST:
            raise ValueError(f"values are {len(texts)}; allowed: up to {number.MOST}")
        values = tuple(_read(options, own, "values", text) for text in texts)
        again = number.repeated(values)
        if again is not None:
            raise ValueError(f"values hold {texts[again].strip()} a second time; allowed: each once")
        return values
    found = {name: _read(options, own, name, text) for name, text in given.items()}
    _check_ends(options, scene, found, given)
    if options.over == "pressure" and len(found) < len(ends):
        check_memory(scene.num_points)
        full = Problem.from_scene(scene).full_contact_pressure
        found = {"from": _SMALLEST_LOAD * full, "to": _BEYOND * full} | found
    for name in ends:
        if name not in found:
            raise ValueError(f"{name} is missing; allowed: a number, or --values, with --over {options.over}")
    count, spacing = _POINTS if options.points is None else options.points, options.spacing
    checks.integer("points", count, f"an integer from 2 to {number.MOST}", 2, number.MOST)
    if spacing == "area":
        if options.over != "pressure":
            raise ValueError(f"spacing is 'area'; allowed: with --over pressure, not {options.over}")
        return even_areas.loads(scene, found["from"], found["to"], count)
    if options.over == "seed":
        spacing = "linear" if spacing == "auto" else spacing
        count = int(min(count, abs(found["to"] - found["from"]) + 1))
    return number.spaced(found["from"], found["to"], count, spacing, number.whole(scene, options.over))


def _check_ends(options: Options, scene: Scene, found: Mapping[str, float], given: Mapping[str, str]) -> None:
    """Raise `ValueError` for an end that makes no scene, or whose scene has no solution, as it was given.

    found: the ends that are given, by the names of their options; given: the texts that stand for them. Ends that are
        not finite, or no integers where they should be, are left to `number.spaced`.
    """
    over = options.over
    for name, value in found.items():
        if not math.isfinite(value) or (number.whole(scene, over) and value != int(value)):
            continue
        try:
            if value == max(found.values()):
                number.check(scene, over, [value], options.accuracy)
            else:
                number.put(scene, over, value)
        except ValueError as error:
            if not is_refusal(error):
                raise
            about, _, allowed = str(error).partition("; allowed: ")
            why = f"; allowed: {allowed}" if about.startswith(f"{over} is ") else f", where {error}"
            raise ValueError(f"{name} is {given[name]}{why}") from None


def _read(options: Options, own: Own | None, option: str, text: str) -> float:
    return read(option, text, own, PRESSURE if unit(options.over) == "pressure" else "a number")


def draw(path: Path) -> "dict[str, Figure]":
    """The figure of a stored curve."""
    from . import figures

    return figures.draw(path)


def plans(options: Options) -> Sequence[Plan]:
    """The tasks of a scene whose layer and indenter have their defaults."""
    return [plan(options, {title: {} for title in kinds.titled()})]


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw)


def command(options: Options, given: Given) -> int:
    """Solve the curve as asked, or the rest of it; returns the exit status."""
    ready = plan(options, given)
    if options.profile == MeasuredIndenter.name:
        console.Output().print(scan_table.table(ready.runs[0].point, options.over))  # type: ignore[attr-defined]
    folder = options.folder or Path("results") / f"{NAME}-{ready.configuration['over'].replace('_', '-')}"
    return run_study(replace(STUDY, plans=lambda _: [ready]), replace(options, folder=folder))
