"""Real transforms planned once and done often, over buffers that the kernels share, in the way that is fastest.

Convention: forward sum_i x_i exp(-2 pi i k i/N), k = 0 ... N/2; the inverse is unnormalised (a factor N), so the
factors in between carry 1/N.
"""

from collections.abc import Callable

import numpy as np

from ...kernels import CHUNK
from ..arrays import Array
from .backend import Transforms
from .four_step import FASTER, FourStep, row_length
from .plain import IN_PLACE


class Real(Transforms):
    """FFTW's own real transforms, long ones in place. spectrum: flat real view of the half spectrum, N + 2 values or
    N + 1, and zeros.
    """

    way = "real"

    def prepare(self) -> None:
        count = 2 * (self.num_points // 2 + 1)
        self.spectrum = self.buffer(count)
        self._modes = self.complex(self.spectrum[:count])
        self._in_place = self.dtype == np.float64 and self.num_points >= IN_PLACE and self.num_points % CHUNK == 0
        """Takes less time, and there is no padding."""

    def field(self) -> Array:
        return self.spectrum[: self.num_points] if self._in_place else self.buffer()

    def _at(self, array: Array) -> Array:
        """Where the values of an array are transformed."""
        return (self.spectrum if self._in_place else array)[: self.num_points]

    def forward(self, source: Array) -> Callable[[], None]:
        values = self._at(source)
        execute = self.plan(values, self._modes, "FFTW_FORWARD")
        if np.shares_memory(source, values):
            return execute

        def run() -> None:
            values[:] = source[: values.size]
            execute()

        return run

    def inverse(self, target: Array) -> Callable[[], None]:
        values = self._at(target)
        execute = self.plan(self._modes, values, "FFTW_BACKWARD")
        if np.shares_memory(target, values):
            return execute

        def run() -> None:
            execute()
            target[: values.size] = values

        return run


WAYS: dict[str, type[Transforms]] = {kind.way: kind for kind in (Real, FourStep)}
"""By name: FFTW's real transforms, and long ones on parts that fit into the cache."""


def plan_transforms(
    num_points: int,
    precision: str,
    threads: int = 1,
    planning: str = "estimate",
    backend: str = "warp",
    way: str | None = None,
) -> Transforms:
    """Transforms of N values, see `Transforms`.

    threads, planning: the caller has checked them. way: one of `WAYS`, by default the fastest. Raises `ValueError`.
    """
    if way is None:
        way = "four-step" if num_points >= FASTER and row_length(num_points) else "real"
    return WAYS[way](num_points, precision, threads, planning, backend)
