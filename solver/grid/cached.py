"""What follows from a layer or an indenter on a grid is kept for the next solve: a curve, an ensemble or a moved slider
solves many scenes with the same layer on the same grids.
"""

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import Any, TypeVar

from ..arrays import Array64

Made = TypeVar("Made")

_GRIDS = 7  # whose results are kept, which is those of one scene on nested grids
MOST_POINTS = 2**20
"""Of a grid whose results are kept: they take some 100 bytes a point."""
_BY_IDENTITY: Any = object.__hash__
_clearing: list[Callable[[], None]] = []  # of every function: forgets what it has kept


def cached(make: Callable[[Any, int, float], Made]) -> Callable[[Any, int, float], Made]:
    """A function of a layer or an indenter, the grid's points and the period, whose latest results are kept.

    What it makes is used again and must not be changed: arrays should be made read-only. Layers and indenters that
    cannot be hashed, or whose hash does not know of a change, and grids of more than 2^20 points are computed anew
    every time.
    """
    known = lru_cache(maxsize=_GRIDS)(make)
    _clearing.append(known.cache_clear)

    @wraps(make)
    def call(part: Any, num_points: int, period: float) -> Made:
        try:
            hash(part)
        except TypeError:
            return make(part, num_points, period)
        by_value = type(part).__hash__ is not _BY_IDENTITY
        return (known if by_value and num_points <= MOST_POINTS else make)(part, num_points, period)

    return call


def read_only(values: Array64) -> Array64:
    """A view of values that are used again, which must not be changed."""
    found = values.view()
    found.flags.writeable = False
    return found


def forget() -> None:
    """Forget what is kept of layers and indenters: for measurements, for tests, and after a class was changed."""
    for clear in _clearing:
        clear()
