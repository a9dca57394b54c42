"""What all figures share."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..files import study_files, writing
from ..files.study_files import StudyFile

# Okabe and Ito: safe for colour-blind readers
COLOURS = ("#0072b2", "#009e73", "#e69f00", "#d55e00", "#cc79a7", "#444444")
MARKERS = "os^Dv*"
STYLE = {
    "font.size": 9,
    "axes.linewidth": 0.8,
    "axes.titlesize": 9,
    "legend.frameon": False,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "figure.subplot.left": 0.15,
    "figure.subplot.right": 0.97,
    "figure.subplot.bottom": 0.13,
    "figure.subplot.top": 0.92,
    "savefig.dpi": 180,
    "text.usetex": False,  # a file's text is for no other program
}


class NothingToDraw(writing.StoreError):
    """A file whose runs are too few for a figure."""


MOST = 64  # panels, or lines of a legend


def distinct(values: Iterable[Any]) -> list[Any]:
    """Each value once, in the order of their first appearance. Raises `ValueError` for more than a figure can show."""
    found = list(dict.fromkeys(values))
    if len(found) > MOST:
        raise ValueError(f"{len(found)} different values; allowed: up to {MOST} in a figure")
    return found


def load(path: Path) -> StudyFile:
    """Read a study's file with at least one run. Raises `StoreError`, and `NothingToDraw` for a file without a run."""
    study = study_files.load_study(path)
    if not study.runs:
        raise NothingToDraw(f"file {path} holds no finished run yet")
    return study
