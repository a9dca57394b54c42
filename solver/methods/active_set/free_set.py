"""What belongs to one set of free nodes; the search by displacements makes a new one whenever it changes the set."""

import math
from dataclasses import dataclass, field

import numpy as np

from ...arrays import Array64, Mask
from ...grid.patches import Patches
from .greens_function import GreensFunction
from .limits import MOST_ITERATIONS
from .local_inverses import LONGEST_DENSE, blocks_of, invert_blocks


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
class FreeSet:
    """A set of free nodes, in the compact order of `Patches`, and conjugate gradients on it."""

    gaps: Patches
    """Its runs of neighbouring nodes."""
    free: Mask
    """Which nodes are free, shape (N,)."""
    inverse: GapByGap | None = None
    """The preconditioner; made when it is needed."""
    direction: Array64 = field(default_factory=lambda: np.zeros(0))
    """Search direction of conjugate gradients, shape (free nodes,) [u]."""
    last_product: float = 0.0
    """Residual times preconditioned residual of the previous iteration [p u]; 0 makes the next step one of steepest
    descent."""
    first_residual: float = math.inf
    """Residual when the set was new, over p (dimensionless)."""
    settled: bool = False
    """No node wanted to join or leave when the set was last examined."""
    iterations: int = 0
    """On this set."""

    @classmethod
    def of(cls, free: Mask) -> "FreeSet":
        """The set of the nodes that are free, shape (N,)."""
        return cls(Patches.of(free), free)

    @property
    def key(self) -> int:
        """By which a set that comes back is recognised."""
        return hash((self.gaps.first.tobytes(), self.gaps.last.tobytes()))

    @property
    def exhausted(self) -> bool:
        """Whether more iterations are of no use."""
        return self.iterations >= MOST_ITERATIONS

    def begin_anew(self) -> None:
        """Let conjugate gradients begin anew on this set, with as many iterations as on a new one."""
        self.last_product, self.iterations = 0.0, 0

    def turn(self, force: Array64, green: GreensFunction) -> float:
        """Turn the search direction for a net force on the free nodes [p], shape (free nodes,). Returns that force
        times the preconditioned one [p u].
        """
        if self.inverse is None:
            self.inverse = GapByGap(green, self.gaps)
        z = self.inverse.apply(force)
        product = float(force @ z)
        share = product / self.last_product if self.last_product else 0.0
        self.direction = z + share * self.direction if share else z
        self.last_product = product
        return product
