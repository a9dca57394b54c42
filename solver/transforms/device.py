"""Where a solve can run, and whether that is there; threads of its transforms, and FFTW's effort in planning them."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from ... import locks
from ...kernels import start_warp
from .. import checks

DEVICES = ("cpu", "cuda")
"""Where a method can work: on the CPU, or on a GPU of NVIDIA's."""
PLANNING = ("estimate", "measure", "patient")
"""Planning effort. 'estimate' plans at once, and takes plans of an earlier, greater effort from wisdom."""

_one_at_a_time = threading.RLock()


def check_settings(threads: int, planning: str) -> tuple[int, str]:
    """Both, if they are allowed. Raises `ValueError`, too, for threads in a process that was forked: had FFTW threads
    before, by whatever called it, it would wait for these for ever.
    """
    allowed = checks.integer("threads", threads, "an integer from 1 to 1024", 1, 1024)
    if allowed > 1 and locks.forked:
        here = "1 in a process that was forked (by 'spawn' or 'forkserver' it may have more)"
        raise ValueError(f"threads is {allowed}; allowed: {here}")
    return allowed, checks.choice("planning", planning, PLANNING)


def check_device(device: str) -> None:
    """Raise `ValueError` for a device that is not there, or lacks a library."""
    if device == "cpu":
        return
    start_warp()
    import warp as wp

    none = f"device is {device!r}, but there is no GPU with a driver for it; allowed: cpu"
    if not wp.is_cuda_available():
        raise ValueError(none)
    try:
        import cupy.cuda.cufft

        found = cupy.cuda.runtime.getDeviceCount() > 0
    except ImportError as error:
        what = f"device is {device!r}, for which CuPy or a library of CUDA is missing ({error})"
        raise ValueError(f"{what}; allowed: cpu, or cuda with `pip install 'cupy-cuda13x[ctk]'`") from error
    except cupy.cuda.runtime.CUDARuntimeError:
        found = False
    if not found:
        raise ValueError(none)


@contextmanager
def borrowed(device: str) -> Iterator[None]:
    """A GPU is one solve's at a time, and gets its memory back at the end of the block; nothing happens on the CPU."""
    if device == "cpu":
        yield
        return
    from . import on_gpu

    with _one_at_a_time:
        try:
            yield
        finally:
            on_gpu.free_memory()


def device_name(device: str) -> str:
    """The device's own name; 'cpu' for the CPU."""
    if device == "cpu":
        return device
    import warp as wp

    return str(wp.get_device(device).name)


def gpu_libraries() -> str:
    """The libraries that a GPU's transforms come from, with their versions."""
    import cupy

    return f"CuPy {cupy.__version__} and cuFFT {cupy.cuda.cufft.getVersion()}"
