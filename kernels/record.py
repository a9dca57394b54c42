"""Kernel sequences recorded once and replayed: on Warp as a CPU graph, on NumPy as the reference kernels in turn.

    replay = record("warp", [Call("spectral_multiply", inputs=(coefficient,), outputs=(spectrum,))])
    replay()

A call gives the arrays in the kernel's order: one-dimensional, contiguous NumPy arrays, float32 or float64, whose
length is a multiple of `CHUNK` (sums: one value per chunk). Warp works on the same memory, nothing is copied.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from numpy.typing import NDArray

from ..locks import RECORDING
from . import reference
from .compiled import load
from .layout import CHUNK

Array = NDArray[Any]

BACKENDS = ("warp", "numpy")


class Call(NamedTuple):
    """One launch of a kernel, or with the arrays' names in their place a line of a sequence of kernels."""

    kernel: str
    """Its name, one of `KERNELS`."""
    inputs: tuple[Any, ...]
    """Arrays that it reads, in the kernel's order."""
    outputs: tuple[Any, ...]
    """Arrays that it writes, and may also read, in the kernel's order."""


Launch = tuple[Any, int, Sequence[Any], Sequence[Any]]
"""A Warp kernel, its number of threads, and the Warp arrays that it reads and that it writes."""


def record(backend: str, calls: Sequence[Call]) -> Callable[[], None]:
    """A function without arguments that runs `calls` in order.

    Raises `ValueError` for an unknown backend or an array that a kernel cannot take.
    """
    for name, inputs, outputs in calls:
        for array in (*inputs, *outputs):
            if array.ndim != 1 or not array.flags.c_contiguous:
                raise ValueError(f"{name}: an array of shape {array.shape} is not one-dimensional and contiguous")
        if name != "fire_control" and inputs[0].size % CHUNK:
            raise ValueError(f"{name}: length is {inputs[0].size}; allowed: multiples of {CHUNK}")
    if backend == "warp":
        kernels, launches = load(), []
        for name, inputs, outputs in calls:
            threads = 1 if name == "fire_control" else inputs[0].size // CHUNK
            launches.append((kernels[name], threads, [*map(share, inputs)], [*map(share, outputs)]))
        return record_launches(launches)
    if backend != "numpy":
        raise ValueError(f"backend is {backend!r}; allowed: {', '.join(BACKENDS)}")
    parts = [functools.partial(getattr(reference, c.kernel), *c.inputs, *c.outputs) for c in calls]

    def replay() -> None:
        for part in parts:
            part()

    return replay


def record_launches(launches: Sequence[Launch], times: int = 1) -> Callable[[], Any]:
    """A function without arguments that does all launches in order, `times` times: a CPU graph, the cheapest way to
    repeat them. Scalars are frozen.
    """
    import warp as wp

    with RECORDING, wp.ScopedCapture(device="cpu") as capture:
        for _ in range(times):
            for kernel, threads, inputs, outputs in launches:
                wp.launch(kernel, dim=threads, inputs=inputs, outputs=outputs, device="cpu")
    return functools.partial(wp.capture_launch, capture.graph)


def launch(name: str, threads: int, inputs: Sequence[Array | bool], outputs: Sequence[Array]) -> None:
    """One launch of a kernel, not recorded, on one-dimensional, contiguous arrays of float64, and scalars. Raises
    `ValueError` if Warp's kernel cache cannot be used.
    """
    kernel = load()[name]
    import warp as wp

    with RECORDING:  # else another thread would record it
        wp.launch(kernel, threads, inputs=inputs, outputs=outputs, device="cpu")


def share(array: Array) -> Any:
    """The same memory as a Warp array. array: one-dimensional and contiguous, float32 or float64."""
    import warp as wp

    return wp.array(array, copy=False, device="cpu")
