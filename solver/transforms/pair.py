"""Transforms there and back with buffers of their own."""

from collections.abc import Callable

import numpy as np

from ..arrays import Array64, Modes, parts
from .fftw import Plan, pyfftw


class Pair:
    """Forward and inverse transform of one length, in float64 and planned at once.

    length: n >= 1. real: buffer of n values; modes: of their half spectrum, n//2 + 1 complex numbers. Both hold
    anything at first.
    """

    def __init__(self, length: int) -> None:
        self.real: Array64 = pyfftw.empty_aligned(length)
        self.modes: Modes = pyfftw.empty_aligned(length // 2 + 1, dtype=np.complex128)
        self.forward: Callable[[], None] = Plan(self.real, self.modes, flags=["FFTW_ESTIMATE"])
        """real -> modes."""
        flags = ["FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"]
        self.inverse: Callable[[], None] = Plan(self.modes, self.real, direction="FFTW_BACKWARD", flags=flags)
        """modes -> real, times n; destroys the modes."""

    def multiply(self, values: Array64, symbol: Array64) -> None:
        """Put into `real` what n values are after their spectrum was multiplied by a symbol, shape (n//2 + 1,)."""
        self.real[:] = values
        self.forward()
        self.modes *= symbol
        self.inverse()
        self.real /= self.real.size

    def power(self, symbol: Array64) -> float:
        """The sum of a symbol, shape (n//2 + 1,), times |x_k|^2 over all n modes of `real`, over n; destroys `real`."""
        self.forward()
        total, n = 0.0, self.real.size
        for part in parts(self.modes.size):
            power = self.modes[part].real ** 2 + self.modes[part].imag ** 2
            total += 2 * float(symbol[part] @ power)
        total -= float(symbol[0] * np.abs(self.modes[0]) ** 2)  # the mean mode stands once,
        if n % 2 == 0:  # and so does the Nyquist mode
            total -= float(symbol[-1] * np.abs(self.modes[-1]) ** 2)
        return total / n
