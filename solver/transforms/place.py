"""Where a method's arrays are, and what runs its kernels: the machine's own memory, and the CPU."""

from collections.abc import Callable, Sequence

import numpy as np

from ...kernels import CHUNK, Call, record
from ..arrays import Array, Array64


class OnCpu:
    """The few things that a method asks of the place where it works; `on_gpu.Transforms` has the same for a GPU."""

    def put(self, target: Array, values: Array64) -> None:
        """Copy values into the first places of a buffer."""
        target[: values.size] = values

    def take(self, values: Array64) -> Array64:
        """The values as an array where the kernels work."""
        return values

    def fetch(self, values: Array) -> Array:
        """An array of the kernels' as one of NumPy's."""
        return values

    def sums(self, length: int) -> Array64:
        """Zeros, one for each chunk of a buffer of that length."""
        return np.zeros(length // CHUNK)

    def record(self, backend: str, calls: Sequence[Call]) -> Callable[[], None]:
        """A function without arguments that runs kernels in order; backend: 'warp', or 'numpy' for the twins."""
        return record(backend, calls)
