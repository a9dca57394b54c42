"""The same loops in C, compiled on the spot: kernels are measured against them."""

import ctypes
import functools
import hashlib
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

from linecontact.kernels import derived, instructions, layout, processor
from linecontact.solver.transforms.wisdom import cache_folder

from .benchmark import READS, Benchmark
from .benchmarks import BENCHMARKS

REALS = {"float32": "float", "float64": "double"}
"""Names of the precisions in C."""

# enough for reordered sums, and no more: -ffast-math would switch denormals off for the whole process
FLAGS = "-O3 -march=native -fassociative-math -fno-signed-zeros -fno-trapping-math -fno-math-errno"

BUILDS = {"c": "", "c-unrolled": "-funroll-loops -mprefer-vector-width=256"}
"""Further flags, by which one loop gains and another loses."""

_PEAK = """
typedef {real} {real}_vector __attribute__((vector_size(WIDTH)));
double peak_{real}(long n, double *operations) {{  // ten chains, because a multiply-add takes several cycles
    {real}_vector a = {{0}}, b = a, c = a, d = a, e = a, f = a, g = a, h = a, k = a, l = a;
    {real}_vector x = a + ({real})0.5, y = a + ({real})0.25;
    for (long i = 0; i < n; i++) {{
        a = a * x + y; b = b * x + y; c = c * x + y; d = d * x + y; e = e * x + y;
        f = f * x + y; g = g * x + y; h = h * x + y; k = k * x + y; l = l * x + y;
        __asm__ volatile("" : KEEP(a), KEEP(b), KEEP(c), KEEP(d), KEEP(e));  // every turn is to be made
        __asm__ volatile("" : KEEP(f), KEEP(g), KEEP(h), KEEP(k), KEEP(l));
    }}
    *operations = 2.0 * 10 * n * (WIDTH / sizeof({real}));
    a = a + b + c + d + e + f + g + h + k + l;
    return a[0];
}}
"""
_WIDTH = """
#if defined(__AVX512F__)
#define WIDTH 64
#elif defined(__AVX__)
#define WIDTH 32
#else
#define WIDTH 16
#endif
#if defined(__SSE2__)
#define KEEP "+x"
#else
#define KEEP "+w"  // vector registers of ARM
#endif
"""


class Library(NamedTuple):
    """The loops of one build."""

    build: str
    """Its name, one of `BUILDS`."""
    loops: ctypes.CDLL


class Compiled(NamedTuple):
    """The compiled library."""

    libraries: list[Library]
    """One for each build that worked; none without a compiler."""
    compiler: str
    """Its version and flags, or why there is none."""


def source() -> str:
    """The C source of all loops in both precisions; a kernel with sums has an inner loop over each chunk.

    Every function takes the arrays, the number of points, how often to do it all again, and a zero: `roof_NAME` moves
    the memory that NAME moves and computes next to nothing.
    """
    lines = ["#include <math.h>", _WIDTH, *(f"#define {n} {v}" for n, v in vars(layout).items() if n.isupper())]
    for real in REALS.values():
        lines += [f"#undef REAL\n#define REAL {real}", _PEAK.format(real=real)]
        for one in BENCHMARKS.values():
            body = one.c_whole or _loop(one, one.c) if one.c or one.c_whole else _calls(one, real)
            if body:
                lines.append(_function(one.name, one, real, body))
            if one.c and one.group == "kernels":
                lines.append(_function(f"roof_{one.name}", one, real, _loop(one, _roof(one))))
    return "\n".join(lines) + "\n"


def _function(name: str, one: Benchmark, real: str, body: str) -> str:
    arguments = ", ".join(
        ("const " if a.role in READS else "")
        + f"{'REAL' if a.per_point else 'double'} *restrict {a.name}{'_out' if a.role == 'sum' else ''}"
        for a in one.arrays
    )
    again = 'for (long again = 0; again < repeats; again++) { __asm__ volatile("" ::: "memory");'
    return (
        f"void {name}_{real}({arguments}, long n, long repeats, double zero) {{\n{again} {one.c_scalars}\n{body} }} }}"
    )


def _calls(one: Benchmark, real: str) -> str:
    """The calls of a sequence, in order; nothing for one with transforms, which are not C's."""
    if one.transforms:
        return ""
    names = {a.name: f"{a.name}_out" if a.role == "sum" else a.name for a in one.arrays}
    calls = ((line.kernel, [names[n] for n in (*line.inputs, *line.outputs)]) for line in one.lines)
    return " ".join(f"{kernel}_{real}({', '.join(given)}, n, 1, zero);" for kernel, given in calls)


def _loop(one: Benchmark, body: str) -> str:
    sums = [(a.name, part) for a in one.arrays if a.role == "sum" for part in range(a.per_chunk)]
    if not sums:
        return f"for (long i = 0; i < n; i++) {{ {body} }}"
    stores = " ".join(f"{name}_out[{part} * (n / CHUNK) + k] = {name}[{part}];" for name, part in sums)
    (name, last) = sums[-1]
    loop = f"for (long k = 0; k < n / CHUNK; k++) {{ REAL {name}[{last + 1}] = {{0}};\n"
    return loop + f"  for (long i = k * CHUNK; i < (k + 1) * CHUNK; i++) {{ {body} }}\n  {stores} }}"


def _roof(one: Benchmark) -> str:
    """A loop's body that reads and writes the same arrays and leaves them as they are."""
    read = " + ".join(f"{a.name}[i]" for a in one.arrays if a.role in ("in", "inout"))
    written = "".join(
        f" {a.name}[i] = {'t' if a.role == 'out' else f'{a.name}[i] + (REAL)zero * t'};"
        for a in one.arrays
        if a.role in ("out", "inout")
    )
    sums = "".join(f" {a.name}[{k}] += t;" for a in one.arrays if a.role == "sum" for k in range(a.per_chunk))
    return f"REAL t = {read};{written}{sums}"


@functools.cache
def compile_c() -> Compiled:
    """The loops of all builds; they are compiled once for a source, a compiler and a processor, and kept."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        return Compiled([], "no C compiler (cc, gcc, clang) found")
    said = subprocess.run([compiler, "--version"], capture_output=True, text=True).stdout
    libraries, trouble = [], ""
    for build, extra in BUILDS.items():
        flags = f"{FLAGS} {extra}".split()
        about = [source(), said, processor(), instructions(), *flags]
        key = hashlib.sha256("\n".join(about).encode()).hexdigest()[:16]
        try:
            libraries.append(Library(build, _loaded(compiler, flags, key)))
        except (OSError, subprocess.CalledProcessError) as error:
            trouble = trouble or " ".join(str(getattr(error, "stderr", "") or error).split())[:200]
    if not libraries:
        return Compiled([], f"C compiler {compiler} failed: {trouble}")
    names = "; ".join(BUILDS[library.build] or "no more" for library in libraries)
    return Compiled(libraries, f"{said.partition(chr(10))[0]}, {FLAGS} and the best of: {names}")


def _loaded(compiler: str, flags: list[str], key: str) -> ctypes.CDLL:
    """The library with this key, from the cache or compiled into it."""
    folder = cache_folder() / "c"
    library = folder / f"{key}.so"
    if not derived.is_whole(library):
        derived.discard(library)
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as temporary:
            code, made = Path(temporary) / "loops.c", Path(temporary) / "loops.so"
            code.write_text(source())
            command = [compiler, *flags, "-shared", "-fPIC", "-o", str(made), str(code), "-lm"]
            subprocess.run(command, capture_output=True, text=True, check=True)
            made.replace(library)
        derived.seal(library)
    return ctypes.CDLL(str(library))
