"""The columns of a transform in four steps: some at a time are transformed, taken apart and turned by their twiddle
factors, and the way back; see `four_step`.
"""

from collections.abc import Callable

import numpy as np

from ...kernels import Call, layout, padded_length
from ..arrays import Array, Indices, Modes
from .planner import Transforms
from .sharing import do_all

_WIDTH = layout.COLUMNS


class Columns:
    """Transforms of the columns of N = R C real values, there and back."""

    def __init__(self, num_points: int, row: int, planner: Transforms) -> None:
        """row: C, the number of columns, a multiple of those that are worked on at a time."""
        count = num_points // row // 2 + 1
        starts, rows = np.arange(0, row, _WIDTH), np.arange(count)
        near = planner.buffer(2 * _WIDTH * count)
        turns = rows[:, None] * np.arange(_WIDTH)
        planner.complex(near)[: turns.size] = _twiddle_factors(turns, num_points).ravel()
        far = np.zeros((starts.size, padded_length(2 * count)), near.dtype)
        planner.complex(far)[:, :count] = _twiddle_factors(starts[:, None] * rows, num_points)
        self._parts = [(slice(start, start + _WIDTH), one) for start, one in zip(starts.tolist(), far, strict=True)]
        """Columns that are worked on at a time, with the first one's twiddle factors."""
        threads = min(planner.threads, starts.size)
        self._workers = [_Worker(num_points // row, near, planner) for _ in range(threads)]

    def forward(self, source: Array, spectrum: Array) -> Callable[[], None]:
        """source: shape (R, C), and spectrum: shape (R/2 + 1, 2, C), may be the same memory."""

        def work(worker: _Worker, part: tuple[slice, Array]) -> None:
            columns, worker.far[:] = part
            worker.columns[:] = source[:, columns]
            worker.transform()
            worker.unpack()
            spectrum[:, :, columns] = worker.spectra

        return lambda: do_all(self._workers, self._parts, work)

    def inverse(self, spectrum: Array, target: Array) -> Callable[[], None]:
        """The way back, times R."""

        def work(worker: _Worker, part: tuple[slice, Array]) -> None:
            columns, worker.far[:] = part
            worker.spectra[:] = spectrum[:, :, columns]
            worker.pack()
            worker.transform_back()
            target[:, columns] = worker.columns

        return lambda: do_all(self._workers, self._parts, work)


class _Worker:
    """Buffers for some columns, plans and kernels on them. columns: shape (R, columns); spectra: shape (R/2 + 1, 2,
    columns), of two columns after the other; far: their first column's twiddle factors.
    """

    def __init__(self, num_rows: int, near: Array, planner: Transforms) -> None:
        """near: twiddle factors from the first column."""
        count = num_rows // 2 + 1
        self.far = planner.buffer(2 * count)
        columns, spectra = planner.buffer(num_rows * layout.STRIDE), planner.buffer(near.size)
        columns = columns[: num_rows * layout.STRIDE]
        self.columns = columns.reshape(-1, layout.STRIDE)[:, :_WIDTH]
        self.spectra = spectra[: 2 * _WIDTH * count].reshape(count, 2, _WIDTH)
        modes = planner.complex(self.columns)
        self.transform = planner.plan(modes, modes, "FFTW_FORWARD", axis=0, threads=1)
        self.transform_back = planner.plan(modes, modes, "FFTW_BACKWARD", axis=0, threads=1)
        self.unpack = planner.record([Call("unpack_columns", (near, self.far, columns), (spectra,))])
        self.pack = planner.record([Call("pack_columns", (near, self.far, spectra), (columns,))])


def _twiddle_factors(turns: Indices, num_points: int) -> Modes:
    return np.asarray(np.exp(-2j * np.pi / num_points * turns))
