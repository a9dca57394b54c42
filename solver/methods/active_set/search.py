"""The search for the contact nodes in both of its forms, by pressures and by displacements.

Conjugate gradients go on until the residual has fallen to a given part of the one when the set last changed. Then the
set is updated. The search ends when an update changes nothing at the tolerance asked for. When a set comes back it
goes on cautiously, and ends if one comes back then, too. All numbers are dimensionless.
"""

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ...arrays import Array64, Indices
from ...grid.patches import Patches
from ...grid.problem import Problem
from ..method import ExecutionConfig, Method
from .fields import Everywhere
from .greens_function import GreensFunction

SMALLEST = 0.1
"""Force of a node that joins or leaves, over the tolerance: below, sets would change by rounding."""
OVER_FLOOR = 0.3
"""Residual that can be reached, over the equilibrium residual that rounding leaves."""
_SAFETY = 0.2
"""Residual to stop at over the tolerance: the equilibrium residual is up to four times the pressure's error, mostly.
Once more after the certificate has found it too large."""
_PATIENCE = 25  # iterations in which the residual does not become less; then it is rounding, too, and may grow
_BOLD, _CAUTIOUS = 0.05, 1e-4  # part of a new set's residual at which the set is updated


@dataclass(eq=False, kw_only=True)
class NodeSet:
    """A set of nodes with conjugate gradients on it, in the compact order of its runs of neighbouring nodes."""

    patches: Patches
    """Its runs of neighbouring nodes."""
    preconditioner: Callable[[Array64], Array64] | None = None
    """Made when it is needed."""
    direction: Array64 = field(default_factory=lambda: np.zeros(0))
    """Search direction, shape (nodes,): a pressure [p] or a displacement [u]."""
    last_product: float = 0.0
    """Residual times preconditioned residual of the previous iteration [p u]; 0 makes the next step one of steepest
    descent."""
    first_residual: float = math.inf
    """Residual when the set was new, over p."""
    least_residual: float = math.inf
    """The smallest of them, over p."""
    in_vain: int = 0
    """Iterations since then."""
    settled: bool = False
    """No node wanted to join or leave when the set was last examined."""

    @property
    def nodes(self) -> Indices:
        """Grid index of each of them, shape (nodes,)."""
        return self.patches.nodes

    def begin_anew(self) -> None:
        """Conjugate gradients begin anew on this set, with another operator or solution."""
        self.last_product, self.least_residual, self.in_vain = 0.0, math.inf, 0

    def turn(self, residual: Array64, preconditioned: Array64) -> Array64:
        """The next conjugate direction, from the residual and the preconditioned one."""
        product = float(residual @ preconditioned)
        share = product / self.last_product if self.last_product else 0.0
        self.direction = preconditioned + share * self.direction if share else preconditioned
        self.last_product = product
        return self.direction


class Search(Method):
    """The active set on one grid, in either form."""

    iteration = 0
    residual = math.inf
    stopped = False
    patience = None  # the residual starts anew with every set
    _set: NodeSet

    def __init__(
        self, problem: Problem, config: ExecutionConfig, green: GreensFunction, everywhere: Everywhere
    ) -> None:
        """everywhere: the field that is carried along on all nodes."""
        self._all = everywhere
        self.problem, self.tolerance, self._fixed_set = problem, config.tolerance, config.fixed_set
        self._green, self._target = green, _SAFETY * config.tolerance
        self._begin()

    def _begin(self, cautious: bool = False) -> None:
        """Begin from another set. cautious: solve every set well before it is updated; a search becomes so when a set
        comes back.
        """
        self._cautious, self._floor, self.stopped = cautious, 0.0, False
        self._keys: set[int] = set()  # of the sets since then

    @property
    def transform_pairs(self) -> float:
        return self._all.pairs + self._green.transformed / self.problem.num_points

    def rest(self) -> None:
        self._all.rest()
        self._green.layer.rest()

    @property
    def _aim(self) -> float:
        """The residual to stop at; below the floor, sets would be decided on rounding."""
        return max(self._target, self._floor)

    def tighten(self) -> bool:
        self._target *= _SAFETY
        self._floor *= _SAFETY
        self.stopped = False
        self._keys.clear()
        return True

    def _go_on(self, iterate: Callable[[], bool]) -> None:
        """Update the set if it is solved well enough for that; else one iteration on it.

        iterate: one of conjugate gradients; False where rounding has left no way down.
        """
        now = self._set
        if math.isinf(now.first_residual):
            now.first_residual = self.residual
        forcing = 0.0 if now.settled else _CAUTIOUS if self._cautious else _BOLD
        if self.residual <= max(self._aim, forcing * now.first_residual):
            if self._update_set():
                self.iteration += 1
                return
            now.settled = True
            if self.residual <= self._aim:
                self.stopped = True
                return
        self.iteration += 1
        now.in_vain += 1
        if self.residual < now.least_residual:
            now.least_residual, now.in_vain = self.residual, 0
        if not math.isfinite(self.residual):
            self.stopped = True
        elif now.in_vain > _PATIENCE or not iterate():
            if self._operator_is_exact():
                # this set is not solved any further; it may be the wrong one, unless it was examined before: now
                # rounding would decide
                self.stopped = now.settled or not self._update_set() or self.stopped
            else:
                now.begin_anew()

    def _operator_is_exact(self) -> bool:
        """Whether rounding alone can be in the way; else the operator is an exact one from now on."""
        return True

    @abstractmethod
    def _update_set(self) -> bool:
        """Take the next set; False if no node wants to join or leave."""

    def _circles(self, before: NodeSet) -> bool:
        """Whether the new set comes back although the search is cautious, which ends it with the one before."""
        key = hash((self._set.patches.first.tobytes(), self._set.patches.last.tobytes()))
        if key in self._keys and self._cautious:
            self._set, self.stopped, self.residual = before, True, max(self.residual, 2 * self.tolerance)
            return True
        if key in self._keys:
            self._cautious, self._keys = True, set()
        self._keys.add(key)
        return False
