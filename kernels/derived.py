"""Files that can be made again, with checksums beside them: one that a power cut has shortened is made again."""

import hashlib
import os
import shutil
from contextlib import suppress
from pathlib import Path


def is_whole(file: Path) -> bool:
    """Whether a file is there with the content that it was sealed with."""
    try:
        both = file.is_file() and _seal(file).is_file()  # reading a pipe never ends
        return both and _seal(file).read_bytes() == _checksum(file)
    except OSError:
        return False


def seal(file: Path) -> None:
    """Note the contents of a file; where the folder cannot be written to, the next process makes it anew."""
    new = _seal(file).with_suffix(f".{os.getpid()}")
    with suppress(OSError):
        if not is_whole(file):
            new.write_bytes(_checksum(file))
            new.replace(_seal(file))


def discard(file: Path) -> None:
    """Take away a file, or a folder in its place, and its seal, as far as the folder lets us."""
    for one in (file, _seal(file)):
        with suppress(OSError):
            shutil.rmtree(one) if one.is_dir() and not one.is_symlink() else one.unlink(missing_ok=True)


def _seal(file: Path) -> Path:
    return file.with_name(f"{file.name}.sha256")


def _checksum(file: Path) -> bytes:
    return hashlib.sha256(file.read_bytes()).hexdigest().encode()
