"""The published study's Figure 5: randomly rough surfaces on layers of any thickness, means over realisations.

python studies/rough.py [--quick] [--folder FOLDER]
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from linecontact.studies.rough_surfaces import ensembles
from linecontact.studies.rough_surfaces.report import missed, report
from linecontact.studies.rough_surfaces.tasks import QUICK, Configuration, plan
from linecontact.studies.runner import study
from linecontact.studies.runner.run import run_study
from linecontact.studies.terminal import console

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CONFIGURATION = Configuration()


@dataclass(frozen=True)
class Options(study.Options):
    """Randomly rough surfaces (the published study's Figure 5), 2^18 points, 32 realisations: minutes on two cores.

    Run again after an interruption, it continues; run again when finished, it says so.
    """

    quick: bool = False
    """2^14 points, 8 realisations, two layers less, and a surface with fewer waves (lambda_s/lambda_r = 1/32)."""
    standard_error: float | None = None
    """Instead of a number of surfaces: the standard error of kappa and of the contact area wanted at every point, over
    their means, like 0.01. Most surfaces are then solved on coarse grids. It needs a folder of its own."""


def plans(options: Options) -> Sequence[study.Plan]:
    """The tasks at full size, or those of the quick study. Raises `ValueError`."""
    configuration = QUICK if options.quick else CONFIGURATION
    if options.standard_error is not None:
        return [ensembles.plan(configuration, options.standard_error)]
    return [plan(configuration)]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from linecontact.studies.rough_surfaces import figures

    return figures.draw(path)


STUDY = study.Study(name="rough", options=Options, plans=plans, report=report, draw=draw, missed=missed)


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    return run_study(STUDY, options)


if __name__ == "__main__":
    sys.exit(console.run(Options, command, "python -m linecontact.studies.rough"))
