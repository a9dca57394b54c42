"""Locks of what a process has once, and what a fork finds of them.

A child of `os.fork` has one thread, and every lock that another thread held would stay taken there for ever. So the
thread that forks takes them all first, in the order in which they are taken one inside of the other.
"""

import functools
import gc
import os
import sys
import threading
from collections.abc import Callable
from typing import ParamSpec, TypeVar

_Given = ParamSpec("_Given")
_Made = TypeVar("_Made")

BUFFERS = threading.Lock()
COMPILING, RECORDING, PLANNING = (threading.RLock() for _ in range(3))
"""Of the buffers that `solver.transforms.plain` keeps; of Warp's modules; of the launches that Warp records, beside
which another launch would crash; and of FFTW's planner and wisdom."""

_ALL = (BUFFERS, COMPILING, RECORDING, PLANNING)

forked = False
"""Whether this process was forked from one that had this module, and so perhaps threads of FFTW, or a GPU."""


def once(make: Callable[_Given, _Made]) -> Callable[_Given, _Made]:
    """A function that makes each thing once, also where several threads ask for it: `functools.cache` lets them all."""
    known = functools.cache(make)

    @functools.wraps(make)
    def call(*given: _Given.args, **named: _Given.kwargs) -> _Made:
        with COMPILING:
            return known(*given, **named)  # type: ignore[arg-type]

    return call


def _take() -> None:
    for lock in _ALL:
        lock.acquire()


def _give_back() -> None:
    for lock in reversed(_ALL):
        lock.release()


def _begin_child() -> None:
    global forked
    forked = True
    _give_back()
    if sys.version_info < (3, 12):  # every cached property has a lock of its own there
        for one in gc.get_objects():
            if type(one) is functools.cached_property:
                one.lock = threading.RLock()  # type: ignore[attr-defined]


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_take, after_in_parent=_give_back, after_in_child=_begin_child)
