"""Launches of Warp kernels recorded, to be repeated.

Several are recorded as a CPU graph, the cheapest way to repeat them. A single short one is kept as a launch: a graph
would take 0.2 ms to record, which is as long as many of its replays.
"""

import functools
import threading
from collections.abc import Callable, Sequence
from typing import Any

Launch = tuple[Any, int, Sequence[Any], Sequence[Any]]
"""A Warp kernel, its number of threads, and the Warp arrays that it reads and that it writes."""

_SHORT = 2**6  # threads of a launch

_one_at_a_time = threading.Lock()
"""Warp would put what another thread launches into the graph that is being recorded."""


def record_launches(launches: Sequence[Launch], times: int = 1) -> Callable[[], Any]:
    """A function without arguments that does all launches in order, `times` times. Scalars are frozen."""
    import warp as wp

    if len(launches) == times == 1 and launches[0][1] <= _SHORT:
        ((kernel, threads, inputs, outputs),) = launches
        with _one_at_a_time:
            command = wp.launch(kernel, dim=threads, inputs=inputs, outputs=outputs, device="cpu", record_cmd=True)

        def replay() -> None:
            with _one_at_a_time:
                command.launch()

        return replay
    with _one_at_a_time, wp.ScopedCapture(device="cpu") as capture:
        for _ in range(times):
            for kernel, threads, inputs, outputs in launches:
                wp.launch(kernel, dim=threads, inputs=inputs, outputs=outputs, device="cpu")
    return functools.partial(wp.capture_launch, capture.graph)
