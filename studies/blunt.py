"""The published study's Figure 4: the blunt indenter, h = (R/n) |x/R|^n with n = 4, on layers of any thickness.

python -m linecontact.studies.blunt [--quick] [--folder FOLDER]
"""

import sys
from dataclasses import dataclass

from .power_profiles import study as asperity
from .terminal import console

CONFIGURATION = asperity.Configuration(exponent=4.0, published_alpha=2.94)


@dataclass(frozen=True)
class Options(asperity.Options):
    """A blunt indenter, n = 4, on layers of any thickness (the published study's Figure 4): data, figures, table.

    2^18 points. Run again after an interruption, it continues; run again when finished, it says so.
    """


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    return asperity.command("blunt", CONFIGURATION, options)


if __name__ == "__main__":
    sys.exit(console.run(Options, command, "python -m linecontact.studies.blunt"))
