"""Cores: which this process may use, and keeping a thread on one of them."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

CORES = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
"""Numbers of the cores that this process may use; empty where the system does not tell."""


@contextlib.contextmanager
def pinned() -> Iterator[int]:
    """Keep the calling thread on the last of the usable cores; gives its number, -1 where the system cannot."""
    if not CORES:
        yield -1
        return
    os.sched_setaffinity(0, CORES[-1:])
    try:
        yield CORES[-1]
    finally:
        os.sched_setaffinity(0, CORES)


@contextlib.contextmanager
def unpinned() -> Iterator[None]:
    """Let the calling thread, and those that it starts, use all cores meanwhile."""
    if not CORES:
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, CORES)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def another_core() -> int | None:
    """A usable core beside the last one that is not the same physical core; None if there is none."""
    if not CORES:
        return None
    try:
        text = Path(f"/sys/devices/system/cpu/cpu{CORES[-1]}/topology/thread_siblings_list").read_text()
    except OSError:
        text = str(CORES[-1])
    siblings = {int(number) for part in text.strip().split(",") for number in part.split("-")}
    return next((core for core in reversed(CORES) if core not in siblings), None)
