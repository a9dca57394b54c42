"""Real transforms planned by FFTW: over buffers that the kernels share, and short ones for convolutions.

Convention: forward sum_i x_i exp(-2 pi i k i/N), k = 0 ... N/2; the inverse is unnormalised (a factor N), so what
multiplies in between carries 1/N.

Where that is faster, the N real values are taken as N/2 = M complex numbers x_(2j) + i x_(2j+1), whose transform Z is
made in place. A real symbol g multiplies the real transform (k -> M - k is conjugation there) if

    Z_k <- (s - d sin phi) Z_k + i d cos phi conj(Z_(M-k)),   s, d = (g_k +- g_(M-k))/2, phi = 2 pi k/N,

and the inverse, in place, has a factor of M only. FFTW finds better plans for such transforms than for long real ones.
But modes k and M - k then share their rounding: what is small of one because its g is has the error of the other.
"""

from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache

import numpy as np

from ...kernels import CHUNK, Call, padded_length
from .. import checks
from ..arrays import Array, Array64, Modes
from . import wisdom
from .fftw import pyfftw
from .place import OnCpu, Place

PLANNING = ("estimate", "measure", "patient")
"""Planning effort. 'estimate' plans at once, and takes what wisdom holds of an earlier, greater effort."""

_STAGGER = 1024  # bytes: buffers that start at equal page offsets slow each other down
_HALF_LENGTH = 2**17, 2**19
"""Values, in float64, from which and up to which half the length takes 0.5 to 0.9 of the time, if FFTW estimates."""

_TABLES = 2**20 + 1, 2**22
"""Values of a real transform whose tables are kept: making them takes about as long as the transform. They hold up to
16 bytes for each value; those of shorter ones are kept with the plans of `plain`."""


_IN_PLACE = 2**22
"""Values beyond which a field that is transformed there and back shares the memory of its spectrum."""


