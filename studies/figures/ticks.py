"""Few ticks, whose numbers do not run into each other in a figure one column wide.

Numbers are plain text: Matplotlib writes powers of ten as formulas, and typesetting these took a quarter of the time of
a solution's figure.
"""

import math
import re

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterSciNotation, LogLocator, MaxNLocator, NullFormatter, ScalarFormatter

_TIMES = "\N{MULTIPLICATION SIGN}"
_FORMULA = re.compile(r"\$\\mathdefault\{(?:([\d.]+)\\times)?(\d+)\^\{(-?\d+)\}\}\$")
_RAISED = str.maketrans("-\N{MINUS SIGN}0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class _Numbers(ScalarFormatter):
    """Numbers; powers of ten but small ones stand once at the axis."""

    def __init__(self) -> None:
        super().__init__(useOffset=False, useMathText=False)
        self.set_powerlimits((-2, 4))

    def get_offset(self) -> str:
        offset = super().get_offset()
        before, power, exponent = offset.partition("1e")
        return f"{before}{_TIMES}10{exponent.translate(_RAISED)}" if power else str(offset)


class _Powers(LogFormatterSciNotation):
    """Powers of ten, or of another base, and their multiples."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        formula = super().__call__(x, pos)
        if not (found := _FORMULA.fullmatch(formula)):
            return str(formula)
        factor, base, exponent = found.groups("")
        return f"{factor}{_TIMES}" * bool(factor) + base + exponent.translate(_RAISED)


def few_ticks(axes: Axes, bins: int = 4) -> None:
    """Few ticks on both axes, once everything is drawn; bins: the most intervals of an axis that is not logarithmic."""
    for axis, limits in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        if axis.get_scale() == "log":
            _logarithmic(axis, math.log10(limits[1] / limits[0]))
            continue
        axis.set_major_locator(MaxNLocator(bins, steps=[1, 2, 2.5, 5, 10]))
        axis.set_major_formatter(_Numbers())


def _logarithmic(axis: Axis, decades: float) -> None:
    """Numbers at powers of ten, and between them where these are too few to read an axis by."""
    labelled = (1.0, 2.0, 5.0) if decades < 1.4 else (1.0, 3.0) if decades < 2.2 else (1.0,)
    if len(labelled) > 1:
        axis.set_major_locator(LogLocator(subs=labelled))
        axis.set_major_formatter(_Powers(labelOnlyBase=False, minor_thresholds=(math.inf, math.inf)))
    axis.set_minor_formatter(NullFormatter())


def in_plain_text(figure: Figure) -> None:
    """Have the numbers at all logarithmic axes of a figure in plain text."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            major, minor = axis.get_major_formatter(), axis.get_minor_formatter()
            base = getattr(axis.get_transform(), "base", 10.0)
            if type(major) is LogFormatterSciNotation:
                axis.set_major_formatter(_Powers(base))
            if type(minor) is LogFormatterSciNotation:
                axis.set_minor_formatter(_Powers(base, labelOnlyBase=minor.labelOnlyBase))
