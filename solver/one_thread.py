"""Linear algebra on one thread: its matrices are small, and where cores are busy its threads wait for each other."""

import threading
from collections.abc import Callable
from functools import cache, wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

_Given = ParamSpec("_Given")
_Result = TypeVar("_Result")

_limiting = threading.Lock()
"""Held while one of these functions has set the limit, which is the whole process's."""


@cache
def _libraries() -> ThreadpoolController:
    """The libraries that this process has loaded; finding them takes a few milliseconds."""
    return ThreadpoolController()


def on_one_thread(function: Callable[_Given, _Result]) -> Callable[_Given, _Result]:
    """A function during which linear algebra takes one thread; what the user has set is back after it.

    The limit is that of the whole process. Where several threads are in such functions, the first of them sets it and
    takes it back at its end; the others leave it alone.
    """

    @wraps(function)
    def limited(*args: _Given.args, **kwargs: _Given.kwargs) -> _Result:
        if not _limiting.acquire(blocking=False):
            return function(*args, **kwargs)
        try:
            with _libraries().limit(limits=1, user_api="blas"):
                return function(*args, **kwargs)
        finally:
            _limiting.release()

    return limited
