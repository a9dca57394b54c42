"""Locks of things that a process has once, and their state after a fork.

A child of `os.fork` has one thread, and every lock that another thread held would stay taken there for ever. So the
thread that forks takes them all first, in the order in which they are taken one inside of the other.
"""

import _frozen_importlib
import atexit
import concurrent.futures.thread  # noqa: F401  # its lock and logging's are registered first, so taken after ours
import functools
import gc
import importlib
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import ParamSpec, TypeVar

_Given = ParamSpec("_Given")
_Made = TypeVar("_Made")

DRAWING, IMPORTING, COMPILING, RECORDING, PLANNING, LIMITING = (threading.RLock() for _ in range(6))
"""Of Matplotlib, whose settings all threads share; of the imports of the package's front, for a module that is half
imported would stay so; of Warp's modules; of the launches that Warp records, beside which another launch would crash;
of FFTW's planner and wisdom; and of the limit on BLAS threads."""

_IMPORTED = "linecontact", "numpy", "pyfftw", "warp", "cupy", "h5py", "matplotlib", "rich", "SurfaceTopography", "bokeh"
"""Packages whose imports end before a fork."""

_taken = threading.local()
_ALL = (DRAWING, IMPORTING, COMPILING, RECORDING, PLANNING, LIMITING)


def _had_fftw() -> bool:
    """Whether pyFFTW was there before, in a process that was forked and runs no other program (as Linux says)."""
    try:
        flags = int(Path("/proc/self/stat").read_text().rpartition(")")[2].split()[6])
    except (OSError, IndexError, ValueError):
        return False
    return "pyfftw" in sys.modules and "multiprocessing.forkserver" not in sys.modules and bool(flags & 0x40)


forked = _had_fftw()
"""Whether this process was forked from one that had this module or pyFFTW, and so perhaps threads of FFTW, or a GPU."""


def once(make: Callable[_Given, _Made]) -> Callable[_Given, _Made]:
    """A function that makes each thing once, also where several threads ask for it: `functools.cache` lets them all."""
    known = functools.cache(make)

    @functools.wraps(make)
    def call(*given: _Given.args, **named: _Given.kwargs) -> _Made:
        with COMPILING:
            return known(*given, **named)  # type: ignore[arg-type]

    return call


@contextmanager
def _free_h5py() -> Iterator[None]:
    """h5py takes its own lock before a fork, perhaps before `_take`, which may wait for an import that needs it."""
    early = True
    try:
        sys.modules["h5py._objects"].phil.release()
    except RuntimeError:  # h5py takes it later
        early = False
    except (KeyError, AttributeError):  # h5py is not there
        pass
    try:
        yield
    finally:
        if early:
            with suppress(KeyError, AttributeError):  # also where it came meanwhile: it gives back after the fork
                sys.modules["h5py._objects"].phil.acquire()


def _take() -> None:
    _taken.locks = []
    with _free_h5py():
        for lock in _ALL:  # Ctrl-C may come while one is waited for
            lock.acquire()
            _taken.locks.append(lock)
        under_way = getattr(_frozen_importlib, "_module_locks", {})
        for name in list(under_way):
            if name.partition(".")[0] in _IMPORTED:
                with suppress(Exception):  # another thread's import: a child would wait for ever for its end
                    importlib.import_module(name)


def _give_back() -> None:
    for lock in reversed(_taken.locks):
        lock.release()


def _begin_child() -> None:
    global forked
    forked = True
    _give_back()
    if sys.version_info < (3, 12):  # every cached property has a lock of its own there
        for one in gc.get_objects():
            if type(one) is functools.cached_property:
                one.lock = threading.RLock()  # type: ignore[attr-defined]


atexit.register(PLANNING.acquire)  # FFTW is cleared away at the end, which a thread that plans would not survive
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_take, after_in_parent=_give_back, after_in_child=_begin_child)
