"""Names of the files that figures are written to, and the mark that they bear."""

from collections.abc import Iterable
from pathlib import Path

FORMATS = (".png", ".pdf")
"""Endings of the files that every figure is written to."""

_PROGRAM = "linecontact"
_MARKS = {".png": ("Software", f"Software\0{_PROGRAM}"), ".pdf": ("Creator", f"/Creator ({_PROGRAM})")}
"""Where the program's name stands in the files of figures, and how."""


def names(path: Path, endings: Iterable[str]) -> list[Path]:
    """The files of the figures of a stored file, beside it: for each ending of a figure's name one in every format."""
    return [path.with_name(path.stem + ending + form) for ending in endings for form in FORMATS]


def marked(form: str) -> dict[str, str] | None:
    """Metadata that tell that linecontact has drawn a figure, for a file with that ending; None for other ones."""
    return {_MARKS[form][0]: _PROGRAM} if form in _MARKS else None


def is_ours(file: Path) -> bool:
    """Whether a file is there, and linecontact has drawn it: a figure of this version or a later one."""
    return file.is_file() and _MARKS[file.suffix][1].encode() in file.read_bytes()
