"""The Warp kernels, compiled: as the program uses them, or with another chunk and other flags for an experiment."""

import functools
import gc
import importlib
import logging
import os
import threading
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

from .interrupts import undivided
from .layout import COLUMNS
from .module_copies import copy_module
from .tuning import flags

MODULES = {
    "warp_fields": ("spectral_multiply", "paired_multiply", "advance_response", "count_below"),
    "warp_fire": ("restrict_to_free", "fire_control", "fire_step", "plain_step"),
    "warp_sums": ("net_force", "plain_sums"),
    "warp_columns": ("unpack_columns", "pack_columns"),
}
"""The kernels, by the modules that they are in."""
ON_CPU_ONLY = ("warp_columns",)
"""Modules that no GPU needs."""
GPU_BLOCK = 256
"""Threads of a block on a GPU; Warp compiles a module anew for another number."""
KERNELS = tuple(name for names in MODULES.values() for name in names)

_lock = threading.RLock()  # of several threads one compiles
_logger = logging.getLogger("linecontact.kernels")


def load() -> dict[str, Any]:
    """Compile every kernel in both precisions, or fetch it from Warp's kernel cache; Warp's kernels by name.

    Raises `ValueError` if the cache cannot be used.
    """
    start_warp()
    with _lock:
        return _load()


@functools.cache
def _load() -> dict[str, Any]:
    import warp as wp

    modules = [importlib.import_module(f"{__package__}.{name}") for name in MODULES]
    for module in modules:
        wp.set_module_options({"cpu_compiler_flags": flags()[module.__name__.rpartition(".")[2]]}, module)
    return compile_modules(modules)


def recompile(names: Collection[str], chunk: int, compiled_with: str | None) -> dict[str, Any]:
    """Kernels from the same source, with `chunk` points per thread and other flags of the compiler, by name.

    names: of the kernels that are needed; those of their modules are compiled. chunk: a power of two; compiled_with:
    all flags, None the program's. Raises `ValueError` like `load`, for a name that there is not, and for a chunk that
    is shorter than a row of columns.
    """
    if unknown := set(names) - set(KERNELS):
        raise ValueError(f"names has {min(unknown)!r}; allowed: {', '.join(KERNELS)}")
    if chunk < 2 * COLUMNS and (rows := set(names) & set(MODULES["warp_columns"])):
        raise ValueError(f"chunk is {chunk}; allowed for {min(rows)}: at least {2 * COLUMNS}, a row of it")
    start_warp()
    with _lock:
        needed = [module for module, there in MODULES.items() if not set(there).isdisjoint(names)]
        copies = [_recompile(module, chunk, compiled_with) for module in needed]
    return {name: kernel for copy in copies for name, kernel in copy.items()}


@functools.cache
def _recompile(module: str, chunk: int, compiled_with: str | None) -> dict[str, Any]:
    return compile_modules([copy_module(module, chunk, flags()[module] if compiled_with is None else compiled_with)])


def compile_modules(modules: list[ModuleType], device: str = "cpu") -> dict[str, Any]:
    """Warp's kernels by name, in both precisions, of `MODULES` or of copies of them; device: Warp's name of it."""
    import warp as wp

    names = (*KERNELS, "fold_sums")
    kernels = {name: vars(module)[name] for module in modules for name in names if name in vars(module)}
    for kernel in kernels.values():
        if kernel.is_generic:
            arguments = {a.label: a.type for a in kernel.adj.args}
            for real in (wp.float32, wp.float64):
                types = {k: wp.array(dtype=real) if t.dtype is Any else t for k, t in arguments.items()}
                wp.overload(kernel, types)
    if "advance_response" in kernels:
        single, double, state = wp.array(dtype=wp.float32), wp.array(dtype=wp.float64), wp.array(dtype=wp.float64)
        wp.overload(kernels["advance_response"], {"change": single, "state": state, "response": double})
    if not all(_is_compiled(module.__name__, device) for module in modules):
        what = "this processor" if device == "cpu" else "the GPU"
        _logger.warning("linecontact: compiling kernels for %s, once; this takes some seconds", what)
    for module in modules:
        wp.load_module(module, device=device)
    return kernels


def _is_compiled(module: str, device: str) -> bool:
    """Whether Warp's cache holds this module for a device; for the CPU, where blocks are of one thread."""
    import warp as wp

    block, endings = (1, ("o",)) if device == "cpu" else (GPU_BLOCK, ("cubin", "ptx"))
    folder = Path(str(wp.config.kernel_cache_dir)) / wp.get_module(module).get_module_identifier(block)
    return any(file for ending in endings for file in folder.glob(f"*.{ending}"))


def started() -> bool:
    """Whether Warp has been started, which takes half a second."""
    return start_warp.cache_info().currsize > 0


@functools.cache
def start_warp() -> None:
    """Import and initialise Warp. Raises `ValueError` if its kernel cache cannot be used."""
    with undivided(), _without_collection():  # what Ctrl-C has cut off cannot be imported again
        import warp as wp  # takes as long as everything else together, and often is not needed

    wp.config.log_level = wp.LOG_WARNING
    try:
        with _silent_stderr():
            wp.init()
    except OSError as error:
        raise ValueError(f"Warp's kernel cache: {error}; allowed: a writable folder, set WARP_CACHE_PATH") from error


@contextmanager
def _without_collection() -> Iterator[None]:
    """Python looks for no garbage within the block: Warp's import makes a hundred thousand objects that stay."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()


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
