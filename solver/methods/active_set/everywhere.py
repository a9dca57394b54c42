"""The response to the contact pressure on all nodes, in fields in the storage's order, and the kernels that work on it.

A node's gap is h + w - level, w = G sigma being the response and the level the rigid approach.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ....kernels import CHUNK, Call, layout, record
from ...arrays import Array, Array64, Indices
from .compliance import Compliance
from .storage import Whole

Operators = tuple[Compliance, Compliance]
"""G on search directions and on the pressure: two objects in mixed precision, else the same one."""


class Everywhere:
    """w = G sigma on all nodes. height: h, shape (N,) [u]."""

    def __init__(self, height: Array64, storage: Whole, make_operators: Callable[[], Operators], backend: str) -> None:
        self._storage, self._make_operators, self._backend = storage, make_operators, backend
        directions, responses = self._operators
        self.mixed = directions is not responses
        """Whether images of search directions are float32 and the response is float64."""
        self.pair_length = responses.pair_length
        """Length of the transforms over N (dimensionless)."""
        self.field = responses.new_field()
        """w [u], of the storage's length and padding."""
        self._height = storage.heights(height, self.field)
        self._state = np.zeros(layout.GAP_STATE_LENGTH)
        self._counts = np.zeros(self._height.size // CHUNK)

    @cached_property
    def _operators(self) -> Operators:
        return self._make_operators()

    @cached_property
    def _advance(self) -> Callable[[], None]:
        call = Call("advance_response", (self._operators[0].target, self._state), (self.field,))
        return record(self._backend, [call], seldom=True)

    def rest(self) -> None:
        """Give back the operators; they are made anew when they are needed."""
        for name in ("_advance", "_operators"):
            self.__dict__.pop(name, None)

    @cached_property
    def _count(self) -> Callable[[], None]:
        call = Call("count_below", (self.field, self._height, self._state), (self._counts,))
        return record(self._backend, [call], seldom=True)

    def renew(self, places: Indices, pressure: Array64) -> None:
        """Make the response to a pressure at these places, 0 elsewhere [p]."""
        responses = self._operators[1]
        responses.apply(places, pressure)
        self.field[:] = responses.target

    def image(self, places: Indices, direction: Array64) -> Array:
        """The response to a search direction at these places, in the precision of its transforms, there [u]."""
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
        return self._storage.nodes_at(chunks[row] * CHUNK + column)

    def at(self, nodes: Indices) -> Array:
        """The response at some nodes [u]."""
        return np.asarray(self.field[self._storage.places(nodes)])
