"""The operator of the active set: the response of all nodes to a pressure on the contact nodes."""

from ....kernels import record
from ...arrays import Array64, Indices
from ...transforms.planned import Transforms
from .storage import Whole


class Compliance:
    """G = 1/K without the mean mode, applied by one pair of transforms, in the precision of the transforms.

    The symbol, G(q_k), has the shape (N//2 + 1,) [1/K]. The transforms have the storage's length.
    """

    def __init__(self, symbol: Array64, storage: Whole, transforms: Transforms, backend: str) -> None:
        self.new_field = transforms.buffer
        """Makes a field like the target."""
        self.target = transforms.buffer()
        forward, inverse = transforms.forward(self.target), transforms.inverse(self.target)
        self._parts = forward, record(backend, [storage.multiply(symbol, transforms, self.target)]), inverse
        self.pair_length = storage.length / storage.num_points
        """Length of its transforms over N (dimensionless)."""

    def apply(self, places: Indices, values: Array64) -> None:
        """target = G values; values: pressure, 0 at all other places, both of shape (contact nodes,)."""
        self.target[:] = 0
        self.target[places] = values
        for part in self._parts:
            part()
