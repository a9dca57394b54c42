"""Long real transforms in four steps, on parts that fit into the processor's cache.

N = R C values stand in R rows of C columns, x_(C r + c). With w_N = exp(-2 pi i/N), mode k + R m is

    X_(k + R m) = sum_c w_C^(c m) { w_N^(c k) [ sum_r w_R^(r k) x_(C r + c) ] }:

transforms of the columns, twiddle factors, transforms of the rows (W. M. Gentleman and G. Sande, AFIPS Conf. Proc. 29,
563 (1966); D. H. Bailey, J. Supercomputing 4, 23 (1990)). The fourth step, a transposition, is left out: what
multiplies the modes is put into their order instead. So a transform there and back goes over the memory three times:
forward along the columns, along the rows there and back with the multiplication in between, backward along the columns.
FFTW's plans for long transforms go over it many times.

Two real columns are transformed as one complex column and then taken apart, so R/2 + 1 rows are all that is needed, and
long and short waves do not share their rounding. Columns that are worked on at a time are put where their values were,
as R/2 rows of twice as many values; only the last row, k = R/2, comes behind them.
"""

import math
from collections.abc import Callable

import numpy as np

from ...kernels import CHUNK, Call, layout, padded_length
from ..arrays import Array, Array64
from .columns import Columns
from .planner import Transforms
from .sharing import do_all

FASTER = 2**20
"""Values from which it takes less time than FFTW's transforms, if FFTW estimates."""

_ROWS = 8  # that are transformed at a time
_SHORTEST_ROW = CHUNK // (2 * _ROWS)  # complex numbers; a multiple of the columns that are worked on at a time
_LONGEST_ROW = 2**12  # whose transform stays in the cache
_MOST_ROWS = 16  # over the columns: longer columns would not stay there
_TOGETHER = 33  # rows that are put into their order together; a power of two would push itself out of the cache


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
        self._columns = Columns(self.num_points, self._row, self)

    def field(self) -> Array:
        return self.spectrum[: padded_length(self.num_points)]

    def forward(self, source: Array) -> Callable[[], None]:
        """Plan source[:N] -> columns transformed and turned."""
        return self._columns.forward(source[: self.num_points].reshape(-1, self._row), self._split)

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan columns turned back and transformed -> target[:N], times R."""
        return self._columns.inverse(self._split, target[: self.num_points].reshape(-1, self._row))

    def multiplication(self, symbol: Array64, target: Array) -> Callable[[], None]:
        """The rows are transformed before, and back after it. It is the same for every target."""
        factors = self._by_row(symbol / self.num_points)
        doubled = self.doubled(factors.ravel())[: 2 * factors.size].reshape(self._num_rows, -1)
        workers = [_Worker(self._row, self) for _ in range(min(self.threads, len(self._batches)))]

        def work(worker: _Worker, batch: tuple[Array, Array]) -> None:
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


class _Worker:
    """Buffers for some rows, plans and kernels on them. values: by row, columns worked on at a time, half of them, and
    value; factors: those of `multiply`.
    """

    def __init__(self, row: int, planner: Transforms) -> None:
        """row: C."""
        rows = planner.buffer(2 * row * _ROWS)
        self.values = rows.reshape(_ROWS, -1, 2, layout.COLUMNS)
        modes = planner.complex(rows).reshape(_ROWS, row)
        self.transform = planner.plan(modes, modes, "FFTW_FORWARD", threads=1)
        self.transform_back = planner.plan(modes, modes, "FFTW_BACKWARD", threads=1)
        self.factors = planner.buffer(rows.size)
        self.multiply = planner.record([Call("spectral_multiply", (self.factors,), (rows,))])
