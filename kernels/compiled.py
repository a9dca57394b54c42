"""The Warp kernels, compiled: as the program uses them, or with another chunk and other flags for an experiment."""

import functools
import hashlib
import importlib.util
import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

from .layout import CHUNK

KERNELS = (
    "spectral_multiply",
    "mirror_multiply",
    "net_force",
    "search_sums",
    "restrict_to_free",
    "fire_control",
    "fire_step",
    "plain_sums",
    "plain_step",
    "advance_response",
    "count_below",
    "rest_on_wall",
)
MODULES = ("warp_fields", "warp_fire")
"""The modules that they are in."""

_logger = logging.getLogger("linecontact.kernels")


@functools.cache
def load() -> dict[str, Any]:
    """Compile every kernel in both precisions, or fetch it from Warp's kernel cache; Warp's kernels by name.

    Raises `ValueError` if the cache cannot be used.
    """
    start_warp()
    return compile_modules([importlib.import_module(f"{__package__}.{name}") for name in MODULES])


@functools.cache
def recompile(chunk: int = CHUNK, flags: str | None = None) -> dict[str, Any]:
    """The same kernels from the same source, with `chunk` points per thread and the compiler's flags `flags`.

    chunk: a power of two; flags: all of them, default the program's. Raises `ValueError` like `load`.
    """
    start_warp()
    import warp as wp

    copies = []
    which = f"{chunk}_{'' if flags is None else hashlib.sha256(flags.encode()).hexdigest()[:8]}"
    for name in MODULES:
        original = importlib.import_module(f"{__package__}.{name}")
        copy = _copy_of(original, f"{original.__name__}_{which}")
        vars(copy)["CHUNK_LENGTH"] = wp.constant(chunk)
        if "HALF_CHUNK" in vars(copy):
            vars(copy)["HALF_CHUNK"] = wp.constant(chunk // 2)
        if flags is not None:
            wp.set_module_options({"cpu_compiler_flags": flags}, copy)
        copies.append(copy)
    return compile_modules(copies)


def flags() -> str:
    """The compiler's flags for the kernels, all of them."""
    from .warp_options import OPTIONS

    return str(OPTIONS["cpu_compiler_flags"])


def compile_modules(modules: list[ModuleType]) -> dict[str, Any]:
    """Warp's kernels by name, in both precisions, of modules that hold the kernels under the program's names."""
    import warp as wp

    kernels = {name: vars(module)[name] for module in modules for name in KERNELS if name in vars(module)}
    for kernel in kernels.values():
        if kernel.is_generic:
            arguments = {a.label: a.type for a in kernel.adj.args}
            for real in (wp.float32, wp.float64):
                types = {k: wp.array(dtype=real) if t.dtype is Any else t for k, t in arguments.items()}
                wp.overload(kernel, types)
    if "advance_response" in kernels:
        single, double, state = wp.array(dtype=wp.float32), wp.array(dtype=wp.float64), wp.array(dtype=wp.float64)
        wp.overload(kernels["advance_response"], {"change": single, "state": state, "response": double})
    cold = [module for module in modules if not _is_compiled(module.__name__)]
    if cold:
        _logger.warning("linecontact: compiling kernels for this processor, once; this takes some seconds")
    for module in modules:
        wp.load_module(module, device="cpu")
    return kernels


def _is_compiled(module: str) -> bool:
    """Whether Warp's cache holds this module for the CPU, where blocks are of one thread."""
    import warp as wp

    folder = Path(str(wp.config.kernel_cache_dir)) / wp.get_module(module).get_module_identifier(1)
    return any(folder.glob("*.o"))


def _copy_of(module: ModuleType, name: str) -> ModuleType:
    """A module with the same source under another name, so that Warp compiles it anew."""
    spec = importlib.util.spec_from_file_location(name, module.__file__)
    if spec is None or spec.loader is None:
        raise ImportError(f"module {module.__name__} has no source file")
    copy = importlib.util.module_from_spec(spec)
    sys.modules[name] = copy
    spec.loader.exec_module(copy)
    return copy


@functools.cache
def start_warp() -> None:
    """Import and initialise Warp. Raises `ValueError` if its kernel cache cannot be used."""
    import warp as wp  # takes as long as everything else together, and often is not needed

    wp.config.log_level = wp.LOG_WARNING
    try:
        with _silent_stderr():
            wp.init()
    except OSError as error:
        raise ValueError(f"Warp's kernel cache: {error}; allowed: a writable folder, set WARP_CACHE_PATH") from error


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """Warp's native code reports a missing CUDA driver on file descriptor 2, whatever its log level."""
    saved = os.dup(2)
    with open(os.devnull, "w") as null:
        os.dup2(null.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)
