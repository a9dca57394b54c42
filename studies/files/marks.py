"""Files that linecontact has made and can make again, which may be replaced: figures by the mark that they bear, tables
by their first line.
"""

import re
from collections.abc import Iterable
from pathlib import Path

FORMATS = (".png", ".pdf")
"""Endings of the files that every figure is written to."""

_PROGRAM = "linecontact"
_MARKS = {
    ".png": ("Software", f"Software\0{_PROGRAM}"),
    ".pdf": ("Creator", f"/Creator ({_PROGRAM})"),
}
"""How figures bear the program's name. Vector graphics that people edit, like .svg, bear none."""

_UNIT = re.compile(r" \[[^]]*\]")


def names(path: Path, endings: Iterable[str]) -> list[Path]:
    """The files of the figures of a stored file, beside it: for each ending of a figure's name one in every format."""
    return [path.with_name(path.stem + ending + form) for ending in endings for form in FORMATS]


def marked(form: str) -> dict[str, str] | None:
    """Metadata that tell that linecontact has drawn a figure, for a file with that ending; None for other ones."""
    return {_MARKS[form][0]: _PROGRAM} if form in _MARKS else None


def is_ours(file: Path, head: str = "") -> bool:
    """Whether a file is there, and is a figure of linecontact's or a table with the columns of this one.

    head: the first line of a table, or nothing for a figure; units may differ.
    """
    if not file.is_file():
        return False
    if file.suffix.lower() in _MARKS:
        return _MARKS[file.suffix.lower()][1].encode() in file.read_bytes()
    with file.open("rb") as lines:
        first = lines.readline(len(head) + 1000).decode(errors="replace")
    return bool(head) and _UNIT.sub("", first.rstrip("\r\n")) == _UNIT.sub("", head)
