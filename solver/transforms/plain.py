"""Transforms of plain arrays now and then, in float64, with NumPy's normalisation: 1/N on the way back.

Short ones are NumPy's own, which need no plan. What is done often on arrays of one length goes through `planned`.
"""

import threading
from functools import lru_cache

import numpy as np

from ..arrays import Array64, Modes
from .fftw import pyfftw
from .planned import Pair

_PLANNED_FROM = 2**12
"""Values from which FFTW is faster, its planning included."""
_KEPT_UP_TO = 2**20
"""Values up to which plans and buffers are kept, because making them takes twice as long as the transform. They hold 16
bytes for each value."""


_kept = lru_cache(maxsize=10)(Pair)
_busy = threading.Lock()  # of the buffers that are kept


def rfft(values: Array64) -> Modes:
    """Half spectrum X_k = sum_i x_i exp(-2 pi i k i/N), k = 0 ... N//2, shape (N//2 + 1,), of N real values."""
    if values.size < _PLANNED_FROM:
        return np.fft.rfft(values)
    if values.size <= _KEPT_UP_TO:
        with _busy:
            pair = _kept(values.size)
            pair.real[:] = values
            pair.forward()
            return pair.modes.copy()
    source = np.require(values, np.float64, ["C", "W"])
    modes: Modes = pyfftw.empty_aligned(values.size // 2 + 1, dtype=np.complex128)
    pyfftw.FFTW(source, modes, flags=["FFTW_ESTIMATE"]).execute()
    return modes


def irfft(modes: Modes | Array64, num_points: int, overwrite: bool = False) -> Array64:
    """The real values, shape (num_points,), that have this half spectrum: the inverse of `rfft`.

    modes: shape (M,); cut off or filled up with zeros to M = num_points//2 + 1. overwrite: what `rfft` gave may be
    destroyed, which saves memory.
    """
    if num_points < _PLANNED_FROM:
        return np.fft.irfft(modes, num_points)
    held = source = modes[: num_points // 2 + 1]
    if num_points <= _KEPT_UP_TO:
        with _busy:
            pair = _kept(num_points)
            np.multiply(held, 1 / num_points, out=pair.modes[: held.size])
            pair.modes[held.size :] = 0
            pair.inverse()
            return pair.real.copy()
    if not overwrite:
        source = pyfftw.zeros_aligned(num_points // 2 + 1, dtype=np.complex128)
    np.multiply(held, 1 / num_points, out=source[: held.size])
    values: Array64 = pyfftw.empty_aligned(num_points)
    flags = ["FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"]
    pyfftw.FFTW(source, values, direction="FFTW_BACKWARD", flags=flags).execute()
    return values


def hfft(values: Modes | Array64, num_points: int) -> Array64:
    """The real spectrum, shape (num_points,), of Hermitian values: `rfft`'s exponent, no factor.

    values: the first half of them, shape (M,); cut off or filled up with zeros to M = num_points//2 + 1.
    """
    return irfft(np.conj(values) * num_points, num_points)
