"""Contact sets of few nodes, solved by elimination instead of iterations."""

import numpy as np

from ...arrays import Array64
from .contact_set import ContactSet
from .greens_function import GreensFunction
from .search import Search

_SMALL = 256  # nodes up to which elimination takes less time than the iterations
_HARD = 1024  # nodes up to which a set is eliminated, too, that is hard to iterate on
_MANY = 40  # iterations on one set, of which a dozen are usual, after which it is hard
_IMPOSSIBLE = np.linalg.LinAlgError, ZeroDivisionError, MemoryError


def suits(now: ContactSet, search: Search) -> bool:
    """Whether to solve this set by elimination: it is small enough, and that was not tried."""
    hard = now.iterations > _MANY
    most = _HARD if hard else _SMALL
    few = search.few_at_a_time
    if few and not few.spent:
        most = few.most(hard)
    return now.nodes.size <= most and not now.eliminated and not now.patches.full


def solve(now: ContactSet, green: GreensFunction, height: Array64, search: Search) -> ContactSet | None:
    """The set with the pressure at which all of its nodes touch; None where rounding or too little memory has made that
    impossible.

    height: h of all nodes, shape (N,) [u]. Where few nodes are added at a time, those that would pull are left out.
    """
    now.eliminated, nodes, few = True, now.nodes, search.few_at_a_time
    try:
        if few and not few.spent:
            nodes, pressure = few.without_pull(green, nodes, height[nodes], np.maximum(now.pressure, 0.0))
            few.dropped += now.nodes.size - nodes.size
        else:
            pressure, _ = green.solve(nodes, height[nodes])
    except _IMPOSSIBLE:
        return None
    if not np.isfinite(pressure).all():
        return None
    if nodes.size < now.nodes.size:
        order = np.argsort(nodes)
        now = ContactSet.of(nodes[order], pressure[order], height.size)
        now.eliminated, pressure = True, now.pressure
    now.begin_anew()  # the search direction belongs to another pressure
    now.pressure = pressure
    return now


def refine(now: ContactSet, green: GreensFunction, touching: Array64, search: Search) -> bool:
    """Correct a pressure that elimination has found for its rounding, by one more elimination; False where that is
    impossible.

    Under a stiff coating the elements of G are millions of times as large as what the pressure's short waves need of
    them. touching: h + w, made by transforms, shape (contact nodes,) [u]; search: its work on eliminations is counted.
    """
    if search.few_at_a_time:
        search.few_at_a_time.work += float(now.nodes.size) ** 3
    try:
        change, _ = green.solve(now.nodes, touching - touching.mean(), load=0.0)
    except _IMPOSSIBLE:
        return False
    if not np.isfinite(change).all():
        return False
    now.pressure = now.pressure + change
    return True
