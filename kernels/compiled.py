"""The Warp kernels, compiled as the program uses them, or in another way for an experiment or a GPU.

Every array is one-dimensional and padded to a multiple of `CHUNK`; one thread works on one chunk. An inner loop whose
length is a compile-time power of two is what LLVM turns into vector code; a thread per element, a run-time bound or a
tail test stays scalar. The reassociation flags let it vectorise the sums as well. On a GPU the points of `LANES`
threads take turns instead (`on_gpu`).
"""

import ctypes
import hashlib
import importlib.util
import logging
import sys
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

from .. import locks
from .derived import discard, is_whole, seal
from .interrupts import undivided
from .layout import CHUNK, COLUMNS

MODULES = {
    "warp_fields": ("spectral_multiply", "advance_response"),
    "warp_fire": ("net_force", "plain_sums", "restrict_to_free", "fire_control", "fire_step", "plain_step"),
    "warp_columns": ("unpack_columns", "pack_columns"),
}
"""The kernels, by the modules that they are in."""
ON_CPU_ONLY = ("warp_columns",)
"""Modules that no GPU needs."""
GPU_BLOCK = 256
"""Threads of a block on a GPU; Warp compiles a module anew for another number."""
_ROOM = 2**18
"""Bytes that a compiled module takes at most."""
KERNELS = tuple(name for names in MODULES.values() for name in names)

_logger = logging.getLogger("linecontact.kernels")


def flags() -> str:
    """All flags of the compiler for the kernels: Warp's own, and those that make sums vector code."""
    import warp as wp

    return f"{wp.config.cpu_compiler_flags or ''} -mreassociate -fno-signed-zeros -ffp-contract=fast".strip()


@locks.once
def load() -> dict[str, Any]:
    """Compile every kernel in both precisions, or fetch it from Warp's kernel cache; Warp's kernels by name.

    Raises `ValueError` if the cache cannot be used.
    """
    start_warp()
    return compile_modules([copy_module(module, CHUNK, flags()) for module in (*MODULES, "warp_ends")])


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
    how = flags() if compiled_with is None else compiled_with
    needed = [module for module, there in MODULES.items() if not set(there).isdisjoint(names)]
    return compile_modules([copy_module(module, chunk, how) for module in needed])


@locks.once
def copy_module(name: str, chunk: int, compiled_with: str, lanes: int = 1) -> ModuleType:
    """A module of kernels from its source, for Warp to compile in one way.

    chunk: points per thread, a power of two; compiled_with: all flags of the compiler; lanes: neighbouring threads
    whose points take turns, so that their reads at one time lie side by side, as a GPU needs it; a power of two.
    """
    import warp as wp

    file = Path(__file__).with_name(f"{name}.py")
    which = hashlib.sha256(compiled_with.encode()).hexdigest()[:8]
    spec = importlib.util.spec_from_file_location(f"{__package__}.{name}_{chunk}_{lanes}_{which}", file)
    if spec is None or spec.loader is None:
        raise ImportError(f"file {file} is no module")
    copy = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = copy  # Warp looks for the source there
    spec.loader.exec_module(copy)
    vars(copy).update(CHUNK_LENGTH=wp.constant(chunk), LANES=wp.constant(lanes), SPAN=wp.constant(lanes * chunk))
    wp.set_module_options({"cpu_compiler_flags": compiled_with}, copy)
    return copy


def compile_modules(modules: list[ModuleType], device: str = "cpu") -> dict[str, Any]:
    """Warp's kernels by name, in both precisions, of `MODULES` or of copies of them; device: Warp's name of it."""
    import warp as wp

    kernels = {k: v for module in modules for k, v in vars(module).items() if isinstance(v, wp.Kernel)}
    for kernel in kernels.values():
        if kernel.is_generic:
            arguments = {a.label: a.type for a in kernel.adj.args}
            for real in (wp.float32, wp.float64):
                types = {k: wp.array(dtype=real) if t.dtype is Any else t for k, t in arguments.items()}
                wp.overload(kernel, types)
    compiled = [_is_compiled(module, device) for module in modules]
    if not all(compiled):
        what = "this processor" if device == "cpu" else "the GPU"
        _logger.warning("linecontact: compiling kernels for %s, once; this takes some seconds", what)
    for module, there in zip(modules, compiled, strict=True):
        _compile(module, device, there)
    return kernels


def _compile(module: ModuleType, device: str, there: bool) -> None:
    """Have Warp load a module; there: compiled before. Raises `ValueError` if the kernel cache cannot be used."""
    import warp as wp

    try:
        if not there:
            _check_room()
        try:
            wp.load_module(module, device=device)
        except Exception as error:  # another process takes away files that it finds without a seal
            _logger.debug("linecontact: %s is compiled again: %s", module.__name__, error)
            _check_room()
            wp.get_module(module.__name__).mark_modified()
            wp.load_module(module, device=device)
    except OSError as error:
        raise _unusable(error) from error
    for file in _files(module, device):
        seal(file)


def _check_room() -> None:
    """Raise `OSError` if the kernel cache cannot take a compiled module: LLVM would end the process."""
    import warp as wp

    with tempfile.TemporaryFile(dir=wp.config.kernel_cache_dir) as file:
        file.write(bytes(_ROOM))


def _unusable(error: OSError) -> ValueError:
    import warp as wp

    what = f"Warp's kernel cache {wp.config.kernel_cache_dir} cannot be used ({error.strerror or error})"
    return ValueError(f"{what}; allowed: a writable folder with room, set WARP_CACHE_PATH")


def _files(module: ModuleType, device: str) -> list[Path]:
    """Files of a module for a device in Warp's cache; a file in their folder's place is taken away."""
    import warp as wp

    block, endings = (1, (".o", ".meta")) if device == "cpu" else (GPU_BLOCK, (".cubin", ".ptx", ".meta"))
    folder = Path(str(wp.config.kernel_cache_dir)) / wp.get_module(module.__name__).get_module_identifier(block)
    if not folder.is_dir():
        discard(folder)
    return [file for file in folder.glob("*") if file.suffix in endings]


def _is_compiled(module: ModuleType, device: str) -> bool:
    """Whether Warp's cache holds a module for a device; damaged files, as a power cut leaves them, are taken away."""
    for file in _files(module, device):
        if not is_whole(file):
            discard(file)
    return {file.suffix == ".meta" for file in _files(module, device)} == {True, False}  # its description, and code


@locks.once
def start_warp() -> None:
    """Import and initialise Warp. Raises `ValueError` if its kernel cache cannot be used."""
    with undivided():  # a module that Ctrl-C has cut off cannot be imported again
        import warp as wp  # takes as long as everything else together

    wp.config.log_level = wp.LOG_WARNING
    try:
        with _silent():
            wp.init()
    except OSError as error:
        raise _unusable(error) from error


@contextmanager
def _silent() -> Iterator[None]:
    """Warp's native code reports a missing CUDA driver on C's `stderr`, whatever its log level. Where that is a
    variable (on Linux), it leads nowhere meanwhile; Python and descriptor 2, which all threads share, stay as they are.
    """
    try:
        libc = ctypes.CDLL(None)
        stderr = ctypes.c_void_p.in_dll(libc, "stderr")
        libc.fmemopen.restype = ctypes.c_void_p
    except (TypeError, ValueError, AttributeError):  # on Windows, and on macOS
        yield
        return
    before, stderr.value = stderr.value, libc.fmemopen(None, ctypes.c_size_t(2**12), b"w")
    try:
        yield
    finally:
        stderr.value = before  # another thread may be writing to the other stream, so that stays open
