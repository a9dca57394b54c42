"""The published study's Figure 3: the sharp indenter, h = (R/n) |x/R|^n with n = 1.5, on layers of any thickness.

python -m linecontact.studies.sharp [--quick] [--folder FOLDER]
"""

import sys
from dataclasses import dataclass

from .power_profiles import study as asperity
from .terminal import console

# thinner incompressible layers would be below a grid spacing, and the residual of 1e-8 below float64's rounding
CONFIGURATION = asperity.Configuration(exponent=1.5, published_alpha=2.20, thinnest_incompressible=0.02)


@dataclass(frozen=True)
class Options(asperity.Options):
    """A sharp indenter, n = 1.5, on layers of any thickness (the published study's Figure 3): data, figures, table.

    2^18 points. Run again after an interruption, it continues; run again when finished, it says so.
    """


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    return asperity.command("sharp", CONFIGURATION, options)


if __name__ == "__main__":
    sys.exit(console.run(Options, command, "python -m linecontact.studies.sharp"))
