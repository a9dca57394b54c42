"""A field of all nodes that an operator makes and adds to: with G the response w = G sigma to a contact pressure,
with K the force K u of a displacement.
"""

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from ....kernels import CHUNK, Call, layout, record
from ...arrays import Array, Array64, Indices
from ...grid.cached import MOST_POINTS
from ...transforms.planned import plan_transforms
from ..method import ExecutionConfig


class Operator:
    """G = 1/K without the mean mode, or K, applied by one pair of transforms, in the precision of the transforms."""

    def __init__(self, symbol: Array64, num_points: int, precision: str, config: ExecutionConfig) -> None:
        transforms = plan_transforms(num_points, precision, config.threads, config.planning, config.backend)
        self.new_field = transforms.buffer
        self.target = transforms.field()
        forward, inverse = transforms.forward(self.target), transforms.inverse(self.target)
        self._parts = forward, transforms.multiplication(symbol, self.target), inverse

    def apply(self, places: Indices | slice, values: Array64) -> Array:
        """`target` after it was these values at these places and 0 elsewhere."""
        self.target[:] = 0
        self.target[places] = values
        for part in self._parts:
            part()
        return self.target


class Everywhere:
    """The field of an operator, on all nodes: w [u] or K u [p]. It serves after `begin`, one solve at a time."""

    def __init__(self, symbol: Array64, num_points: int, config: ExecutionConfig) -> None:
        """symbol: of the operator, shape (N//2 + 1,); num_points: N."""
        self._symbol, self._num_points, self._config = symbol, num_points, config
        self.mixed = config.precision == "mixed"
        """Whether images of search directions are float32 and the field is float64."""
        self.field = self._operators[1].new_field()
        """Shape (N,) and padding."""
        self.pairs = 0.0
        """Transform pairs in this solve, short ones by their length over N."""
        self._state = np.zeros(layout.GAP_STATE_LENGTH)
        self._counts = np.zeros(self.field.size // CHUNK)

    def begin(self, height: Array64) -> None:
        """Turn to a scene. height: h, shape (N,) [u]."""
        self.pairs = 0.0
        self.field[:] = 0  # of an earlier solve
        self._height: Array = height
        if self.field.shape != height.shape or self.field.dtype != height.dtype:
            self._height = np.full_like(self.field, math.inf)  # padding never touches
            self._height[: height.size] = height
        self.__dict__.pop("_count", None)

    @cached_property
    def _operators(self) -> tuple[Operator, Operator]:
        """For search directions and for the field itself: two objects in mixed precision, else the same one."""
        of = self._symbol, self._num_points
        directions = Operator(*of, self._config.working_precision, self._config)
        return directions, Operator(*of, "float64", self._config) if self.mixed else directions

    @cached_property
    def _advance(self) -> Callable[[], None]:
        call = Call("advance_response", (self._operators[0].target, self._state), (self.field,))
        return record(self._config.backend, [call])

    @cached_property
    def _count(self) -> Callable[[], None]:
        call = Call("count_below", (self.field, self._height, self._state), (self._counts,))
        return record(self._config.backend, [call])

    def rest(self) -> None:
        """Give back the operators on a large grid; they are made anew when they are needed."""
        for name in ("_advance", "_operators") if self._num_points > MOST_POINTS else ():
            self.__dict__.pop(name, None)

    def renew(self, places: Indices | slice, values: Array64) -> None:
        """Make the field of values at these places, 0 elsewhere."""
        self.pairs += 1
        self.field[:] = self._operators[1].apply(places, values)

    def places(self, nodes: Indices) -> Indices:
        """Where these nodes have their values."""
        return nodes

    def image(self, places: Indices | slice, direction: Array64) -> Array:
        """The image of a search direction at these places, in the precision of its transforms, there."""
        self.pairs += 1
        return np.asarray(self._operators[0].apply(places, direction)[places])

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
