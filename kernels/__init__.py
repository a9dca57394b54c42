"""Warp kernels on the CPU and their NumPy twins. Knows arrays and numbers: no scene, no file, no transform."""

from . import layout
from .layout import CHUNK, padded_length
from .record import BACKENDS, KERNELS, Call, load, record
from .sequences import sequence

__all__ = ["BACKENDS", "CHUNK", "KERNELS", "Call", "layout", "load", "padded_length", "record", "sequence"]
