"""The members that an indenter must have, and those that it may have.

A new indenter is a frozen dataclass that inherits from `Indenter`. It must offer everything without a default here.
Heights come in units of the period L, so that a shape has no unit of its own.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar, Self

import numpy as np

from ..arrays import Array64
from ..value import Kind

_SIXTH, _EIGHTH = (45 / 60, -9 / 60, 1 / 60), (4 / 5, -1 / 5, 4 / 105, -1 / 280)
"""Shares of the nodes on either side in central differences of that order."""


class Indenter(Kind):
    """A rigid, periodic indenter, as the program needs to know it."""

    part: ClassVar[str] = "profile"

    knows_lowest: ClassVar[bool] = False
    """Whether `depth_between_nodes` tells the lowest point between the nodes."""

    @abstractmethod
    def profile(self, num_points: int, period: float) -> Array64:
        """Heights h(x_i) above the lowest point, shape (num_points,), in units of the period; the lowest is 0.

        On a grid coarser than the scene's it is the same surface without the waves that this grid cannot hold.
        """

    def depth_between_nodes(self, heights: Array64) -> float:
        """How far the lowest point lies below the lowest node of a grid, in the unit of `heights`, shape (N,).

        `heights`: the profile there. First touch is at that point. 0 unless more is known of the profile between nodes.
        """
        return 0.0

    def hidden_depth(self, heights: Array64) -> float:
        """By how much more the lowest point may lie below the lowest node, in the unit of `heights`, shape (N,).

        Between straight flanks that is up to the second difference there, in a wave an eighth of it. 0 where the lowest
        point is known, or part of a plateau. Grids that share their lowest node do not tell of it by their changes.
        """
        at = int(np.argmin(heights))
        left, lowest, right, next_one = (float(heights[(at + i) % heights.size]) for i in (-1, 0, 1, 2))
        if self.knows_lowest or lowest == right == next_one:
            return 0.0
        wave = self.shortest_wave(heights.size) and not self.kinked
        return (left - 2 * lowest + right) / (8 if wave else 1)

    @abstractmethod
    def shortest_wave(self, num_points: int) -> int:
        """How many of the shortest wave of the profile fit into the period, as a grid of `num_points` holds it.

        0 for a smooth profile without a shortest wave, which every grid resolves as far as it resolves anything.
        """

    def slope(self, num_points: int, period: float) -> Array64:
        """Slopes h'(x_i), shape (num_points,), dimensionless; unless there is better, by central differences of the
        sixth order, which have a wave of eight grid spacings right to 0.2 %.
        """
        return _central_differences(np.asarray(self.profile(num_points, period)), _SIXTH)

    def squared_slope_doubt(self, num_points: int, period: float) -> Array64 | None:
        """The error of `slope`, as h'^2 at the nodes, shape (num_points,); None where it is the profile's own.

        A profile without a shortest wave may have a kink in the contact, between any two nodes: there h'^2 is off by up
        to half of the square of the slope's jump, which second differences unlike those two nodes away tell. For short
        waves the differences of sixth and eighth order differ by about the error of the former.
        """
        if type(self).slope is not Indenter.slope:
            return None
        h = np.asarray(self.profile(num_points, period))
        if not self.shortest_wave(num_points):
            bend = num_points * (np.roll(h, -1) - 2 * h + np.roll(h, 1))
            return (bend - (np.roll(bend, 2) + np.roll(bend, -2)) / 2) ** 2 / 2
        return _central_differences(h, _SIXTH) ** 2 - _central_differences(h, _EIGHTH) ** 2

    def squared_slope_between(self, left: Array64, right: Array64, num_points: int, period: float) -> Array64 | None:
        """Integrals of h'^2 from some places to others, of their shape [grid spacings]; None, by default, where only
        the nodes tell. left, right: in grid spacings, the first node at 0.
        """
        return None

    def on_grid(self, num_points: int, period: float) -> Self:
        """The same surface for a scene of `num_points`."""
        return self

    def check(self, num_points: int) -> None:
        """Raise `ValueError` if a grid of that many points cannot hold the surface."""
        return

    @property
    def doubts(self) -> str:
        """Doubts about the surface itself, in words, for a warning; empty if there are none."""
        return ""

    @property
    def kinked(self) -> bool:
        """Whether it has a few kinks."""
        return False

    def omitted(self, num_points: int) -> float:
        """Share of the mean square slope in waves that a grid of that many points leaves out (dimensionless)."""
        return 0.0 if 2 * self.shortest_wave(num_points) < num_points else 1.0

    @property
    def given_points(self) -> int | None:
        """Number of points that the heights are given at; None if the surface is known between the points, too."""
        return None

    @property
    def given_period(self) -> float | None:
        """The period that the heights belong to [length]; None if they may have any."""
        return None

    @property
    def power_law(self) -> tuple[float, float] | None:
        """Exponent n and radius R [length] if this is one power profile h = (R/n) |x/R|^n, the shape of the closed
        forms and the collocation (`linecontact.solver.reference`); None for any other shape.
        """
        return None

    @property
    def steepness(self) -> float:
        """n - 1 of a power profile with n > 2, else 1: how much faster than a parabola's its slopes change at ends."""
        return max(self.power_law[0] - 1, 1.0) if self.power_law else 1.0

    def end_error(self, width: float) -> float:
        """How far an end may be moved by a tip between smooth flanks, or by steep sides, of which the nodes do not tell
        enough [grid spacings]; 0 without. width: of the contact with the lowest point in its middle [grid spacings].
        """
        return 0.0


def _central_differences(heights: Array64, shares: Sequence[float]) -> Array64:
    """h' of heights on a periodic grid, shape (N,), in units of the period. shares: of the nodes on either side."""
    differences = (share * (np.roll(heights, -k) - np.roll(heights, k)) for k, share in enumerate(shares, start=1))
    return sum(differences, np.zeros(heights.size)) * heights.size
