"""Linear algebra on one thread: its matrices are small, and where cores are busy its threads wait for each other."""

from collections.abc import Callable
from functools import cache, wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

_Given = ParamSpec("_Given")
_Result = TypeVar("_Result")


@cache
def _libraries() -> ThreadpoolController:
    """The libraries that this process has loaded; finding them takes a few milliseconds."""
    return ThreadpoolController()


def on_one_thread(function: Callable[_Given, _Result]) -> Callable[_Given, _Result]:
    """A function during which linear algebra takes one thread; what the user has set is back after it."""

    @wraps(function)
    def limited(*args: _Given.args, **kwargs: _Given.kwargs) -> _Result:
        with _libraries().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited
