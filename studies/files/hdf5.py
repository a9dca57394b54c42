"""HDF5 files with a checksum: the common part of solution files and study files.

Before the HDF5 part, as its user block, stands the SHA-256 of all that follows. A file is read only if the checksum
fits: HDF5's library does not survive every damaged file. Against malice nothing is done.
"""

import contextlib
import hashlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..terminal.text import printable
from .writing import DamagedError, StoreError, write_bytes

if TYPE_CHECKING:  # h5py is imported where a file is opened: much of the program never opens one
    import h5py

_HEAD = 512  # bytes of HDF5's user block
_MAX_TEXT = 10_000  # characters of a stored text that are kept

_written: set[str] = set()  # checksums of files that this process has written


@contextlib.contextmanager
def new_file(path: str | os.PathLike[str]) -> Iterator["h5py.File"]:
    """An HDF5 file that appears under `path` only when it is complete. Raises `StoreError` if it cannot be written.

    HDF5 builds it in memory, because its library does not survive a full disk.
    """
    import h5py

    path = Path(path)
    with h5py.File(path.name, "w", driver="core", backing_store=False) as file:
        yield file
        file.flush()
        image = file.id.get_file_image()
    digest = hashlib.sha256(image).hexdigest()
    write_bytes(path, [head(digest), image])
    _written.add(digest)


@contextlib.contextmanager
def open_file(path: str | os.PathLike[str]) -> Iterator["h5py.File"]:
    """Read an HDF5 file; raises `StoreError` for a missing or foreign one, `DamagedError` for a damaged one, also where
    the reader does not find in it the names that it looks for.
    """
    path = Path(path)
    if not os.path.isfile(path):  # Path's own raises for some names
        what = "is no regular file" if os.path.lexists(path) else "does not exist"
        raise StoreError(f"file {path} {what}; allowed: an HDF5 file")
    digest = _verify(path)
    try:
        import h5py

        with h5py.File(path, "r") as file:
            yield file
    except (AttributeError, LookupError, OSError, RuntimeError, TypeError, ValueError) as error:  # h5py's, and groups
        if isinstance(error, StoreError) or digest in _written:  # a bug
            raise
        why = f"file {path} is whole, but not as this version writes it ({type(error).__name__}: {error})"
        allowed = "one of this version's, or to make it anew"
        bug = "if this version has written it, this is a bug, please report it"
        raise DamagedError(f"{why}; allowed: {allowed}; {bug}") from error


def _verify(path: Path) -> str:
    """The file's checksum, before HDF5 sees the file. Raises `StoreError` if it does not fit the stored one."""
    try:
        with path.open("rb") as file:
            start = file.read(_HEAD)
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise StoreError(f"file {path} cannot be read ({error.strerror})") from None
    if start == head(digest):
        return digest
    expected = head("")[:40]
    alike = sum(a == b for a, b in zip(start, expected, strict=False))
    few = 2 if len(start) >= len(expected) else 0
    # zeros, a few flipped bits or an early end make no stranger of it
    if any(start) and alike < min(len(start), len(expected)) - few:
        raise StoreError(f"file {path} is not one of linecontact's HDF5 files; allowed: one that it wrote")
    reason = "its checksum does not fit" if start else "it is empty"
    raise DamagedError(f"file {path} is damaged: {reason}; allowed: a whole one, or to make it anew")


def head(digest: str) -> bytes:
    """The user block of a file whose HDF5 part has the SHA-256 `digest`."""
    return f"linecontact, SHA-256 of all but these {_HEAD} bytes: {digest}\n".encode().ljust(_HEAD, b"\0")


def file_kind(path: Path) -> str:
    """'solution' or the study's name. Raises like `open_file`."""
    with open_file(path) as file:
        return str(file.attrs["kind"])


def column_of_numbers(dataset: "h5py.Dataset") -> NDArray[np.float64]:
    """The values of a dataset, shape (its length,). Raises `ValueError` if it is no column of numbers."""
    if dataset.ndim != 1 or dataset.dtype.kind != "f":
        raise ValueError(f"{dataset.name} is no column of numbers")
    return np.asarray(dataset[:], dtype=np.float64)


def scalar(value: Any) -> Any:
    """A stored number or text as Python has it; of text no more than the terminal and figures can show."""
    value = value.item() if isinstance(value, np.generic) else value
    value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
    return printable(value[:_MAX_TEXT]) if isinstance(value, str) else value
