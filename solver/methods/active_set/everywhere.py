"""A field of all nodes that an operator makes and adds to, and the kernels that work on it.

With G it is the response w = G sigma to the contact pressure: a node's gap is h + w - level, the level being the rigid
approach. With K it is the net force r = 1 - K u.
"""

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from ....kernels import CHUNK, Call, layout, record
from ...arrays import Array, Array64, Indices
from ...grid.cached import MOST_POINTS
from ...transforms.planned import plan_transforms
from ...transforms.planner import Transforms
from ..method import ExecutionConfig

_TIMES_ROUNDING = 50
"""Tolerance over the relative error that rounding of the strongest mode puts into the weakest, down to which transforms
may be of half the length: these take less time, but mix the rounding of long and short waves."""


def modes_apart(symbol: Array64, tolerance: float) -> bool:
    """Whether the rounding of no mode may spoil another one of an operator, for a tolerance (dimensionless)."""
    weakest = float(symbol[1:].min())
    rounding = np.finfo(np.float64).eps * float(symbol.max()) / weakest if weakest > 0 else math.inf
    return bool(tolerance <= _TIMES_ROUNDING * rounding)


class Compliance:
    """G = 1/K without the mean mode, or K, applied by one pair of transforms, in the precision of the transforms.

    The symbol, G(q_k) or K(q_k), has the shape (N//2 + 1,).
    """

    def __init__(self, symbol: Array64, transforms: Transforms) -> None:
        self.new_field = transforms.buffer
        """Makes a field of the target's length and type."""
        self.target = transforms.field()
        forward, inverse = transforms.forward(self.target), transforms.inverse(self.target)
        multiply = transforms.multiplication(symbol, self.target)
        self._parts = forward, multiply, inverse

    def apply(self, places: Indices | slice, values: Array64) -> None:
        """target = G values, or K values; values: 0 at all other places, of the places' shape."""
        self.target[:] = 0
        self.target[places] = values
        for part in self._parts:
            part()


class Everywhere:
    """The field of an operator, on all nodes: w [u] or r [p]."""

    def __init__(self, symbol: Array64, height: Array64, config: ExecutionConfig, apart: bool) -> None:
        """symbol: of the operator, shape (N//2 + 1,); height: h, shape (N,) [u]; apart: see `modes_apart`."""
        self._symbol, self._config, self._num_points, self._apart = symbol, config, height.size, apart
        self.mixed = config.precision == "mixed"
        """Whether images of search directions are float32 and the field is float64."""
        self.field = self._operators[1].new_field()
        """Shape (N,) and padding."""
        self._state = np.zeros(layout.GAP_STATE_LENGTH)
        self.begin(height)

    def begin(self, height: Array64) -> None:
        """Turn to another scene. height: h, shape (N,) [u]."""
        self.field[:] = 0  # what an earlier solve has left
        self._height: Array = height
        if self.field.shape != height.shape or self.field.dtype != height.dtype:
            self._height = np.full_like(self.field, math.inf)  # padding never touches
            self._height[: height.size] = height
        self._counts = np.zeros(self._height.size // CHUNK)
        self.__dict__.pop("_count", None)

    @cached_property
    def _operators(self) -> tuple[Compliance, Compliance]:
        """For search directions and for the field itself: two objects in mixed precision, else the same one."""
        config = self._config

        def operator(precision: str) -> Compliance:
            how = config.threads, config.planning, config.backend
            return Compliance(self._symbol, plan_transforms(self._num_points, precision, *how, apart=self._apart))

        directions = operator(config.working_precision)
        return directions, operator("float64") if self.mixed else directions

    @cached_property
    def _advance(self) -> Callable[[], None]:
        call = Call("advance_response", (self._operators[0].target, self._state), (self.field,))
        return record(self._config.backend, [call])

    def rest(self) -> None:
        """Give back the operators on a large grid; they are made anew when they are needed."""
        for name in ("_advance", "_operators") if self._num_points > MOST_POINTS else ():
            self.__dict__.pop(name, None)

    @cached_property
    def _count(self) -> Callable[[], None]:
        call = Call("count_below", (self.field, self._height, self._state), (self._counts,))
        return record(self._config.backend, [call])

    def renew(self, places: Indices, pressure: Array64) -> None:
        """Make the response to a pressure at these places, 0 elsewhere [p]."""
        whole = self._operators[1]
        whole.apply(places, pressure)
        self.field[:] = whole.target

    def renew_force(self, displacement: Array64) -> None:
        """Make the net force 1 - K u of a displacement, shape (N,) [u]."""
        whole = self._operators[1]
        whole.apply(slice(displacement.size), displacement)
        np.subtract(1, whole.target, out=self.field)

    def image(self, places: Indices, direction: Array64) -> Array:
        """The image of a search direction at these places, in the precision of its transforms, there."""
        directions = self._operators[0]
        directions.apply(places, direction)
        return np.asarray(directions.target[places])

    def advance(self, step: float) -> None:
        """Add the latest image times a step."""
        self._state[layout.STEP] = step
        self._advance()

    def below(self, bound: float) -> Indices:
        """Nodes where h + w is below a bound [u]."""
        self._state[layout.BOUND] = bound
        self._count()
        chunks = np.flatnonzero(self._counts)
        height, response = (array.reshape(-1, CHUNK)[chunks] for array in (self._height, self.field))
        row, column = np.nonzero(height + response < bound)
        return np.asarray(chunks[row] * CHUNK + column)
