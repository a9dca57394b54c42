"""Draws the figures of a stored file and puts them beside it in every format."""

import io
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib
from linecontact.locks import DRAWING
from matplotlib.figure import Figure
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from ..files.marks import FORMATS, is_ours, marked, names
from ..files.writing import StoreError, expecting, write_bytes
from .style import STYLE
from .ticks import in_plain_text

matplotlib.use("Agg")


class ForeignFileError(StoreError):
    """A file that has the name of a figure, but is another program's, or an earlier version's."""


def save(
    path: Path, draw: Callable[[Path], dict[str, Figure]], overwrite: bool = False, own: bool = False
) -> list[Path]:
    """Draw and write the figures of a stored file; returns the files. Raises `StoreError`, and `ForeignFileError` where
    another program's file has the name of one.

    draw: makes figures from the stored file, by the endings of their names. overwrite: whether such a file may be
    replaced. own: as in `expecting`.
    """
    written = []
    with DRAWING, matplotlib.rc_context(STYLE), expecting(path, own):
        drawn = draw(path)
        for file in names(path, () if overwrite else drawn):
            if file.is_file() and not is_ours(file):
                reason = "has the name of a figure, and is not one that this version of linecontact has drawn"
                allowed = "to move it away, or linecontact plot --overwrite"
                raise ForeignFileError(f"file {file} {reason}; allowed: {allowed}")
        for ending, figure in drawn.items():
            in_plain_text(figure)
            _lay_out(figure)
            for form, file in zip(FORMATS, names(path, [ending]), strict=True):
                write_bytes(file, [_image(figure, form)])
                written.append(file)
            if pyplot := sys.modules.get("matplotlib.pyplot"):  # then it may have made the figure, and keeps it
                pyplot.close(figure)
    return written


def _image(figure: Figure, form: str) -> bytes:
    """A figure as a file with that ending."""
    image, palette = io.BytesIO(), io.BytesIO()
    figure.savefig(image, format=form[1:], metadata=marked(form))
    if form != ".png":
        return image.getvalue()
    with Image.open(image) as full:  # 256 colours take a third of the room
        notes, name = PngInfo(), "Software"
        notes.add_text(name, full.info[name])
        full.convert("RGB").quantize().save(palette, "png", pnginfo=notes, dpi=full.info["dpi"])
    return palette.getvalue()


def _lay_out(figure: Figure) -> None:
    """Lay out the figure once; otherwise every format does it again, which is half of its time."""
    engine = figure.get_layout_engine()
    if engine is not None:
        figure.set_dpi(matplotlib.rcParams["savefig.dpi"])
        engine.execute(figure)
        figure.set_layout_engine(None)
