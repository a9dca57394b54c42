"""pyFFTW without SciPy and Dask, which its interfaces would import although nothing here uses them; and its planner.

They are hidden only while pyFFTW is being imported; afterwards they can be imported as ever. pyFFTW's interfaces for
them are then missing: who wants those imports pyFFTW first.
"""

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ... import locks
from ...locks import PLANNING


@contextmanager
def _hidden(*names: str) -> Iterator[None]:
    """Modules that are not loaded yet cannot be imported meanwhile."""
    hidden = [name for name in names if name not in sys.modules]
    for name in hidden:
        sys.modules[name] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        for name in hidden:
            del sys.modules[name]


with _hidden("scipy", "dask"):
    import pyfftw

__all__ = ["Plan", "next_fast_len", "pyfftw"]

next_fast_len = pyfftw.next_fast_len


_PATIENCE = 20.0  # s, for a plan that takes microseconds


@locks.once
def _await_planner() -> None:
    """Raise `ValueError` if a thread that a fork has left behind has FFTW's planner: one of the user's own."""
    values = pyfftw.empty_aligned(2, dtype=complex)
    thread = threading.Thread(target=pyfftw.FFTW, args=(values, values), daemon=True)
    thread.start()
    thread.join(_PATIENCE)
    if thread.is_alive():
        what = "the process was forked while another of its threads planned a transform of its own"
        raise ValueError(f"{what}, and waits for that for ever; allowed: 'spawn' or 'forkserver'")


class Plan:
    """A plan of FFTW's, made as `pyfftw.FFTW` is and done by calling it.

    pyFFTW takes its planner's lock to make and to remove one, and a child of a fork would wait for ever for a thread
    of its parent that held it.
    """

    def __init__(self, *arrays: Any, **options: Any) -> None:
        if locks.forked:
            _await_planner()
        with PLANNING:
            self._execute: Callable[[], None] = pyfftw.FFTW(*arrays, **options).execute

    def __call__(self) -> None:
        self._execute()

    def __del__(self) -> None:
        with PLANNING:
            self.__dict__.clear()
