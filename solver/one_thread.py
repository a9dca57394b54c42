"""Linear algebra on one thread: its matrices are small, and where cores are busy its threads wait for each other."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import numpy as np
from threadpoolctl import ThreadpoolController

_limiting = threading.Lock()
"""Held while one of these functions has set the limit, which is the whole process's."""


@cache
def _libraries() -> ThreadpoolController:
    """The libraries that this process has loaded; finding them takes a few milliseconds."""
    return ThreadpoolController()


@contextmanager
def on_one_thread() -> Iterator[None]:
    """Linear algebra takes one thread meanwhile (also as a decorator), and numbers that underflow are no error; the
    user's settings are back afterwards.

    Where several threads are here, the first of them sets the limit and takes it back at its end.
    """
    with np.errstate(divide="warn", over="warn", under="ignore", invalid="warn"):
        if not _limiting.acquire(blocking=False):
            yield
            return
        try:
            with _libraries().limit(limits=1, user_api="blas"):
                yield
        finally:
            _limiting.release()
