"""Few ticks, whose numbers do not run into each other in a figure one column wide."""

import math

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import LogFormatterSciNotation, LogLocator, MaxNLocator, NullFormatter, ScalarFormatter


def few_ticks(axes: Axes, bins: int = 4) -> None:
    """Few ticks on both axes, once everything is drawn; bins: the most intervals of an axis that is not logarithmic."""
    for axis, limits in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        if axis.get_scale() == "log":
            _logarithmic(axis, math.log10(limits[1] / limits[0]))
            continue
        axis.set_major_locator(MaxNLocator(bins, steps=[1, 2, 2.5, 5, 10]))
        numbers = ScalarFormatter(useMathText=True, useOffset=False)
        numbers.set_powerlimits((-2, 4))  # other powers of ten stand once at the axis
        axis.set_major_formatter(numbers)


def _logarithmic(axis: Axis, decades: float) -> None:
    """Numbers at powers of ten, and between them where these are too few to read an axis by."""
    labelled = (1.0, 2.0, 5.0) if decades < 1.4 else (1.0, 3.0) if decades < 2.2 else (1.0,)
    if len(labelled) > 1:
        axis.set_major_locator(LogLocator(subs=labelled))
        axis.set_major_formatter(LogFormatterSciNotation(labelOnlyBase=False, minor_thresholds=(math.inf, math.inf)))
    axis.set_minor_formatter(NullFormatter())
