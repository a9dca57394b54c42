"""The published study's Figure 2: Hertz's parabola, h = (R/n) |x/R|^n with n = 2, on layers of any thickness.

python studies/hertz.py [--quick] [--folder FOLDER]
"""

import math
import sys
from dataclasses import dataclass

from linecontact.studies.power_profiles import study
from linecontact.studies.power_profiles.tasks import Configuration
from linecontact.studies.runner.run import run_study
from linecontact.studies.terminal import console

CONFIGURATION = Configuration(exponent=2.0, published_alpha=3 * math.pi / 4)


@dataclass(frozen=True)
class Options(study.Options):
    """Hertz: a parabola on layers of any thickness (the published study's Figure 2): data, figures, table.

    2^18 points. Run again after an interruption, it continues; run again when finished, it says so.
    """


STUDY = study.make_study("hertz", CONFIGURATION, Options)


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    return run_study(STUDY, options)


if __name__ == "__main__":
    sys.exit(console.run(Options, command, "python -m linecontact.studies.hertz"))
