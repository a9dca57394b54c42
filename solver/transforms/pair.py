"""Short transforms there and back, with buffers of their own."""

from collections.abc import Callable

import numpy as np

from ..arrays import Array64, Modes
from .fftw import pyfftw


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
