"""Names of the files that figures are written to."""

from collections.abc import Iterable
from pathlib import Path

FORMATS = (".png", ".pdf")
"""Endings of the files that every figure is written to."""


def names(path: Path, endings: Iterable[str]) -> list[Path]:
    """The files of the figures of a stored file, beside it: for each ending of a figure's name one in every format."""
    return [path.with_name(path.stem + ending + form) for ending in endings for form in FORMATS]
