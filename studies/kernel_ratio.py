"""Two ratios measured in one run: the fused FIRE update against a C loop, and an iteration's cost outside the FFTs.

    python -m linecontact.studies.kernel_ratio [--num-points N] [--repeats R]

The C loop is compiled on the spot (cc -O3 -march=native) and works on the same buffers as the Warp kernel and its NumPy
twin. Agreement is checked before any timing; loading and warm-up are outside; the candidates are timed in turn, so
that a change of the machine's speed hits all of them. Minimum and median over the repeats; trust the ratios, not the
times.
"""

import ctypes
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from linecontact.kernels import CHUNK, Call, layout, padded_length, record
from linecontact.solver import Scene, checks
from linecontact.solver.fire import Fire
from linecontact.solver.problem import Problem
from linecontact.solver.transforms import Transforms
from numpy.typing import NDArray
from rich import box
from rich.console import Console
from rich.table import Table

from . import console

C_SOURCE = """
#define STEP(NAME, REAL) \\
void NAME(const REAL *restrict a, const REAL *restrict h, REAL *restrict u, REAL *restrict v, \\
          REAL mix, REAL gain, REAL dt, long n) { \\
    for (long i = 0; i < n; i++) { \\
        REAL w = mix * v[i] + gain * a[i]; \\
        REAL x = u[i] + dt * w; \\
        int hit = x > h[i]; \\
        u[i] = hit ? h[i] : x; \\
        v[i] = hit ? 0 : w; \\
    } \\
}
STEP(step_float32, float)
STEP(step_float64, double)
"""

MIX, GAIN, DT = 0.9, 0.1, 0.25
Timings = dict[str, list[float]]


@dataclass(frozen=True)
class Options:
    """The fused FIRE update against a C loop, and what an iteration costs outside its transforms."""

    num_points: int = 2**18
    """Grid points, even, at least 1024."""
    repeats: int = 200
    """Timed repeats of each candidate, 3 to 100000."""


def compile_c(folder: Path) -> ctypes.CDLL:
    """The C loops as a library; raises `ValueError` without a compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise ValueError("no C compiler (cc, gcc, clang) found; allowed: a machine with one")
    source, library = folder / "step.c", folder / "step.so"
    source.write_text(C_SOURCE)
    result = subprocess.run(
        [compiler, "-O3", "-march=native", "-shared", "-fPIC", "-o", str(library), str(source)],
        capture_output=True,
        text=True,
    )
    if result.returncode:
        raise ValueError(
            f"C compiler {compiler} failed: {result.stderr.strip()}; allowed: one that takes -march=native"
        )
    return ctypes.CDLL(str(library))


def c_step(library: ctypes.CDLL, arrays: tuple[NDArray[np.floating], ...]) -> Callable[[], None]:
    """The C loop bound to (a, h, u, v)."""
    precision = arrays[0].dtype.name
    real = {"float32": ctypes.c_float, "float64": ctypes.c_double}[precision]
    function = getattr(library, f"step_{precision}")
    function.argtypes = [ctypes.c_void_p] * 4 + [real] * 3 + [ctypes.c_long]
    function.restype = None
    bound = [array.ctypes.data for array in arrays] + [MIX, GAIN, DT, arrays[0].size]
    return lambda: function(*bound)


def step_candidates(
    library: ctypes.CDLL, precision: str, num_points: int
) -> tuple[dict[str, Callable[[], None]], Callable[[], None]]:
    """Warp, C and NumPy steps on one set of buffers, checked to agree, and a function that restores the buffers."""
    transforms = Transforms(num_points, precision)
    a, h, u, v = (transforms.buffer() for _ in range(4))
    rng = np.random.default_rng(0)
    start = [rng.standard_normal(a.size).astype(precision) for _ in range(4)]

    def restore() -> None:
        for array, values in zip((a, h, u, v), start, strict=True):
            array[:] = values
        h[:] += 1
        np.minimum(u, h, out=u)

    state = np.zeros(layout.STATE_LENGTH)
    state[[layout.MIX, layout.GAIN, layout.DT]] = MIX, GAIN, DT
    call = Call("fire_step", (a, h, state), (u, v))
    candidates = {"C": c_step(library, (a, h, u, v)), "Warp": record("warp", [call]), "NumPy": record("numpy", [call])}
    results = {}
    for name, step in candidates.items():
        restore()
        step()
        results[name] = np.concatenate([u, v])
    for name, result in results.items():
        if not np.allclose(result, results["NumPy"], rtol=1e-5, atol=20 * np.finfo(precision).eps):
            raise RuntimeError(f"{name} and NumPy disagree in {precision}")
    restore()
    return candidates, restore


def time_in_turn(candidates: dict[str, Callable[[], None]], repeats: int, restore: Callable[[], None]) -> Timings:
    """Seconds of every repeat by candidate; buffers are restored between rounds so that nothing decays to denormals."""
    seconds: Timings = {name: [] for name in candidates}
    for round_ in range(repeats + 3):
        for name, step in candidates.items():
            restore()
            step()  # warm: the caches hold this candidate's last run, as within an iteration
            begin = time.perf_counter()
            step()
            if round_ >= 3:
                seconds[name].append(time.perf_counter() - begin)
    return seconds


def iteration_parts(precision: str, num_points: int, repeats: int) -> Timings:
    """Seconds of the transforms and of everything else in plain FIRE's iteration."""
    problem = Problem.from_scene(Scene(num_points=num_points, precision=precision))
    state = Fire(problem, Transforms(num_points, precision), 1e-14)
    seconds: Timings = {"FFTs": [], "rest": []}
    for _ in range(repeats + 3):
        spent = dict.fromkeys(seconds, 0.0)
        for kind, part in state.parts():
            begin = time.perf_counter()
            part()
            spent[kind] += time.perf_counter() - begin
        for kind, value in spent.items():
            seconds[kind].append(value)
    return {name: values[3:] for name, values in seconds.items()}


