"""The search for the contact nodes with the displacement of the free nodes as unknown.

Where much of the period is in contact, few nodes are free, and K between them is short-ranged, so that this form of
the same problem takes fewer iterations: K_FF u_F = p - K_FC h_C by preconditioned conjugate gradients. K u of all nodes
is carried along; on the free nodes p - K u is the residual that the certificate looks at, too. An update puts free
nodes that penetrate onto the wall, and sets those free that the wall would have to hold by pulling.

Not for layers whose longest waves are the stiffest, thin and incompressible ones: there K is long-ranged.
"""

import math
from functools import partial

import numpy as np

from ...arrays import Array64, Mask
from ...grid.patches import Patches
from ...grid.problem import Problem, foundation_pressure, rounding_floor
from ..method import ExecutionConfig
from .fields import Everywhere
from .greens_function import GreensFunction
from .preconditioner import Inverse, RunByRun
from .search import OVER_FLOOR, SMALLEST, NodeSet, Search


def gap_by_gap(green: GreensFunction, gaps: Patches) -> RunByRun:
    """Approximate inverse of K on runs of free nodes: a displacement in one gap hardly presses on the next, so no loads
    need to be solved for together. On long gaps 1/K on a short ring of nodes is nearly the inverse.
    """

    def long(size: int) -> Inverse:
        ring = green.ring(size)
        return lambda force: ring(ring.inverse_stiffness, force)

    return RunByRun(gaps, partial(green.factor, of_stiffness=True), long)


class FreeNodes(Search):
    """The active set on one grid, by displacements; in float64. Its set is that of the free nodes."""

    def __init__(
        self, problem: Problem, config: ExecutionConfig, green: GreensFunction, everywhere: Everywhere
    ) -> None:
        """everywhere: K u of all nodes."""
        super().__init__(problem, config, green, everywhere)
        self._displacement, self._free = np.zeros(problem.num_points), problem.height > 0
        self._set = NodeSet(patches=Patches.of(self._free))

    def start(self, displacement: Array64) -> None:
        if (displacement < self.problem.height).all():  # K knows no load without contact
            self.start_from_pressure(np.zeros(displacement.size))
        else:
            displacement = np.minimum(displacement, self.problem.height)
            self._take(displacement, displacement < self.problem.height)

    def start_from_pressure(self, pressure: Array64) -> None:
        if not pressure.any():
            pressure = foundation_pressure(self.problem)
        # nodes that penetrate stay free at first: the pressure is only about right, and most of them belong outside
        self._take(self.problem.surface_under(pressure), ~(pressure > 0))
        self._all.pairs += 1

    def _take(self, displacement: Array64, free: Mask) -> None:
        """Begin from a displacement [u] and the nodes that are free, both shape (N,)."""
        self._begin()
        self._displacement, self._free, self._set = displacement, free, NodeSet(patches=Patches.of(free))
        self._make_force()
        self._floor = OVER_FLOOR * rounding_floor(self.problem.stiffness, displacement, "float64")

    def _make_force(self) -> None:
        """The force of all nodes from their displacement, those in contact on the exact wall."""
        held = ~self._free
        self._displacement[held] = self.problem.height[held]
        self._all.renew(slice(held.size), self._displacement)

    def tighten(self) -> bool:
        self._make_force()  # the force carried along has lost touch with the displacement
        self._set.begin_anew()
        return super().tighten()

    def step(self) -> None:
        """One iteration on the free nodes; where they are solved well enough, update which nodes are free instead."""
        force = 1 - self._all.field[self._set.nodes]  # on the free nodes
        self.residual = math.sqrt(float(force @ force) / max(1, force.size))
        self._go_on(lambda: self._iterate(force))

    def _iterate(self, force: Array64) -> bool:
        """One iteration of conjugate gradients; False if rounding has left no way down."""
        now = self._set
        if now.preconditioner is None:
            now.preconditioner = gap_by_gap(self._green, now.patches)
        direction = now.turn(force, now.preconditioner(force))
        curvature = float(direction @ self._all.image(now.nodes, direction))
        if not curvature > 0:
            return False
        step = now.last_product / curvature
        self._displacement[now.nodes] += step * direction
        self._all.advance(step)
        return True

    def _update_set(self) -> bool:
        """Put nodes that penetrate onto the wall, set nodes free that pull; False if none does."""
        height, nodes = self.problem.height, self._set.nodes
        penetrating = nodes[self._displacement[nodes] > height[nodes]]
        pull = self._all.field[: height.size] > 1 + SMALLEST * self.tolerance
        pull &= ~self._free
        if self._fixed_set or not (penetrating.size or pull.any()):
            return False
        free = self._free | pull
        free[penetrating] = False
        if free.all():  # K knows no load without contact
            free[np.argmax(self._displacement - height)] = False
        now, self._set = self._set, NodeSet(patches=Patches.of(free))
        if not self._circles(now):
            self._free = free
            self._make_force()
        return True

    @property
    def displacement(self) -> Array64:
        return np.minimum(self._displacement, self.problem.height)

    @property
    def contact_pressure(self) -> Array64:
        return np.where(self._free, 0.0, np.maximum(1 - self._all.field[: self.problem.num_points], 0.0))
