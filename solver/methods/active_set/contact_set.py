"""What belongs to one set of contact nodes; the active set makes a new one whenever it changes the set."""

import math
from dataclasses import dataclass, field

import numpy as np

from ...arrays import Array64, Indices, Mask
from ...grid.patches import Patches
from .limits import MOST_ITERATIONS
from .preconditioner import PatchDeflation

_PATIENCE = 25  # iterations in which the residual does not become less; then it is rounding, too, and may grow


@dataclass
class ContactSet:
    """A set of contact nodes, in the compact order of `Patches`, and conjugate gradients on it."""

    patches: Patches
    """Its runs of neighbouring nodes."""
    nodes: Indices
    """Grid index of each contact node, shape (contact nodes,)."""
    pressure: Array64
    """Contact pressure, shape (contact nodes,) [p]; negative where the wall would have to pull."""
    direction: Array64
    """Search direction of conjugate gradients, shape (contact nodes,) [p]."""
    places: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Where they have their values in the response that is carried along, shape (contact nodes,)."""
    preconditioner: PatchDeflation | None = None
    """Made when it is needed."""
    last_product: float = 0.0
    """Residual times preconditioned residual of the previous iteration [p u]; 0 makes the next step one of steepest
    descent."""
    first_residual: float = math.inf
    """Residual when the set was new, over p (dimensionless)."""
    settled: bool = False
    """No node wanted to join or leave when the set was last examined."""
    eliminated: bool = False
    """Whether the pressure is or was that by elimination."""
    iterations: int = 0
    """On this set."""
    least_residual: float = math.inf
    """The smallest of them, over p (dimensionless)."""
    in_vain: int = 0
    """Iterations since then."""

    @classmethod
    def of(cls, nodes: Indices, pressure: Array64, num_points: int) -> "ContactSet":
        """The set of nodes in ascending order, with their pressure [p], shape (contact nodes,) each; num_points: N."""
        patches = Patches.of_nodes(nodes, num_points)
        compact = patches.nodes
        if compact[0] != nodes[0]:  # a patch goes on at node 0
            pressure = np.roll(pressure, -int(np.searchsorted(nodes, compact[0])))
        return cls(patches, compact, pressure, np.zeros(nodes.size))

    @property
    def key(self) -> int:
        """By which a set that comes back is recognised."""
        return hash((self.patches.first.tobytes(), self.patches.last.tobytes()))

    def pressure_everywhere(self, num_points: int) -> Array64:
        """The pressure of all nodes, at least 0, shape (num_points,) [p]."""
        pressure = np.zeros(num_points)
        pressure[self.nodes] = np.maximum(self.pressure, 0.0)
        return pressure

    @property
    def pulling(self) -> Indices:
        """Nodes on which the wall would have to pull, shape (number of nodes,)."""
        return self.nodes[self.pressure < 0]

    def changed(self, new: Indices) -> tuple[Indices, Mask]:
        """Drop nodes that pull and add new ones: the nodes of the next set in ascending order, and which of this one's
        stay and keep their pressure.

        Where m nodes pull at the end of a patch, about 2m lie outside of the contact (it shrinks by half of that with
        every update): 2m - 1 are dropped.
        """
        kept: Mask = self.pressure >= 0
        place, first = np.arange(kept.size), self.patches.offset
        last = first + self.patches.size - 1
        inner = np.minimum.reduceat(np.where(kept, place, kept.size), first), np.maximum.reduceat(place * kept, first)
        beyond = 2 * inner[0] - first, 2 * inner[1] - last
        label = self.patches.label
        bears = (inner[0] <= inner[1]) & (beyond[0] < beyond[1])
        kept &= ~bears[label] | ((place > beyond[0][label] - 2) & (place < beyond[1][label] + 2))
        if not (new.size or kept.any()):
            kept[np.argmax(self.pressure)] = True
        return np.sort(np.concatenate([self.nodes[kept], new]), kind="stable"), kept  # merges what is in order

    def iterate(self, residual: float) -> bool:
        """Count an iteration that begins with this residual, over p; False if more of them are of no use."""
        self.iterations += 1
        self.in_vain += 1
        if residual < self.least_residual:
            self.least_residual, self.in_vain = residual, 0
        assert self.preconditioner is not None
        return self.iterations <= max(MOST_ITERATIONS, self.preconditioner.share) and self.in_vain <= _PATIENCE

    def begin_anew(self) -> None:
        """Conjugate gradients begin anew on this set, with another operator or preconditioner."""
        self.iterations = self.in_vain = 0
        self.last_product, self.least_residual = 0.0, math.inf

    def turn(self, residual: Array64, preconditioned: Array64) -> Array64:
        """The next conjugate direction, from the residual [u] and the preconditioned one [p]."""
        product = float(residual @ preconditioned)
        share = product / self.last_product if self.last_product else 0.0
        self.direction = preconditioned + share * self.direction if share else preconditioned
        self.last_product = product
        return self.direction

    def precondition(self, residual: Array64) -> Array64:
        """The preconditioned residual, a pressure; both of shape (contact nodes,)."""
        assert self.preconditioner is not None
        return self.preconditioner.apply(residual)
