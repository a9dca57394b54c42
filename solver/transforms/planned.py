"""Real transforms planned once and done often, over buffers that the kernels share.

Convention: forward sum_i x_i exp(-2 pi i k i/N), k = 0 ... N/2; the inverse is unnormalised (a factor N), so what
multiplies in between carries 1/N. There are several ways to do them, of which the fastest for a length is taken.
"""

import copy
from collections.abc import Callable
from typing import Protocol

from ..arrays import Array, Array64
from . import four_step, half_length
from .four_step import FourStep
from .half_length import HalfLength
from .place import OnCpu, Place
from .planner import Planner, check_settings
from .real import Real


class Way(Protocol):
    """A way to transform N real values there and back."""

    spectrum: Array
    planner: Planner

    def __init__(self, num_points: int, planner: Planner) -> None: ...

    def field(self) -> Array: ...

    def multiplication(self, symbol: Array64, target: Array) -> Callable[[], None]: ...

    def forward(self, source: Array) -> Callable[[], None]: ...

    def inverse(self, target: Array) -> Callable[[], None]: ...


WAYS: dict[str, type[Way]] = {"real": Real, "half-length": HalfLength, "four-step": FourStep}
"""By name: FFTW's real transforms, complex ones of half the length, and long ones on parts that fit into the cache."""


class Transforms(OnCpu, Place):
    """Plans between real buffers of `num_points` values and one shared spectrum.

    num_points: N; precision: 'float64' or 'float32'; threads: of the transforms, >= 1; planning: one of
    `planner.PLANNING`; backend: of the kernels in between, see `ExecutionConfig`; way: one of `WAYS`, by default what
    is fastest. apart: the rounding of no mode may spoil another one, which leaves out 'half-length'. Raises
    `ValueError`.
    """

    def __init__(
        self,
        num_points: int,
        precision: str,
        threads: int = 1,
        planning: str = "estimate",
        backend: str = "warp",
        way: str | None = None,
        apart: bool = False,
    ) -> None:
        self.num_points = num_points
        self.planner = planner = Planner(precision, threads, planning, backend)
        self.real = planner.real
        self.way = way or _fastest(num_points, planner, apart)
        """How the transforms are done."""
        self._way = WAYS[self.way](num_points, planner)

    def replanned(self, threads: int, planning: str) -> "Transforms":
        """The same on the same buffers, for plans of another kind. Raises `ValueError`, for 'four-step', too."""
        if self.way == "four-step":
            raise ValueError("way is 'four-step'; allowed: 'real' or 'half-length', whose plans are made anew")
        found, planner = copy.copy(self), copy.copy(self.planner)
        planner.threads, planner.planning = check_settings(threads, planning)
        found._way = copy.copy(self._way)
        found.planner = found._way.planner = planner
        return found

    @property
    def spectrum(self) -> Array:
        """What a forward transform gives, a flat real view (re, im, ...) padded with zeros, in the way's own order."""
        return self._way.spectrum

    def buffer(self, length: int | None = None) -> Array:
        """A padded, aligned, staggered array for `length` (default N) values: zeros."""
        return self.planner.buffer(self.num_points if length is None else length)

    def field(self) -> Array:
        """A buffer for N values that are transformed there and back; it may share the spectrum's memory."""
        return self._way.field()

    def multiplication(self, symbol: Array64, target: Array) -> Callable[[], None]:
        """As `Place.multiplication`."""
        return self._way.multiplication(symbol, target)

    def forward(self, source: Array) -> Callable[[], None]:
        """Plan source[:N] -> spectrum; the plan keeps `source`. Plan before filling it."""
        return self._way.forward(source)

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan spectrum -> target[:N], with the factor that `multiplication` to this target makes up for; it destroys
        the spectrum.
        """
        return self._way.inverse(target)


def _fastest(num_points: int, planner: Planner, apart: bool) -> str:
    """The way that takes least time, as far as that is known."""
    if four_step.is_faster(num_points, planner, apart):
        return "four-step"
    return "half-length" if not apart and half_length.is_faster(num_points, planner) else "real"
