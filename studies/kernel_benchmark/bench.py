"""A benchmark's buffers with the variants bound to them, and the check that all of them do the same."""

import contextlib
from collections.abc import Iterable

import numpy as np
from linecontact.kernels import CHUNK
from linecontact.solver import checks
from linecontact.solver.transforms.planned import plan_transforms

from . import agreement
from .benchmark import Array, Benchmark
from .benchmarks import ROW
from .shipped import reference_kernels, shipped
from .transforms import without_wisdom
from .variants import Arrays, Runs, Variant, own

UNCHECKED = ("copy", "roof", "roof-unrolled", "transforms")
"""Variants that do something else."""

_SMALL = 2**16  # points
_CODE = "allowed: code that runs, flags that Warp's compiler knows"


class Bench:
    """A benchmark on buffers of its own, staggered as the program's are.

    variants: the ways to do it by name, each from a number of repetitions to a function without arguments; the first
    is the program's. notes: further numbers of a variant, by name; slow: names of those that are timed a few
    times only; threads: of FFTW, by name.
    """

    def __init__(self, benchmark: Benchmark, precision: str, num_points: int, only: Iterable[str] = ()) -> None:
        """only: names of the variants to bind, default all."""
        if num_points % CHUNK and benchmark.group != "transforms":
            raise ValueError(f"size is {num_points}; allowed for {benchmark.name}: a multiple of {CHUNK}")
        self.benchmark, self.precision, self.num_points = benchmark, precision, num_points
        self.transforms = transforms = plan_transforms(num_points, precision, way=benchmark.way)
        self._start = benchmark.make(num_points, precision)
        self.arrays: dict[str, Array] = {}
        for argument in benchmark.arrays:
            size = benchmark.length(argument, num_points)
            if argument.name == "spectrum" and benchmark.transforms:
                self.arrays[argument.name] = transforms.spectrum
            else:
                self.arrays[argument.name] = transforms.buffer(size)[:size] if argument.per_point else np.zeros(size)
        self.variants: dict[str, Runs] = {}
        self.notes: dict[str, dict[str, float]] = {}
        self.slow: set[str] = set()
        self.threads: dict[str, int] = {}
        self._views: dict[str, Arrays] = {}
        wanted = set(only)
        for variant in (*shipped(benchmark), *own(benchmark.name)):
            if (
                (not wanted or variant.name in wanted)
                and num_points % variant.multiple == 0
                and variant.fits(num_points)
            ):
                self._bind(variant, Arrays(benchmark, transforms, self.arrays))
        self._fill(self._start)  # after FFTW's planning, which writes

    def _bind(self, variant: Variant, arrays: Arrays) -> None:
        hidden = self.benchmark.transforms and not variant.wisdom
        what = f"variant {variant.name} of {self.benchmark.name}"
        with without_wisdom() if hidden else contextlib.nullcontext(), checks.own_code(what, _CODE):
            runs = variant.build(arrays)
        if not callable(runs):
            raise ValueError(f"{what} gave {runs!r}; allowed: launched(...) or repeated(...)")
        self.variants[variant.name] = runs
        self._views[variant.name], self.notes[variant.name] = arrays, arrays.notes
        self.slow |= {variant.name} if variant.slow else set()
        self.threads[variant.name] = variant.threads

    def restore(self) -> None:
        """Put the first values back into the buffers whose values change from call to call."""
        changing = [a.name for a in self.benchmark.arrays if a.role in ("inout", "control")]
        self._fill({name: self._start[name] for name in changing})

    def _fill(self, values: dict[str, Array]) -> None:
        for name, given in values.items():
            self.arrays[name][: given.size] = given

    def check(self) -> None:
        """Run every variant once; raises `RuntimeError` where one disagrees with NumPy in a single value.

        On few points a call to do it twice is also compared with two calls.
        """
        start = self.benchmark.make(self.num_points, self.precision, exact=True)
        expected = self._expected(start)
        for name in [name for name in self.variants if expected and name not in UNCHECKED]:
            with checks.own_code(f"variant {name} of {self.benchmark.name}", _CODE):
                found = self._run(name, start, (1,))
            for argument in self.benchmark.arrays:
                if argument.name in expected:
                    agreement.compare(name, argument, found, expected, self.benchmark.transforms)
            if self.num_points <= _SMALL and not self._same_twice(name, start, expected):
                raise RuntimeError(f"{name} does something else when it is told to do it twice")
        self._fill(self._start)

    def _same_twice(self, name: str, start: dict[str, Array], names: Iterable[str]) -> bool:
        once_more = self._run(name, start, (1, 1))
        twice = {array: once_more[array].copy() for array in names}
        once = self._run(name, start, (2,))
        return all(np.array_equal(once[array], twice[array], equal_nan=True) for array in names)

    def _run(self, name: str, start: dict[str, Array], repeats: Iterable[int]) -> dict[str, Array]:
        """The arrays, until the next run, after a variant has been run that often, one after the other."""
        own = self._views[name].arrays
        for argument in self.benchmark.arrays:
            if argument.role in ("out", "sum"):  # values that are not written are seen
                own[argument.name][:] = np.nan
        self._fill({a.name: start[a.name] for a in self.benchmark.arrays if a.role not in ("out", "sum")})
        for count in repeats:
            self.variants[name](count)()
        return own

    def _expected(self, start: dict[str, Array]) -> dict[str, Array]:
        """The right arrays afterwards; of a transform there and back a multiple; nothing for roofs."""
        n, names = self.num_points, list(start)
        first, last = names[0], names[-1]
        if self.benchmark.group == "roofs":
            return {}
        if self.benchmark.group == "transforms":
            length = min(ROW, n // 2) if self.benchmark.name == "rows_pair" else n
            whole = n if first != last else n // 2 // length * length * 2
            return {last: np.concatenate([length * start[first][:whole], start[first][whole:]])}
        view = Arrays(self.benchmark, self.transforms, {name: np.array(array) for name, array in self.arrays.items()})
        for name, values in start.items():
            view.arrays[name][: values.size] = values
        reference_kernels(view)(1)()
        return {name: values for name, values in view.arrays.items() if name != "spectrum" or not self.benchmark.lines}
