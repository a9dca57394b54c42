"""Times of a benchmark's variants: in turn, pinned to one core, checked to agree before."""

import os
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .bench import Bench
from .benchmarks import BENCHMARKS
from .c_code import BUILDS
from .variants import Runs

Record = dict[str, Any]
Times = dict[str, NDArray[np.float64]]

_SPAN, _MOST_CALLS = 1e-4, 1000  # s that are timed at once, and calls after which in-place results still are ordinary
_LEAST_ROUNDS, _SLOW_ROUNDS = 5, 2
_TOGETHER = 0.02  # s that cores work at once
_CORES = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []  # that this process may use


def time_in_turn(
    variants: Mapping[str, Runs], restore: Callable[[], None], seconds: float, slow: Collection[str] = ()
) -> tuple[Times, dict[str, int]]:
    """Time variants in turn: seconds of a call in every round, NaN where it was left out, and calls timed at once.

    seconds: to spend in all; slow: variants that are timed in the first rounds only.

    They take turns, so that a change of the machine's speed hits all of them, in an order that changes from round to
    round, because who comes after whom matters to the caches. Before each is timed it runs untimed, so that the caches
    hold what its own runs leave, and before each round the buffers are restored, so that nothing decays to denormals.
    """
    runs, calls = {}, {}
    for name, variant in variants.items():
        calls[name] = _calls(variant(1))
        runs[name] = variant(calls[name])
    found: dict[str, list[float]] = {name: [] for name in variants}
    rng, rounds, end = np.random.default_rng(0), 0, time.perf_counter() + seconds
    while rounds < _LEAST_ROUNDS or time.perf_counter() < end:
        restore()
        for name in rng.permutation(list(variants)):
            if rounds >= _SLOW_ROUNDS and name in slow:
                found[name].append(np.nan)
                continue
            run = runs[name]
            if name not in slow:
                run()
            begin = time.perf_counter()
            run()
            found[name].append((time.perf_counter() - begin) / calls[name])
        rounds += 1
    return {name: np.array(values) for name, values in found.items()}, calls


def _calls(run: Callable[[], object]) -> int:
    """How many calls take as long as is timed at once."""
    run()
    begin = time.perf_counter()
    run()
    return int(np.clip(_SPAN / (time.perf_counter() - begin), 1, _MOST_CALLS))


def measure(name: str, precision: str, num_points: int, seconds: float, first: bool) -> Record:
    """Times of a benchmark's variants on new buffers. first: also check them, and time what is needed only once.

    'seconds.V' is the median time of a call, 'ratio.V' the median over the rounds of the time over the yardstick's in
    the same round: C's, of a transform FFTW's estimate, or a copy's where there is no compiler. Raises `RuntimeError`
    where a variant disagrees with NumPy.
    """
    benchmark = BENCHMARKS[name]
    bench = Bench(benchmark, precision, num_points)
    if first:
        bench.check()
    slow = bench.slow
    variants = {v: runs for v, runs in bench.variants.items() if first or v not in slow}
    times, calls = time_in_turn(variants, bench.restore, seconds, slow)
    times = _fastest_build(times)
    yardstick = next((v for v in ("c", "estimate", "copy") if v in times), "")
    record: Record = {"rounds": len(next(iter(times.values()))), "yardstick": yardstick}
    for variant, values in times.items():
        record[f"seconds.{variant}"] = float(np.nanmedian(values))
        if yardstick:
            record[f"ratio.{variant}"] = float(np.nanmedian(values / times[yardstick]))
    for variant, notes in bench.notes.items():
        record |= {f"seconds.planning.{variant}": notes["plan"]} if "plan" in notes else {}
        record |= {f"measured.{variant}": int(notes["measured"])} if "measured" in notes else {}
    record |= {
        "flops": benchmark.operations(num_points),
        "bytes.traffic": benchmark.traffic(num_points, precision),
        "bytes.working_set": benchmark.working_set(num_points, precision),
    }
    if first and "warp" in bench.variants and len(_CORES) > 1:
        record["ratio.two_cores"] = two_cores(bench, calls["warp"])
    return record


def _fastest_build(times: Times) -> Times:
    """C's builds as one: that with the smallest median."""
    builds = [build for build in BUILDS if build in times]
    if not builds:
        return times
    best = min(builds, key=lambda build: float(np.median(times[build])))
    return {name: values for name, values in times.items() if name not in builds} | {"c": times[best]}


def _seconds(run: Callable[[], object]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


@contextmanager
def pinned() -> Iterator[int]:
    """Keep the calling thread on the last of the usable cores; gives its number, -1 where the system cannot."""
    if not _CORES:
        yield -1
        return
    os.sched_setaffinity(0, _CORES[-1:])
    try:
        yield _CORES[-1]
    finally:
        os.sched_setaffinity(0, _CORES)


def two_cores(bench: Bench, calls: int) -> float:
    """Time of a call while another core does the same on buffers of its own, over that of a call alone."""
    other = Bench(bench.benchmark, bench.precision, bench.num_points, only={"warp"})
    alone = _at_once([bench], calls)
    return _at_once([bench, other], calls) / alone


def _at_once(benches: list[Bench], calls: int) -> float:
    """Median time of a call of the program's variant [s], every bench in a thread on a core of its own."""
    barrier, found = threading.Barrier(len(benches)), [0.0] * len(benches)
    runs = [bench.variants["warp"](calls) for bench in benches]  # Warp records one graph at a time

    def work(index: int) -> None:
        os.sched_setaffinity(0, [_CORES[-1 - index]])
        bench, run = benches[index], runs[index]
        several: list[float] = []
        barrier.wait()
        end = time.perf_counter() + _TOGETHER
        while time.perf_counter() < end or len(several) < _LEAST_ROUNDS:
            bench.restore()
            run()
            several.append(_seconds(run) / calls)
        found[index] = float(np.median(several))

    threads = [threading.Thread(target=work, args=(index,)) for index in range(len(benches))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return float(np.mean(found))
