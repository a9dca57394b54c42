"""Launches of Warp kernels recorded as a CPU graph, the cheapest way to repeat them."""

import functools
from collections.abc import Callable, Sequence
from typing import Any

from ..locks import RECORDING

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
