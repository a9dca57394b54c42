"""Times: the candidates of a kernel in turn, the parts of a plain FIRE iteration, and what is known of the machine."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver import Scene
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods.fire_state import Fire
from linecontact.solver.provenance import provenance
from linecontact.solver.transforms.planned import Transforms

from ..files import records
from .candidates import Bench, compile_c, load

ITERATION = "iteration"
"""Stands for a kernel in the rows of the FIRE iteration."""

_CACHES = Path("/sys/devices/system/cpu/cpu0/cache")
_SPAN, _MOST_CALLS = 1e-4, 100  # s that are timed at once, and calls after which in-place results still are ordinary
_LEAST_ROUNDS = 7
_WARM_SPAN, _MOST_WARM = 1e-2, 3  # s, and calls: after one the third-level cache may still hold the others' data

Record = dict[str, Any]


def time_in_turn(
    candidates: Mapping[str, Callable[[], object]], restore: Callable[[], None], seconds: float
) -> dict[str, list[float]]:
    """Time the candidates in turn: seconds of a call by candidate, one value for each round.

    seconds: to spend in all.

    They take turns, so that a change of the machine's speed hits all of them, in an order that changes from round to
    round, because who comes after whom matters to the caches. Before a candidate is timed the buffers are restored, so
    that nothing decays to denormals, and it runs untimed, so that the caches hold what its own runs leave.
    """
    calls, warm = {}, {}
    for name, run in candidates.items():
        restore()
        run()
        begin = time.perf_counter()
        run()
        once = time.perf_counter() - begin
        calls[name] = int(np.clip(_SPAN / once, 1, _MOST_CALLS))
        warm[name] = int(np.clip(_WARM_SPAN / once, 1, _MOST_WARM))
    found: dict[str, list[float]] = {name: [] for name in candidates}
    rng, rounds, end = np.random.default_rng(0), 0, time.perf_counter() + seconds
    while rounds < _LEAST_ROUNDS or time.perf_counter() < end:
        for name in rng.permutation(list(candidates)):
            run = candidates[name]
            restore()
            for _ in range(warm[name]):
                run()
            begin = time.perf_counter()
            for _ in range(calls[name]):
                run()
            found[name].append((time.perf_counter() - begin) / calls[name])
        rounds += 1
    return found


def kernel_times(kernel: str, precision: str, num_points: int, seconds: float) -> Record:
    """Times of every candidate of a kernel, checked to agree before. Raises `RuntimeError` where one does not.

    The ratios to C are medians of the ratios of single rounds, which slow changes of the machine leave alone.
    """
    load()
    bench = Bench(kernel, precision, num_points)
    bench.check()
    times = time_in_turn(bench.candidates, bench.restore, seconds)
    over_c = {f"over_c.{v}": float(np.median(np.divide(t, times["c"]))) for v, t in times.items() if "c" in times}
    return (
        _statistics(times)
        | over_c
        | {
            "flops": bench.spec.flops * num_points,
            "bytes.traffic": bench.spec.traffic(num_points, precision),
            "bytes.working_set": bench.spec.working_set(num_points, precision),
            "bytes.copied": bench.copied_bytes,
        }
    )


def iteration_times(precision: str, num_points: int, seconds: float) -> Record:
    """The transforms and everything else in plain FIRE's iteration on a half-space."""
    problem = Problem.from_scene(Scene(num_points=num_points, precision=precision))  # type: ignore[arg-type]
    state = Fire(problem, Transforms(num_points, precision), 1e-14, "warp")
    times: dict[str, list[float]] = {"FFTs": [], "rest": []}
    end = time.perf_counter() + seconds
    while len(times["rest"]) < _LEAST_ROUNDS + 3 or time.perf_counter() < end:
        spent = dict.fromkeys(times, 0.0)
        for kind, part in state.parts():
            begin = time.perf_counter()
            part()
            spent[kind] += time.perf_counter() - begin
        for kind, value in spent.items():
            times[kind].append(value)
    return _statistics({kind: values[3:] for kind, values in times.items()})


def _statistics(times: Mapping[str, list[float]]) -> Record:
    found: Record = {"rounds": len(next(iter(times.values())))}
    for name, values in times.items():
        found |= {f"seconds.{name}.median": float(np.median(values)), f"seconds.{name}.min": min(values)}
    return found


def machine() -> Record:
    """Versions and processor, the C compiler or why there is none, and the sizes of the data caches, where known."""
    caches = {}
    for index in sorted(_CACHES.glob("index*")):
        try:
            level, kind, size = ((index / name).read_text().strip() for name in ("level", "type", "size"))
            if kind != "Instruction":
                caches[f"bytes.cache.L{level}"] = int(size.rstrip("KM")) * {"K": 2**10, "M": 2**20}.get(size[-1], 1)
        except (OSError, ValueError):
            continue
    return records.flatten({"provenance": provenance()}) | {"compiler": compile_c()[1]} | caches