class Transforms(OnCpu, Place):
    """Plans between real buffers of `num_points` values and one shared spectrum.

    num_points: N; precision: 'float64' or 'float32'; threads: of FFTW, >= 1; planning: one of `PLANNING`; half_length:
    whether transforms are complex ones of N/2 numbers, for a multiple of `CHUNK` points; by default where that is
    faster, which it is not if wisdom holds a plan that was measured.
    spectrum: flat real view (re, im, ...), 2 (N//2 + 1) values and zeros up to a padded length: the half spectrum, or
    the N/2 modes of the half length and the first one again.
    known, planned: plans so far that FFTW's wisdom held, from measuring at some time, and those that were made anew.

    Raises `ValueError`.
    """

    def __init__(
        self,
        num_points: int,
        precision: str,
        threads: int = 1,
        planning: str = "estimate",
        half_length: bool | None = None,
    ) -> None:
        self.threads, self.planning = check_settings(threads, planning)
        self.num_points = num_points
        self.real = np.dtype(precision)
        self.known = self.planned = self._count = 0
        wisdom.load()
        self.half_length = num_points % CHUNK == 0 and (self._slow() if half_length is None else half_length)
        self.spectrum = self.buffer(2 * (num_points // 2 + 1))

    def _slow(self) -> bool:
        """Whether FFTW has nothing but a poor plan for real transforms of this length."""
        least, most = _HALF_LENGTH
        n, one = self.num_points, self.threads == 1 and self.planning == "estimate"
        if not (one and self.real == np.float64 and least <= n <= most):
            return False
        real, modes = pyfftw.empty_aligned(n), pyfftw.empty_aligned(n // 2 + 1, dtype=np.complex128)
        try:
            pyfftw.FFTW(real, modes, flags=["FFTW_MEASURE", "FFTW_WISDOM_ONLY"])
        except RuntimeError:
            return True
        return False

    def buffer(self, length: int | None = None) -> Array:
        """A padded, aligned, staggered array for `length` (default N) values: zeros."""
        length = self.num_points if length is None else length
        padded = padded_length(length)
        offset = self._count * _STAGGER // self.real.itemsize
        self._count += 1
        array: Array = pyfftw.zeros_aligned(padded + offset, dtype=self.real, n=64)[offset:]
        return array

    def field(self) -> Array:
        """A buffer for N values that are transformed there and back; long ones share the spectrum's memory."""
        if self.half_length or self.num_points <= _IN_PLACE:
            return self.buffer()
        return self.spectrum[: padded_length(self.num_points)]

    def multiply(self, symbol: Array64, target: Array) -> Call:
        """The kernel between `forward` and `inverse` to this target that multiplies by a symbol, shape (N//2 + 1,),
        and by what normalises the inverse.
        """
        if not self.half_length:
            return Call("spectral_multiply", (self._doubled(symbol / self.num_points),), (self.spectrum,))
        half = self.num_points // 2
        sine = np.sin(np.pi / half * np.arange(half // 2 + 1))  # of mode k, and of N/2 - k
        here, mirrored = symbol[: half // 2 + 1] / half, symbol[: half // 2 - 1 : -1] / half
        mean, difference = (here + mirrored) / 2, (here - mirrored) / 2
        crossed, difference = difference * sine[::-1], difference * sine
        straight = self._doubled(np.concatenate([mean - difference, (mean + difference)[-2:0:-1]]))
        crossed = self._doubled(np.concatenate([crossed, crossed[-2:0:-1]]))
        return Call("paired_multiply", (straight, crossed, self.spectrum), (target,))

    def _doubled(self, values: Array64) -> Array:
        """A buffer with every value twice, for both parts of a mode."""
        found = self.buffer(2 * values.size)
        for part in range(2):
            found[part : 2 * values.size : 2] = values
        return found

    def forward(self, source: Array) -> Callable[[], None]:
        """Plan source[:N] -> spectrum; the plan keeps `source`. Plan before filling it."""
        n = self.num_points
        if not self.half_length:
            if n > _TABLES[1]:
                _keep_tables.cache_clear()  # the memory is needed
            elif n >= _TABLES[0] and self.real == np.float64:
                _keep_tables(n)
            return self._plan(source[:n], self._complex(self.spectrum[: 2 * (n // 2 + 1)]), "FFTW_FORWARD")
        packed, first, again = self.spectrum[:n], self.spectrum[:2], self.spectrum[n : n + 2]
        execute = self._plan(self._complex(packed), self._complex(packed), "FFTW_FORWARD")

        def run() -> None:
            packed[:] = source[:n]
            execute()
            again[:] = first

        return run

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan spectrum -> target[:N], times N, which destroys the spectrum; of half the length, what `multiply` has
        put into the target there, times N/2.
        """
        n = self.num_points
        if not self.half_length:
            return self._plan(self._complex(self.spectrum[: 2 * (n // 2 + 1)]), target[:n], "FFTW_BACKWARD")
        return self._plan(self._complex(target[:n]), self._complex(target[:n]), "FFTW_BACKWARD")

    def _complex(self, values: Array) -> Array:
        found: Array = values.view(np.result_type(self.real, np.complex64))
        return found

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
    """Forward and inverse transform of one length, in float64 and planned at once.

    length: n >= 1. real: buffer of n values; modes: of their half spectrum, n//2 + 1 complex numbers. Both hold
    anything at first.
    """

    def __init__(self, length: int) -> None:
        self.real: Array64 = pyfftw.empty_aligned(length)
        self.modes: Modes = pyfftw.empty_aligned(length // 2 + 1, dtype=np.complex128)
        forward = pyfftw.FFTW(self.real, self.modes, flags=["FFTW_ESTIMATE"])
        flags = ["FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"]
        inverse = pyfftw.FFTW(self.modes, self.real, direction="FFTW_BACKWARD", flags=flags)
        self.forward: Callable[[], None] = forward.execute
        """real -> modes."""
        self.inverse: Callable[[], None] = inverse.execute
        """modes -> real, times n; destroys the modes."""


@lru_cache(maxsize=1)
def _keep_tables(length: int) -> Pair:
    """Plans that keep FFTW's tables of that length, which all plans that are alive share. Their buffers are never
    touched and take no memory, but count against a limit of it.
    """
    return Pair(length)


def library() -> str:
    """The library that plans, with its version."""
    return str(pyfftw.fftw_version)


def check_settings(threads: int, planning: str) -> tuple[int, str]:
    """Both, if they are allowed. Raises `ValueError`."""
    allowed = checks.integer("threads", threads, "an integer from 1 to 1024", 1, 1024)
    return allowed, checks.choice("planning", planning, PLANNING)
