"""Contact sets of few nodes, solved by elimination instead of iterations."""

import numpy as np

from ...arrays import Array64
from .contact_set import ContactSet
from .greens_function import HARD, GreensFunction

_SMALL = 256  # nodes up to which elimination takes less time than the iterations


def suits(now: ContactSet, cautious: bool) -> bool:
    """Whether to solve this set by elimination: it is small enough, and that was not tried."""
    return now.nodes.size <= (HARD if cautious else _SMALL) and not now.eliminated and not now.patches.full


def solve(now: ContactSet, green: GreensFunction, height: Array64, cautious: bool) -> ContactSet | None:
    """The set with the pressure at which all of its nodes touch; None where rounding or too little memory has made that
    impossible.

    height: h of all nodes, shape (N,) [u]. cautious: nodes that would pull are dropped until none does.
    """
    now.eliminated, nodes = True, now.nodes
    pressure = green.solve(nodes, height[nodes])
    while cautious and pressure is not None and (pressure < 0).any():
        nodes = nodes[pressure >= 0]
        pressure = green.solve(nodes, height[nodes])
    if pressure is None:
        return None
    if nodes.size < now.nodes.size:
        order = np.argsort(nodes)
        now = ContactSet.of(nodes[order], pressure[order], height.size)
        now.eliminated, pressure = True, now.pressure
    now.begin_anew()  # the search direction belongs to another pressure
    now.pressure = pressure
    return now
