"""Draws any stored file: a solution, or a study's file by the drawing that its study carries."""

import warnings
from pathlib import Path

from .. import STUDIES
from ..figures import saving, solution
from ..files import hdf5, solution_files, writing
from .study import find


def draw(path: Path, overwrite: bool = False, own: bool = False) -> list[Path]:
    """Draw everything that a stored file has figures for; returns the figures' files. Raises `StoreError`.

    overwrite: whether another program's files may be replaced. own: as in `writing.expecting`.
    """
    kind = hdf5.file_kind(path)
    if kind != solution_files.KIND and kind not in STUDIES:
        allowed = ", ".join((*STUDIES, solution_files.KIND))
        raise writing.StoreError(f"file {path} is of kind {kind!r}; allowed: {allowed}")
    with warnings.catch_warnings(action="ignore"):  # Matplotlib's, of odd numbers in a file
        return saving.save(path, solution.draw if kind == solution_files.KIND else find(kind).draw, overwrite, own)
