"""Real transforms planned by FFTW: over buffers that the kernels share, and short ones for convolutions.

Convention: forward sum_i x_i exp(-2 pi i k i/N), k = 0 ... N/2; the inverse is unnormalised (a factor N), so the
coefficients multiplied in between carry 1/N.
"""

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from ...kernels import padded_length
from .. import checks
from ..arrays import Array, Array64, Modes
from . import wisdom
from .fftw import pyfftw

PLANNING = ("estimate", "measure", "patient")
"""Planning effort. 'estimate' plans at once, and takes what wisdom holds of an earlier, greater effort."""

_STAGGER = 1024  # bytes: buffers that start at equal page offsets slow each other down


class Transforms:
    """Plans between real buffers of `num_points` values and one shared half spectrum.

    num_points: N; precision: 'float64' or 'float32'; threads: of FFTW, >= 1; planning: one of `PLANNING`.
    spectrum: flat real view of the half spectrum (re, im, ...), 2 (N//2 + 1) values and zeros up to a padded length.
    known, planned: plans so far that FFTW's wisdom held, from measuring at some time, and those that were made anew.

    Raises `ValueError`.
    """

    def __init__(self, num_points: int, precision: str, threads: int = 1, planning: str = "estimate") -> None:
        self.threads, self.planning = check_settings(threads, planning)
        self.num_points = num_points
        self.real = np.dtype(precision)
        self.known = self.planned = self._count = 0
        length = 2 * (num_points // 2 + 1)
        self.spectrum = self.buffer(length)
        self._modes = self.spectrum[:length].view(np.result_type(self.real, np.complex64))
        wisdom.load()

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
        """The plan that wisdom holds, or else a new one, which is kept at once if finding it took effort."""

        def plan(effort: str, *more: str) -> Callable[[], None]:
            flags = [f"FFTW_{effort.upper()}", *more]
            if direction == "FFTW_BACKWARD":
                flags.append("FFTW_DESTROY_INPUT")
            made = pyfftw.FFTW(source, target, direction=direction, threads=self.threads, flags=flags)
            execute: Callable[[], None] = made.execute
            return execute

        estimated = self.planning == "estimate"
        with suppress(RuntimeError):  # wisdom does not hold it
            known = plan("measure" if estimated else self.planning, "FFTW_WISDOM_ONLY")
            self.known += 1
            return known
        self.planned += 1
        if estimated:
            return plan("estimate")
        try:
            return plan(self.planning)
        finally:
            wisdom.save()  # after Ctrl-C, too, which waits until FFTW has finished


class Pair:
    """Forward and inverse transform of one short length, in float64 and planned at once.

    length: n >= 1. real: buffer of n values; modes: of their half spectrum, n//2 + 1 complex numbers.
    """

    def __init__(self, length: int) -> None:
        self.real: Array64 = pyfftw.zeros_aligned(length)
        self.modes: Modes = pyfftw.zeros_aligned(length // 2 + 1, dtype=np.complex128)
        forward = pyfftw.FFTW(self.real, self.modes, flags=["FFTW_ESTIMATE"])
        inverse = pyfftw.FFTW(self.modes, self.real, direction="FFTW_BACKWARD", flags=["FFTW_ESTIMATE"])
        self.forward: Callable[[], None] = forward.execute
        """real -> modes."""
        self.inverse: Callable[[], None] = inverse.execute
        """modes -> real, times n; leaves the modes."""


def fast_length(length: int) -> int:
    """The least length from this one on that FFTW transforms quickly: factors up to 7, and 11 or 13 once."""
    return int(pyfftw.next_fast_len(length))


def library() -> str:
    """The library that plans, with its version."""
    return str(pyfftw.fftw_version)


def check_settings(threads: int, planning: str) -> tuple[int, str]:
    """Both, if they are allowed. Raises `ValueError`."""
    allowed = checks.integer("threads", threads, "an integer from 1 to 1024", 1, 1024)
    return allowed, checks.choice("planning", planning, PLANNING)
