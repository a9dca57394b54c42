"""Fields and transforms that a solve leaves to the next one with the same layer on the same grid.

Made anew for every solve they take a twentieth of its time.
"""

import math
import weakref
from collections import defaultdict
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np

from ...arrays import Array64
from ...transforms.planned import Transforms
from ..method import ExecutionConfig
from .compliance import Compliance
from .everywhere import Everywhere, Operators

_MOST_POINTS = 2**18
"""Of a grid whose fields are kept: they take 40 bytes a point."""

_TIMES_ROUNDING = 50
"""Tolerance over the relative error that rounding of the strongest mode puts into the weakest, down to which transforms
may be of half the length: these take less time, but mix the rounding of long and short waves."""

User = TypeVar("User")


@dataclass(frozen=True)
class Loan:
    """A field with its operator, for one user at a time."""

    everywhere: Everywhere
    """The field."""
    shelf: list[Everywhere]
    """Where it belongs."""
    kept: bool
    """Whether it is given back."""

    def to(self, user: User) -> User:
        """Give it back when this user is gone."""
        if self.kept:
            weakref.finalize(user, self.shelf.append, self.everywhere).atexit = False
        return user


class Spare:
    """What solves with one layer on one grid have left."""

    def __init__(self) -> None:
        self._shelves: dict[tuple[object, ...], list[Everywhere]] = defaultdict(list)

    def lend(self, symbol: Array64, name: str, num_points: int, setting: ExecutionConfig) -> Loan:
        """The field of an operator: one that is free, or a new one.

        symbol: of the operator, shape (N//2 + 1,), always the same by that name; num_points: N.
        """
        kept = num_points <= _MOST_POINTS
        apart = setting.tolerance <= _TIMES_ROUNDING * _rounding_of(symbol)
        means = setting.precision, setting.threads, setting.planning, setting.backend
        shelf = self._shelves[name, apart, *means]
        try:
            return Loan(shelf.pop(), shelf, kept)
        except IndexError:  # all are in use
            make = partial(_operators, symbol, num_points, setting, apart=apart)
            return Loan(Everywhere(make, setting.backend, large=not kept), shelf, kept)


def _rounding_of(symbol: Array64) -> float:
    """Relative error that rounding of an operator's strongest mode to float64 puts into its weakest."""
    weakest = float(symbol[1:].min())
    return float(np.finfo(np.float64).eps) * float(symbol.max()) / weakest if weakest > 0 else math.inf


def _operators(symbol: Array64, num_points: int, setting: ExecutionConfig, apart: bool) -> Operators:
    """For search directions and for the field itself."""

    def operator(precision: str) -> Compliance:
        how = setting.threads, setting.planning, setting.backend
        return Compliance(symbol, Transforms(num_points, precision, *how, apart=apart))

    directions = operator(setting.working_precision)
    return directions, operator("float64") if setting.precision == "mixed" else directions
