"""Arrays: names for their types, long ones part by part, nodes of a quadrature, and linear algebra on one thread."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from ..locks import LIMITING

Array = NDArray[Any]
"""Real numbers in the precision that a method works in, float32 or float64."""

Array64 = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
Modes = NDArray[np.complex128]
"""Fourier coefficients for the wave numbers from 0 to N/2 (half spectrum)."""

_PART = 2**14  # values whose intermediate results stay in the cache
_NODES = 200  # of Gauss-Legendre quadrature: smooth integrands to rounding
_inside = 0  # threads in `on_one_thread`
_limit: Any = None  # of the whole process, which they share


def chunks(length: int) -> Iterator[slice]:
    """The parts of an array of that length, in order: memory for long intermediate results takes longer to get than
    their values take to compute.
    """
    return (slice(start, start + _PART) for start in range(0, length, _PART))


@cache
def gauss_legendre() -> tuple[Array64, Array64]:
    """Nodes and weights on (-1, 1), shape (M,) each, kept because they cost an eigenvalue problem."""
    return np.polynomial.legendre.leggauss(_NODES)


@cache
def _libraries() -> ThreadpoolController:
    """The libraries that this process has loaded; finding them takes a few milliseconds."""
    return ThreadpoolController()


@contextmanager
def on_one_thread() -> Iterator[None]:
    """Linear algebra takes one thread meanwhile (also as a decorator), and NumPy's error settings are its defaults, so
    that numbers that underflow are no error; the user's settings are back afterwards.

    Its matrices are small, and where cores are busy its threads wait for each other. Where several threads are here,
    the first of them sets the limit and the last one takes it back, so that all sum in the same order.
    """
    global _inside, _limit
    with np.errstate(divide="warn", over="warn", under="ignore", invalid="warn"):
        with LIMITING:
            if not _inside:
                _limit = _libraries().limit(limits=1, user_api="blas")
            _inside += 1
        try:
            yield
        finally:
            with LIMITING:
                _inside -= 1
                if not _inside:
                    _limit.restore_original_limits()
