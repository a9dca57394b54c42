"""Which devices a solve can run on, and whether there is one of them."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from ...kernels import start_warp

DEVICES = ("cpu", "cuda")
"""Where a method can work: on the CPU, or on a GPU of NVIDIA's."""

_one_at_a_time = threading.RLock()


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
    """What the device calls itself; 'cpu' for the CPU."""
    if device == "cpu":
        return device
    import warp as wp

    return str(wp.get_device(device).name)


def gpu_libraries() -> str:
    """The libraries that a GPU's transforms come from, with their versions."""
    import cupy

    return f"CuPy {cupy.__version__} and cuFFT {cupy.cuda.cufft.getVersion()}"
