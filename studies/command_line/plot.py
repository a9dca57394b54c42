"""`linecontact plot`: the figures of a stored file."""

from dataclasses import dataclass
from pathlib import Path

from .. import STUDIES
from ..files import hdf5, study_files
from ..runner import drawing
from ..terminal.text import complain, printable


@dataclass(frozen=True)
class Options:
    """Draw the figures of a stored solution or study beside its file."""

    file: Path
    """An HDF5 file that linecontact wrote."""
    overwrite: bool = False
    """Replace another program's files that have the names of the figures."""


def command(options: Options) -> int:
    """Draw the figures and print their paths; returns the exit status."""
    drawn = drawing.draw(options.file, options.overwrite)
    if hdf5.file_kind(options.file) in STUDIES and not study_files.is_complete(options.file):
        complain(f"file {options.file} does not hold all that was asked for; run its study again to go on")
    for file in drawn:
        print(printable(str(file)))
    return 0
