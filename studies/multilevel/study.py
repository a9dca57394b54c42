"""`linecontact ensemble`: means over random surfaces to a standard error asked for."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from linecontact.solver import INDENTERS, RoughIndenter, Scene

from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..scenes import kinds, making
from ..scenes.described import base_scene, described
from ..scenes.making import Given
from ..terminal.options import one_of, text
from . import tasks
from .mean import MOST_SAMPLES, check_scene, check_wanted
from .report import missed, report
from .samples import OBSERVABLES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = tasks.KIND


@dataclass(frozen=True)
class Options(making.Options, study.Options):
    """Mean over random surfaces to the standard error you ask for, on as fine a grid as it needs: table, file, figure.

    Most surfaces are solved on coarse grids, where that is cheap, and few on fine ones, which tell the coarse
    ones' error (multilevel Monte Carlo). For instance --profile rough --hurst 0.8 --pressure 0.01 --standard-error
    0.005. Run again after an interruption, it continues.
    """

    profile: str = one_of(INDENTERS, RoughIndenter.name)
    """Indenter, one with a seed; each one and its options are described below."""
    num_points: int | None = None
    """Points of the finest grid that may be used, like 2^20; it is used only if the bias asks for it. Default 2^20."""
    precision: ClassVar[str] = Scene.precision
    observable: str = text(f"{', '.join(OBSERVABLES)}, or several of them separated by commas", "kappa")
    """Whose mean is wanted: kappa, contact-area, peak-pressure, approach or mean-gap, or several of them separated by
    commas."""
    standard_error: float | None = None
    """Standard error wanted of every mean, 1e-60 and more, in its own unit; it must be given."""
    relative: bool = False
    """The standard error is over the mean, up to 1 (dimensionless)."""
    max_seconds: float = math.inf
    """Time of solving that may be planned, of all processes together [s]; beyond, it stops and says how much it would
    take."""
    max_samples: int = MOST_SAMPLES
    """Solves that may be planned."""


_SCENE = ("profile", "layer", "pressure", "pressure_unit", "period", "precision")
_FINEST = 2**20
_ANY = 0.01  # standard error of a plan that nobody asked for


def plan(options: Options, given: Given) -> Plan:
    """The first tasks. Raises `ValueError`."""
    limits = options.max_seconds, options.max_samples
    asked = check_wanted(options.observable.split(","), options.standard_error, options.relative, *limits)
    told = {name: getattr(options, name) for name in _SCENE}
    told["num_points"] = _FINEST if options.num_points is None else options.num_points
    description = described(told, given)
    scene = base_scene(description)
    check_scene(scene)
    return tasks.plan(description, scene, asked)


def draw(path: Path) -> "dict[str, Figure]":
    """The figure of a stored ensemble."""
    from . import figures

    return figures.draw(path)


def plans(options: Options) -> Sequence[Plan]:
    """The first tasks of a scene whose layer and indenter have their defaults, also if no standard error is given."""
    error = _ANY if options.standard_error is None else options.standard_error
    return [plan(replace(options, standard_error=error), {title: {} for title in kinds.titled()})]


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw, missed=missed)


def command(options: Options, given: Given) -> int:
    """Sample as asked, or the rest of it; returns the exit status, 3 if that is not reached."""
    ready = plan(options, given)
    return run_study(replace(STUDY, plans=lambda _: [ready]), options)
