"""Draws the figures of a stored file and puts them beside it in every format."""

import io
from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from ..files.writing import expecting, write_bytes
from .names import FORMATS, names
from .style import STYLE
from .ticks import in_plain_text


def save(path: Path, draw: Callable[[Path], dict[str, Figure]]) -> list[Path]:
    """Draw and write the figures of a stored file; returns the files. Raises `StoreError`.

    draw: makes figures from the stored file, by the endings of their names.
    """
    written = []
    with plt.rc_context(STYLE), expecting(path):
        for ending, figure in draw(path).items():
            in_plain_text(figure)
            _lay_out(figure)
            for form, file in zip(FORMATS, names(path, [ending]), strict=True):
                image = io.BytesIO()
                figure.savefig(image, format=form[1:])
                write_bytes(file, [image.getvalue()])
                written.append(file)
            plt.close(figure)
    return written


def _lay_out(figure: Figure) -> None:
    """Lay out the figure once; otherwise every format does it again, which is half of its time."""
    engine = figure.get_layout_engine()
    if engine is not None:
        figure.set_dpi(matplotlib.rcParams["savefig.dpi"])
        engine.execute(figure)
        figure.set_layout_engine(None)
