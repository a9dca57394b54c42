"""A search that has failed begins anew, and adds few nodes at a time.

Large sets of a stiff coating on a soft base are too ill-conditioned to be iterated on, and as every node's pressure is
felt by all others the primal-dual active set, which changes all nodes at once that pull or penetrate, may not settle:
its sets grow from hundreds of nodes to a quarter of all. The search then begins anew with the nodes that it has started
with, those of the coarser grid's contact, or else with the lowest node. Every set is solved by elimination, nodes that
pull are dropped until none does, and the deepest of those that penetrate are added. The energy falls with every set, so
none comes back (C. L. Lawson and R. J. Hanson, Solving Least Squares Problems (1974), ch. 23, with the load fixed).
"""

from contextlib import suppress

import numpy as np

from ...arrays import Array64, Indices
from ...grid.problem import Problem
from .contact_set import ContactSet
from .greens_function import GreensFunction
from .search import Search
from .storage import Whole

MOST = 4096
"""Nodes of a set that is eliminated; that many take a third of a gigabyte."""

_WORK = 2e12  # sum of the cubes of the numbers of nodes that one search may eliminate: half a minute
_LOST = 1e-3  # residual over p with which a search that ends has failed
_UPDATES = 20  # of which a dozen are usual, after which a search with such a residual has failed before its end,
_EARLY, _PULLING = 8, 0.25  # or after fewer, if more than this share of the nodes pulls
_TOO_MANY = 40  # updates after which a search has failed that is not nearly there
_NEARLY, _ANYWAY = 1e-4, 200  # residual over p of one that is, and updates after which it has failed, too
_POINTS, _FEW = 2**14, 1024  # points of a grid, or nodes in contact, up to which it begins with the lowest node
_NOTHING = 1e-14  # pressure over the largest


def has_failed(search: Search, residual: float, tolerance: float, ended: bool) -> bool:
    """Whether a search has failed: by the residual that it ended with, by how many updates it has taken and how many
    nodes still pull, or because it goes round in circles.
    """
    lost = not residual <= max(_LOST, tolerance)
    too_many = search.updates > (_ANYWAY if residual <= _NEARLY else _TOO_MANY)
    most = _EARLY if search.pulling > _PULLING else _UPDATES
    return (lost and (ended or search.updates > most)) or too_many or search.circling


def first_set(problem: Problem, storage: Whole, start: Indices | None, num_nodes: int) -> ContactSet | None:
    """The set with which a search begins anew; None where it had better not.

    start: the nodes that it has started with; None if these were a guess or are too many. num_nodes: in contact so far.
    """
    if start is None:
        if problem.num_points > _POINTS and num_nodes > _FEW:
            return None
        start = np.array([np.argmin(problem.height)])
    nodes = storage.with_images(start)
    return ContactSet.of(nodes, np.ones(nodes.size), storage)


def most(search: Search) -> int:
    """Nodes of the largest set that may be eliminated."""
    return MOST if search.work < _WORK else 0


def without_pull(
    green: GreensFunction, nodes: Indices, height: Array64, pressure: Array64, search: Search
) -> tuple[Indices, Array64]:
    """Drop nodes that would pull, until none does: the others, and their pressure.

    All that pull are dropped at once; where that does not lower the energy, one after the other on a way down. All of
    shape (M,), height and pressure as `GreensFunction.solve` has them, pressure >= 0. Raises what that raises, and
    `numpy.linalg.LinAlgError` where rounding or too much work leaves no way on.
    """
    wanted, energy = _solve(green, nodes, height, search)
    some, above, found, least = nodes, height, wanted, energy
    with suppress(np.linalg.LinAlgError, ZeroDivisionError):
        while (found < 0).any():
            some, above = some[found >= 0], above[found >= 0]
            found, least = _solve(green, some, above, search)
        if least < search.energy:
            search.energy = least
            return some, found
    while (wanted < 0).any():
        pulling = wanted < 0
        step = float((pressure[pulling] / (pressure - wanted)[pulling]).min())  # until the first bears nothing
        pressure = pressure + step * (wanted - pressure)
        left = ~(pulling & (pressure <= _NOTHING * float(pressure.max())))
        if left.all():
            raise np.linalg.LinAlgError
        nodes, height, pressure = nodes[left], height[left], pressure[left]
        wanted, energy = _solve(green, nodes, height, search)
    search.energy = energy
    return nodes, wanted


def _solve(green: GreensFunction, nodes: Indices, height: Array64, search: Search) -> tuple[Array64, float]:
    """The pressure at which all of some nodes touch, as `GreensFunction.solve` has it, and its energy [p u].

    Raises `numpy.linalg.LinAlgError` after too much work, and for a pressure that is not finite.
    """
    if search.work >= _WORK:
        raise np.linalg.LinAlgError
    search.work += float(nodes.size) ** 3
    pressure, level = green.solve(nodes, height)
    if not np.isfinite(pressure).all():
        raise np.linalg.LinAlgError
    return pressure, (level * green.num_points + float(pressure @ height)) / 2


def deepest(nodes: Indices, gap: Array64, now: ContactSet) -> Indices:
    """Which nodes are added next to a set: those that penetrate most, up to a quarter of what it holds.

    nodes, gap: of those that penetrate, shape (M,) [u].
    """
    return np.sort(nodes[np.argsort(gap, kind="stable")[: 1 + now.nodes.size // 4]])
