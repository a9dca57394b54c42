"""The ways to run a kernel, on one set of buffers: Warp three times, the NumPy twin, and C compiled on the spot."""

import ctypes
import functools
import shutil
import subprocess
import tempfile
import timeit
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from linecontact import kernels
from linecontact.kernels import CHUNK, Call, layout
from linecontact.solver.transforms.planned import Transforms

from .specs import READS, SPECS, Array, Spec

PRECISIONS = {"float32": "float", "float64": "double"}
"""With C's names."""

VARIANTS = ("numpy", "warp-element", "warp-launch", "warp-graph", "c")
"""The twin; one thread per element; per chunk by wp.launch; per chunk, recorded; a C loop."""

# what reordered sums need, and no more: -ffast-math would switch denormals off for the whole process
FLAGS = "-O3 -march=native -fassociative-math -fno-signed-zeros -fno-trapping-math -fno-math-errno"

BUILDS = ("", "-mprefer-vector-width=256", "-funroll-loops")
"""Further flags, by which one loop gains and another loses."""

Candidates = dict[str, Callable[[], None]]


def c_source() -> str:
    """The C source of all loops in both precisions; a kernel with sums has an inner loop over each chunk."""
    lines = [f"#define {n} {v}" for n, v in vars(layout).items() if n.isupper()]
    for real in PRECISIONS.values():
        lines += [f"#undef REAL\n#define REAL {real}", *(_function(name, spec, real) for name, spec in SPECS.items())]
    return "\n".join(lines) + "\n"


def _function(name: str, spec: Spec, real: str) -> str:
    if not spec.c:
        return ""
    sums = [a.name for a in spec.arrays if a.role == "sum"]
    arguments = ", ".join(
        ("const " if a.role in READS else "")
        + f"{'REAL' if a.per_point else 'double'} *restrict {a.name}{'_out' if a.role == 'sum' else ''}"
        for a in spec.arrays
    )
    body = f"{{ {spec.c} }}"
    if sums:
        scalars, stores = ", ".join(f"{s} = 0" for s in sums), " ".join(f"{s}_out[k] = {s};" for s in sums)
        loop = f"for (long k = 0; k < n / CHUNK; k++) {{ REAL {scalars};\n"
        loop += f"  for (long i = k * CHUNK; i < (k + 1) * CHUNK; i++) {body}\n  {stores} }}"
    else:
        loop = f"for (long i = 0; i < n; i++) {body}"
    return f"void {name}_{real}({arguments}, long n) {{ {spec.c_scalars}\n{loop} }}"


