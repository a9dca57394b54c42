"""A search that has failed begins anew, and adds few nodes at a time.

Under a stiff coating on a soft base every node's pressure is felt by all others, and the primal-dual active set, which
drops and adds nodes at once and decides on rough solutions, may not settle: its sets grow from hundreds of nodes to a
quarter of all. The search then begins anew with the nodes that it has started with, those of the coarser grid's
contact, or else with the lowest node. It solves every set well, drops nodes that pull until none does, and only then
adds some of those that penetrate: the deepest, and fewer of them if many nodes had to be dropped after the last ones.
(On layers whose longest waves are the stiffest nodes hardly feel each other, and all are added that penetrate.)

Sets of up to 2048 nodes are solved by elimination. As long as all are, the energy falls with every set, but for
rounding, so none comes back (C. L. Lawson and R. J. Hanson, Solving Least Squares Problems (1974), ch. 23, with the
load fixed).
"""

import math
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ...arrays import Array64, Indices
from .greens_function import GreensFunction

FORCING_TERM = 1e-4
"""Part of a new set's residual at which it is updated (dimensionless)."""
_UNKNOWNS, _MOST_UNKNOWNS = 2048, 4096
"""Patches with a coarse unknown each, at first, and after many iterations on one set: patches that share one make a set
ill-conditioned, under stiffer coatings too much so to be iterated on."""
_MANY = 100  # iterations, which take about as long as a dense matrix with more unknowns
_MOST, _MOST_HARD = 2048, 4096  # nodes of a set that is eliminated; of one that is hard to iterate on
_WORK = 1e11  # sum of the cubes of the numbers of nodes that one search may eliminate: a few seconds
_POINTS, _FEW = 2**14, 1024  # points of a grid, or nodes in contact, up to which it begins with the lowest node
_NOTHING = 1e-14  # pressure over the largest
_LARGEST = 0.25  # nodes that are added at once, over those in contact
# nodes dropped since the last ones were added, over these: beyond the first fewer are added, up to the second more
_TOO_BOLD, _BOLDER = 0.25, 0.05


def first_nodes(height: Array64, start: Indices | None, num_nodes: int) -> Indices | None:
    """The nodes with which a search begins anew; None where it had better not.

    height: h, shape (N,) [u]; start: the nodes that it has started with, None if these were a guess; num_nodes: in
    contact so far.
    """
    if start is not None:
        return start
    if height.size > _POINTS and num_nodes > _FEW:
        return None
    return np.array([np.argmin(height)])


@dataclass
class FewAtATime:
    """How a search with few nodes at a time is getting on."""

    share: float = _LARGEST
    """Nodes to add next over those in contact (dimensionless)."""
    added: int = 0
    """Nodes that were added last."""
    dropped: int = 0
    """Nodes that were dropped since then."""
    energy: float = math.inf
    """Of the last set that was eliminated [p u]."""
    work: float = 0.0
    """Of elimination: the sum of the cubes of the numbers of nodes."""
    unknowns: int = _UNKNOWNS
    """Patches with a coarse unknown each, at most."""

    @property
    def spent(self) -> bool:
        """Whether the work that may go into elimination is done."""
        return self.work >= _WORK

    def takes_more(self, iterations: int, share: float) -> bool:
        """After so many iterations on one set, whether there are to be more coarse unknowns from now on.

        share: patches over coarse unknowns (dimensionless).
        """
        if share <= 1 or iterations < _MANY or self.unknowns == _MOST_UNKNOWNS:
            return False
        self.unknowns = _MOST_UNKNOWNS
        return True

    def most(self, hard: bool) -> int:
        """Nodes of the largest set to eliminate; hard: whether it is hard to iterate on."""
        return _MOST_HARD if hard else _MOST

    def to_add(self, nodes: Indices, gap: Array64, pulling: int, num_nodes: int) -> Indices:
        """Which nodes to add to a set, in ascending order: none while nodes pull, then the deepest.

        nodes, gap: of those that penetrate, shape (M,) [u]; pulling: how many nodes pull; num_nodes: in contact.
        """
        self.dropped += pulling
        if pulling or not nodes.size:
            return nodes[:0]
        if self.added and self.dropped > _TOO_BOLD * self.added:
            self.share = max(self.share / 4, 1 / num_nodes)
        elif self.dropped <= _BOLDER * self.added:
            self.share = min(2 * self.share, _LARGEST)
        found = np.sort(nodes[np.argsort(gap, kind="stable")[: 1 + int(self.share * num_nodes)]])
        self.added, self.dropped = found.size, 0
        return found

    def without_pull(
        self, green: GreensFunction, nodes: Indices, height: Array64, pressure: Array64
    ) -> tuple[Indices, Array64]:
        """Drop nodes that would pull, until none does: the others, and their pressure.

        All that pull are dropped at once; where that does not lower the energy, one after the other on a way down. All
        of shape (M,), height and pressure as `GreensFunction.solve` has them, pressure >= 0. Raises what that raises,
        and `numpy.linalg.LinAlgError` where rounding or too much work leaves no way on.
        """
        wanted, energy = self._solve(green, nodes, height)
        some, above, found, least = nodes, height, wanted, energy
        with suppress(np.linalg.LinAlgError, ZeroDivisionError):
            while (found < 0).any():
                some, above = some[found >= 0], above[found >= 0]
                found, least = self._solve(green, some, above)
            if least < self.energy:
                self.energy = least
                return some, found
        while (wanted < 0).any():
            pulling = wanted < 0
            step = float((pressure[pulling] / (pressure - wanted)[pulling]).min())  # until the first bears nothing
            pressure = pressure + step * (wanted - pressure)
            left = ~(pulling & (pressure <= _NOTHING * float(pressure.max())))
            if left.all():
                raise np.linalg.LinAlgError
            nodes, height, pressure = nodes[left], height[left], pressure[left]
            wanted, energy = self._solve(green, nodes, height)
        self.energy = energy
        return nodes, wanted

    def _solve(self, green: GreensFunction, nodes: Indices, height: Array64) -> tuple[Array64, float]:
        """The pressure at which all of some nodes touch, as `GreensFunction.solve` has it, and its energy [p u].

        Raises `numpy.linalg.LinAlgError` after too much work, and for a pressure that is not finite.
        """
        if self.spent:
            raise np.linalg.LinAlgError
        self.work += float(nodes.size) ** 3
        pressure, level = green.solve(nodes, height)
        if not np.isfinite(pressure).all():
            raise np.linalg.LinAlgError
        return pressure, (level * green.num_points + float(pressure @ height)) / 2
