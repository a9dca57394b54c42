"""Common parts of all figures."""

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linecontact.solver.display import rounded_up

from ..files import study_files, writing
from ..files.study_files import StudyFile

if TYPE_CHECKING:  # Matplotlib takes its time, and a study's command needs this module before it draws
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito: safe for colour-blind readers
COLOURS = ("#0072b2", "#009e73", "#e69f00", "#d55e00", "#cc79a7", "#444444")
MARKERS = "os^Dv*"
STYLE = {
    "font.size": 8,
    "hatch.linewidth": 0.4,
    "axes.labelsize": 8,
    "axes.linewidth": 0.7,
    "axes.titlesize": 8,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "xtick.direction": "in",
    "xtick.labelsize": 7,
    "ytick.direction": "in",
    "ytick.labelsize": 7,
    "savefig.dpi": 300,
    "savefig.transparent": False,
    "text.usetex": False,  # a file's text is for no other program
}

ONE_COLUMN, TWO_COLUMNS = 3.4, 7.0
"""Widths of a figure in a journal [inch]: printed as wide as that, its text has 7 and 8 points."""


class NothingToDraw(writing.StoreError):
    """A file whose runs are too few for a figure."""


MOST = 64  # panels, or lines of a legend


def distinct(values: Iterable[Any]) -> list[Any]:
    """Each value once, in the order of their first appearance. Raises `ValueError` for more than a figure can show."""
    found = list(dict.fromkeys(values))
    if len(found) > MOST:
        raise ValueError(f"{len(found)} different values; allowed: up to {MOST} in a figure")
    return found


def typeset(value: float, digits: int = 4) -> str:
    """A number for a formula, powers of ten as people write them."""
    return _typeset(f"{value:.{digits}g}")


def typeset_error(value: float) -> str:
    """An estimated error, for a formula."""
    return _typeset(rounded_up(value))


def _typeset(number: str) -> str:
    if number == "inf":
        return r"\infty"
    factor, _, power = number.partition("e")
    if not power:
        return factor
    return f"{factor}\\times" * (factor != "1") + f"10^{{{int(power)}}}"


def layer(thickness: float) -> str:
    """A layer's thickness in periods L as people write it; inf is the half-space."""
    return "half-space" if math.isinf(thickness) else f"$d={typeset(thickness)}\\,L$"


def kind(name: str) -> str:
    """A layer's name as figures say it; nothing if it is bonded, as most are."""
    return _KINDS.get(name, plain(name))


_KINDS = {"bonded": "", "file": "layer from a table"}


def plain(text: str) -> str:
    """A file's text as it is, without formulas."""
    return text.replace("$", r"\$")


def legend_below(figure: "Figure", axes: "Axes", columns: int) -> None:
    """Put the legend of a panel below all panels, where it hides nothing."""
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=columns)


def panels(rows: int, columns: int, width: float, height: float, **options: Any) -> "tuple[Figure, Any]":
    """An empty figure, of which pyplot knows nothing, and its panels, shape (rows, columns); sizes in inches.

    Labels, titles, and legends with `loc="outside ..."` find their places by themselves. options: of
    `Figure.subplots`.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)  # one renderer for layout and image, so that each formula is read once
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def load(path: Path) -> StudyFile:
    """Read a study's file with at least one run. Raises `StoreError`, and `NothingToDraw` for a file without a run."""
    study = study_files.load_study(path)
    if not study.runs:
        raise NothingToDraw(f"file {path} holds no finished run yet")
    return study
