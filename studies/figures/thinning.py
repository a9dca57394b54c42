"""Curves and patches with no more points than a screen can show, and with nothing lost that it could."""

import numpy as np
from linecontact.solver.arrays import Array64, Indices


def extremes(values: Array64, pixels: int) -> Indices:
    """Places of the lowest and the highest value of each pixel, and of both ends, in increasing order.

    values: shape (N,), any unit. pixels: at least 1. Returns at most 2 pixels + 4 places, shape (M,).
    """
    count = values.size
    size = -(-count // pixels)  # values to a pixel
    if size <= 2:
        return np.arange(count)
    whole = count // size * size
    blocks = values[:whole].reshape(-1, size)
    begin = np.arange(0, whole, size)
    places = [begin + blocks.argmin(axis=1), begin + blocks.argmax(axis=1), [0, count - 1]]
    if whole < count:
        places.append([whole + int(values[whole:].argmin()), whole + int(values[whole:].argmax())])
    return np.unique(np.concatenate(places)).astype(np.int64)


def merged(left: Array64, right: Array64, pixel: float) -> tuple[Array64, Array64]:
    """Patches with those that begin in the same pixel taken together.

    left, right: ends in increasing order, shape (M,), in the unit of `pixel`, the width of one.
    """
    if not left.size:
        return left, right
    begins = np.flatnonzero(np.diff(np.floor(left / pixel), prepend=-np.inf))
    return left[begins], np.maximum.reduceat(right, begins)
