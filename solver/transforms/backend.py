"""A method's arrays, their transforms and the kernels between them."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

import numpy as np

from ...kernels import CHUNK, Call
from ..arrays import Array, Array64


class Backend(ABC):
    """Transforms of N values, with the arrays and the kernels between them: `planner.Transforms` on the CPU,
    `on_gpu.Transforms` on a GPU.

    num_points: N; dtype: of the values; spectrum: result of a forward transform, a flat real view (re, im, ...)
    padded with zeros.
    """

    spectrum: Array
    chunk: int = CHUNK
    """Points for each thread of a kernel."""

    def __init__(self, num_points: int, precision: str) -> None:
        self.num_points, self.dtype = num_points, np.dtype(precision)

    @abstractmethod
    def buffer(self, length: int | None = None) -> Array:
        """A padded array for `length` (default N) values: zeros."""

    def field(self) -> Array:
        """A buffer for N values that are transformed there and back; it may share the spectrum's memory."""
        return self.buffer()

    def put(self, target: Array, values: Array64) -> None:
        """Copy values into the first places of a buffer."""
        target[: values.size] = self.take(values)

    def take(self, values: Array64) -> Array64:
        """NumPy's values as an array where the kernels work; on the CPU the same array."""
        return values

    def fetch(self, values: Array) -> Array:
        """An array of the backend as one of NumPy's."""
        return values

    def sums(self, length: int) -> Array64:
        """Zeros, one for each chunk of a buffer of that length."""
        return self.take(np.zeros(length // self.chunk))

    @abstractmethod
    def record(self, calls: Sequence[Call]) -> Callable[[], None]:
        """A function without arguments that runs kernels in order."""

    def doubled(self, values: Array64) -> Array:
        """A buffer with every value twice, for both parts of a mode."""
        found = self.buffer(2 * values.size)
        for part in range(2):
            self.put(found[part : 2 * values.size : 2], values)
        return found

    def complex(self, values: Array) -> Array:
        """Complex numbers on a flat real view (re, im, ...)."""
        found: Array = values.view(np.result_type(self.dtype, np.complex64))
        return found

    def multiplication(self, symbol: Array64, target: Array) -> Callable[[], None]:
        """A function without arguments that multiplies by a symbol, shape (N//2 + 1,), and by the factor of the
        inverse, between `forward` and `inverse` to this target.
        """
        return self.record([Call("spectral_multiply", (self.doubled(symbol / self.num_points),), (self.spectrum,))])

    @abstractmethod
    def forward(self, source: Array) -> Callable[[], None]:
        """A function without arguments that transforms source[:N], which it keeps, into the spectrum. Plan before
        filling the source.
        """

    @abstractmethod
    def inverse(self, target: Array) -> Callable[[], None]:
        """A function without arguments that transforms the spectrum, which it may destroy, into target[:N]."""
