"""Real transforms by cuFFT on a GPU, between arrays that the kernels share; `planned` has the convention.

CuPy holds the arrays and calls cuFFT; all of it goes into the queue of Warp's stream, so that transforms and kernels
are recorded as one graph. CuPy's own work is in the default stream, which waits for Warp's stream, and
for which that waits. Nothing here is imported unless a GPU is asked for.
"""

from collections.abc import Callable, Sequence
from typing import Any, cast

import cupy
import warp as wp
from cupy.cuda import cufft

from ...kernels import Call, on_gpu, padded_length
from ..arrays import Array, Array64
from .backend import Backend

OutOfMemory: type[Exception] = cupy.cuda.memory.OutOfMemoryError

_KINDS = {"float64": (cufft.CUFFT_D2Z, cufft.CUFFT_Z2D), "float32": (cufft.CUFFT_R2C, cufft.CUFFT_C2R)}


class Transforms(Backend):
    """Plans between real buffers of `num_points` values and one shared spectrum, all in the GPU's memory.

    num_points: N; precision: 'float64' or 'float32'. The arrays are CuPy's, which work like NumPy's.
    """

    chunk = on_gpu.CHUNK

    def __init__(self, num_points: int, precision: str) -> None:
        super().__init__(num_points, precision)
        self.stream = cupy.cuda.Stream.from_external(wp.get_stream("cuda"))
        self._forward, self._inverse = (cufft.Plan1d(num_points, kind, 1) for kind in _KINDS[self.dtype.name])
        self.spectrum = self.buffer(2 * (num_points // 2 + 1))
        self._modes = self.complex(self.spectrum[: 2 * (num_points // 2 + 1)])

    def buffer(self, length: int | None = None) -> Array:
        return cast(Array, cupy.zeros(padded_length(length or self.num_points, on_gpu.SPAN), dtype=self.dtype))

    def take(self, values: Array64) -> Array64:
        return cast(Array64, cupy.asarray(values))

    def fetch(self, values: Array) -> Array:
        return cast(Array, cupy.asnumpy(values))

    def record(self, calls: Sequence[Call]) -> Callable[[], None]:
        return on_gpu.prepare(calls)

    def forward(self, source: Array) -> Callable[[], None]:
        return self._execute(self._forward, source[: self.num_points], self._modes, cufft.CUFFT_FORWARD)

    def inverse(self, target: Array) -> Callable[[], None]:
        return self._execute(self._inverse, self._modes, target[: self.num_points], cufft.CUFFT_INVERSE)

    def _execute(self, plan: Any, source: Array, target: Array, direction: int) -> Callable[[], None]:
        def run() -> None:
            with self.stream:
                plan.fft(source, target, direction)

        return run


def capture(functions: Sequence[Callable[[], None]]) -> Callable[[], None]:
    """A function without arguments that puts all that functions put into the queue there at once, as one graph."""
    with wp.ScopedCapture(device="cuda", force_module_load=False) as captured:
        for function in functions:
            function()

    def replay() -> None:
        wp.capture_launch(captured.graph)

    return replay


def free_memory() -> int:
    """Give back memory that CuPy keeps for later arrays; the GPU's memory that is free then [bytes]."""
    cupy.get_default_memory_pool().free_all_blocks()
    return int(cupy.cuda.runtime.memGetInfo()[0])
