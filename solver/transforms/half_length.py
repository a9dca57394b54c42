"""Real transforms as complex ones of half the length, in place.

N real values are taken as N/2 = M complex numbers x_(2j) + i x_(2j+1), whose transform is Z. A real symbol g multiplies
the real transform (k -> M - k is conjugation there) if

    Z_k <- (s - d sin phi) Z_k + i d cos phi conj(Z_(M-k)),   s, d = (g_k +- g_(M-k))/2, phi = 2 pi k/N,

and the inverse has a factor of M only. FFTW finds better plans for such transforms than for long real ones. But modes k
and M - k then share their rounding: what is small of one because its g is has the error of the other.
"""

from collections.abc import Callable

import numpy as np

from ...kernels import Call
from ..arrays import Array, Array64
from .planner import Transforms


class HalfLength(Transforms):
    """Complex transforms of N/2 numbers, N a multiple of `CHUNK`. spectrum: flat real view of the modes and the first
    one again.
    """

    way = "half-length"

    def prepare(self) -> None:
        self.spectrum = self.buffer(self.num_points + 2)

    def multiplication(self, symbol: Array64, target: Array) -> Callable[[], None]:
        half = self.num_points // 2
        sine = np.sin(np.pi / half * np.arange(half // 2 + 1))  # of mode k, and of N/2 - k
        here, mirrored = symbol[: half // 2 + 1] / half, symbol[: half // 2 - 1 : -1] / half
        mean, difference = (here + mirrored) / 2, (here - mirrored) / 2
        crossed, difference = difference * sine[::-1], difference * sine
        straight = self.doubled(np.concatenate([mean - difference, (mean + difference)[-2:0:-1]]))
        crossed = self.doubled(np.concatenate([crossed, crossed[-2:0:-1]]))
        return self.record([Call("paired_multiply", (straight, crossed, self.spectrum), (target,))])

    def forward(self, source: Array) -> Callable[[], None]:
        n = self.num_points
        packed, first, again = self.spectrum[:n], self.spectrum[:2], self.spectrum[n : n + 2]
        modes = self.complex(packed)
        execute = self.plan(modes, modes, "FFTW_FORWARD")

        def run() -> None:
            packed[:] = source[:n]
            execute()
            again[:] = first

        return run

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan what the multiplication has put into the target, times N/2."""
        modes = self.complex(target[: self.num_points])
        return self.plan(modes, modes, "FFTW_BACKWARD")
