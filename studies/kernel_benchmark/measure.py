"""Times of a benchmark's variants: in turn, pinned to one core, checked to agree before."""

import contextlib
import math
import os
import threading
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .bench import Bench
from .benchmarks import BENCHMARKS
from .c_code import BUILDS
from .cores import CORES, another_core, unpinned
from .variants import Runs

Record = dict[str, Any]
ROOFS = ("roof", "roof-unrolled")
"""Names of the builds of the loop that only moves memory."""

Times = dict[str, NDArray[np.float64]]

_SPAN, _MOST_CALLS = 1e-4, 300  # s that are timed at once, and calls after which in-place results still are ordinary
_LEAST_ROUNDS, _SLOW_ROUNDS = 6, 1
_TOGETHER = 0.02  # s that cores work at once
_PATIENCE = 300.0  # s that one core waits for another


def time_in_turn(
    variants: Mapping[str, Runs],
    restore: Callable[[], None],
    seconds: float,
    slow: Collection[str] = (),
    several: Collection[str] = (),
) -> tuple[Times, dict[str, int]]:
    """Time variants in turn: seconds of a call in every round, NaN where it was left out, and calls timed at once.

    restore: puts the buffers back; seconds: to spend in all; slow: variants that are timed in the first rounds only;
    several: those that may use all cores.

    They take turns, so that a change of the machine's speed hits all of them, in an order that changes from round to
    round, because who comes after whom matters to the caches. Before each is timed it runs untimed, so that the caches
    hold the results of its own runs. The buffers are restored before they have been worked on so often that numbers
    overflow, or decay to denormals, which take longer.
    """
    restore()
    calls = {name: _calls(variant, restore) for name, variant in variants.items()}
    runs = {name: variant(calls[name]) for name, variant in variants.items()}
    found: dict[str, list[float]] = {name: [] for name in variants}
    rng, rounds, done, end = np.random.default_rng(0), 0, _MOST_CALLS, time.perf_counter() + seconds
    while rounds < _LEAST_ROUNDS or time.perf_counter() < end:
        for name in rng.permutation(list(variants)):
            if rounds >= _SLOW_ROUNDS and name in slow:
                found[name].append(np.nan)
                continue
            if done + calls[name] > _MOST_CALLS:
                restore()
                done = 0
            done += 2 * calls[name]
            with unpinned() if name in several else contextlib.nullcontext():
                if name not in slow or calls[name] > 1:
                    runs[name]()
                found[name].append(_seconds(runs[name]) / calls[name])
        rounds += 1
    return {name: np.array(values) for name, values in found.items()}, calls


def _calls(variant: Runs, restore: Callable[[], None]) -> int:
    """How many calls take as long as is timed at once; starting them takes time, too, so more are tried and more."""
    count = 1
    while True:
        run = variant(count)
        took = _seconds(run)
        if took < 100 * _SPAN:
            took = _seconds(run)
        if took >= _SPAN or count >= _MOST_CALLS:
            return count
        count = min(
            _MOST_CALLS, 2 * count if took <= 0 else int(np.clip(1.2 * count * _SPAN / took, 2 * count, 10 * count))
        )
        restore()


def measure(name: str, precision: str, num_points: int, seconds: float, first: bool) -> Record:
    """Times of a benchmark's variants on new buffers. first: also check them, and time their preparation.

    'seconds.V' is the median time of a call, 'ratio.V' the median over the rounds of the time over the yardstick's in
    the same round: C's, of a transform FFTW's estimate, or a copy's where there is no compiler. Raises `RuntimeError`
    where a variant disagrees with NumPy.
    """
    benchmark = BENCHMARKS[name]
    bench = Bench(benchmark, precision, num_points)
    _check(bench, first)
    slow = bench.slow
    variants = {v: runs for v, runs in bench.variants.items() if first or v not in slow}
    several = {name for name, threads in bench.threads.items() if threads > 1}
    with np.errstate(over="ignore", invalid="ignore"):  # pairs in place grow with every call
        times, calls = time_in_turn(variants, bench.restore, seconds, slow, several)
    times = _fastest(_fastest(times, tuple(BUILDS)), ROOFS)
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
    if first and "warp" in bench.variants:
        record["ratio.two_cores"] = two_cores(bench, calls["warp"])
    return record


_wrong: dict[tuple[str, str, int], str] = {}  # found by the check in this process


def _check(bench: Bench, first: bool) -> None:
    """Check the variants once; wrong ones are not timed in later repetitions either. Raises `RuntimeError`."""
    key = bench.benchmark.name, bench.precision, bench.num_points
    if first:
        _wrong.pop(key, None)
        try:
            bench.check()
        except RuntimeError as error:
            _wrong[key] = f"{key[0]} in {key[1]} on {key[2]} points: {error}"
    if key in _wrong:
        raise RuntimeError(_wrong[key])


def _fastest(times: Times, builds: Sequence[str]) -> Times:
    """Times with several builds of one loop as one, under the first one's name: that with the smallest median."""
    there = [build for build in builds if build in times]
    if not there:
        return times
    best = min(there, key=lambda build: float(np.median(times[build])))
    return {name: values for name, values in times.items() if name not in there} | {builds[0]: times[best]}


def _seconds(run: Callable[[], object]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


def two_cores(bench: Bench, calls: int) -> float:
    """Time of a call while another core does the same on buffers of its own, over that of a call alone.

    NaN where there is no other core. Two threads of one process, which hand the interpreter to each other now and then.
    """
    core = another_core()
    if core is None:
        return math.nan
    other = Bench(bench.benchmark, bench.precision, bench.num_points, only={"warp"})
    benches = {CORES[-1]: bench, core: other}
    runs = {core: bench.variants["warp"](calls) for core, bench in benches.items()}
    alone = _at_once({CORES[-1]: bench}, runs)
    return _at_once(benches, runs) / alone


def _at_once(benches: Mapping[int, Bench], runs: Mapping[int, Callable[[], object]]) -> float:
    """Mean of the median times of the runs of some benches [s], each in a thread on its core."""
    barrier, found = threading.Barrier(len(benches)), dict.fromkeys(benches, math.nan)

    def work(core: int) -> None:
        os.sched_setaffinity(0, [core])
        times: list[float] = []
        barrier.wait(_PATIENCE)
        end = time.perf_counter() + _TOGETHER
        while time.perf_counter() < end or len(times) < _LEAST_ROUNDS:
            benches[core].restore()
            runs[core]()
            times.append(_seconds(runs[core]))
        found[core] = float(np.median(times))

    threads = [threading.Thread(target=work, args=(core,)) for core in benches]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return float(np.mean(list(found.values())))
