"""A benchmark: named arrays with values like the solver's, the work on them, and how much that is."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from linecontact.kernels import CHUNK, Call, layout, padded_length
from numpy.typing import NDArray

Array = NDArray[Any]

READS = ("in", "part", "state")
"""Roles of inputs; all others are outputs."""

PRECISIONS = ("float32", "float64")
LARGEST = 2**28
"""The largest number of points."""

_QUANTUM, _LARGEST = 1 / 8, 2.0
"""Values of the check are multiples of the one up to the other, so that kernels and their sums are exact in float32."""


class Argument(NamedTuple):
    """An array that a benchmark works on."""

    name: str
    """As the kernels call it."""
    role: str
    """'in', 'out' and 'inout' hold one value per point; 'part' (read) and
    'sum' (written) one float64 per chunk, or several; 'state' (read) and 'control' (read and written) scalars."""

    @property
    def per_point(self) -> bool:
        """Whether it holds one value per point, in the precision asked for; all else is float64."""
        return self.role in ("in", "out", "inout")

    @property
    def per_chunk(self) -> int:
        """Sums per chunk."""
        return layout.PARTS if self.name == "sums" else 1

    def size(self, num_points: int) -> int:
        """Number of values that it holds."""
        if self.per_point:
            return _SIZES[self.name](num_points) if self.name in _SIZES else num_points
        return self.per_chunk * num_points // CHUNK if self.role in ("part", "sum") else layout.STATE_LENGTH

    def dtype(self, precision: str) -> str:
        """Type of its values."""
        return precision if self.per_point else "float64"

    def size_bytes(self, num_points: int, precision: str) -> int:
        """Memory that it takes [byte]; that of scalars is not counted."""
        if self.role in ("state", "control"):
            return 0
        return self.size(num_points) * np.dtype(self.dtype(precision)).itemsize

    def make(self, size: int, precision: str, rng: np.random.Generator, exact: bool) -> Array:
        """Make values like the solver's: forces of both signs, a third of the nodes on the wall, no decay.

        exact: round them so that nothing that a kernel makes of them is rounded.
        """
        few = min(size, 65521)  # repeated: drawing takes long; a prime, so that no two chunks are alike
        values, on_wall = rng.standard_normal(few), rng.random(few) < 0.3
        if exact:
            values = np.clip(np.round(values / _QUANTUM) * _QUANTUM, -_LARGEST, _LARGEST)
        if not self.per_point:
            values = np.abs(values)
        elif self.name in _VALUES:
            values = _VALUES[self.name](values, on_wall)
        return np.resize(values.astype(self.dtype(precision)), size)


_SIZES: dict[str, Callable[[int], int]] = {
    "far": lambda n: n // layout.COLUMNS,
    "columns": lambda n: (n // layout.COLUMNS - 2) * layout.STRIDE,
}
"""Of the arrays of a four-step transform whose spectra, and twiddle factors near the first column, are n values."""

_VALUES: dict[str, Callable[[Array, Array], Array]] = {
    "coefficient": lambda x, _: np.where(x < 0, -1, 1) * (1 + np.clip(np.round(x), -1, 1) / 32),  # used again and again
    "weight": lambda x, _: np.where(x < 0, -1, 1),
    "velocity": lambda x, wall: np.where(wall, layout.TOUCHING, x),
    "v": lambda x, wall: np.where(wall, layout.TOUCHING, x),
    "force": lambda x, wall: np.where(wall, 0.0, x),
    "h": lambda x, _: np.abs(x),
    "u": lambda x, _: -np.abs(x),
}


@dataclass(frozen=True)
class Benchmark:
    """Something that is measured."""

    name: str
    """Unique among all benchmarks."""
    group: str
    """'kernels', 'sequences' of them, whole 'iterations', 'transforms', or 'roofs' of the memory."""
    arguments: str
    """'name:role ...'; of a kernel in its order, inputs first."""
    flops: Callable[[int], float] = lambda num_points: 0.0
    """From the number of points to the floating-point operations of a call, comparisons not counted."""
    c: str = ""
    """Body of the loop over i in C, where a 'sum' is an array of one chunk's."""
    c_scalars: str = ""
    """C's reads from the state before the loop."""
    c_whole: str = ""
    """Body of a C function that is no loop over points, instead of `c`."""
    state: dict[str, float] = field(default_factory=dict)
    """Values of the state by the names of their slots."""
    lines: tuple[Call, ...] = ()
    """Kernels and transforms in order, with the names of the arrays that they work on."""
    parts: tuple["Benchmark", ...] = ()
    """The benchmarks of these kernels and transforms by themselves."""

    @cached_property
    def arrays(self) -> list[Argument]:
        """The arguments, one by one."""
        return [Argument(*text.split(":")) for text in self.arguments.split()]

    def length(self, argument: Argument, num_points: int) -> int:
        """Number of values that one of its arrays holds, padding included."""
        spectral = self.transforms and argument.name in ("spectrum", "coefficient", "weight")
        return padded_length(num_points + 2) if spectral else argument.size(num_points)

    @cached_property
    def steps(self) -> tuple[Call, ...]:
        """Its steps, in order; of a kernel the only line."""
        inputs = tuple(a.name for a in self.arrays if a.role in READS)
        return self.lines or (Call(self.name, inputs, tuple(a.name for a in self.arrays if a.role not in READS)),)

    @property
    def transforms(self) -> bool:
        """Whether it is a transform, or there is one in it."""
        return self.group == "transforms" or any(part.transforms for part in self.parts)

    @property
    def way(self) -> str:
        """How its real transforms are done, see `linecontact.solver.transforms.planned`."""
        return "four-step" if any(line.kernel == "product" for line in self.lines) else "real"

    def traffic(self, num_points: int, precision: str) -> int:
        """Bytes that a call reads and writes: each array once, and arrays changed in place twice; of several kernels
        the sum. A transform counts as one pass."""
        if self.parts:
            return sum(part.traffic(num_points, precision) for part in self.parts)
        return sum((1 + (a.role == "inout")) * a.size_bytes(num_points, precision) for a in self.arrays)

    def operations(self, num_points: int) -> float:
        """Floating-point operations of a call."""
        return sum(part.operations(num_points) for part in self.parts) if self.parts else self.flops(num_points)

    def working_set(self, num_points: int, precision: str) -> int:
        """Bytes of all arrays."""
        return sum(a.size_bytes(num_points, precision) for a in self.arrays)

    def make(self, num_points: int, precision: str, exact: bool = False) -> dict[str, Array]:
        """Make the values of every array by name; outputs that are not read are zeros. exact: see `Argument.make`."""
        rng = np.random.default_rng(0)
        made = {a.name: a.make(self.length(a, num_points), precision, rng, exact) for a in self.arrays}
        for argument in self.arrays:
            values = made[argument.name]
            if argument.role in ("state", "control"):
                values[:] = 0
                for slot, value in self.state.items():
                    values[getattr(layout, slot)] = value
            elif argument.role in ("out", "sum"):
                values[:] = 0
            elif self.transforms and argument.name in ("coefficient", "weight"):
                values /= num_points  # the transforms' factor
        return made


def compose(name: str, group: str, lines: tuple[Call, ...], known: dict[str, Benchmark]) -> Benchmark:
    """The benchmark of several kernels and transforms in order. known: the benchmark of each by itself."""
    roles: dict[str, str] = {}
    state: dict[str, float] = {}
    for line in lines:
        part = known[line.kernel]
        state |= part.state
        for array, argument in zip((*line.inputs, *line.outputs), part.arrays, strict=True):
            first = roles.get(array, "in")
            roles[array] = argument.role if first in ("in", "state") else first
    arguments = " ".join(f"{array}:{role}" for array, role in roles.items())
    parts = tuple(known[line.kernel] for line in lines)
    return Benchmark(name, group, arguments, state=state, lines=lines, parts=parts)
