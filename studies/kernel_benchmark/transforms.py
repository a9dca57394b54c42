"""Transforms by FFTW's plans, by NumPy, and by other libraries where they are installed."""

import contextlib
import functools
import importlib
import importlib.util
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from linecontact.solver.transforms import wisdom
from linecontact.solver.transforms.device import PLANNING
from linecontact.solver.transforms.four_step import row_length
from linecontact.solver.transforms.plain import pyfftw
from linecontact.solver.transforms.planned import plan_transforms

from .benchmark import Array, Benchmark
from .benchmarks import ROW
from .variants import Arrays, Run, Runs, Variant, in_turn, product, repeated

LIBRARIES = ("numpy", "scipy", "ducc0")
"""Libraries beside FFTW; those that are not installed are left out."""
MOST_SECONDS = 10.0
"""Time that FFTW may take for a plan [s]; its best plan by then is used."""


def variants(benchmark: Benchmark) -> list[Variant]:
    """FFTW by effort and on two threads, the program's four steps, and the other libraries."""
    found = [Variant(effort, functools.partial(_fftw, effort), wisdom=effort != "estimate") for effort in PLANNING]
    found.append(Variant("2-threads", functools.partial(_fftw, "estimate", threads=2), threads=2))
    if benchmark.name == "real_pair":
        found.append(Variant("four-step", _four_step, fits=lambda num_points: row_length(num_points) > 0))
    there = [name for name in LIBRARIES if importlib.util.find_spec(name)]
    return found + [Variant(name, functools.partial(_library, name)) for name in there]


def _steps(arrays: Arrays) -> list[tuple[Array, Array, str]]:
    """The transforms, in order: source, target and the kind of transform."""
    n = arrays.num_points
    complex_type = np.result_type(arrays.transforms.dtype, np.complex64)
    if arrays.benchmark.name == "real_pair":
        modes = arrays.spectrum[: 2 * (n // 2 + 1)].view(complex_type)
        return [(arrays.source[:n], modes, "r2c"), (modes, arrays.target[:n], "c2r")]
    values = arrays.rows[: n // 2 * 2].view(complex_type)
    row = min(ROW, values.size)
    values = values[: values.size // row * row].reshape(-1, row)
    return [(values, values, "forward"), (values, values, "backward")]


def _fftw(effort: str, arrays: Arrays, threads: int = 1) -> Runs:
    """Plans of one effort, from wisdom if it holds them; those that are measured are kept."""
    wisdom.load()
    known, begin = pyfftw.export_wisdom(), time.perf_counter()
    plans = [_plan(step, effort, threads) for step in _steps(arrays)]
    arrays.notes["plan"] = time.perf_counter() - begin
    arrays.notes["measured"] = measured = effort != "estimate" and pyfftw.export_wisdom() != known
    if measured:
        wisdom.save()
    return in_turn([repeated(plan) for plan in plans])


@contextlib.contextmanager
def without_wisdom() -> Iterator[None]:
    """FFTW knows nothing of earlier plans meanwhile, which an estimate would make use of."""
    wisdom.load()
    known = pyfftw.export_wisdom()
    pyfftw.forget_wisdom()
    try:
        yield
    finally:
        pyfftw.import_wisdom(known)


def _four_step(arrays: Arrays) -> Runs:
    """The program's own way for long ones, with its multiplication in between."""
    transforms = plan_transforms(arrays.num_points, arrays.precision, way="four-step")
    return repeated(product(transforms, arrays.source, arrays.target, arrays.num_points))


def _plan(step: tuple[Array, Array, str], effort: str, threads: int) -> Run:
    source, target, kind = step
    own = [f"FFTW_{effort.upper()}", *(["FFTW_DESTROY_INPUT"] if kind == "c2r" else [])]
    direction = "FFTW_BACKWARD" if kind in ("c2r", "backward") else "FFTW_FORWARD"
    limit = None if effort == "estimate" else MOST_SECONDS
    plan = pyfftw.FFTW(
        source, target, axes=(-1,), direction=direction, flags=own, threads=threads, planning_timelimit=limit
    )
    run: Run = plan.execute
    return run


def _library(name: str, arrays: Arrays) -> Runs:
    transform = {"numpy": _by_numpy, "scipy": _by_scipy, "ducc0": _by_ducc}[name]
    return in_turn([repeated(transform(*step)) for step in _steps(arrays)])


def _by_numpy(source: Array, target: Array, kind: str) -> Run:
    if kind == "r2c":
        return lambda: np.fft.rfft(source, out=target)
    if kind == "c2r":
        return lambda: np.fft.irfft(source, target.size, norm="forward", out=target)
    function = np.fft.fft if kind == "forward" else functools.partial(np.fft.ifft, norm="forward")
    return lambda: function(source, out=target)


def _by_scipy(source: Array, target: Array, kind: str) -> Run:
    fft = importlib.import_module("scipy.fft")
    functions: dict[str, Callable[[], Any]] = {
        "r2c": lambda: fft.rfft(source),
        "c2r": lambda: fft.irfft(source, target.size, norm="forward"),
        "forward": lambda: fft.fft(source, overwrite_x=True),
        "backward": lambda: fft.ifft(source, norm="forward", overwrite_x=True),
    }

    def run() -> None:
        result = functions[kind]()
        if result is not target:
            target[...] = result

    return run


def _by_ducc(source: Array, target: Array, kind: str) -> Run:
    fft = importlib.import_module("ducc0.fft")
    if kind == "r2c":
        return lambda: fft.r2c(source, out=target)
    if kind == "c2r":
        return lambda: fft.c2r(source, lastsize=target.size, forward=False, out=target)
    axes = (source.ndim - 1,)
    return lambda: fft.c2c(source, axes=axes, forward=kind == "forward", out=target)
