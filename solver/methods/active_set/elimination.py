"""Contact sets of few nodes, solved by elimination instead of iterations.

Large sets of a stiff coating on a soft base are too ill-conditioned to be iterated on, and as every node's pressure is
felt by all others the primal-dual active set, which changes all nodes at once that pull or penetrate, may not settle.
On small grids the search then begins anew, one by one: with the lowest node, and few new ones at a time. No pressure is
ever negative, and the energy falls with every set, so none comes back (C. L. Lawson and R. J. Hanson, Solving Least
Squares Problems (1974), ch. 23, with the load fixed).
"""

import numpy as np

from ...arrays import Array64, Indices
from ...grid.problem import Problem
from .contact_set import ContactSet
from .greens_function import GreensFunction
from .search import Search
from .storage import Whole

_SMALL = 256  # nodes up to which elimination takes less time than the iterations
_MANY, _MOST = (
    40,
    1024,
)  # iterations on one set, of which most take a dozen, after which sets of so many nodes are small
_LOST, _POINTS = 1e-3, 2**14  # residual over p with which a search has failed; points of grids on which it begins anew
_NOTHING = 1e-14  # pressure over the largest


def suits(now: ContactSet, search: Search) -> bool:
    """Whether a set is to be solved by elimination, which has not been tried yet."""
    hard = search.one_by_one or now.iterations > _MANY
    return now.nodes.size <= (_MOST if hard else _SMALL) and not now.eliminated and not now.patches.full


def solve(now: ContactSet, green: GreensFunction, storage: Whole, height: Array64, search: Search) -> ContactSet | None:
    """The set with the pressure at which all of its nodes touch; None where rounding has made that impossible.

    height: h of all nodes, shape (N,) [u]. Of a search one by one the nodes that would pull are left out.
    """
    now.eliminated, nodes = True, now.nodes
    try:
        if search.one_by_one:
            nodes, pressure = _without_pull(green, nodes, height[nodes], now.pressure)
        else:
            pressure = green.solve(nodes, height[nodes])
    except (np.linalg.LinAlgError, ZeroDivisionError):
        return None
    if not np.isfinite(pressure).all():
        return None
    if nodes.size < now.nodes.size:
        everywhere = np.zeros(storage.num_points)
        everywhere[nodes] = pressure
        nodes = storage.with_images(np.sort(nodes))
        now = ContactSet.of(nodes, everywhere[nodes], storage)
        now.eliminated, pressure = True, now.pressure
    now.pressure = pressure if now.mirrored is None else (pressure + pressure[now.mirrored]) / 2
    return now


def _without_pull(green: GreensFunction, nodes: Indices, height: Array64, pressure: Array64) -> tuple[Indices, Array64]:
    """From a pressure >= 0 on some nodes to the least energy on those that need not pull: these, and their pressure.

    All of shape (M,), height and pressure as `GreensFunction.solve` has them, which may raise.
    """
    while True:
        wanted = green.solve(nodes, height)
        pulling = wanted < 0
        if not pulling.any():
            return nodes, wanted
        step = float((pressure[pulling] / (pressure - wanted)[pulling]).min())  # until the first bears nothing
        pressure = pressure + step * (wanted - pressure)
        left = ~(pulling & (pressure <= _NOTHING * float(pressure.max())))
        nodes, height, pressure = nodes[left], height[left], pressure[left]


def deepest(nodes: Indices, gap: Array64, now: ContactSet) -> Indices:
    """Which nodes are added next to a set, one by one: those that penetrate most, up to a quarter of what it holds.

    nodes, gap: of those that penetrate, shape (M,) [u].
    """
    return np.sort(nodes[np.argsort(gap, kind="stable")[: 1 + now.nodes.size // 4]])


def anew(problem: Problem, storage: Whole, search: Search, residual: float) -> ContactSet | None:
    """The set that a search one by one begins with, where this one has failed; None where it may still succeed."""
    lost = residual > _LOST and problem.num_points <= _POINTS and not search.one_by_one
    if not lost:
        return None
    lowest = storage.with_images(np.array([np.argmin(problem.height)]))
    return ContactSet.of(lowest, np.ones(lowest.size), storage)
