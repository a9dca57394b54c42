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

from collections.abc import Callable, Iterator

import numpy as np

from ...kernels import CHUNK, Call, layout, padded_length
from ..arrays import Array, Array64, Modes
from .columns import Columns
from .planner import Planner
from .sharing import do_all

FASTER = 2**20
"""Values from which it takes less time than any other way, if FFTW estimates: 0.7 of the next one's at first, 0.6 on
2^22."""
_FASTER_THAN_REAL = 2**18
"""Values, in float64, from which it takes less time than real transforms."""

_ROWS = 8  # that are transformed at a time
_SHORTEST_ROW = CHUNK // (2 * _ROWS)  # complex numbers; a multiple of the columns that are worked on at a time
_LONGEST_ROW = 2**12  # whose transform stays in the cache
_MOST_ROWS = 16  # over the columns: longer columns would not stay there
_TOGETHER = 32  # rows whose modes are put into their order together


def row_length(num_points: int) -> int:
    """C, a power of two about as large as R = N/C, which is even and at most 16 C; 0 where there is none."""
    length = _LONGEST_ROW
    while length > _SHORTEST_ROW and (num_points % (2 * length) or (length // 2) ** 2 >= num_points):
        length //= 2
    return 0 if num_points % (2 * length) or num_points > _MOST_ROWS * length**2 else length


def is_faster(num_points: int, planner: Planner, apart: bool) -> bool:
    """Whether it takes less time than the other ways that are allowed; apart: only real transforms are."""
    least = _FASTER_THAN_REAL if apart and planner.real == np.float64 else FASTER
    return num_points >= least and row_length(num_points) > 0 and planner.has_poor_plan(num_points)


class FourStep:
    """Transforms of N = R C values. spectrum: R/2 + 1 rows of C complex numbers, stored as the module's head has it."""

    def __init__(self, num_points: int, planner: Planner) -> None:
        self.num_points, self.planner = num_points, planner
        self._row = row_length(num_points)
        if not self._row:
            powers = f"a power of two from {_SHORTEST_ROW} to {_LONGEST_ROW}"
            allowed = f"R C with C {powers} and R even, at most {_MOST_ROWS} C"
            raise ValueError(f"num_points is {num_points}; allowed for four steps: {allowed}")
        self._num_rows = num_points // self._row // 2 + 1
        self._num_batches = -(-self._num_rows // _ROWS)
        self.spectrum = planner.buffer(max(self._num_batches * self._batch_size, padded_length(num_points)))
        self._columns = Columns(num_points, self._row, planner)

    @property
    def _batch_size(self) -> int:
        """Values of the rows that are transformed at a time."""
        return 2 * self._row * _ROWS

    def field(self) -> Array:
        """A buffer for N values that are transformed there and back; it shares the spectrum's memory."""
        return self.spectrum[: padded_length(self.num_points)]

    def forward(self, source: Array) -> Callable[[], None]:
        """Plan source[:N] -> columns transformed and turned."""
        return self._columns.forward(source[: self.num_points].reshape(-1, self._row), self._split)

    def inverse(self, target: Array) -> Callable[[], None]:
        """Plan columns turned back and transformed -> target[:N], times R."""
        return self._columns.inverse(self._split, target[: self.num_points].reshape(-1, self._row))

    @property
    def _split(self) -> Array:
        """The spectrum by row, half of the columns worked on at a time, and value."""
        return self.spectrum[: 2 * self._row * self._num_rows].reshape(-1, 2, self._row)

    @property
    def _batches(self) -> Array:
        """The spectrum by batches of rows, each in the order of its modes."""
        batches = self.spectrum[: self._num_batches * self._batch_size]
        by_halves = batches.reshape(-1, _ROWS, 2, self._row // layout.COLUMNS, layout.COLUMNS)
        return by_halves.swapaxes(2, 3)

    def multiplication(self, symbol: Array64, target: Array) -> Callable[[], None]:
        """See `planned.Transforms.multiplication`; the rows are transformed before, and back after it. It is the same
        for every target, and recorded in any case.
        """
        factors = self._by_row(symbol)
        factors /= self.num_points
        workers = [_Worker(self._row, self.planner) for _ in range(min(self.planner.threads, self._num_batches))]
        batches = list(zip(self._batches, self._in_batches(factors), strict=True))

        def work(worker: _Worker, batch: tuple[Array, Array]) -> None:
            values, worker.factors[:] = batch
            worker.values[:] = values
            worker.transform()
            worker.multiply()
            worker.transform_back()
            values[:] = worker.values

        return lambda: do_all(workers, batches, work)

    def multiply_once(self, symbol: Array64) -> None:
        """What `multiplication` does, without anything that would serve again."""
        worker, factors = _Worker(self._row, self.planner), self._by_row(symbol)
        factors /= self.num_points
        for values, factor in self._with(factors):
            worker.values[:] = values
            worker.transform()
            worker.modes[: len(factor)] *= factor
            worker.transform_back()
            values[:] = worker.values

    def power(self, symbol: Array64) -> float:
        """The sum of a symbol times |x_k|^2 over all N modes, after a forward transform; see `pair.Pair.power`."""
        worker, factors, total = _Worker(self._row, self.planner), self._by_row(symbol), 0.0
        factors[1 : self.num_points // self._row - self._num_rows + 1] *= 2  # for the rows that are not needed
        for values, factor in self._with(factors):
            worker.values[:] = values
            worker.transform()
            found = worker.modes[: len(factor)]
            total += sum(float(np.einsum("ij,ij,ij", factor, part, part)) for part in (found.real, found.imag))
        return total / self.num_points

    def _with(self, factors: Array64) -> Iterator[tuple[Array, Array64]]:
        """The batches, each with the factors of its rows; factors: by row, see `_by_row`."""
        for number, values in enumerate(self._batches):
            yield values, factors[number * _ROWS : (number + 1) * _ROWS]

    def put(self, half: Modes | Array64) -> None:
        """Make the spectrum that has this half, shape (N//2 + 1,), with the rows transformed back and normalised."""
        worker, real = _Worker(self._row, self.planner), self._by_row(half.real)
        imaginary = self._by_row(half.imag, conjugate=True) if np.iscomplexobj(half) else None
        if imaginary is not None:
            imaginary[0, [0, self._row // 2]] = 0  # the mean and the Nyquist mode are real
        for start, values in zip(range(0, self._num_rows, _ROWS), self._batches, strict=True):
            found = worker.modes[: self._num_rows - start]
            np.divide(real[start : start + _ROWS], self.num_points, out=found.real)
            found.imag = 0 if imaginary is None else imaginary[start : start + _ROWS] / self.num_points
            worker.transform_back()
            values[:] = worker.values

    def _in_batches(self, values: Array64) -> Array:
        """What the kernel multiplies the rows by, shape (batches of rows, values): each value twice."""
        size = self._num_batches * self._batch_size
        factors = self.planner.buffer(size)[:size]
        factors[: 2 * values.size].reshape(-1, 2)[:] = values.reshape(-1, 1)
        return factors.reshape(self._num_batches, -1)

    def _by_row(self, half: Array64, conjugate: bool = False) -> Array64:
        """All modes' values in the order of the spectrum, shape (R/2 + 1, C), from those of the half spectrum;
        conjugate: the others have the opposite sign.
        """
        by_column = half[:-1].reshape(self._row // 2, -1)  # k + R m by m and k
        found = np.empty((self._num_rows, self._row))
        first, others = np.split(found, 2, axis=1)
        few = np.empty((self._row // 2, _TOGETHER + 1))  # far faster than all at once; one more for the cache
        for start in range(0, self._num_rows, _TOGETHER):
            stop = min(start + _TOGETHER, self._num_rows)
            here = few[:, : stop - start]
            here[:] = by_column[:, start:stop]
            first[start:stop] = here.T
            after = max(start, 1)
            here = few[:, : stop - after]
            here[:] = by_column[:, by_column.shape[1] - stop + 1 : by_column.shape[1] - after + 1]  # N - k - R m
            others[after:stop] = here[::-1, ::-1].T
        others[0, 0], others[0, 1:] = half[-1], first[0, :0:-1]
        if conjugate:
            others *= -1
        return found


class LongPair:
    """Transforms of N values there and back with buffers of their own, as `pair.Pair`. real: buffer of N values."""

    def __init__(self, num_points: int) -> None:
        self._way = way = FourStep(num_points, Planner("float64", 1, "estimate", "warp"))
        field = way.field()
        self.real: Array64 = field[:num_points]
        self._forward, self._inverse = way.forward(field), way.inverse(field)

    def multiply(self, values: Array64, symbol: Array64) -> None:
        """As `pair.Pair.multiply`."""
        self._way.forward(values)()
        self._way.multiply_once(symbol)
        self._inverse()

    def invert(self, modes: Modes | Array64) -> Array64:
        """`real` with the half spectrum `modes`, shape (N//2 + 1,), normalised by 1/N."""
        self._way.put(modes)
        self._inverse()
        return self.real

    def power(self, symbol: Array64) -> float:
        """As `pair.Pair.power`."""
        self._forward()
        return self._way.power(symbol)


class _Worker:
    """Buffers for some rows, plans and kernels on them. values: by row, columns worked on at a time, half of them, and
    value; modes: the same, shape (rows, C); factors: what `multiply` multiplies them by.
    """

    def __init__(self, row: int, planner: Planner) -> None:
        """row: C."""
        rows = planner.buffer(2 * row * _ROWS)
        self.values = rows.reshape(_ROWS, -1, 2, layout.COLUMNS)
        self.modes = modes = planner.complex(rows).reshape(_ROWS, row)
        self.transform = planner.plan(modes, modes, "FFTW_FORWARD", threads=1)
        self.transform_back = planner.plan(modes, modes, "FFTW_BACKWARD", threads=1)
        self.factors = planner.buffer(rows.size)
        self.multiply = planner.record([Call("spectral_multiply", (self.factors,), (rows,))])
