"""Transforms of plain arrays now and then, in float64, with NumPy's normalisation: 1/N on the way back.

Short ones are NumPy's own, which need no plan. What is done often on arrays of one length goes through `planned`.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

import numpy as np

from ...kernels import started
from ...locks import BUFFERS
from ..arrays import Array64, Modes
from . import four_step
from .four_step import LongPair
from .pair import Pair

_PLANNED_FROM = 2**12
"""Values from which FFTW is faster, its planning included."""

_kept = lru_cache(maxsize=10)(Pair)  # making them takes twice as long as the transform


@contextmanager
def pair(num_points: int) -> Iterator[Pair | LongPair]:
    """Both transforms of N values with their buffers, which hold anything at first.

    Where they are kept, the block takes no other transform of this module, and leaves nothing in the buffers.
    """
    if num_points < four_step.FASTER:
        with BUFFERS:
            yield _kept(num_points)
    elif started() and four_step.row_length(num_points):  # who has done without Warp is not to wait for it
        yield LongPair(num_points)
    else:
        yield Pair(num_points)


def rfft(values: Array64) -> Modes:
    """Half spectrum X_k = sum_i x_i exp(-2 pi i k i/N), k = 0 ... N//2, shape (N//2 + 1,), of N real values."""
    if values.size < _PLANNED_FROM:
        return np.fft.rfft(values)
    if values.size >= four_step.FASTER:
        return Pair(values.size).transform(values)
    with BUFFERS:
        return _kept(values.size).transform(values).copy()


def irfft(modes: Modes | Array64, num_points: int) -> Array64:
    """The real values, shape (num_points,), that have this half spectrum: the inverse of `rfft`.

    modes: shape (M,); cut off or filled up with zeros to M = num_points//2 + 1.
    """
    if num_points < _PLANNED_FROM:
        return np.fft.irfft(modes, num_points)
    with pair(num_points) as transforms:
        transforms.invert(modes[: num_points // 2 + 1])
        return transforms.real.copy() if num_points < four_step.FASTER else transforms.real


def hfft(values: Modes | Array64, num_points: int) -> Array64:
    """The real spectrum, shape (num_points,), of Hermitian values: `rfft`'s exponent, no factor.

    values: the first half of them, shape (M,); cut off or filled up with zeros to M = num_points//2 + 1.
    """
    return irfft(np.conj(values) * num_points, num_points)
