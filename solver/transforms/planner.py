"""What ways of transforming are made from: staggered buffers, FFTW's plans, and kernels."""

from collections.abc import Callable, Sequence
from contextlib import suppress

import numpy as np

from ... import locks
from ...kernels import Call, padded_length, record
from .. import checks
from ..arrays import Array, Array64
from . import wisdom
from .fftw import Plan, pyfftw

PLANNING = ("estimate", "measure", "patient")
"""Planning effort. 'estimate' plans at once, and takes what wisdom holds of an earlier, greater effort."""

_STAGGER = 1024  # bytes: buffers that start at equal page offsets slow each other down


class Planner:
    """Makes buffers of one precision, plans between them and kernels on them.

    precision: 'float64' or 'float32'; threads: of the transforms, >= 1; planning: one of `PLANNING`; backend: see
    `ExecutionConfig.backend`. Raises `ValueError`.
    """

    def __init__(self, precision: str, threads: int, planning: str, backend: str) -> None:
        self.threads, self.planning = check_settings(threads, planning)
        self._backend = backend
        self.real = np.dtype(precision)
        """Type of the values."""
        self.known = self.planned = self._count = 0
        """Plans so far that FFTW's wisdom held, from measuring at some time, and those that were made anew."""
        wisdom.load()

    def has_poor_plan(self, num_points: int) -> bool:
        """Whether all that FFTW has for a real transform of that length is an estimate."""
        if self.planning != "estimate":
            return False
        modes = self.complex(pyfftw.empty_aligned(2 * (num_points // 2 + 1), dtype=self.real))
        for values in (pyfftw.empty_aligned(num_points, dtype=self.real), modes.view(self.real)[:num_points]):
            with suppress(RuntimeError):  # wisdom does not hold it
                Plan(values, modes, threads=self.threads, flags=["FFTW_MEASURE", "FFTW_WISDOM_ONLY"])
                return False
        return True

    def buffer(self, length: int) -> Array:
        """A padded, aligned, staggered array for so many values: zeros."""
        padded = padded_length(length)
        offset = self._count * _STAGGER // self.real.itemsize
        self._count += 1
        array: Array = pyfftw.zeros_aligned(padded + offset, dtype=self.real, n=64)[offset:]
        return array

    def doubled(self, values: Array64) -> Array:
        """A buffer with every value twice, for both parts of a mode."""
        found = self.buffer(2 * values.size)
        for part in range(2):
            found[part : 2 * values.size : 2] = values
        return found

    def complex(self, values: Array) -> Array:
        """Complex numbers on a flat real view (re, im, ...)."""
        found: Array = values.view(np.result_type(self.real, np.complex64))
        return found

    def record(self, calls: Sequence[Call]) -> Callable[[], None]:
        """A function without arguments that runs kernels in order."""
        return record(self._backend, calls)

    def plan(
        self, source: Array, target: Array, direction: str, axis: int = -1, threads: int | None = None
    ) -> Callable[[], None]:
        """The plan that wisdom holds, or else a new one, which is kept at once if finding it took effort.

        direction: 'FFTW_FORWARD', or 'FFTW_BACKWARD', which destroys the source; axis: of arrays of two dimensions;
        threads: by default the planner's.
        """

        def plan(effort: str, *more: str) -> Callable[[], None]:
            flags = [f"FFTW_{effort.upper()}", *more]
            if direction == "FFTW_BACKWARD":
                flags.append("FFTW_DESTROY_INPUT")
            count = threads or self.threads
            return Plan(source, target, axes=(axis,), direction=direction, threads=count, flags=flags)

        estimated = self.planning == "estimate"
        with suppress(RuntimeError):  # wisdom does not hold it
            known = plan("measure" if estimated else self.planning, "FFTW_WISDOM_ONLY")
            self.known += 1
            return known
        self.planned += 1
        if estimated:
            return plan("estimate")
        try:
            return plan(self.planning)
        finally:
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
