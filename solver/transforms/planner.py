"""Parts of all transforms on the CPU: staggered buffers, FFTW's plans, and kernels."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import ClassVar

import numpy as np

from ... import locks
from ...kernels import Call, padded_length, record
from .. import checks
from ..arrays import Array
from . import wisdom
from .backend import Backend
from .fftw import Plan, pyfftw

PLANNING = ("estimate", "measure", "patient")
"""Planning effort. 'estimate' plans at once, and takes what wisdom holds of an earlier, greater effort."""

_STAGGER = 1024  # bytes: buffers that start at equal page offsets slow each other down


class Transforms(Backend):
    """Transforms of N values in one way, and the buffers, plans and kernels that it is made from.

    precision: 'float64' or 'float32'; threads: of the transforms, >= 1; planning: one of `PLANNING`; backend: see
    `ExecutionConfig.backend`. Raises `ValueError`.
    """

    way: ClassVar[str]
    """How the transforms are done."""

    def __init__(
        self, num_points: int, precision: str, threads: int = 1, planning: str = "estimate", backend: str = "warp"
    ) -> None:
        super().__init__(num_points, precision)
        self.threads, self.planning = check_settings(threads, planning)
        self._backend, self._count = backend, 0
        wisdom.load()
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Make the spectrum, and other buffers of a way."""

    def buffer(self, length: int | None = None) -> Array:
        """A padded, aligned, staggered array for `length` (default N) values: zeros."""
        padded = padded_length(self.num_points if length is None else length)
        offset = self._count * _STAGGER // self.dtype.itemsize
        self._count += 1
        return np.asarray(pyfftw.zeros_aligned(padded + offset, dtype=self.dtype, n=64)[offset:])

    def record(self, calls: Sequence[Call]) -> Callable[[], None]:
        return record(self._backend, calls)

    def plan(
        self, source: Array, target: Array, direction: str, axis: int = -1, threads: int | None = None
    ) -> Callable[[], None]:
        """The plan that wisdom holds, or else a new one, which is kept at once if finding it took effort.

        direction: 'FFTW_FORWARD', or 'FFTW_BACKWARD', which destroys the source; axis: of arrays of two dimensions;
        threads: by default the transforms'.
        """

        def plan(effort: str, *more: str) -> Callable[[], None]:
            flags = [f"FFTW_{effort.upper()}", *more, *(["FFTW_DESTROY_INPUT"] if direction == "FFTW_BACKWARD" else [])]
            count = threads or self.threads
            return Plan(source, target, axes=(axis,), direction=direction, threads=count, flags=flags)

        estimated = self.planning == "estimate"
        with suppress(RuntimeError):  # wisdom does not hold it
            return plan("measure" if estimated else self.planning, "FFTW_WISDOM_ONLY")
        try:
            return plan(self.planning)
        finally:
            if not estimated:
                wisdom.save()  # after Ctrl-C, too, which waits until FFTW has finished


def library() -> str:
    """The library that plans, with its version."""
    return str(pyfftw.fftw_version)


def check_settings(threads: int, planning: str) -> tuple[int, str]:
    """Both, if they are allowed. Raises `ValueError`, too, for threads in a process that was forked: had FFTW threads
    before, by whatever called it, it would wait for these for ever.
    """
    allowed = checks.integer("threads", threads, "an integer from 1 to 1024", 1, 1024)
    if allowed > 1 and locks.forked:
        here = "1 in a process that was forked (by 'spawn' or 'forkserver' it may have more)"
        raise ValueError(f"threads is {allowed}; allowed: {here}")
    return allowed, checks.choice("planning", planning, PLANNING)
