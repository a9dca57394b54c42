"""`linecontact export`: a stored file as a table for pandas or a spreadsheet."""

import sys
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from ..files import csv_tables, writing

OUTPUT = Path("-")
"""The name that means standard output."""


@dataclass(frozen=True)
class Options:
    """Write a stored study or solution as a table: of a study a line for each run, of a solution one for each point.

    The first line names the columns, with units. Numbers have all their digits. A text that a spreadsheet would take
    for a formula has an apostrophe before it.
    """

    file: Path
    """An HDF5 file that linecontact wrote."""
    csv: Path = OUTPUT
    """The file to write, of comma-separated values; - is standard output."""
    overwrite: bool = False
    """Let --csv replace a file with other columns than these."""


def command(options: Options) -> int:
    """Write the table; returns the exit status."""
    writing.check_csv("csv", options.csv)
    parts = csv_tables.table(options.file)
    if options.csv == OUTPUT:
        sys.stdout.buffer.writelines(parts)
        return 0
    head = next(parts)
    writing.check_targets([("file", options.file)], [("csv", options.csv)], options.overwrite, head.decode().strip())
    writing.write_bytes(options.csv, chain([head], parts))
    return 0
