"""Transforms of plain arrays now and then, in float64, with NumPy's normalisation: 1/N on the way back.

Short ones are NumPy's own, which need no plan. What is done often on arrays of one length goes through `planned`.
"""

from contextlib import AbstractContextManager, nullcontext
from functools import lru_cache
from typing import Any

import numpy as np

from ...kernels import started
from ...locks import BUFFERS
from ..arrays import Array64, Modes
from . import four_step
from .fftw import Plan, pyfftw
from .four_step import LongPair
from .pair import Pair

_PLANNED_FROM = 2**12
"""Values from which FFTW is faster, its planning included."""
_KEPT_UP_TO = 2**20
"""Values up to which plans and buffers are kept, because making them takes twice as long as the transform. They hold
up to 16 bytes for each value."""


_FEW = 128  # values for each mode, from which a spectrum of few modes takes less time by short transforms
_AT_ONCE = 16  # short transforms

_kept = lru_cache(maxsize=10)(Pair)
_kept_long = lru_cache(maxsize=1)(LongPair)


def guard(num_points: int) -> AbstractContextManager[Any]:
    """For the `with` block in which a `pair` of N values is used; it takes no other transform of this module."""
    return BUFFERS if num_points <= _KEPT_UP_TO else nullcontext()


def _in_four_steps(num_points: int) -> bool:
    """Whether that is faster; who has done without Warp until now is not to wait for it."""
    return num_points >= four_step.FASTER and four_step.row_length(num_points) > 0 and started()


def pair(num_points: int) -> Pair | LongPair:
    """Both transforms of N values with their buffers, which hold anything at first. To be used under their `guard`."""
    kept = num_points <= _KEPT_UP_TO
    if _in_four_steps(num_points):
        return (_kept_long if kept else LongPair)(num_points)
    return (_kept if kept else Pair)(num_points)


def rfft(values: Array64) -> Modes:
    """Half spectrum X_k = sum_i x_i exp(-2 pi i k i/N), k = 0 ... N//2, shape (N//2 + 1,), of N real values."""
    if values.size < _PLANNED_FROM:
        return np.fft.rfft(values)
    if values.size <= _KEPT_UP_TO:
        with BUFFERS:
            kept = _kept(values.size)
            kept.real[:] = values
            kept.forward()
            return kept.modes.copy()
    source = np.require(values, np.float64, ["C", "W"])
    modes: Modes = pyfftw.empty_aligned(values.size // 2 + 1, dtype=np.complex128)
    Plan(source, modes, flags=["FFTW_ESTIMATE"])()
    return modes


def irfft(modes: Modes | Array64, num_points: int) -> Array64:
    """The real values, shape (num_points,), that have this half spectrum: the inverse of `rfft`.

    modes: shape (M,); cut off or filled up with zeros to M = num_points//2 + 1.
    """
    if num_points < _PLANNED_FROM:
        return np.fft.irfft(modes, num_points)
    held = modes[: num_points // 2 + 1]
    if num_points >= _FEW * held.size and num_points % (32 * _AT_ONCE) == 0:
        return _from_few(held, num_points)
    if num_points <= _KEPT_UP_TO:
        with BUFFERS:
            kept = _kept(num_points)
            np.multiply(held, 1 / num_points, out=kept.modes[: held.size])
            kept.modes[held.size :] = 0
            kept.inverse()
            return kept.real.copy()
    if held.size == num_points // 2 + 1 and _in_four_steps(num_points):
        return LongPair(num_points).invert(held)
    source = pyfftw.zeros_aligned(num_points // 2 + 1, dtype=np.complex128)
    np.multiply(held, 1 / num_points, out=source[: held.size])
    values: Array64 = source.view(np.float64)[:num_points]  # in place
    flags = ["FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"]
    Plan(source, values, direction="FFTW_BACKWARD", flags=flags)()
    return values


def _from_few(modes: Modes | Array64, num_points: int) -> Array64:
    """`irfft` of so few modes M that N/P >= 32 short transforms of P >= 2 M values give it:

    x_(r + R m) = sum_k (X_k exp(2 pi i k r/N)) exp(2 pi i k m/P)/N, R = N/P.
    """
    count, length = modes.size, num_points
    while length % 2 == 0 and length // 2 >= 2 * count:
        length //= 2
    angle = 2j * np.pi / num_points * np.arange(count)
    turned = np.exp(np.arange(_AT_ONCE)[:, None] * angle) * (modes / num_points)
    spectra: Modes = pyfftw.zeros_aligned((_AT_ONCE, length // 2 + 1), dtype=np.complex128)
    short: Array64 = pyfftw.empty_aligned((_AT_ONCE, length))
    flags = ["FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"]
    transform = Plan(spectra, short, axes=(1,), direction="FFTW_BACKWARD", flags=flags)
    values = np.empty((length, num_points // length))
    for start in range(0, values.shape[1], _AT_ONCE):
        np.multiply(turned, np.exp(start * angle), out=spectra[:, :count])
        spectra[:, count:] = 0
        transform()
        values[:, start : start + _AT_ONCE] = short.T
    return values.ravel()


def hfft(values: Modes | Array64, num_points: int) -> Array64:
    """The real spectrum, shape (num_points,), of Hermitian values: `rfft`'s exponent, no factor.

    values: the first half of them, shape (M,); cut off or filled up with zeros to M = num_points//2 + 1.
    """
    return irfft(np.conj(values) * num_points, num_points)
