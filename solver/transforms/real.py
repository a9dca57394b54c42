"""FFTW's own real transforms."""

from collections.abc import Callable

from ..arrays import Array
from .planner import Transforms


class Real(Transforms):
    """Real transforms of N values. spectrum: flat real view of the half spectrum, N + 2 values or N + 1, and zeros."""

    way = "real"

    def prepare(self) -> None:
        self.spectrum = self.buffer(2 * (self.num_points // 2 + 1))

    def forward(self, source: Array) -> Callable[[], None]:
        return self.plan(source[: self.num_points], self._modes, "FFTW_FORWARD")

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan spectrum -> target[:N], times N, which destroys the spectrum."""
        return self.plan(self._modes, target[: self.num_points], "FFTW_BACKWARD")

    @property
    def _modes(self) -> Array:
        return self.complex(self.spectrum[: 2 * (self.num_points // 2 + 1)])
