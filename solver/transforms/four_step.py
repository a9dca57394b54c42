"""Long real transforms in four steps, on parts that fit into the processor's cache.

N = R C values stand in R rows of C columns, x_(C r + c). With w_N = exp(-2 pi i/N), mode k + R m is

    X_(k + R m) = sum_c w_C^(c m) { w_N^(c k) [ sum_r w_R^(r k) x_(C r + c) ] }:

transforms of the columns, twiddle factors, transforms of the rows (W. M. Gentleman and G. Sande, AFIPS Conf. Proc. 29,
563 (1966); D. H. Bailey, J. Supercomputing 4, 23 (1990)). The fourth step, a transposition, is left out: what
multiplies the modes is put into their order instead. docs/architecture.md says how the memory is gone over.

Two real columns are transformed as one complex column and then taken apart, so R/2 + 1 rows are all that is needed, and
long and short waves do not share their rounding. Columns that are worked on at a time are put where their values were,
as R/2 rows of twice as many values; only the last row, k = R/2, comes behind them.
"""

import math
import threading
from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from ...kernels import CHUNK, Call, layout, padded_length, undivided
from ..arrays import Array, Array64, Indices, Modes
from .backend import Transforms

FASTER = 2**20
"""Values from which it takes less time than FFTW's transforms. With measured plans those take 0.9 of the time on 2^20
values and as long on more, but measuring takes 10 to 80 s instead of half a second."""

_ROWS = 8  # that are transformed at a time
_SHORTEST_ROW = CHUNK // (2 * _ROWS)  # complex numbers; a multiple of the columns that are worked on at a time
_LONGEST_ROW = 2**12  # whose transform stays in the cache
_MOST_ROWS = 16  # over the columns: longer columns would not stay there
_TOGETHER = 33  # rows that are put into their order together; a power of two would push itself out of the cache

Worker = TypeVar("Worker")
Part = TypeVar("Part")


