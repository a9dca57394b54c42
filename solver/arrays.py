"""Names for the types of arrays that the whole solver uses."""

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
    """An array of that length, part by part: long intermediate results take longer to make room for than to compute."""
    return (slice(start, start + _PART) for start in range(0, length, _PART))
