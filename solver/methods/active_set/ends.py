"""Where the ends of a wrong contact belong, as the pressure there tells: a cold start gets there in fewer updates."""

from collections.abc import Iterator

import numpy as np

from ...arrays import Array64, Indices
from ...grid.edge_curves import half_space_curve
from ...grid.patches import Patches

_LEAST_NODES = 5  # nodes of the smallest patch whose ends are predicted


def edge_moves(patches: Patches, pressure: Array64) -> Indices:
    """Nodes by which a wrong contact is too large (> 0) or too small (< 0) at the ends of its patches, shape (2, M).

    On a wrong set the edge is still A S_j + B (S_j - S_(j-1)) (see `edge_curves`), only that beta = -B/A is not between
    0 and 1; its whole part is the number of nodes. At most half a patch.

    pressure: on the contact nodes in compact order, shape (contact nodes,) [any unit].
    """
    table = half_space_curve().table
    limit = np.where(patches.size < _LEAST_NODES, 0, patches.size // 2)
    last = patches.offset + patches.size - 1
    inner = np.minimum(patches.size - 1, 1)
    ends = pressure[np.stack([patches.offset, last])]
    next_to = pressure[np.stack([patches.offset + inner, last - inner])]
    drop = next_to * table[0] - ends * table[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        beta = drop / (drop + ends * table[0])
    beta = np.where(np.isfinite(beta), beta, 0.0)
    return np.clip(np.floor(beta), -limit, limit).astype(np.int64)


def moved_ends(patches: Patches, pressure: Array64) -> Iterator[tuple[Indices, bool]]:
    """Nodes to be put into the contact (True) or out of it (False), one after the other, where ends are two nodes off
    or more. Arguments as for `edge_moves`.
    """
    moves = edge_moves(patches, pressure)
    for side, patch in zip(*np.nonzero(np.abs(moves) > 1), strict=True):
        move = int(moves[side, patch])
        end, inward = (patches.first[patch], 1) if side == 0 else (patches.last[patch], -1)
        nearby, outside = np.arange(-2 * abs(move), 0), np.arange(min(move, 0), max(move, 0))  # steps into the patch
        yield (end + inward * nearby) % patches.num_points, False
        yield (end + inward * outside) % patches.num_points, move < 0
