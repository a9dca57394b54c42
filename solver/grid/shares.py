"""How several patches share a load, put right where a grid has the compliance of patches of few nodes slightly wrong.

All patches are pressed by the same approach. If patch k would have to lie deeper by r_k for its load
(`narrow`), then the loads are to change by D_k, of sum 0, such that

    c_k D_k + sum over j != k of G_kj D_j = r_k + one constant,

with c_k the compliance of a flat punch in its place and G_kj the displacement at one patch by a unit load at the centre
of another (docs/edges.md). Of many patches those that follow each other share their load.
"""

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from ..arrays import Array64, Indices
from .few_nodes import node_compliance
from .narrow import Ends, punch_compliance
from .patches import Patches

_TOGETHER = 128  # patches that share their load with each other, those that follow each other


def shared_loads(
    patches: Patches,
    chosen: Indices,
    pressure: Array64,
    found: Ends,
    green: Array64,
) -> Array64:
    """The loads of all patches, shape (M,) [grid spacings], over E*, after some of them were put right.

    pressure: over E*, on the contact nodes in compact order; found: ends of the chosen patches with the loads that the
    grid has; green: see `LayerOnGrid.around_node`. Loads may come out negative or 0: such a patch may not touch at
    all. Where rounding makes the matrix singular, all stay.
    """

    def at(node: Indices) -> Array64:
        node = node % patches.num_points
        return green[np.minimum(node, patches.num_points - node)]

    load = patches.sums(pressure)
    centre = patches.first + patches.sums(pressure * patches.step) / load
    # a load that lies elsewhere than the grid has it presses the other patches, too
    compliance = _of_nodes(patches.size, at(np.arange(int(patches.size.max()))))
    moment, error = np.zeros((2, patches.count))
    solved, chosen = found.solved, chosen[found.solved]
    moved = found.centre[solved] - centre[chosen]
    centre[chosen] += moved
    moment[chosen] = moved * load[chosen]
    of_punch = punch_compliance(found.half_width[solved])
    compliance[chosen] += of_punch - _of_nodes(patches.size[chosen], node_compliance())
    error[chosen] = found.deeper[solved] - of_punch * load[chosen]
    shared = load.copy()
    for begin in range(0, patches.count, _TOGETHER):
        some = slice(begin, begin + _TOGETHER)
        with suppress(np.linalg.LinAlgError):
            shared[some] += _changes(centre[some], moment[some], compliance[some], error[some], at)
    return shared


def _changes(
    centre: Array64, moment: Array64, compliance: Array64, error: Array64, at: Callable[[Indices], Array64]
) -> Array64:
    """D_k of some patches, of their shape. at: the displacement so many nodes from a unit load."""
    across = centre[:, None] - centre
    away = np.abs(across)
    node = away.astype(np.int64)
    here = at(node)
    slope = at(node + 1) - here
    matrix = np.ones((centre.size + 1, centre.size + 1))
    matrix[:-1, :-1] = here + (away - node) * slope
    np.fill_diagonal(matrix, np.append(compliance, 0.0))
    moved = (slope * np.sign(across)) @ moment
    return np.asarray(np.linalg.solve(matrix, np.append(error + moved, 0.0))[:-1])


def _of_nodes(size: Indices, response: Array64) -> Array64:
    """Mean displacement of patches of so many nodes by a unit load that is spread evenly over them, of their shape."""
    sums = np.cumsum(np.cumsum(response[: int(size.max())]))
    return np.asarray((2 * sums[size - 1] - size * response[0]) / size.astype(np.float64) ** 2)
