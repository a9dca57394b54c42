"""The area-pressure relation over the load: where is kappa constant, and where does the layer bend it?

linecontact study pressure [--quick] [--folder FOLDER]
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan
from .report import report
from .tasks import CONFIGURATION, QUICK, plan

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Options(study.Options):
    """Area over the load: three power profiles and rough surfaces on the half-space and on 15 layers, 2^18 points.

    From first touch to nearly full contact, beside closed forms and Persson's theory; up to 32 random surfaces for
    every point. Run again after an interruption, it continues; run again when finished, it says so.
    """

    quick: bool = False
    """2^14 points, 3 layers and up to 8 surfaces of another roughness, down to waves of L/256 only."""


def plans(options: Options) -> Sequence[Plan]:
    """The tasks at full size, or those of the quick study."""
    return [plan(QUICK if options.quick else CONFIGURATION)]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


STUDY = study.Study(name="pressure", options=Options, plans=plans, report=report, draw=draw)


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    return run_study(STUDY, options)
