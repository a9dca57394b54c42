"""Warp kernels on the CPU, their reference kernels in NumPy, and in `on_gpu` the same kernels on a GPU.

Knows arrays and numbers: no scene, no file, no transform.
"""

from . import layout
from .compiled import KERNELS, flags, load, recompile, start_warp
from .interrupts import undivided
from .layout import CHUNK, padded_length
from .processor import instructions, processor
from .record import BACKENDS, Call, launch, record, record_launches, share
from .sequences import sequence

__all__ = [
    "BACKENDS",
    "CHUNK",
    "KERNELS",
    "Call",
    "flags",
    "instructions",
    "launch",
    "layout",
    "load",
    "padded_length",
    "processor",
    "recompile",
    "record",
    "record_launches",
    "sequence",
    "share",
    "start_warp",
    "undivided",
]
