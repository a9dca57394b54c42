"""FFTW's wisdom, kept in the user's cache folder: plans found with effort are not looked for again."""

import json
import os
import tempfile
import warnings
from pathlib import Path

from ...kernels import derived
from ...locks import PLANNING
from .plain import pyfftw

_loaded = False


def cache_folder() -> Path:
    """The user's cache folder for linecontact ($XDG_CACHE_HOME/linecontact, default ~/.cache/linecontact)."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "linecontact"


def wisdom_file() -> Path:
    """Where FFTW's wisdom is kept (JSON: one string per FFTW precision)."""
    return cache_folder() / "fftw-wisdom.json"


def load() -> None:
    """Import the stored wisdom once per process; a broken file is removed with a `RuntimeWarning`."""
    global _loaded
    with PLANNING:
        if not _loaded:
            _loaded = True
            _import()


def _import() -> None:
    try:
        path = wisdom_file()
        if not path.exists():
            return
        text = path.read_bytes() if path.is_file() else b""
    except (OSError, RuntimeError) as error:  # RuntimeError: a user without a home
        warnings.warn(f"FFTW wisdom is ignored: {error}", RuntimeWarning, stacklevel=3)
        return
    try:
        stored = json.loads(text)
        parts = tuple(stored[name].encode("ascii") for name in ("double", "single", "long double"))
        done = all(pyfftw.import_wisdom(parts))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        done = False
    if not done:
        derived.discard(path)  # new plans are kept in a new one
        warnings.warn(f"FFTW wisdom in {path} was broken and is ignored", RuntimeWarning, stacklevel=3)


def save() -> None:
    """Add this process's wisdom to the stored one; the file is replaced in one step, trouble only warns."""
    try:
        path = wisdom_file()
        path.parent.mkdir(parents=True, exist_ok=True)
        with PLANNING, warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            _import()
            double, single, long_double = (part.decode("ascii") for part in pyfftw.export_wisdom())
        text = json.dumps({"double": double, "single": single, "long double": long_double})
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=path.name) as folder:
            new = Path(folder) / path.name
            new.write_text(text, "ascii")
            new.replace(path)
    except (OSError, RuntimeError) as error:
        warnings.warn(f"FFTW wisdom could not be kept: {error}", RuntimeWarning, stacklevel=2)
