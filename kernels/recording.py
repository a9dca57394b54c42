"""Launches of Warp kernels recorded as a CPU graph, the cheapest way to repeat them, or kept as they are."""

import functools
from collections.abc import Callable, Sequence
from typing import Any

from .locks import RECORDING

Launch = tuple[Any, int, Sequence[Any], Sequence[Any]]
"""A Warp kernel, its number of threads, and the Warp arrays that it reads and that it writes."""


def record_launches(launches: Sequence[Launch], times: int = 1) -> Callable[[], Any]:
    """A function without arguments that does all launches in order, `times` times. Scalars are frozen."""
    import warp as wp

    with RECORDING, wp.ScopedCapture(device="cpu") as capture:
        for _ in range(times):
            for kernel, threads, inputs, outputs in launches:
                wp.launch(kernel, dim=threads, inputs=inputs, outputs=outputs, device="cpu")
    return functools.partial(wp.capture_launch, capture.graph)


def keep_launch(launch: Launch) -> Callable[[], None]:
    """A function without arguments that does one launch. It is made in a seventh of the 0.2 ms that a graph takes, but
    every call takes 3 us more, and waits for what other threads record or launch here.
    """
    import warp as wp

    kernel, threads, inputs, outputs = launch
    with RECORDING:
        command = wp.launch(kernel, dim=threads, inputs=inputs, outputs=outputs, device="cpu", record_cmd=True)

    def replay() -> None:
        with RECORDING:
            command.launch()

    return replay
