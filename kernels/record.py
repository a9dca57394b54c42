"""Kernel sequences recorded once and replayed: on Warp as a CPU graph, on NumPy as the twins in turn.

    replay = record("warp", [Call("spectral_multiply", inputs=(coefficient,), outputs=(spectrum,))])
    replay()

A call gives the arrays in the kernel's order: one-dimensional, contiguous NumPy arrays, float32 or float64, whose
length is a multiple of `CHUNK` (sums: one value per chunk). Warp works on the same memory, nothing is copied.
"""

import functools
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import numpy_twin
from .layout import CHUNK

Array = NDArray[Any]

BACKENDS = ("warp", "numpy")
KERNELS = (
    "spectral_multiply",
    "mirror_multiply",
    "net_force",
    "search_sums",
    "restrict_to_free",
    "fire_control",
    "fire_step",
    "plain_sums",
    "plain_step",
    "advance_response",
    "count_below",
    "rest_on_wall",
)

_capture_lock = threading.Lock()


class Call(NamedTuple):
    """One launch of a kernel."""

    kernel: str
    """Its name, one of `KERNELS`."""
    inputs: tuple[Array, ...]
    """Arrays that it reads, in the kernel's order."""
    outputs: tuple[Array, ...]
    """Arrays that it writes, and may also read, in the kernel's order."""


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """Warp's native code reports a missing CUDA driver on file descriptor 2, whatever its log level."""
    saved = os.dup(2)
    with open(os.devnull, "w") as null:
        os.dup2(null.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)


@functools.cache
def load() -> dict[str, Any]:
    """Compile every kernel in both precisions, or fetch it from Warp's kernel cache; Warp's kernels by name.

    Raises `ValueError` if the cache cannot be used.
    """
    import warp as wp  # takes as long as everything else together, and often is not needed

    from . import warp_fields, warp_fire

    wp.config.log_level = wp.LOG_WARNING
    try:
        with _silent_stderr():
            wp.init()
    except OSError as error:
        raise ValueError(f"Warp's kernel cache: {error}; allowed: a writable folder, set WARP_CACHE_PATH") from error
    kernels = {name: getattr(warp_fields, name, None) or getattr(warp_fire, name) for name in KERNELS}
    for kernel in kernels.values():
        if kernel.is_generic:
            arguments = {a.label: a.type for a in kernel.adj.args}
            for real in (wp.float32, wp.float64):
                types = {k: wp.array(dtype=real) if t.dtype is Any else t for k, t in arguments.items()}
                wp.overload(kernel, types)
    single, double, state = wp.array(dtype=wp.float32), wp.array(dtype=wp.float64), wp.array(dtype=wp.float64)
    wp.overload(kernels["advance_response"], {"change": single, "state": state, "response": double})
    for module in (warp_fields, warp_fire):
        wp.load_module(module, device="cpu")
    return kernels


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
    kernels = load()
    import warp as wp

    with _capture_lock, wp.ScopedCapture(device="cpu") as capture:
        for call in calls:
            threads = 1 if call.kernel == "fire_control" else call.inputs[0].size // CHUNK
            wp.launch(
                kernels[call.kernel],
                dim=threads,
                inputs=[_share(array) for array in call.inputs],
                outputs=[_share(array) for array in call.outputs],
                device="cpu",
            )
    graph = capture.graph
    return lambda: wp.capture_launch(graph)


def _share(array: Array) -> Any:
    """The same memory as a Warp array."""
    import warp as wp

    return wp.array(array, dtype=wp.float32 if array.dtype == np.float32 else wp.float64, copy=False, device="cpu")