@functools.cache
def compile_c() -> tuple[list[ctypes.CDLL], str]:
    """The C loops as one library for each build, and the compiler with its flags; without one, the reason."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        return [], "no C compiler (cc, gcc, clang) found"
    libraries: list[ctypes.CDLL] = []
    flags, trouble = [], ""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "kernels.c"
        source.write_text(c_source())
        for extra in BUILDS:
            library = Path(folder) / f"kernels{len(libraries)}.so"
            command = [compiler, *FLAGS.split(), *extra.split(), "-shared", "-fPIC", "-o", str(library), str(source)]
            result = subprocess.run(command, capture_output=True, text=True)
            if result.returncode == 0:
                libraries.append(ctypes.CDLL(str(library)))
                flags.append(extra or "no more")
            else:
                trouble = trouble or " ".join(result.stderr.split())[:200]
    if not libraries:
        return [], f"C compiler {compiler} failed: {trouble}"
    version = subprocess.run([compiler, "--version"], capture_output=True, text=True).stdout.partition("\n")[0]
    return libraries, f"{version}, {FLAGS} and the best of: {'; '.join(flags)}"


def _bind_c(kernel: str, arrays: list[Array], num_points: int, precision: str) -> Candidates:
    """The C loop of the build that is fastest in a short trial; nothing without a compiler."""
    bound = [*(ctypes.c_void_p(array.ctypes.data) for array in arrays), ctypes.c_long(num_points)]
    functions = []
    for library in compile_c()[0] if SPECS[kernel].c else []:
        function = getattr(library, f"{kernel}_{PRECISIONS[precision]}")
        function.restype = None
        functions.append(functools.partial(function, *bound))
    fastest = min(functions, key=lambda f: min(timeit.repeat(f, number=1, repeat=9)), default=None)
    return {"c": fastest} if fastest else {}


@functools.cache
def load() -> dict[str, Any]:
    """Compile or fetch all Warp kernels, those of one thread per element among them; the others by name."""
    loaded = kernels.load()
    import warp as wp

    from . import elements

    for name, spec in SPECS.items():
        for precision in PRECISIONS if hasattr(elements, name) else ():
            types = [wp.array(dtype=getattr(wp, a.dtype(precision))) for a in spec.arrays]
            wp.overload(getattr(elements, name), types)
    wp.load_module(elements, device="cpu")
    return loaded


def _bind_warp(kernel: str, arrays: list[Array], num_points: int) -> Candidates:
    """The kernel in chunks by wp.launch, and with one thread per element as a recorded graph."""
    import warp as wp

    from . import elements

    loaded = load()
    shared = [wp.array(x, dtype=getattr(wp, x.dtype.name), copy=False, device="cpu") for x in arrays]
    count = sum(a.role in READS for a in SPECS[kernel].arrays)
    inputs, outputs = shared[:count], shared[count:]
    chunked, threads = loaded[kernel], num_points // CHUNK if SPECS[kernel].c else 1

    def launch() -> None:
        wp.launch(chunked, dim=threads, inputs=inputs, outputs=outputs, device="cpu")

    found: Candidates = {"warp-launch": launch}
    if hasattr(elements, kernel):
        with wp.ScopedCapture(device="cpu") as capture:
            wp.launch(getattr(elements, kernel), dim=num_points, inputs=inputs, outputs=outputs, device="cpu")
        graph = capture.graph
        found["warp-element"] = lambda: wp.capture_launch(graph)
    return found


class Bench:
    """A kernel's buffers, staggered, with the candidates bound to them, and a copy of as many bytes.

    `candidates` holds them by name, the copy as 'copy'; `restore` puts back what they change.
    """

    def __init__(self, kernel: str, precision: str, num_points: int) -> None:
        self.spec, self.precision, self.num_points = SPECS[kernel], precision, num_points
        self._start = self.spec.make(num_points, precision)
        transforms = Transforms(num_points, precision)
        self.arrays = [
            transforms.buffer() if argument.per_point else np.zeros_like(values)
            for argument, values in zip(self.spec.arrays, self._start, strict=True)
        ]
        for array, values in zip(self.arrays, self._start, strict=True):
            array[:] = values
        count = sum(a.role in READS for a in self.spec.arrays)
        call = Call(kernel, tuple(self.arrays[:count]), tuple(self.arrays[count:]))
        found = _bind_warp(kernel, self.arrays, num_points)
        found |= {f: kernels.record(b, [call]) for f, b in (("warp-graph", "warp"), ("numpy", "numpy"))}
        found |= _bind_c(kernel, self.arrays, num_points, precision)
        half = max(CHUNK, self.spec.working_set(num_points, precision) // 2 // np.dtype(precision).itemsize)
        source, target = transforms.buffer(half), transforms.buffer(half)
        source[:] = 1
        self.copied_bytes = 2 * source.nbytes
        self.candidates = {v: found[v] for v in VARIANTS if v in found} | {"copy": lambda: np.copyto(target, source)}
        self.restore()  # after the builds' trial

    def restore(self) -> None:
        """Put the first values back into all buffers that are written."""
        for argument, array, values in zip(self.spec.arrays, self.arrays, self._start, strict=True):
            if argument.role not in READS:
                array[:] = values

    def check(self) -> None:
        """Run every candidate once; raises `RuntimeError` where one disagrees with the twin."""
        self._run("numpy")
        expected = [array.copy() for array in self.arrays]
        for name in self.candidates.keys() - {"numpy", "copy"}:
            self._run(name)
            for argument, array, values in zip(self.spec.arrays, self.arrays, expected, strict=True):
                wrong = self._disagreeing(argument.role, array, values)
                if wrong:
                    raise RuntimeError(f"{name} and numpy disagree in {wrong} values of {argument.name}")

    def _run(self, name: str) -> None:
        self.restore()
        self.candidates[name]()

    def _disagreeing(self, role: str, array: Array, expected: Array) -> int:
        """Number of values off by more than rounding, 0 if as few as rounding explains.

        Values below 10 are two roundings apart; sums of CHUNK of them, added one after the other, up to CHUNK eps of
        the sum of their magnitudes, which is 20 CHUNK at most or, of squares, the sum itself; what is made of the sums
        of all chunks, an eps a chunk. A node so near the wall, or a bound, that rounding decides its side differs
        wholly: one in 1/(100 eps) may.
        """
        eps = float(np.finfo(self.precision).eps)
        bound = {"sum": 20 * CHUNK * eps, "control": self.num_points / CHUNK * 1e-15}.get(role, 20 * eps)
        share = CHUNK * eps if role == "sum" else 4 * eps
        wrong = int(np.count_nonzero(~(np.abs(array - expected) <= bound + share * np.abs(expected))))
        return wrong if wrong > 100 * eps * self.num_points else 0
