"""FFTW: the library, its plans, and transforms of plain arrays now and then.

Those are in float64, with NumPy's normalisation: 1/N on the way back. Transforms done often on arrays of one length go
through `planned`.

pyFFTW is imported without SciPy and Dask, which its interfaces would import although nothing here uses them. They are
hidden only while pyFFTW is being imported; afterwards they can be imported as ever. pyFFTW's interfaces for them are
then missing: who wants those imports pyFFTW first.
"""

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ... import locks
from ...locks import PLANNING
from ..arrays import Array64, Modes, chunks


@contextmanager
def _hidden(*names: str) -> Iterator[None]:
    """Modules that are not loaded yet cannot be imported meanwhile."""
    hidden = [name for name in names if name not in sys.modules]
    for name in hidden:
        sys.modules[name] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        for name in hidden:
            del sys.modules[name]


with _hidden("scipy", "dask"):
    import pyfftw

__all__ = ["IN_PLACE", "Pair", "Plan", "irfft", "library", "next_fast_len", "pair", "pyfftw", "rfft"]

next_fast_len = pyfftw.next_fast_len

_PATIENCE = 20.0  # s, for a plan that takes microseconds
IN_PLACE = 2**18
"""Values, in float64, from which FFTW's real transforms take less time in place."""
_TOO_LONG, _MOST_PAIRS = 2**22, 64
"""Values of all pairs that a thread keeps, so that a longer one is never kept; and their number."""


def library() -> str:
    """The library that plans, with its version."""
    return str(pyfftw.fftw_version)


@locks.once
def _await_planner() -> None:
    """Raise `ValueError` if a thread that a fork has left behind has FFTW's planner: one of the user's own."""
    values = pyfftw.empty_aligned(2, dtype=complex)
    thread = threading.Thread(target=pyfftw.FFTW, args=(values, values), daemon=True)
    thread.start()
    thread.join(_PATIENCE)
    if thread.is_alive():
        what = "the process was forked while another of its threads planned a transform of its own"
        raise ValueError(f"{what}, and waits for that for ever; allowed: 'spawn' or 'forkserver'")


class Plan:
    """A plan of FFTW's, made as `pyfftw.FFTW` is and done by calling it.

    pyFFTW takes its planner's lock to make and to remove one, and a child of a fork would wait for ever for a thread
    of its parent that held it. A collection of garbage may end a plan anywhere, beside any other lock, so it never
    waits: what it cannot remove at once goes with a later one.
    """

    _ended: ClassVar[list[Any]] = []

    def __init__(self, *arrays: Any, **options: Any) -> None:
        if locks.forked:
            _await_planner()
        with PLANNING:
            self._execute: Callable[[], None] = pyfftw.FFTW(*arrays, **options).execute

    def __call__(self) -> None:
        self._execute()

    def __del__(self) -> None:
        self._ended.append(self.__dict__.pop("_execute", None))
        if PLANNING.acquire(blocking=False):
            self._ended.clear()
            PLANNING.release()


class Pair:
    """Forward and inverse transform of one length, in float64 and planned at once, when they are first needed.

    length: n >= 1. real: buffer of n values; modes: of their half spectrum, n//2 + 1 complex numbers, which are in the
    same memory where n is large. Both hold anything at first.
    """

    def __init__(self, length: int) -> None:
        self.modes: Modes = pyfftw.empty_aligned(length // 2 + 1, dtype=np.complex128)
        in_place = length >= IN_PLACE
        self.real: Array64 = self.modes.view(float)[:length] if in_place else pyfftw.empty_aligned(length)

    @cached_property
    def forward(self) -> Callable[[], None]:
        """real -> modes; may destroy the values."""
        return Plan(self.real, self.modes, flags=["FFTW_ESTIMATE"])

    @cached_property
    def inverse(self) -> Callable[[], None]:
        """modes -> real, times n; destroys the modes."""
        flags = ["FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"]
        return Plan(self.modes, self.real, direction="FFTW_BACKWARD", flags=flags)

    def transform(self, values: Array64) -> Modes:
        """`modes` of n values."""
        self.real[:] = values
        self.forward()
        return self.modes

    def multiply(self, values: Array64, symbol: Array64) -> None:
        """Put n values into `real`, their spectrum multiplied by a symbol, shape (n//2 + 1,)."""
        self.real[:] = values
        self.filter(symbol)
        self.real /= self.real.size

    def filter(self, symbol: Array64) -> None:
        """Multiply the spectrum of `real` by a symbol, shape (n//2 + 1,), and by n."""
        self.forward()
        self.modes *= symbol
        self.inverse()

    def invert(self, modes: Modes | Array64) -> None:
        """Put into `real` the values that have this half spectrum, normalised by 1/n; modes that lack are 0."""
        np.multiply(modes, 1 / self.real.size, out=self.modes[: modes.size])
        self.modes[modes.size :] = 0
        self.inverse()

    def power(self, symbol: Array64) -> float:
        """The sum of a symbol, shape (n//2 + 1,), times |x_k|^2 over all n modes of `real`, over n; destroys `real`."""
        self.forward()
        total, n = 0.0, self.real.size
        for part in chunks(self.modes.size):
            power = self.modes[part].real ** 2 + self.modes[part].imag ** 2
            total += 2 * float(symbol[part] @ power)
        total -= float(symbol[0] * np.abs(self.modes[0]) ** 2)  # the mean mode stands once,
        if n % 2 == 0:  # and so does the Nyquist mode
            total -= float(symbol[-1] * np.abs(self.modes[-1]) ** 2)
        return total / n


class _Kept(threading.local):
    """The pairs of this thread, by length, the latest last: to make one takes longer than many short transforms."""

    def __init__(self) -> None:
        self.pairs: dict[int, Pair] = {}


_kept = _Kept()


def pair(length: int) -> Pair:
    """Both transforms of so many values with their buffers, which hold anything at first and until the thread asks for
    this length again.
    """
    found = _kept.pairs.pop(length, None) or Pair(length)
    if length <= _TOO_LONG:
        _kept.pairs[length] = found
        while len(_kept.pairs) > _MOST_PAIRS or sum(_kept.pairs) > _TOO_LONG:
            del _kept.pairs[next(iter(_kept.pairs))]
    return found


def rfft(values: Array64) -> Modes:
    """Half spectrum X_k = sum_i x_i exp(-2 pi i k i/N), k = 0 ... N//2, shape (N//2 + 1,), of N real values."""
    modes = pair(values.size).transform(values)
    return modes.copy() if values.size <= _TOO_LONG else modes


def irfft(modes: Modes | Array64, num_points: int) -> Array64:
    """The real values, shape (num_points,), that have this half spectrum: the inverse of `rfft`.

    modes: shape (M,); cut off or filled up with zeros to M = num_points//2 + 1.
    """
    transforms = pair(num_points)
    transforms.invert(modes[: num_points // 2 + 1])
    return transforms.real.copy() if num_points <= _TOO_LONG else transforms.real
