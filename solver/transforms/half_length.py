"""Real transforms as complex ones of half the length, in place.

N real values are taken as N/2 = M complex numbers x_(2j) + i x_(2j+1), whose transform is Z. A real symbol g multiplies
the real transform (k -> M - k is conjugation there) if

    Z_k <- (s - d sin phi) Z_k + i d cos phi conj(Z_(M-k)),   s, d = (g_k +- g_(M-k))/2, phi = 2 pi k/N,

and the inverse has a factor of M only. FFTW finds better plans for such transforms than for long real ones. But modes k
and M - k then share their rounding: what is small of one because its g is has the error of the other.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from ...kernels import CHUNK, Call
from ..arrays import Array, Array64
from .fftw import Plan, pyfftw
from .planner import Planner

_FASTER = 2**17, 2**19
"""Values, in float64, from which and up to which it takes 0.5 to 0.9 of the time, if FFTW estimates."""


def is_faster(num_points: int, planner: Planner) -> bool:
    """Whether it takes less time than real transforms."""
    least, most = _FASTER
    allowed = planner.real == np.float64 and num_points % CHUNK == 0 and least <= num_points <= most
    return planner.threads == 1 and allowed and planner.has_poor_plan(num_points)


class HalfLength:
    """Complex transforms of N/2 numbers, N a multiple of `CHUNK`. spectrum: flat real view of the modes and the first
    one again.
    """

    def __init__(self, num_points: int, planner: Planner) -> None:
        self.num_points, self.planner = num_points, planner
        self.spectrum = planner.buffer(num_points + 2)

    def field(self) -> Array:
        """A buffer for N values that are transformed there and back."""
        return self.planner.buffer(self.num_points)

    def multiplication(self, symbol: Array64, target: Array) -> Callable[[], None]:
        """See `planned.Transforms.multiplication`."""
        half = self.num_points // 2
        sine = np.sin(np.pi / half * np.arange(half // 2 + 1))  # of mode k, and of N/2 - k
        here, mirrored = symbol[: half // 2 + 1] / half, symbol[: half // 2 - 1 : -1] / half
        mean, difference = (here + mirrored) / 2, (here - mirrored) / 2
        crossed, difference = difference * sine[::-1], difference * sine
        straight = self.planner.doubled(np.concatenate([mean - difference, (mean + difference)[-2:0:-1]]))
        crossed = self.planner.doubled(np.concatenate([crossed, crossed[-2:0:-1]]))
        return self.planner.record([Call("paired_multiply", (straight, crossed, self.spectrum), (target,))])

    def forward(self, source: Array) -> Callable[[], None]:
        """Plan source[:N] -> spectrum."""
        n = self.num_points
        packed, first, again = self.spectrum[:n], self.spectrum[:2], self.spectrum[n : n + 2]
        modes = self.planner.complex(packed)
        execute = self.planner.plan(modes, modes, "FFTW_FORWARD")
        if self.planner.real == np.float64:
            _keep_tables(n)

        def run() -> None:
            packed[:] = source[:n]
            execute()
            again[:] = first

        return run

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan what the multiplication has put into the target, times N/2."""
        modes = self.planner.complex(target[: self.num_points])
        return self.planner.plan(modes, modes, "FFTW_BACKWARD")


@lru_cache(maxsize=1)
def _keep_tables(num_points: int) -> object:
    """A plan that keeps FFTW's tables of that length, whose making takes as long as the transform; see `real`."""
    values = pyfftw.empty_aligned(num_points // 2, dtype=np.complex128)
    return Plan(values, values, flags=["FFTW_ESTIMATE"])
