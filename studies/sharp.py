"""The published study's Figure 3: the sharp indenter, h = (R/n) |x/R|^n with n = 1.5, on layers of any thickness.

python studies/sharp.py [--quick] [--folder FOLDER]
"""

import sys
from dataclasses import dataclass

from linecontact.studies.power_profiles import study
from linecontact.studies.power_profiles.tasks import Configuration
from linecontact.studies.runner.run import run_study
from linecontact.studies.terminal import console

# thinner incompressible layers would be below a grid spacing, and the residual of 1e-8 below float64's rounding
CONFIGURATION = Configuration(exponent=1.5, published_alpha=2.20, thinnest_incompressible=0.02)


@dataclass(frozen=True)
class Options(study.Options):
    """A sharp indenter, n = 1.5, on layers of any thickness (the published study's Figure 3): data, figures, table.

    2^18 points. Run again after an interruption, it continues; run again when finished, it says so.
    """


STUDY = study.make_study("sharp", CONFIGURATION, Options)


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    return run_study(STUDY, options)


if __name__ == "__main__":
    sys.exit(console.run(Options, command, "python -m linecontact.studies.sharp"))
