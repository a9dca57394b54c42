"""Times of iterations and of kernels, on the CPU and on the GPU."""

import functools
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from linecontact.kernels import Call, layout
from linecontact.kernels.sequences import parse
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods import METHODS, ExecutionConfig

KERNELS = {
    "spectral_multiply: coefficient -> spectrum": 3,
    "plain_sums: elastic v -> sums": 2,
    "plain_step: elastic h state -> u v": 6,
    "net_force: load elastic v -> force sums": 4,
    "restrict_to_free: force -> acceleration acceleration_sums": 3,
    "fire_step: acceleration h state -> u v": 6,
}
"""The kernels of an iteration on arrays of N values, and how many such arrays each of them reads and writes."""

_SECONDS, _FEWEST = 0.5, 3
_CYCLE = {"cpu": 1, "cuda": 100}  # iterations that are timed together
_ROUNDS, _REPEATED = 5, 20
_ON_DEVICE = 3  # CUDA's name for a copy that stays on the device


def seconds_per_iteration(problem: Problem, method: str, precision: str, device: str, threads: int = 1) -> float:
    """Mean time of an iteration [s], over half a second or more, or over three iterations if these take longer.

    On the GPU it is over hundreds of iterations: the work of mass-weighted FIRE every hundredth time is in its mean.
    """
    state = METHODS[method].begin(problem, ExecutionConfig(1e-14, precision, threads=threads, device=device))
    cycle, least = _CYCLE[device], max(_FEWEST, _CYCLE[device])
    while state.iteration < cycle:
        state.steps(cycle - state.iteration)
    first, begin = state.iteration, time.perf_counter()
    while time.perf_counter() - begin < _SECONDS or state.iteration < first + least or state.iteration % cycle:
        state.steps(cycle - state.iteration % cycle)
        if state.stopped:
            raise ValueError(f"tolerance of {method} is met too early; allowed: a scene that takes longer")
    return (time.perf_counter() - begin) / (state.iteration - first)


def shares_of_the_copy_bandwidth(precision: str, num_points: int) -> dict[str, float]:
    """The bandwidth of every kernel over that of a copy on the GPU, and under 'copy' that [bytes a second].

    Copies of some lengths are slower than of others: the fastest counts of those of the arrays, of half and of
    a quarter of them.
    """
    import cupy.cuda
    from linecontact.solver.transforms import on_gpu

    backend = on_gpu.Transforms(num_points, precision)
    values = np.random.default_rng(0).standard_normal(num_points)

    def array(name: str) -> Any:
        if name.endswith("sums"):
            return backend.sums(layout.PARTS * num_points)
        if name == "state":
            return backend.take(np.zeros(layout.STATE_LENGTH))
        found = backend.buffer()
        backend.put(found, values)
        if name == "v":
            found[::3] = layout.TOUCHING
        return found

    source: Any = backend.buffer()
    target: Any = backend.buffer()
    size = source.nbytes

    def copy(part: int) -> None:
        with backend.stream:
            cupy.cuda.runtime.memcpyAsync(target.data.ptr, source.data.ptr, part, _ON_DEVICE, backend.stream.ptr)

    found = {"copy": max(2 * part / _seconds(functools.partial(copy, part)) for part in (size, size // 2, size // 4))}
    for text, arrays in KERNELS.items():
        line = parse(text)
        call = Call(line.kernel, tuple(map(array, line.inputs)), tuple(map(array, line.outputs)))
        found[line.kernel] = arrays * size / _seconds(backend.record([call])) / found["copy"]
    return found


def _seconds(run: Callable[[], None]) -> float:
    """Least mean time of work put into the GPU's queue, many times as one graph [s]."""
    import warp as wp
    from linecontact.solver.transforms import on_gpu

    run()
    graph, times = on_gpu.capture([run] * _REPEATED), []
    for _ in range(_ROUNDS):
        wp.synchronize_device("cuda")
        begin = time.perf_counter()
        graph()
        wp.synchronize_device("cuda")
        times.append(time.perf_counter() - begin)
    return min(times) / _REPEATED
