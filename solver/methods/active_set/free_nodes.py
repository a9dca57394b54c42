"""The search for the contact nodes with the displacement of the free nodes as unknown.

Where much of the period is in contact, few nodes are free, and K between them is short-ranged, so that this form of
the same problem takes three quarters to a sixth of the iterations: K_FF u_F = p - K_FC h_C by preconditioned conjugate
gradients (M. R. Hestenes and E. Stiefel, 1952), with the preconditioner of `free_set`. The net force r = p - K u of
all nodes is carried along; on the free nodes it is the residual that the certificate looks at, too. When that has
fallen far enough, free nodes that penetrate are put onto the wall, and those that the wall would have to hold by
pulling are set free (primal-dual active set, M. Hintermueller et al., SIAM J. Optim. 13, 865 (2002)).

Not for layers whose longest waves are the stiffest, thin and incompressible ones: there K is long-ranged.
"""

import math

import numpy as np

from ...arrays import Array64, Mask
from ...grid.problem import Problem, foundation_pressure, rounding_floor, typical_stiffness
from ..method import ExecutionConfig, Method
from .everywhere import Everywhere
from .free_set import FreeSet
from .greens_function import GreensFunction
from .limits import HARDER, SAFETY, History

_LEAST = 0.23  # share of the nodes in contact from which this form takes less time than that in the pressure
_FIRST_FORCING_TERM = 0.01
"""Of the set that it begins with. Two or three iterations take most of its residual, short waves from nodes put onto
the wall, and leave the long ones, which decide what nodes belong to the contact."""

_SMALLEST_PULL = 0.1  # of the tolerance on the residual, as a force over p: below, nodes would change by rounding
_FLOOR = 0.5  # of the residual that rounding leaves, below which it is not followed


def suits(problem: Problem, config: ExecutionConfig) -> bool:
    """Whether this form takes less time than that in the pressure."""
    enough = config.contact_share >= _LEAST and config.precision == "float64"
    return enough and problem.rigidity.response.stiffness_decays


class FreeNodes(Method):
    """The active set on one grid, by displacements; in float64."""

    iteration = 0
    residual = math.inf
    stopped = False
    patience = None  # the residual starts anew with every set

    def __init__(
        self, problem: Problem, config: ExecutionConfig, green: GreensFunction, everywhere: Everywhere
    ) -> None:
        """everywhere: the net force of all nodes, by K."""
        self.problem, self.tolerance, self._fixed_set = problem, config.tolerance, config.fixed_set
        self._green, self._all = green, everywhere
        self._target, self._floor, self._pairs = SAFETY * self.tolerance, 0.0, 0.0
        self._history = History()
        self._displacement = np.zeros(problem.num_points)
        self._set = FreeSet.of(self._displacement < problem.height)
        self._all.field[:] = 1

    @property
    def transform_pairs(self) -> float:
        return self._pairs + self._green.transformed / self.problem.num_points

    def start(self, displacement: Array64) -> None:
        if (displacement < self.problem.height).all():  # K knows no load without contact
            self.start_from_pressure(np.zeros(displacement.size))
        else:
            displacement = np.minimum(displacement, self.problem.height)
            self._take(displacement, displacement < self.problem.height)

    def start_from_pressure(self, pressure: Array64) -> None:
        if not pressure.any():
            pressure = foundation_pressure(self.problem, typical_stiffness(self.problem))
        # nodes that penetrate stay free at first: the pressure is only about right, and most of them belong outside
        self._take(self.problem.surface_under(pressure), ~(pressure > 0))
        self._pairs += 1

    def _take(self, displacement: Array64, free: Mask) -> None:
        """Begin from a displacement [u] and the nodes that are free, both shape (N,)."""
        self._displacement, self.stopped, self._history = displacement, False, History()
        self._set = FreeSet.of(free)
        self._make_force()
        self._floor = _FLOOR * rounding_floor(self.problem.stiffness, displacement, "float64")

    def _make_force(self) -> None:
        """The net force of all nodes from their displacement, those in contact on the exact wall."""
        held = ~self._set.free
        self._displacement[held] = self.problem.height[held]
        self._all.renew_force(self._displacement)
        self._pairs += 1

    def tighten(self) -> bool:
        self._target *= HARDER
        self._floor *= HARDER
        self.stopped = False
        self._make_force()  # what is carried along has lost touch with the displacement
        self._set.begin_anew()
        return True

    def step(self) -> None:
        """One iteration on the free nodes; where they are solved well enough, update which nodes are free instead."""
        now = self._set
        force = self._all.field[now.gaps.nodes]
        self.residual = math.sqrt(float(force @ force) / max(1, force.size))
        if math.isinf(now.first_residual):
            now.first_residual = self.residual
        target = max(self._target, self._floor)
        forcing_term = self._history.forcing_term if self._history.keys else _FIRST_FORCING_TERM
        part = 0.0 if now.settled else forcing_term * now.first_residual
        if self.residual <= max(target, part):
            self.iteration += 1
            if self._update():
                return
            now.settled = True
            if self.residual <= target:
                self.stopped = True
                return
        if (now.exhausted or not self._iterate(force)) and not self._update():  # it may be the wrong set
            self.stopped = True

    def _iterate(self, force: Array64) -> bool:
        """One iteration of conjugate gradients; False if rounding has left no way down."""
        now = self._set
        now.iterations += 1
        self.iteration += 1
        product = now.turn(force, self._green)
        curvature = float(now.direction @ self._all.image(now.gaps.nodes, now.direction))
        self._pairs += 1
        if not curvature > 0:
            return False
        step = product / curvature
        self._displacement[now.gaps.nodes] += step * now.direction
        self._all.advance(-step)
        return True

    def _update(self) -> bool:
        """Put nodes that penetrate onto the wall, set nodes free that pull; False if none does."""
        height, nodes = self.problem.height, self._set.gaps.nodes
        penetrating = nodes[self._displacement[nodes] > height[nodes]]
        pull = self._all.field[: self.problem.num_points] < -_SMALLEST_PULL * self.tolerance
        pull &= ~self._set.free
        changed = penetrating.size + int(np.count_nonzero(pull))
        if self._fixed_set or not changed:
            return False
        free = self._set.free | pull
        free[penetrating] = False
        if free.all():  # K knows no load without contact
            free[np.argmax(self._displacement - height)] = False
        now, self._set = self._set, FreeSet.of(free)
        if not self._history.settles(self._set.key):
            self._set, self.stopped, self.residual = now, True, max(self.residual, 2 * self.tolerance)
            return True
        self._make_force()
        return True

    @property
    def punch_approach(self) -> float:
        """As `ActiveSet.punch_approach`: what is left of the free force does its share of the work [u]."""
        u, force = self._displacement[self._set.gaps.nodes], self._all.field[self._set.gaps.nodes]
        return (float(u.sum()) + float(u @ force)) / self.problem.num_points

    @property
    def displacement(self) -> Array64:
        """u, shape (N,) [u], in float64; contact nodes stand on the exact wall."""
        return np.minimum(self._displacement, self.problem.height)

    @property
    def contact_pressure(self) -> Array64:
        """sigma, shape (N,) [p]."""
        return np.where(self._set.free, 0.0, np.maximum(self._all.field[: self.problem.num_points], 0.0))
