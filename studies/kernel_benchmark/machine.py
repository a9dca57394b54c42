"""The origin of results: the measured source, its compiler and flags, and the machine."""

import ctypes
import functools
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from linecontact import kernels, solver
from linecontact.solver.provenance import provenance
from linecontact.solver.transforms import plain

from .benchmark import PRECISIONS
from .benchmarks import BENCHMARKS
from .c_code import REALS, compile_c
from .transforms import LIBRARIES

_CACHES = Path("/sys/devices/system/cpu/cpu0/cache")


@functools.cache
def identity() -> dict[str, str]:
    """The identity that times depend on, as text: results of two identities are never put into one file."""
    import warp as wp

    kernels.load()
    libraries = {name: version(name) for name in ("warp-lang", "numpy", "pyfftw")}
    libraries |= {"FFTW": plain.library(), "Python": platform.python_version()}
    found = {
        "source": source_hash(),
        "flags": kernels.flags(),
        "chunk": str(kernels.CHUNK),
        "compiler": compile_c().compiler,
        "target": wp.get_cpu_kernel_cache_key(cpu_compiler_flags=kernels.flags()),
        "processor": provenance()["processor"],
        "caches": ", ".join(f"{name} {size >> 10} KiB" for name, size in caches().items()),
        "instructions": kernels.instructions(),
    }
    return found | libraries | {name: _version(name) for name in LIBRARIES if name not in libraries}


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:
        return "none"


_SHOWING = ("report.py", "figures.py", "compare.py", "changes.py", "cells.py")  # that measure nothing


def source_hash() -> str:
    """Hash of the source of the kernels, of the transforms and of the measuring code: 12 hexadecimal digits."""
    folders = (kernels.__file__, f"{Path(solver.__file__ or '').parent}/transforms/__init__.py", __file__)
    found = hashlib.sha256()
    for folder in folders:
        for file in sorted(Path(str(folder)).parent.glob("*.py")):
            if file.name in _SHOWING:
                continue
            found.update(file.name.encode() + b"\0" + file.read_bytes())
    return found.hexdigest()[:12]


def key(configuration: dict[str, Any]) -> str:
    """Name of a folder for results of this configuration: 10 hexadecimal digits."""
    return hashlib.sha256(json.dumps(configuration, sort_keys=True).encode()).hexdigest()[:10]


def caches() -> dict[str, int]:
    """Bytes of the first core's data caches by name, as far as known."""
    found = {}
    for index in sorted(_CACHES.glob("index*")):
        try:
            level, kind, size = ((index / name).read_text().strip() for name in ("level", "type", "size"))
            if kind != "Instruction":
                found[f"L{level}"] = int(size.rstrip("KM")) * {"K": 2**10, "M": 2**20}.get(size[-1], 1)
        except (OSError, ValueError):
            continue
    return found


@functools.cache
def vector_widths() -> dict[tuple[str, str], int]:
    """Bits of the widest vectors that a kernel computes with, by kernel and precision, read off its object code.

    Empty where no disassembler is installed, or the processor is none of x86.
    """
    disassembler, found = shutil.which("objdump"), {}
    if disassembler is None or not kernels.instructions().startswith("avx"):
        return {}
    functions: dict[str, str] = {}
    try:
        symbols = _symbols()
    except (AttributeError, ValueError):  # Warp's, and may change
        return {}
    for name, (file, symbol) in symbols.items():
        if file not in functions:
            command = [disassembler, "-d", "--no-show-raw-insn", file]
            functions[file] = subprocess.run(command, capture_output=True, text=True).stdout
        body = re.search(rf"^\w+ <{symbol}_cpu_forward>:\n(.*?)(?:\n\n|\Z)", functions[file], re.MULTILINE | re.DOTALL)
        # packed arithmetic and comparisons; moves and conversions come with every call
        if body is None:
            continue
        packed = re.findall(r"\sv(?:f?n?m?(?:add|sub)|mul|cmp|min|max|sqrt)\w*p[sd]\s.*", body.group(1))
        registers = {register for line in packed for register in re.findall(r"%([xyz])mm", line)}
        found[name] = max(({"x": 128, "y": 256, "z": 512}[register] for register in registers), default=0)
    return found


def _symbols() -> dict[tuple[str, str], tuple[str, str]]:
    """The object file of every kernel in both precisions, and its name there."""
    found = {}
    for name in kernels.KERNELS:
        kernel, per_point = kernels.load()[name], {a.name for a in BENCHMARKS[name].arrays if a.per_point}
        for one in kernel.overloads.values() if kernel.is_generic else (kernel,):
            types = {a.type.dtype.__name__ for a in one.adj.args if a.label in per_point} or {"float64"}
            (compiled,) = one.module.execs.values()
            found[name, types.pop()] = compiled.binary_path, compiled.kernel_names[one]
    return found


def once() -> dict[str, float]:
    """Measured once: how long compiling takes, the widths of vectors, and the processor's largest rates."""
    found = compile_seconds()
    found |= {f"width.{kernel}.{precision}": float(bits) for (kernel, precision), bits in vector_widths().items()}
    found |= {f"peak.{precision}": peak(precision) for precision in PRECISIONS}
    return found | {f"bytes.cache.{name}": float(size) for name, size in caches().items()}


def compile_seconds() -> dict[str, float]:
    """How long Warp takes to compile the kernels into an empty cache, and to load them from a full one [s]."""
    program = "import time; import linecontact.kernels as k; import warp; k.start_warp(); t = time.perf_counter()"
    program += "; k.load(); print(time.perf_counter() - t)"
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in ("cold", "warm"):
            environment = os.environ | {"WARP_CACHE_PATH": folder}
            command = [sys.executable, "-c", program]
            said = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
            found[f"seconds.compile.{name}"] = float(said.split()[-1])
    return found


def peak(precision: str) -> float:
    """The largest rate of floating-point operations of a core in a precision [1/s]; NaN without a compiler."""
    libraries = compile_c().libraries
    if not libraries:
        return float("nan")
    function = getattr(libraries[0].loops, f"peak_{REALS[precision]}")
    function.restype, function.argtypes = ctypes.c_double, [ctypes.c_long, ctypes.POINTER(ctypes.c_double)]
    operations, rates = ctypes.c_double(), []
    for _ in range(9):
        begin = time.perf_counter()
        function(100_000, ctypes.byref(operations))
        rates.append(operations.value / (time.perf_counter() - begin))
    return max(rates)
