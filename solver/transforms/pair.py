"""Transforms there and back with buffers of their own."""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ..arrays import Array64, Modes, parts
from .fftw import Plan, pyfftw


class Pair:
    """Forward and inverse transform of one length, in float64 and planned at once, when they are first needed.

    length: n >= 1. real: buffer of n values; modes: of their half spectrum, n//2 + 1 complex numbers. Both hold
    anything at first.
    """

    def __init__(self, length: int) -> None:
        self.real: Array64 = pyfftw.empty_aligned(length)
        self.modes: Modes = pyfftw.empty_aligned(length // 2 + 1, dtype=np.complex128)

    @cached_property
    def forward(self) -> Callable[[], None]:
        """real -> modes."""
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
        """Put into `real` what n values are after their spectrum was multiplied by a symbol, shape (n//2 + 1,)."""
        self.transform(values)
        self.modes *= symbol
        self.inverse()
        self.real /= self.real.size

    def invert(self, modes: Modes | Array64) -> None:
        """Put into `real` the values that have this half spectrum, normalised by 1/n; modes that lack are 0."""
        np.multiply(modes, 1 / self.real.size, out=self.modes[: modes.size])
        self.modes[modes.size :] = 0
        self.inverse()

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
