"""What the whole solver knows of arrays: names for their types, and long ones part by part."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
"""Real numbers in the precision that a method works in, float32 or float64."""

Array64 = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
Modes = NDArray[np.complex128]
"""Fourier coefficients for the wave numbers from 0 to N/2 (half spectrum)."""

_PART = 2**14  # values whose intermediate results stay in the cache


def parts(length: int) -> Iterator[slice]:
    """The parts of an array of that length, in order: memory for long intermediate results takes longer to get than
    their values take to compute.
    """
    return (slice(start, start + _PART) for start in range(0, length, _PART))
