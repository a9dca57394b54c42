"""Where a method's arrays are, what transforms them and what runs its kernels: what a method asks of that place."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from ...kernels import CHUNK, Call, record
from ..arrays import Array, Array64


class Place(Protocol):
    """Transforms of N values, with the arrays and the kernels between them: `planned.Transforms` on the CPU,
    `on_gpu.Transforms` on a GPU.
    """

    num_points: int
    """N."""

    @abstractmethod
    def buffer(self, length: int | None = None) -> Array:
        """A padded array of the place's precision for `length` (default N) values: zeros."""

    @abstractmethod
    def put(self, target: Array, values: Array64) -> None:
        """Copy values into the first places of a buffer."""

    @abstractmethod
    def take(self, values: Array64) -> Array64:
        """NumPy's values as an array where the kernels work; on the CPU the same array."""

    @abstractmethod
    def fetch(self, values: Array) -> Array:
        """An array of that place as one of NumPy's."""

    @abstractmethod
    def sums(self, length: int) -> Array64:
        """Zeros, one for each chunk of a buffer of that length."""

    @abstractmethod
    def record(self, backend: str, calls: Sequence[Call]) -> Callable[[], None]:
        """A function without arguments that runs kernels in order; backend: see `ExecutionConfig.backend`."""

    @abstractmethod
    def multiplication(self, symbol: Array64, target: Array) -> Callable[[], None]:
        """A function without arguments that multiplies by a symbol, shape (N//2 + 1,), and by what normalises the
        inverse, between `forward` and `inverse` to this target.
        """

    @abstractmethod
    def forward(self, source: Array) -> Callable[[], None]:
        """A function without arguments that transforms source[:N], which it keeps, into the spectrum."""

    @abstractmethod
    def inverse(self, target: Array) -> Callable[[], None]:
        """A function without arguments that transforms the spectrum, which it may destroy, into target[:N]."""


class OnCpu:
    """What of a place needs no transforms, for the machine's own memory."""

    def put(self, target: Array, values: Array64) -> None:
        target[: values.size] = values

    def take(self, values: Array64) -> Array64:
        return values

    def fetch(self, values: Array) -> Array:
        return values

    def sums(self, length: int) -> Array64:
        return np.zeros(length // CHUNK)

    def record(self, backend: str, calls: Sequence[Call]) -> Callable[[], None]:
        return record(backend, calls)
