"""What belongs to one set of free nodes; the search by displacements makes a new one whenever it changes the set."""

from dataclasses import dataclass, field

import numpy as np

from ...arrays import Array64, Mask
from ...grid.patches import Patches
from .greens_function import GreensFunction
from .local_inverses import LONGEST_DENSE, blocks_of, invert_blocks
from .search import NodeSet


class GapByGap:
    """Approximate inverse of K on one set of free nodes: every gap between two patches on its own.

    K is a Toeplitz matrix and short-ranged: a displacement in one gap hardly presses on the next. So no loads need to
    be solved for together, as they have to for the inverse of G on the contact. Gaps share one inverse Cholesky factor;
    in those too long for it 1/K on a short ring of nodes, restricted to the gap, is nearly the inverse.
    """

    def __init__(self, green: GreensFunction, gaps: Patches) -> None:
        """gaps: runs of free nodes."""
        self._gaps, self._green = gaps, green
        short = gaps.size <= LONGEST_DENSE
        self._blocks = list(blocks_of(gaps, short, green.stiffness_factor))
        self._long = np.flatnonzero(~short)

    def apply(self, force: Array64) -> Array64:
        """About K_FF^-1 force, a displacement; both shape (free nodes,) in compact order."""
        z = invert_blocks(self._blocks, force)
        for start, size in zip(self._gaps.offset[self._long], self._gaps.size[self._long], strict=True):
            convolve, part = self._green.around(int(size)), slice(start, start + size)
            z[part] = convolve(convolve.inverse_rigidity, force[part])
        return z


@dataclass(eq=False)
class FreeSet(NodeSet):
    """A set of free nodes, in the compact order of its gaps: `patches` are runs of free nodes here."""

    free: Mask = field(default_factory=lambda: np.zeros(0, dtype=bool))
    """Which nodes are free, shape (N,)."""
    inverse: GapByGap | None = None
    """The preconditioner; made when it is needed."""

    @classmethod
    def of(cls, free: Mask) -> "FreeSet":
        """The set of the nodes that are free, shape (N,)."""
        return cls(Patches.of(free), free=free)
