"""Real transforms planned once and done often, over buffers that the kernels share, in the way that is fastest.

Convention: forward sum_i x_i exp(-2 pi i k i/N), k = 0 ... N/2; the inverse is unnormalised (a factor N), so the
factors in between carry 1/N.
"""

from collections.abc import Callable

from ...kernels import CHUNK
from ..arrays import Array
from .four_step import FASTER, FASTER_THAN_REAL, FourStep, row_length
from .half_length import HalfLength
from .planner import Transforms, check_settings, has_poor_plan


class Real(Transforms):
    """FFTW's own real transforms. spectrum: flat real view of the half spectrum, N + 2 values or N + 1, and zeros."""

    way = "real"

    def prepare(self) -> None:
        count = 2 * (self.num_points // 2 + 1)
        self.spectrum = self.buffer(count)
        self._modes = self.complex(self.spectrum[:count])

    def forward(self, source: Array) -> Callable[[], None]:
        return self.plan(source[: self.num_points], self._modes, "FFTW_FORWARD")

    def inverse(self, target: Array) -> Callable[[], None]:
        return self.plan(self._modes, target[: self.num_points], "FFTW_BACKWARD")


WAYS: dict[str, type[Transforms]] = {kind.way: kind for kind in (Real, HalfLength, FourStep)}
"""By name: FFTW's real transforms, complex ones of half the length, and long ones on parts that fit into the cache."""


def plan_transforms(
    num_points: int,
    precision: str,
    threads: int = 1,
    planning: str = "estimate",
    backend: str = "warp",
    way: str | None = None,
    apart: bool = False,
) -> Transforms:
    """Transforms of N values, see `Transforms`.

    way: one of `WAYS`, by default the fastest. apart: the rounding of no mode may spoil another one, which leaves
    out 'half-length'. Raises `ValueError`.
    """
    threads, planning = check_settings(threads, planning)
    if way is None:
        way = _fastest(num_points, precision, threads, apart) if planning == "estimate" else "real"
    return WAYS[way](num_points, precision, threads, planning, backend)


def _fastest(num_points: int, precision: str, threads: int, apart: bool) -> str:
    """The way that takes least time, as far as that is known, if FFTW estimates."""
    least = FASTER_THAN_REAL if precision == "float64" else FASTER
    if num_points < least or not has_poor_plan(num_points, precision, threads):
        return "real"
    if (apart or num_points >= FASTER) and row_length(num_points):
        return "four-step"
    packed = threads == 1 and num_points < FASTER and num_points % CHUNK == 0 and not apart
    return "half-length" if packed else "real"
