"""The operator of the active set: G on a pressure of the contact nodes, or K on a displacement of the free nodes."""

from ...arrays import Array64, Indices
from ...transforms.planned import Transforms


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
