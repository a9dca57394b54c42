"""A method's arrays, their transforms and the kernels between them: the interface, and its parts on the CPU."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import ClassVar

import numpy as np

from ...kernels import CHUNK, Call, padded_length, record
from ..arrays import Array, Array64
from . import wisdom
from .plain import Plan, pyfftw

_STAGGER = 1024  # bytes: buffers that start at equal page offsets slow each other down


class Backend(ABC):
    """Transforms of N values, with the arrays and the kernels between them: on the CPU `Transforms`, on a GPU
    `on_gpu.Transforms`.

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

    def multiplication(self, symbol: Array64) -> Callable[[], None]:
        """A function without arguments that multiplies by a symbol, shape (N//2 + 1,), and by the factor of the
        inverse, between `forward` and `inverse`.
        """
        return self.record([Call("spectral_multiply", (self.doubled(symbol / self.num_points),), (self.spectrum,))])

    @abstractmethod
    def forward(self, source: Array) -> Callable[[], None]:
        """A function without arguments that transforms source[:N] into the spectrum. It keeps the source unless that is
        a `field`. Plan before filling the source.
        """

    @abstractmethod
    def inverse(self, target: Array) -> Callable[[], None]:
        """A function without arguments that transforms the spectrum, which it may destroy, into target[:N]."""


class Transforms(Backend):
    """Transforms of N values in one way, and the buffers, plans and kernels that it is made from.

    precision: 'float64' or 'float32'; threads: of the transforms, >= 1; planning: one of `PLANNING`; backend: see
    `ExecutionConfig.backend`. Raises `ValueError`.
    """

    way: ClassVar[str]
    """How the transforms are done."""

    def __init__(self, num_points: int, precision: str, threads: int, planning: str, backend: str) -> None:
        super().__init__(num_points, precision)
        self.threads, self.planning = threads, planning
        self._backend, self._count = backend, 0
        wisdom.load()
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Make the spectrum, and other buffers of a way."""

    def buffer(self, length: int | None = None) -> Array:
        """A padded, aligned, staggered array for `length` (default N) values: zeros."""
        padded = padded_length(self.num_points if length is None else length)
        offset = self._count * _STAGGER // self.dtype.itemsize
        self._count += 1
        return np.asarray(pyfftw.zeros_aligned(padded + offset, dtype=self.dtype, n=64)[offset:])

    def record(self, calls: Sequence[Call]) -> Callable[[], None]:
        return record(self._backend, calls)

    def plan(
        self, source: Array, target: Array, direction: str, axis: int = -1, threads: int | None = None
    ) -> Callable[[], None]:
        """The plan that wisdom holds, or else a new one, which is kept at once if finding it took effort.

        direction: 'FFTW_FORWARD', or 'FFTW_BACKWARD', which destroys the source; axis: of arrays of two dimensions;
        threads: by default the transforms'.
        """

        def plan(effort: str, *more: str) -> Callable[[], None]:
            flags = [f"FFTW_{effort.upper()}", *more, *(["FFTW_DESTROY_INPUT"] if direction == "FFTW_BACKWARD" else [])]
            count = threads or self.threads
            return Plan(source, target, axes=(axis,), direction=direction, threads=count, flags=flags)

        estimated = self.planning == "estimate"
        with suppress(RuntimeError):  # wisdom does not hold it
            return plan("measure" if estimated else self.planning, "FFTW_WISDOM_ONLY")
        try:
            return plan(self.planning)
        finally:
            if not estimated:
                wisdom.save()  # after Ctrl-C, too, which waits until FFTW has finished
