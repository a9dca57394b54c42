"""The published study's Figure 2: Hertz's parabola, h = (R/n) |x/R|^n with n = 2, on layers of any thickness.

python -m linecontact.studies.hertz [--quick] [--folder FOLDER]
"""

import math
import sys
from dataclasses import dataclass

from .power_profiles import study as asperity
from .terminal import console

CONFIGURATION = asperity.Configuration(exponent=2.0, published_alpha=3 * math.pi / 4)


@dataclass(frozen=True)
class Options(asperity.Options):
    """Hertz: a parabola on layers of any thickness (the published study's Figure 2): data, figures, table.

    2^18 points. Run again after an interruption, it continues; run again when finished, it says so.
    """


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    return asperity.command("hertz", CONFIGURATION, options)


if __name__ == "__main__":
    sys.exit(console.run(Options, command, "python -m linecontact.studies.hertz"))
