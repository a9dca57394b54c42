"""Warp kernels on the CPU and their NumPy twins. Knows arrays and numbers: no scene, no file, no transform."""

from . import layout
from .compiled import KERNELS, flags, load, recompile, start_warp
from .layout import CHUNK, padded_length
from .record import BACKENDS, Call, record, share
from .sequences import sequence

__all__ = [
    "BACKENDS",
    "CHUNK",
    "KERNELS",
    "Call",
    "flags",
    "layout",
    "load",
    "padded_length",
    "recompile",
    "record",
    "sequence",
    "share",
    "start_warp",
]
