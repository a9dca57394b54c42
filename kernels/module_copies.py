"""Copies of the modules of Warp kernels, for Warp to compile in another way."""

import hashlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType


def copy_module(name: str, chunk: int, compiled_with: str, lanes: int = 1) -> ModuleType:
    """A module of kernels once more, from the same source, for Warp to compile anew.

    name: its name in this folder; chunk: points per thread, a power of two; compiled_with: all flags of the compiler.
    lanes: neighbouring threads whose points take turns, so that what they read at one time lies side by side, as a GPU
    needs it; a power of two. With one a thread's points are consecutive.
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
    vars(copy)["CHUNK_LENGTH"] = wp.constant(chunk)
    vars(copy)["LANES"], vars(copy)["SPAN"] = wp.constant(lanes), wp.constant(lanes * chunk)
    wp.set_module_options({"cpu_compiler_flags": compiled_with}, copy)
    return copy
