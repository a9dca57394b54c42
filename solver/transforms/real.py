"""FFTW's own real transforms."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from ...kernels import Call, padded_length
from ..arrays import Array, Array64
from .pair import Pair
from .planner import Planner

_TABLES = 2**20 + 1, 2**22
"""Values of a real transform whose tables are kept: making them takes about as long as the transform. They hold up to
16 bytes for each value; those of shorter ones are kept with the plans of `plain`."""

_IN_PLACE = 2**22
"""Values beyond which a field that is transformed there and back shares the memory of its spectrum."""


class Real:
    """Real transforms of N values. spectrum: flat real view of the half spectrum, N + 2 values or N + 1, and zeros."""

    def __init__(self, num_points: int, planner: Planner) -> None:
        self.num_points, self.planner = num_points, planner
        self.spectrum = planner.buffer(2 * (num_points // 2 + 1))

    def field(self) -> Array:
        """A buffer for N values that are transformed there and back; long ones share the spectrum's memory."""
        if self.num_points <= _IN_PLACE:
            return self.planner.buffer(self.num_points)
        return self.spectrum[: padded_length(self.num_points)]

    def multiplication(self, symbol: Array64, target: Array) -> Callable[[], None]:
        """See `planned.Transforms.multiplication`."""
        call = Call("spectral_multiply", (self.planner.doubled(symbol / self.num_points),), (self.spectrum,))
        return self.planner.record([call])

    def forward(self, source: Array) -> Callable[[], None]:
        """Plan source[:N] -> spectrum."""
        n = self.num_points
        if n > _TABLES[1]:
            _keep_tables.cache_clear()  # the memory is needed
        elif n >= _TABLES[0] and self.planner.real == np.float64:
            _keep_tables(n)
        return self.planner.plan(source[:n], self._modes, "FFTW_FORWARD")

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan spectrum -> target[:N], times N, which destroys the spectrum."""
        return self.planner.plan(self._modes, target[: self.num_points], "FFTW_BACKWARD")

    @property
    def _modes(self) -> Array:
        return self.planner.complex(self.spectrum[: 2 * (self.num_points // 2 + 1)])


@lru_cache(maxsize=1)
def _keep_tables(length: int) -> Pair:
    """Plans that keep FFTW's tables of that length, which all plans that are alive share. Their buffers are never
    touched and take no memory, but count against a limit of it.
    """
    return Pair(length)
