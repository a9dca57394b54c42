"""Files and folders written safely: beside the final name first and then renamed, so never left half written.

A file that cannot be read or written raises `StoreError`, whose message names it and says what is allowed.
"""

import contextlib
import itertools
import os
import secrets
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from linecontact.solver import checks

from ..terminal import console
from .marks import is_ours

MAX_NAME = 200
"""Bytes of a file's name: most systems take 255, and the names of other files are made from it."""

_OTHER = {".xlsx", ".xls", ".ods", ".h5", ".hdf5", ".npy", ".json", ".png", ".pdf"}
"""Endings of files that are not comma-separated text."""

Named = tuple[str, Path]
"""An option of the command line, and a file that it names."""


class StoreError(ValueError):
    """A file that cannot be read or written as asked; the message names it."""


class DamagedError(StoreError):
    """A file of linecontact that differs from the written one."""


def as_path(name: str, path: object) -> Path:
    """A path from text or a path; raises `StoreError`, which names the parameter, for anything else."""
    text = os.fspath(path) if isinstance(path, str | os.PathLike) else ""
    if not isinstance(text, str) or not text or "\0" in text:
        raise StoreError(str(checks.refusal(name, path, "text or a path, neither empty nor with a null character")))
    return Path(text)


def make_folder(folder: Path) -> None:
    """Make `folder` and its parents; raises `StoreError` if that is impossible."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        for place in (folder, *folder.parents):
            if place.exists() and not place.is_dir():
                raise StoreError(
                    f"folder is {folder}, but {place} is a file; allowed: a new or existing folder"
                ) from None
        raise StoreError(f"folder {folder} cannot be made ({error.strerror}); allowed: a writable place") from None


def check_target(path: Path, overwrite: bool) -> None:
    """Raise `StoreError` before any work if `path` cannot become a new file."""
    if len(os.fsencode(path.name)) > MAX_NAME:
        raise StoreError(f"file {path} has a name longer than {MAX_NAME} bytes; allowed: a shorter one")
    if path.is_dir():
        raise StoreError(f"file {path} is a folder; allowed: the name of a file")
    if path.exists() and not path.is_file():
        raise StoreError(f"file {path} is not a regular file; allowed: the name of a file")
    if path.exists() and not overwrite:
        raise StoreError(
            f"file {path} exists; allowed: a new name, or overwriting it (--overwrite, in Python overwrite=True)"
        )
    if not path.parent.is_dir():
        raise StoreError(f"folder {path.parent} of file {path.name} does not exist; allowed: an existing folder")
    check_folder(path.parent)


def check_csv(option: str, path: Path) -> None:
    """Raise `StoreError` if an option's file has a name for something else than comma-separated values."""
    if path.suffix.lower() in _OTHER:
        other = path.with_suffix(".csv")
        raise StoreError(f"{option} is {path}; allowed: a name for comma-separated values, like {other}")


def check_targets(read: Iterable[Named], written: Iterable[Named], overwrite: bool, head: str) -> None:
    """Raise `StoreError` before any work if a file to be written is one that is read or written, too, or cannot become
    a new file; figures and tables that linecontact has made are replaced.

    read, written: the options that name the files, and the files. head: the first line of the table among them.
    """
    names = {os.path.realpath(path): name for name, path in read}
    for name, path in written:
        other = names.setdefault(os.path.realpath(path), name)
        if other != name:
            raise StoreError(f"{name} is {path}, which is taken by {other}; allowed: another file")
        check_target(path, overwrite or is_ours(path, head))


def check_folder(folder: Path) -> None:
    """Raise `StoreError` if nothing can be written there."""
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        reason = f"cannot be written to ({error.strerror})"
        raise StoreError(f"folder {folder} {reason}; allowed: a writable folder") from None


def write_bytes(path: Path, parts: Iterable[bytes]) -> None:
    """Write a file, part by part, beside its final name and rename it; a link is followed. Raises `StoreError`."""
    path = path.resolve()
    try:
        temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
        try:
            with temporary.open("xb") as target:
                target.writelines(parts)
                target.flush()
                os.fsync(target.fileno())
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise StoreError(f"file {path} could not be written: {error}") from error


def remove(*paths: Path) -> None:
    """Remove files that may be there. Raises `StoreError` if that is impossible."""
    for path in paths:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise StoreError(f"file {path} cannot be removed ({error.strerror})") from None


def set_aside(path: Path) -> None:
    """Rename a damaged file and say so. Raises `StoreError` if that is impossible."""
    ends = itertools.chain([".damaged"], (f".damaged.{k}" for k in itertools.count(2)))
    aside = next(aside for end in ends if not (aside := path.with_name(path.name + end)).exists())
    try:
        path.replace(aside)
    except OSError as error:
        raise StoreError(f"file {path} is damaged and cannot be set aside ({error.strerror})") from None
    console.errors.print(f"file {path} is damaged; it is set aside as {aside.name}, its part is done again")


@contextlib.contextmanager
def expecting(where: Path, own: bool = False) -> Iterator[None]:
    """Turn an error that odd names, numbers or texts can cause inside the block into a `StoreError` that names `where`,
    the file or folder that was read; any other is a bug, and is passed on.

    For blocks that work with the contents of a file: a right checksum does not say that its contents make sense.
    own: whether this process has computed all of it; then such an error is a bug, too.
    """
    try:
        yield
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        if own or isinstance(error, StoreError):
            raise
        reason = f"{type(error).__name__}: {error}, {console.place(error)}"
        what = f"{where} does not hold what linecontact writes there ({reason}); allowed: another one, or to make it"
        raise StoreError(f"{what} anew. If linecontact has written it, this is a bug, please report it") from error
