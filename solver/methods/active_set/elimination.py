"""Contact sets of few nodes, solved by elimination instead of iterations.

Large sets of a stiff coating on a soft base are too ill-conditioned to be iterated on, and as every node's pressure is
felt by all others the primal-dual active set, which changes all nodes at once that pull or penetrate, may not settle.
On small grids, or with few nodes in contact, the search then begins anew with the lowest node, and adds few nodes at a
time. As long as the sets are eliminated, up to 1024 nodes, no pressure is ever negative and the energy falls with every
set, so none comes back (C. L. Lawson and R. J. Hanson, Solving Least Squares Problems (1974), ch. 23, with the load
fixed).
"""

import numpy as np

from ...arrays import Array64, Indices
from ...grid.problem import Problem
from .contact_set import ContactSet
from .greens_function import GreensFunction
from .search import Search
from .storage import Whole

_SMALL = 256  # nodes up to which elimination takes less time than the iterations
_MOST = 1024  # nodes up to which a set is eliminated, too, that is hard to iterate on
_MANY = 40  # iterations on one set, of which a dozen are usual, after which it is hard
_LOST = 1e-3  # residual over p with which a search that ends has failed
_UPDATES = 20  # of which a dozen are usual, after which a search with such a residual has failed before its end
_TOO_MANY = 40  # updates after which a search has failed that is not nearly there
_NEARLY, _ANYWAY = 1e-4, 200  # residual over p of one that is, and updates after which it has failed, too
_POINTS = 2**14  # of the largest grid on which a search begins anew with more nodes than can be eliminated in contact
_WORK = 1e11  # sum of the cubes of the numbers of nodes that one search may eliminate: a few seconds
_NOTHING = 1e-14  # pressure over the largest


def suits(now: ContactSet, search: Search) -> bool:
    """Whether to solve this set by elimination: it is small enough, and that was not tried."""
    hard = (search.few_at_a_time or now.iterations > _MANY) and search.work < _WORK
    return now.nodes.size <= (_MOST if hard else _SMALL) and not now.eliminated and not now.patches.full


def solve(now: ContactSet, green: GreensFunction, storage: Whole, height: Array64, search: Search) -> ContactSet | None:
    """The set with the pressure at which all of its nodes touch; None where rounding has made that impossible.

    height: h of all nodes, shape (N,) [u]. Where few nodes are added at a time, those that would pull are left out.
    """
    now.eliminated, nodes = True, now.nodes
    try:
        if search.few_at_a_time:
            nodes, pressure = _without_pull(green, nodes, height[nodes], now.pressure, search)
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
    now.begin_anew()  # the search direction belongs to another pressure
    now.pressure = pressure if now.mirrored is None else (pressure + pressure[now.mirrored]) / 2
    return now


def _without_pull(
    green: GreensFunction, nodes: Indices, height: Array64, pressure: Array64, search: Search
) -> tuple[Indices, Array64]:
    """From a pressure >= 0 on some nodes to the least energy on those that need not pull: these, and their pressure.

    All of shape (M,), height and pressure as `GreensFunction.solve` has them. Raises what that raises, and
    `numpy.linalg.LinAlgError` where rounding or too much work leaves no way on.
    """
    while search.work < _WORK:
        search.work += float(nodes.size) ** 3
        wanted = green.solve(nodes, height)
        pulling = wanted < 0
        if not (pulling.any() and np.isfinite(wanted).all()):
            return nodes, wanted
        step = float((pressure[pulling] / (pressure - wanted)[pulling]).min())  # until the first bears nothing
        pressure = pressure + step * (wanted - pressure)
        left = ~(pulling & (pressure <= _NOTHING * float(pressure.max())))
        if left.all():
            break
        nodes, height, pressure = nodes[left], height[left], pressure[left]
    raise np.linalg.LinAlgError


def deepest(nodes: Indices, gap: Array64, now: ContactSet) -> Indices:
    """Which nodes are added next to a set, few at a time: those that penetrate most, up to a quarter of what it holds.

    nodes, gap: of those that penetrate, shape (M,) [u].
    """
    return np.sort(nodes[np.argsort(gap, kind="stable")[: 1 + now.nodes.size // 4]])


def anew(problem: Problem, storage: Whole, search: Search, lost: bool, num_nodes: int) -> ContactSet | None:
    """The set with which a search begins anew: the lowest node. None where it does not.

    lost: whether the search has failed; one that has begun anew does not do so again. num_nodes: in contact so far; on
    more than 2^14 points a search with many does not begin anew.
    """
    many = problem.num_points > _POINTS and num_nodes > _MOST
    if not lost or many or search.few_at_a_time:
        return None
    lowest = storage.with_images(np.array([np.argmin(problem.height)]))
    return ContactSet.of(lowest, np.ones(lowest.size), storage)


def has_failed(search: Search, residual: float, tolerance: float, ended: bool) -> bool:
    """Whether a search has failed: by the residual that it ended with, by how many updates it has taken, or because it
    goes round in circles.
    """
    lost = not residual <= max(_LOST, tolerance)
    too_many = search.updates > (_ANYWAY if residual <= _NEARLY else _TOO_MANY)
    return (lost and (ended or search.updates > _UPDATES)) or too_many or search.circling
