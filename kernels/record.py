"""Kernel sequences recorded once and replayed: on Warp as a CPU graph, on NumPy as the twins in turn.

    replay = record("warp", [Call("spectral_multiply", inputs=(coefficient,), outputs=(spectrum,))])
    replay()

A call gives the arrays in the kernel's order: one-dimensional, contiguous NumPy arrays, float32 or float64, whose
length is a multiple of `CHUNK` (sums: one value per chunk). Warp works on the same memory, nothing is copied.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import numpy_twin
from .compiled import load
from .layout import CHUNK
from .recording import record_launches

Array = NDArray[Any]

BACKENDS = ("warp", "numpy")


class Call(NamedTuple):
    """One launch of a kernel."""

    kernel: str
    """Its name, one of `KERNELS`."""
    inputs: tuple[Array, ...]
    """Arrays that it reads, in the kernel's order."""
    outputs: tuple[Array, ...]
    """Arrays that it writes, and may also read, in the kernel's order."""


def record(backend: str, calls: Sequence[Call]) -> Callable[[], None]:
    """A function without arguments that runs `calls` in order.

    Raises `ValueError` for an unknown backend or an array that a kernel cannot take.
    """
    for call in calls:
        for array in (*call.inputs, *call.outputs):
            if array.ndim != 1 or not array.flags.c_contiguous:
                raise ValueError(
                    f"{call.kernel}: an array of shape {array.shape} is not one-dimensional and contiguous"
                )
        if call.kernel != "fire_control" and call.inputs[0].size % CHUNK:
            raise ValueError(f"{call.kernel}: length is {call.inputs[0].size}; allowed: multiples of {CHUNK}")
    if backend == "warp":
        return _record_warp(calls)
    if backend == "numpy":
        return _record_numpy(calls)
    raise ValueError(f"backend is {backend!r}; allowed: {', '.join(BACKENDS)}")


def _record_numpy(calls: Sequence[Call]) -> Callable[[], None]:
    parts = [functools.partial(getattr(numpy_twin, c.kernel), *c.inputs, *c.outputs) for c in calls]

    def replay() -> None:
        for part in parts:
            part()

    return replay


def _record_warp(calls: Sequence[Call]) -> Callable[[], None]:
    kernels, launches = load(), []
    for call in calls:
        threads = 1 if call.kernel == "fire_control" else call.inputs[0].size // CHUNK
        arrays = [share(array) for array in call.inputs], [share(array) for array in call.outputs]
        launches.append((kernels[call.kernel], threads, *arrays))
    return record_launches(launches)


def share(array: Array) -> Any:
    """The same memory as a Warp array. array: one-dimensional and contiguous, float32 or float64."""
    import warp as wp

    return wp.array(array, dtype=wp.float32 if array.dtype == np.float32 else wp.float64, copy=False, device="cpu")