def row_length(num_points: int) -> int:
    """C, a power of two about as large as R = N/C, which is even and at most 16 C; 0 where there is none."""
    length = _LONGEST_ROW
    while length > _SHORTEST_ROW and (num_points % (2 * length) or (length // 2) ** 2 >= num_points):
        length //= 2
    return 0 if num_points % (2 * length) or num_points > _MOST_ROWS * length**2 else length


class FourStep(Transforms):
    """Transforms of N = R C values. spectrum: R/2 + 1 rows of C complex numbers, stored as the module's head has it."""

    way = "four-step"

    def prepare(self) -> None:
        self._row = row_length(self.num_points)
        if not self._row:
            powers = f"a power of two from {_SHORTEST_ROW} to {_LONGEST_ROW}"
            allowed = f"R C with C {powers} and R even, at most {_MOST_ROWS} C"
            raise ValueError(f"num_points is {self.num_points}; allowed for four steps: {allowed}")
        self._num_rows = self.num_points // self._row // 2 + 1
        batches = -(-self._num_rows // _ROWS), _ROWS, 2, self._row // layout.COLUMNS, layout.COLUMNS
        self.spectrum = self.buffer(max(math.prod(batches), padded_length(self.num_points)))
        self._batches = self.spectrum[: math.prod(batches)].reshape(batches).swapaxes(2, 3)
        """The spectrum by batches of rows, each in the order of its modes."""
        self._split = self.spectrum[: 2 * self._row * self._num_rows].reshape(-1, 2, self._row)
        """The spectrum by row, half of the columns worked on at a time, and value."""
        starts, rows = np.arange(0, self._row, layout.COLUMNS), np.arange(self._num_rows)
        near = self.buffer(2 * layout.COLUMNS * rows.size)
        turns = rows[:, None] * np.arange(layout.COLUMNS)
        self.complex(near)[: turns.size] = self._twiddle_factors(turns).ravel()
        far = np.zeros((starts.size, padded_length(2 * rows.size)), near.dtype)
        self.complex(far)[:, : rows.size] = self._twiddle_factors(starts[:, None] * rows)
        columns = [slice(start, start + layout.COLUMNS) for start in starts.tolist()]
        self._columns = list(zip(columns, far, strict=True))
        """Columns that are worked on at a time, with the first one's twiddle factors."""
        threads = min(self.threads, starts.size)
        self._workers = [_ColumnWorker(self.num_points // self._row, near, self) for _ in range(threads)]

    def _twiddle_factors(self, turns: Indices) -> Modes:
        return np.asarray(np.exp(-2j * np.pi / self.num_points * turns))

    def field(self) -> Array:
        return self.spectrum[: padded_length(self.num_points)]

    def forward(self, source: Array) -> Callable[[], None]:
        """Plan source[:N] -> columns transformed and turned; both may be the same memory."""
        values = source[: self.num_points].reshape(-1, self._row)

        def work(worker: _ColumnWorker, part: tuple[slice, Array]) -> None:
            columns, worker.far[:] = part
            worker.columns[:] = values[:, columns]
            worker.transform()
            worker.unpack()
            self._split[:, :, columns] = worker.spectra

        return lambda: do_all(self._workers, self._columns, work)

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan columns turned back and transformed -> target[:N], times R."""
        values = target[: self.num_points].reshape(-1, self._row)

        def work(worker: _ColumnWorker, part: tuple[slice, Array]) -> None:
            columns, worker.far[:] = part
            worker.spectra[:] = self._split[:, :, columns]
            worker.pack()
            worker.transform_back()
            values[:, columns] = worker.columns

        return lambda: do_all(self._workers, self._columns, work)

    def multiplication(self, symbol: Array64) -> Callable[[], None]:
        """The rows are transformed before, and back after it."""
        factors = self._by_row(symbol / self.num_points)
        doubled = self.doubled(factors.ravel())[: 2 * factors.size].reshape(self._num_rows, -1)
        workers = [_RowWorker(self._row, self) for _ in range(min(self.threads, len(self._batches)))]

        def work(worker: _RowWorker, batch: tuple[Array, Array]) -> None:
            values, factor = batch
            worker.factors[: factor.size] = factor.ravel()
            worker.values[:] = values
            worker.transform()
            worker.multiply()
            worker.transform_back()
            values[:] = worker.values

        rows = [doubled[start : start + _ROWS] for start in range(0, self._num_rows, _ROWS)]
        batches = list(zip(self._batches, rows, strict=True))
        return lambda: do_all(workers, batches, work)

    def _by_row(self, half: Array64) -> Array64:
        """All modes' values in the order of the spectrum, shape (R/2 + 1, C), from those of the half spectrum."""
        found = np.empty((self._num_rows, self._row))
        by_column = np.concatenate([half, half[-2:0:-1]]).reshape(self._row, -1)
        for start in range(0, self._num_rows, _TOGETHER):
            rows = slice(start, min(start + _TOGETHER, self._num_rows))
            found[rows] = by_column[:, rows].copy().T
        return found


class _RowWorker:
    """Buffers for some rows, plans and kernels on them. values: by row, columns worked on at a time, half of them, and
    value; factors: those of `multiply`.
    """

    def __init__(self, row: int, transforms: Transforms) -> None:
        """row: C."""
        rows = transforms.buffer(2 * row * _ROWS)
        self.values = rows.reshape(_ROWS, -1, 2, layout.COLUMNS)
        modes = transforms.complex(rows).reshape(_ROWS, row)
        self.transform = transforms.plan(modes, modes, "FFTW_FORWARD", threads=1)
        self.transform_back = transforms.plan(modes, modes, "FFTW_BACKWARD", threads=1)
        self.factors = transforms.buffer(rows.size)
        self.multiply = transforms.record([Call("spectral_multiply", (self.factors,), (rows,))])


class _ColumnWorker:
    """Buffers for some columns, plans and kernels on them. columns: shape (R, columns); spectra: shape (R/2 + 1, 2,
    columns), of two columns after the other; far: their first column's twiddle factors.
    """

    def __init__(self, num_rows: int, near: Array, transforms: Transforms) -> None:
        """near: twiddle factors from the first column."""
        count = num_rows // 2 + 1
        self.far = transforms.buffer(2 * count)
        columns, spectra = transforms.buffer(num_rows * layout.STRIDE), transforms.buffer(near.size)
        columns = columns[: num_rows * layout.STRIDE]
        self.columns = columns.reshape(-1, layout.STRIDE)[:, : layout.COLUMNS]
        self.spectra = spectra[: 2 * layout.COLUMNS * count].reshape(count, 2, layout.COLUMNS)
        modes = transforms.complex(self.columns)
        self.transform = transforms.plan(modes, modes, "FFTW_FORWARD", axis=0, threads=1)
        self.transform_back = transforms.plan(modes, modes, "FFTW_BACKWARD", axis=0, threads=1)
        self.unpack = transforms.record([Call("unpack_columns", (near, self.far, columns), (spectra,))])
        self.pack = transforms.record([Call("pack_columns", (near, self.far, spectra), (columns,))])


def do_all(workers: Sequence[Worker], parts: Sequence[Part], work: Callable[[Worker, Part], None]) -> None:
    """Do `work` on every part, each worker in a thread of its own, the first one in this thread.

    Python's lock is held for a small share of the time only: NumPy, FFTW and Warp give it back while they work. Returns
    when all workers have ended, and then raises the first error; Ctrl-C waits for that, too.
    """
    failed: list[BaseException] = []

    def in_turn(number: int) -> None:
        try:
            for part in parts[number :: len(workers)]:
                work(workers[number], part)
        except BaseException as error:
            failed.append(error)

    here, threads = [0], []
    with undivided():
        for number in range(1, len(workers)):
            thread = threading.Thread(target=in_turn, args=(number,))
            try:
                thread.start()
                threads.append(thread)
            except RuntimeError:  # no more threads, or the interpreter is about to end
                here.append(number)
        for number in here:
            in_turn(number)
        for thread in threads:
            thread.join()
    if failed:
        raise failed[0]
