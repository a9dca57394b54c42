"""What all figures share."""

from pathlib import Path

from .. import store

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
}


class NothingToDraw(store.StoreError):
    """A file whose runs are too few for a figure."""


def load(path: Path) -> store.StudyFile:
    """A study's file with at least one run. Raises `store.StoreError`, for a file without one `NothingToDraw`."""
    study = store.load_study(path)
    if not study.runs:
        raise NothingToDraw(f"file {path} holds no finished run yet")
    return study
