"""Real transforms by pyFFTW over buffers that the kernels share, and FFTW's wisdom kept in the user's cache folder.

Convention: forward sum_i x_i exp(-2 pi i k i/N), k = 0 ... N/2; the inverse is unnormalised (a factor N), so the
coefficients multiplied in between carry 1/N.
"""

import json
import os
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import padded_length
from . import checks
from .fftw import pyfftw

Array = NDArray[Any]

PLANNING = ("estimate", "measure", "patient")
"""Planning effort. 'estimate' plans at once, and takes what wisdom holds of an earlier, greater effort."""

_STAGGER = 1024  # bytes: buffers that start at equal page offsets slow each other down

_MOST_WISDOM = 2**24  # bytes; a plan takes some hundred

_wisdom_loaded = False


class Transforms:
    """Plans between real buffers of `num_points` values and one shared half spectrum.

    num_points: N; precision: 'float64' or 'float32'; threads: of FFTW, >= 1; planning: one of `PLANNING`.
    spectrum: flat real view of the half spectrum (re, im, ...), 2 (N//2 + 1) values and zeros up to a padded length.

    Raises `ValueError`.
    """

    def __init__(self, num_points: int, precision: str, threads: int = 1, planning: str = "estimate") -> None:
        self.threads, self.planning = check_settings(threads, planning)
        self.num_points = num_points
        self.real = np.dtype(precision)
        self._count = 0
        length = 2 * (num_points // 2 + 1)
        self.spectrum = self.buffer(length)
        self._modes = self.spectrum[:length].view(np.result_type(self.real, np.complex64))
        load_wisdom()

    def buffer(self, length: int | None = None) -> Array:
        """A padded, aligned, staggered array for `length` (default N) values: zeros."""
        length = self.num_points if length is None else length
        padded = padded_length(length)
        offset = self._count * _STAGGER // self.real.itemsize
        self._count += 1
        array: Array = pyfftw.zeros_aligned(padded + offset, dtype=self.real, n=64)[offset:]
        return array

    def doubled(self, symbol: Array) -> Array:
        """A buffer like the spectrum's with every value of a symbol, shape (N//2 + 1,), for both parts of its mode."""
        coefficient = self.buffer(2 * symbol.size)
        coefficient[: 2 * symbol.size] = np.repeat(symbol, 2)
        return coefficient

    def forward(self, source: Array) -> Callable[[], None]:
        """Plan source[:N] -> spectrum; the plan keeps `source`. Plan before filling it."""
        return self._plan(source[: self.num_points], self._modes, "FFTW_FORWARD")

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan spectrum -> target[:N], times N; destroys the spectrum."""
        return self._plan(self._modes, target[: self.num_points], "FFTW_BACKWARD")

    def _plan(self, source: Array, target: Array, direction: str) -> Callable[[], None]:
        flags = [f"FFTW_{self.planning.upper()}"]
        if direction == "FFTW_BACKWARD":
            flags.append("FFTW_DESTROY_INPUT")
        plan = pyfftw.FFTW(source, target, direction=direction, threads=self.threads, flags=flags)
        execute: Callable[[], None] = plan.execute
        return execute


def check_settings(threads: int, planning: str) -> tuple[int, str]:
    """Both, if they are allowed. Raises `ValueError`."""
    allowed = checks.integer("threads", threads, "an integer from 1 to 1024", 1, 1024)
    return allowed, checks.choice("planning", planning, PLANNING)


def cache_folder() -> Path:
    """The user's cache folder for linecontact ($XDG_CACHE_HOME/linecontact, default ~/.cache/linecontact)."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "linecontact"


def wisdom_file() -> Path:
    """Where FFTW's wisdom is kept (JSON: one string per FFTW precision)."""
    return cache_folder() / "fftw-wisdom.json"


def load_wisdom() -> None:
    """Import the stored wisdom once per process; a broken file is ignored with a `RuntimeWarning`."""
    global _wisdom_loaded
    if not _wisdom_loaded:
        _wisdom_loaded = True
        _import_wisdom()


def _import_wisdom() -> None:
    try:
        path = wisdom_file()
        if not path.exists():
            return
        if not path.is_file() or path.stat().st_size > _MOST_WISDOM:
            raise OSError(f"{path} is not a file of up to {_MOST_WISDOM >> 20} MiB")
        text = path.read_text("ascii")
    except (OSError, UnicodeDecodeError, RuntimeError) as error:  # RuntimeError: a user without a home
        warnings.warn(f"FFTW wisdom is ignored: {error}", RuntimeWarning, stacklevel=3)
        return
    try:
        stored = json.loads(text)
        parts = tuple(stored[name].encode("ascii") for name in ("double", "single", "long double"))
        done = all(pyfftw.import_wisdom(parts))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        done = False
    if not done:
        warnings.warn(f"FFTW wisdom in {path} is broken and ignored", RuntimeWarning, stacklevel=3)


def save_wisdom() -> None:
    """Add this process's wisdom to the stored one; the file is replaced in one step, trouble only warns."""
    temporary = None
    try:
        path = wisdom_file()
        path.parent.mkdir(parents=True, exist_ok=True)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            _import_wisdom()
        double, single, long_double = (part.decode("ascii") for part in pyfftw.export_wisdom())
        text = json.dumps({"double": double, "single": single, "long double": long_double})
        with tempfile.NamedTemporaryFile("w", dir=path.parent, prefix=path.name, delete=False) as file:
            temporary = Path(file.name)
            file.write(text)
        temporary.replace(path)
    except (OSError, RuntimeError) as error:
        if temporary:
            temporary.unlink(missing_ok=True)
        warnings.warn(f"FFTW wisdom could not be kept: {error}", RuntimeWarning, stacklevel=2)
