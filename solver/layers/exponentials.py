"""Differences that cancel for thin layers, free of it: hyperbolic functions times exp(-x), for x >= 0 of any size."""

import numpy as np

from ..arrays import Array64

_SERIES_BELOW = 2.0
_SERIES_TERMS = 13  # (2^2)^13/27! < 1e-20 of the first term


def sinh_minus_argument(x: Array64) -> Array64:
    """(sinh x - x) exp(-x); shape of `x`."""
    small = np.minimum(x, _SERIES_BELOW)
    series = np.ones_like(small)
    for m in range(_SERIES_TERMS, 0, -1):
        series = 1 + small * small / ((2 * m + 2) * (2 * m + 3)) * series
    with np.errstate(under="ignore"):
        e = np.exp(-x)
        return np.where(x < _SERIES_BELOW, small**3 / 6 * series * e, -np.expm1(-2 * x) / 2 - x * e)
