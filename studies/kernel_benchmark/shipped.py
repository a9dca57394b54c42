"""The ways that every benchmark is done in: by Warp as the program does it, one point a thread, by NumPy, and in C."""

import ctypes
import functools
from collections.abc import Callable

import numpy as np
from linecontact import kernels
from linecontact.kernels import CHUNK, Call, reference

from . import transforms
from .benchmark import Benchmark
from .c_code import REALS, Library, compile_c
from .variants import Arrays, Run, Runs, Variant, by_parts, compiled_again, in_turn, own, repeated, warp_lines


def shipped(benchmark: Benchmark) -> list[Variant]:
    """The variants of a benchmark that the program brings; the one that it uses itself first."""
    if benchmark.group == "transforms":
        return transforms.variants(benchmark)
    built = [Variant(library.build, functools.partial(_c, library)) for library in compile_c().libraries]
    if benchmark.group == "roofs":
        return built
    # a thread for each point is what one would write first
    found = [Variant("warp", lambda arrays: warp_lines(arrays, kernels.load())), *built]
    if benchmark.group == "kernels" and benchmark.c:
        found += [Variant("element", lambda arrays: compiled_again(arrays, 1), slow=True)]
        for library in compile_c().libraries:
            name = library.build.replace("c", "roof", 1)
            found.append(Variant(name, functools.partial(_c, library, prefix="roof_")))
    if benchmark.transforms:
        found += [Variant("transforms", _transforms_alone)]
    found += [] if built else [Variant("copy", _copy)]  # without a compiler it is the yardstick
    return [*found, Variant("numpy", reference_kernels, slow=True)]


def check_names(benchmark: Benchmark) -> None:
    """Raise `ValueError` if a user's variant has the name of one of the program's."""
    taken = {one.name for one in shipped(benchmark)} & {one.name for one in own(benchmark.name)}
    if taken:
        raise ValueError(
            f"variant of {benchmark.name} is {min(taken)!r}; allowed: a name that the program does not use"
        )


def reference_kernels(arrays: Arrays) -> Runs:
    """The reference kernels in order, between NumPy's transforms."""
    runs = []
    for line in arrays.benchmark.steps:
        if line.kernel not in kernels.KERNELS:
            runs.append(_numpy_transform(arrays, line))
        else:
            given = (arrays.arrays[name] for name in (*line.inputs, *line.outputs))
            runs.append(functools.partial(getattr(reference, line.kernel), *given))
    return in_turn([repeated(run) for run in runs])


def _numpy_transform(arrays: Arrays, line: Call) -> Run:
    n, source, target = arrays.num_points, arrays.arrays[line.inputs[0]], arrays.arrays[line.outputs[0]]
    pairs = np.result_type(source, np.complex64)

    def forward() -> None:
        modes = np.fft.rfft(source[:n])
        target[: 2 * modes.size] = modes.view(source.dtype)

    def inverse() -> None:
        modes = source[: 2 * (n // 2 + 1)].view(pairs)
        target[:n] = np.fft.irfft(modes, n, norm="forward")

    def product() -> None:
        target[:n] = np.fft.irfft(np.fft.rfft(source[:n]), n)

    if line.kernel == "product":
        return product
    return forward if line.kernel == "forward" else inverse


def _transforms_alone(arrays: Arrays) -> Runs:
    return by_parts(arrays, lambda _: repeated(lambda: None))


def _copy(arrays: Arrays) -> Runs:
    """A copy of half as many bytes as the benchmark's arrays hold, so that it works on as much memory."""
    half = max(CHUNK, sum(a.nbytes for a in arrays.arrays.values()) // 2 // arrays.transforms.dtype.itemsize)
    source, target = arrays.transforms.buffer(half), arrays.transforms.buffer(half)
    source[:] = 1
    return repeated(lambda: np.copyto(target, source))


def _c(library: Library, arrays: Arrays, prefix: str = "") -> Runs:
    """C's loops of one build; a sequence without transforms is one function."""
    if not arrays.benchmark.transforms:
        given = [arrays.arrays[a.name] for a in arrays.benchmark.arrays]
        return _function(library, prefix + arrays.benchmark.name, arrays.precision, given)
    return by_parts(arrays, lambda lines: in_turn([_line(library, line, arrays) for line in lines]))


def _line(library: Library, line: Call, arrays: Arrays) -> Runs:
    given = [arrays.arrays[name] for name in (*line.inputs, *line.outputs)]
    return _function(library, line.kernel, arrays.precision, given)


def _function(library: Library, name: str, precision: str, given: list[np.ndarray]) -> Runs:
    function: Callable[..., None] = getattr(library.loops, f"{name}_{REALS[precision]}")
    function.restype = None  # type: ignore[attr-defined]
    points = given[0].size * CHUNK // kernels.layout.PARTS if name == "fire_control" else given[0].size
    pointers = [ctypes.c_void_p(array.ctypes.data) for array in given]

    def runs(repeats: int) -> Run:
        rest = ctypes.c_long(points), ctypes.c_long(repeats), ctypes.c_double(0.0)
        return functools.partial(function, *pointers, *rest)

    return runs
