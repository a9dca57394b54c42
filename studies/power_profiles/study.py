"""A study of one power profile, h = (R/n) |x/R|^n, on layers of any thickness, for hertz, sharp and blunt.

kappa_d/kappa_inf over d/a_r for p = 2e-3 E*, R = L = E* = 1. The thicknesses are those at which collocation
finds the wanted d/a_r, and collocation's area and peak pressure are stored beside each run's.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..runner import study
from ..runner.study import Plan, Study
from .report import report
from .tasks import Configuration, plan, quick

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Options(study.Options):
    """The options of the three studies."""

    quick: bool = False
    """2^14 points and fewer thicknesses, in seconds."""


def make_study(name: str, configuration: Configuration, options: type[Options]) -> Study:
    """The study of this name at full size, or a quick one if the options ask for that."""

    def plans(asked: Options) -> Sequence[Plan]:
        return [plan(name, quick(configuration) if asked.quick else configuration)]

    return Study(name=name, options=options, plans=plans, report=report, draw=draw)


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)