def command(options: Options) -> int:
    """Measure and print; returns the exit status."""
    checks.integer("num_points", options.num_points, "an even integer from 1024 to 2^26", CHUNK, 2**26, 2)
    checks.integer("repeats", options.repeats, "an integer from 3 to 100000", 3, 100_000)
    table = Table(
        box=box.SIMPLE,
        title=f"{options.num_points} points, {padded_length(options.num_points) // CHUNK} chunks, one thread",
        caption="Ratios: of the step over the C loop; of the rest of a plain FIRE iteration over its FFTs.",
        pad_edge=False,
    )
    for heading in ("what", "min\n(us)", "median\n(us)", "ratio of\nminima", "ratio of\nmedians"):
        table.add_column(heading, justify="right", no_wrap=True)
    with tempfile.TemporaryDirectory() as folder:
        library = compile_c(Path(folder))
        for precision in ("float32", "float64"):
            candidates, restore = step_candidates(library, precision, options.num_points)
            _add_rows(table, time_in_turn(candidates, options.repeats, restore), "C", f"{precision} step + wall, ")
            parts = iteration_parts(precision, options.num_points, options.repeats)
            _add_rows(table, parts, "FFTs", f"{precision} iteration, ")
    Console().print(table)
    return 0


def _add_rows(table: Table, seconds: Timings, base: str, what: str) -> None:
    least, middle = min(seconds[base]), float(np.median(seconds[base]))
    for name, values in seconds.items():
        low, median = min(values), float(np.median(values))
        ratios = ("", "") if name == base else (f"{low / least:.2f}", f"{median / middle:.2f}")
        table.add_row(what + name, f"{low * 1e6:.0f}", f"{median * 1e6:.0f}", *ratios)


def main() -> int:
    """Entry point of `python -m linecontact.studies.kernel_ratio`."""
    options = console.parse(Options, None, "python -m linecontact.studies.kernel_ratio", Options.__doc__ or "")
    return console.guard(lambda: command(options))


if __name__ == "__main__":
    sys.exit(main())
