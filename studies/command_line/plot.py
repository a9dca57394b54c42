"""`linecontact plot`: the figures of a stored file."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from .. import STUDIES
from ..files import hdf5, study_files
from ..runner import drawing
from ..terminal.text import complain, printable


@dataclass(frozen=True)
class Options:
    """Draw the figures of a stored solution or study beside its file."""

    file: Path
    """An HDF5 file that linecontact wrote."""


def command(options: Options, output: TextIO | None = None) -> int:
    """Draw the figures and print their names, on standard output if nothing else is said; returns the exit status."""
    with warnings.catch_warnings(action="ignore"):  # of what matplotlib finds odd in a file
        drawn = drawing.draw(options.file)
    if hdf5.file_kind(options.file) in STUDIES and not study_files.is_complete(options.file):
        complain(f"file {options.file} does not hold all that was asked for; run its study again to go on")
    for file in drawn:
        print(printable(str(file)), file=output)
    return 0
