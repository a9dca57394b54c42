"""Transforms of plain arrays now and then, in float64, by `numpy.fft` and with its normalisation: 1/N on the way back.

What is done often on arrays of one length goes through `planned`.
"""

import numpy as np

from ..arrays import Array64, Modes


def rfft(values: Array64) -> Modes:
    """Half spectrum X_k = sum_i x_i exp(-2 pi i k i/N), k = 0 ... N//2, shape (N//2 + 1,), of N real values."""
    return np.fft.rfft(values)


def irfft(modes: Modes | Array64, num_points: int) -> Array64:
    """The real values, shape (num_points,), that have this half spectrum: the inverse of `rfft`.

    modes: shape (M,); cut off or filled up with zeros to M = num_points//2 + 1.
    """
    return np.fft.irfft(modes, num_points)


def hfft(values: Modes | Array64, num_points: int) -> Array64:
    """The real spectrum, shape (num_points,), of Hermitian values: `rfft`'s exponent, no factor.

    values: the first half of them, shape (M,); cut off or filled up with zeros to M = num_points//2 + 1.
    """
    return np.fft.hfft(values, num_points)
