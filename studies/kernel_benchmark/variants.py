"""Ways to do the work of a benchmark, and how to add one of your own.

    from linecontact.studies.kernel_benchmark.variants import launched, recompiled, variant

    recompiled("fire_step", "chunk-4096", chunk=4096)

    @variant("fire_step")
    def mine(a):
        return launched([(my_kernel, a.num_points // 256, [a.acceleration, a.h, a.state], [a.u, a.v])])

A variant gets the benchmark's arrays and gives a function that, told how often, gives the function that is timed:
`launched` records launches of Warp kernels, `repeated` calls a Python function. Before it is timed it is checked: on
values for which no kernel rounds anything it must give exactly the reference kernel's result. A file with more of
them is docs/examples/kernel_variants.py.
"""

import copy
import functools
import importlib.util
import itertools
import os
import re
import sys
import traceback
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from linecontact import kernels
from linecontact.kernels import CHUNK, Call
from linecontact.solver import checks
from linecontact.solver.transforms.backend import Transforms
from linecontact.solver.transforms.device import check_settings

from .benchmark import Array, Benchmark
from .benchmarks import BENCHMARKS

Run = Callable[[], object]
Runs = Callable[[int], Run]
"""From how often to do it to a function that does it that often."""
Launch = tuple[Any, int, Sequence[Array], Sequence[Array]]
"""A Warp kernel, its number of threads, the arrays that it reads and those that it writes."""


class Arrays:
    """The arrays of a benchmark as attributes, by their names, with their benchmark: NumPy arrays, which Warp shares.

    One value per point, in `precision`, for `num_points` points; sums have one float64 per `chunk` points, or several.
    """

    def __init__(self, benchmark: Benchmark, transforms: Transforms, arrays: dict[str, Array]) -> None:
        self.benchmark, self.transforms, self.chunk = benchmark, transforms, CHUNK
        self.num_points, self.precision = transforms.num_points, transforms.dtype.name
        self.arrays = dict(arrays)
        self.notes: dict[str, float] = {}
        """Further numbers of a variant: 'plan', the time to plan its transforms [s]; 'measured', 1 if plans
        were measured for that."""

    def __getattr__(self, name: str) -> Array:
        try:
            return self.__dict__["arrays"][name]  # type: ignore[no-any-return]
        except KeyError:
            there = ", ".join(self.__dict__.get("arrays", ()))
            raise AttributeError(f"benchmark {self.benchmark.name} has no array {name!r}; allowed: {there}") from None


@dataclass(frozen=True)
class Variant:
    """A way to do the work of a benchmark."""

    name: str
    """As it stands in tables."""
    build: Callable[[Arrays], Runs]
    """Makes it for arrays; it may put others in their place, for sums over chunks of another length."""
    slow: bool = False
    """Whether it is timed a few times only."""
    threads: int = 1
    """Of FFTW."""
    wisdom: bool = False
    """Whether FFTW may use earlier plans, as plans by measurement do."""
    multiple: int = 1
    """The number of points must be a multiple of this; on other numbers the variant is not measured."""
    fits: Callable[[int], bool] = lambda num_points: True
    """Whether a number of points is measured."""


OWN: dict[str, list[Variant]] = {}
"""The variants that users' files have registered, by benchmark."""


def own(benchmark: str) -> list[Variant]:
    """The variants of a benchmark that users' files have registered."""
    return OWN.get(benchmark, [])


def variant(benchmark: str, name: str | None = None) -> Callable[[Callable[[Arrays], Runs]], Callable[[Arrays], Runs]]:
    """Decorator: register a way to do a benchmark. name: as it stands in tables, default the function's.

    Raises `ValueError` for a benchmark that there is not, and for a name that is taken.
    """
    checks.choice("benchmark", benchmark, tuple(BENCHMARKS))

    def register(build: Callable[[Arrays], Runs]) -> Callable[[Arrays], Runs]:
        _register(benchmark, Variant(name or build.__name__, build))
        return build

    return register


def recompiled(benchmark: str, name: str, chunk: int = CHUNK, compiled_with: str | None = None) -> None:
    """Register the kernels of a benchmark compiled in another way.

    chunk: points per thread, a power of two up to 16384, beyond which sums are not exact in the check; compiled_with:
    all flags of Warp's compiler, default the program's.

    Raises `ValueError` for a benchmark that there is not, a name that is taken, and any other chunk.
    """
    checks.choice("benchmark", benchmark, tuple(BENCHMARKS))
    chunk = checks.integer("chunk", chunk, "a power of two up to 16384", 1, 2**14)
    if chunk & (chunk - 1):
        raise ValueError(f"chunk is {chunk}; allowed: a power of two up to 16384")
    _register(benchmark, Variant(name, lambda arrays: compiled_again(arrays, chunk, compiled_with), multiple=chunk))


