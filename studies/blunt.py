"""The published study's Figure 4: the blunt indenter, h = (R/n) |x/R|^n with n = 4, on layers of any thickness.

python studies/blunt.py [--quick] [--folder FOLDER]
"""

import sys
from dataclasses import dataclass

from linecontact.studies.power_profiles import study
from linecontact.studies.power_profiles.tasks import Configuration
from linecontact.studies.runner.run import run_study
from linecontact.studies.terminal import console

CONFIGURATION = Configuration(exponent=4.0, published_alpha=2.94)


@dataclass(frozen=True)
class Options(study.Options):
    """A blunt indenter, n = 4, on layers of any thickness (the published study's Figure 4): data, figures, table.

    2^18 points. Run again after an interruption, it continues; run again when finished, it says so.
    """


STUDY = study.make_study("blunt", CONFIGURATION, Options)


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    return run_study(STUDY, options)


if __name__ == "__main__":
    sys.exit(console.run(Options, command, "python -m linecontact.studies.blunt"))