def compiled_again(arrays: Arrays, chunk: int, compiled_with: str | None = None) -> Runs:
    """Launches of a benchmark's kernels, compiled with another chunk, of which num_points is a multiple, and flags."""
    if chunk != CHUNK:
        arrays.chunk = chunk
        for argument in arrays.benchmark.arrays:
            if argument.role == "sum":
                arrays.arrays[argument.name] = np.zeros(argument.per_chunk * arrays.num_points // chunk)
    names = {line.kernel for line in arrays.benchmark.steps} & set(kernels.KERNELS)  # and no transforms
    return warp_lines(arrays, kernels.recompile(names, chunk, compiled_with))


def replanned(benchmark: str, name: str, planning: str = "estimate", threads: int = 1) -> None:
    """Register a benchmark with FFTW's transforms planned in another way, see `Transforms`. Raises `ValueError`."""
    checks.choice("benchmark", benchmark, tuple(one.name for one in BENCHMARKS.values() if one.transforms))
    threads, planning = check_settings(threads, planning)

    def build(arrays: Arrays) -> Runs:
        arrays.transforms = again = copy.copy(arrays.transforms)  # on the same buffers
        if again.way == "four-step":
            raise ValueError("way is 'four-step'; allowed: 'real', whose plans are made anew")
        again.threads, again.planning = threads, planning
        return warp_lines(arrays, kernels.load())

    _register(benchmark, Variant(name, build, threads=threads, wisdom=planning != "estimate"))


def _register(benchmark: str, new: Variant) -> None:
    if not re.fullmatch("[A-Za-z0-9_-]+", new.name):
        raise ValueError(f"variant is {new.name!r}; allowed: a name of letters, digits, _ and -")
    if new.name in {one.name for one in own(benchmark)}:
        raise ValueError(f"variant {new.name!r} of {benchmark} is there already; allowed: another name")
    OWN.setdefault(benchmark, []).append(new)


def load_file(path: Path) -> None:
    """Run a user's file of variants, once. Raises `ValueError` for one that is missing, or fails."""
    if not os.path.isfile(path):
        raise ValueError(
            f"variants is {path}, which is not a file; allowed: an existing Python file that registers variants"
        )
    _run_file(path.resolve())


@functools.cache
def _run_file(path: Path) -> None:
    name = f"variants_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ValueError(f"variants is {path}; allowed: a Python file, with .py at the end of its name")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # Warp looks for the source there
    kernels.start_warp()  # in silence
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        where = f"line {lines[-1]}: " if lines else ""
        said = str(error) if "allowed: " in str(error) else f"{type(error).__name__}: {error}; allowed: code that runs"
        raise ValueError(f"variants: file {path}: {where}{said}") from error


def repeated(run: Run) -> Runs:
    """The result of a variant for a Python function that does it once."""

    def runs(repeats: int) -> Run:
        if repeats == 1:
            return run

        def again() -> None:
            for _ in range(repeats):
                run()

        return again

    return runs


def launched(launches: Iterable[Launch]) -> Runs:
    """A variant's result for launches of Warp kernels: all of them, as often as asked for, in one recorded graph."""
    shared = [(k, n, [kernels.share(x) for x in i], [kernels.share(x) for x in o]) for k, n, i, o in launches]
    return lambda repeats: kernels.record_launches(shared, repeats)


def in_turn(parts: Sequence[Runs]) -> Runs:
    """Several things one after the other."""
    if len(parts) == 1:
        return parts[0]
    singles = [part(1) for part in parts]

    def run() -> None:
        for single in singles:
            single()

    return repeated(run)


def warp_lines(arrays: Arrays, compiled: dict[str, Any]) -> Runs:
    """A benchmark's kernels in order, recorded, between its transforms. compiled: Warp's kernels by name."""
    return by_parts(arrays, lambda lines: launched(_launches(lines, arrays, compiled)))


def by_parts(arrays: Arrays, make: Callable[[list[Call]], Runs]) -> Runs:
    """A benchmark's transforms as the program plans them, and the result of `make` for the kernels between them."""
    parts: list[Runs] = []
    for is_kernel, group in itertools.groupby(arrays.benchmark.steps, lambda line: line.kernel in kernels.KERNELS):
        lines = list(group)
        parts += [make(lines)] if is_kernel else [repeated(_plan(arrays, line)) for line in lines]
    return in_turn(parts)


def _plan(arrays: Arrays, line: Call) -> Run:
    source, target = arrays.arrays[line.inputs[0]], arrays.arrays[line.outputs[0]]
    if line.kernel == "product":
        return product(arrays.transforms, source, target)
    return arrays.transforms.forward(source) if line.kernel == "forward" else arrays.transforms.inverse(target)


def product(transforms: Transforms, source: Array, target: Array, factor: float = 1.0) -> Run:
    """A transform there and back with a multiplication by a factor in between."""
    symbol = np.full(transforms.num_points // 2 + 1, factor)
    parts = transforms.forward(source), transforms.multiplication(symbol), transforms.inverse(target)

    def run() -> None:
        for part in parts:
            part()

    return run


def _launches(lines: Iterable[Call], arrays: Arrays, compiled: dict[str, Any]) -> list[Launch]:
    found: list[Launch] = []
    for line in lines:
        inputs, outputs = ([arrays.arrays[n] for n in names] for names in (line.inputs, line.outputs))
        threads = 1 if line.kernel == "fire_control" else inputs[0].size // arrays.chunk
        found.append((compiled[line.kernel], threads, inputs, outputs))
    return found
