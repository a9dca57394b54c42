"""Active set: preconditioned conjugate gradients on the contact, the set of contact nodes updated on the way.

Unknown is the contact pressure sigma >= 0 on the contact nodes C, with the load fixed. There the gap h + G sigma must
be one constant, the rigid approach; elsewhere it must not be less. An iteration takes one application of G, because the
response G sigma is carried along (`surface`). It is made anew, by transforms of all nodes, when the error that it has
gathered comes close to the residual, and before the end. The residual is the preconditioned one, an estimate of the
pressure's error: rms over all nodes, over the mean pressure.

Under a stiff coating on a soft base the search is cautious at once (C. L. Lawson and R. J. Hanson, Solving Least
Squares Problems (1974), ch. 23, with the load fixed, and all nodes at once that penetrate).
"""

import math
import weakref
from dataclasses import replace

import numpy as np

from ...arrays import Array64
from ...grid.cached import MOST_POINTS
from ...grid.problem import Problem, foundation_pressure, rounding_floor
from ..method import ExecutionConfig, MethodKind
from .fields import Everywhere
from .free_nodes import FreeNodes
from .greens_function import HARD, SMALL, GreensFunction
from .preconditioner import PatchDeflation
from .search import OVER_FLOOR, SMALLEST, Search
from .surface import ContactSet, Surface

_SOFT = 0.01  # stiffness of a base over that of its coating, below which the coating is stiff
_LEAST = 0.23  # share of the nodes in contact from which displacements as unknown take less time than pressures
_SHORT_RANGED = 2.0  # K of the longest wave over the least K, up to which K in real space is short-ranged


class ActiveSet(Search):
    """The active set on one grid, by pressures."""

    _set: ContactSet

    def __init__(
        self, problem: Problem, config: ExecutionConfig, green: GreensFunction, everywhere: Everywhere
    ) -> None:
        super().__init__(problem, config, green, everywhere)
        self._precision = config.precision
        # a single node that penetrates so much takes that part of the tolerance as its force
        self._smallest_gap = SMALLEST * self.tolerance / float(problem.stiffness.mean())
        # on a half-space K is q/2: below a stiff coating long waves find a base that is softer
        soft_base = bool(problem.stiffness[1] * (problem.stiffness.size - 1) < _SOFT * problem.stiffness[-1])
        self._begins_cautious = soft_base and config.precision == "float64" and not self._fixed_set
        self._surface = Surface(problem, None if self._begins_cautious else problem.layer.split, everywhere)
        self._begun = False

    def start(self, displacement: Array64) -> None:
        self.start_from_pressure(self.problem.wall_pressure(displacement))

    def start_from_pressure(self, pressure: Array64) -> None:
        """Begin from a contact pressure, shape (N,) [p]; without any, from that of a Winkler foundation."""
        if not pressure.any():
            pressure = foundation_pressure(self.problem)
        nodes = np.flatnonzero(pressure > 0)
        self._set = ContactSet.of(nodes, pressure[nodes], self.problem.num_points)
        self._begin(self._begins_cautious)
        self._begun = True
        self._surface.renew(self._set)
        self._floor = OVER_FLOOR * rounding_floor(self.problem.stiffness, self.displacement, self._precision)

    def step(self) -> None:
        """Solve on the set, by one iteration; where that has come far enough, update the set instead."""
        if not self._begun:
            self.start_from_pressure(np.zeros(self.problem.num_points))
        now, drift = self._set, self._surface.drift
        small = now.nodes.size <= (HARD if self._cautious else SMALL) and self._precision == "float64"
        if small and not (self._surface.nearby or now.eliminated or now.patches.full):
            self._eliminate()
            return
        if now.preconditioner is None:
            now.preconditioner = PatchDeflation(self._green, now.patches, self._cautious)
        touching = self._surface.touching(now)
        r = float(touching.mean()) - touching
        z = now.preconditioner(r)
        self.residual = math.sqrt(float(z @ z) / self.problem.num_points)
        if drift and self.residual <= max(self._aim, drift):
            if math.isinf(now.first_residual):
                now.first_residual = self.residual
            self._surface.renew(now)
            now.last_product = 0.0
            self.iteration += 1
            self._update_set()  # the gap of all nodes is known only now
        else:
            self._go_on(lambda: self._surface.go_along(now, now.turn(r, z)))

    def _eliminate(self) -> None:
        """Solve on a small set by elimination, as well as rounding allows, and update it. In a cautious search nodes
        that would pull are dropped until none does.
        """
        now, height = self._set, self.problem.height
        now.eliminated, nodes = True, now.nodes
        pressure = self._green.solve(nodes, height[nodes])
        while self._cautious and pressure is not None and (pressure < 0).any():
            nodes = nodes[pressure >= 0]
            pressure = self._green.solve(nodes, height[nodes])
        if pressure is None:  # iterate
            return
        if nodes.size < now.nodes.size:
            order = np.argsort(nodes)
            now = self._set = ContactSet.of(nodes[order], pressure[order], height.size)
            now.eliminated = True
        else:
            now.pressure = pressure
        now.begin_anew()  # the search direction belongs to another pressure
        self._renew_eliminated(now)
        # rounding: under a stiff coating elements of G are millions of times as large as the part that short waves need
        if self.residual > self._aim:
            touching = self._surface.touching(now)
            change = self._green.solve(now.nodes, touching - touching.mean(), load=0.0)
            if change is not None:
                now.pressure = now.pressure + change
                self._renew_eliminated(now)
        self.iteration += 1
        if not self._update_set():
            now.settled = True
            self.stopped = self.stopped or self.residual <= self._aim

    def _renew_eliminated(self, now: ContactSet) -> None:
        """Make the response to a pressure by elimination, and its residual."""
        self._surface.renew(now)
        touching = self._surface.touching(now)
        # G_CC^-1 is at most K_CC, and K at most 2
        self.residual = 2 * float(touching.std()) * math.sqrt(touching.size / self.problem.num_points)

    def _operator_is_exact(self) -> bool:
        if not self._surface.nearby:
            return True
        self._surface.split = None
        self._surface.renew(self._set)
        return False

    def _update_set(self) -> bool:
        """Drop nodes that pull, add nodes that penetrate; False if there are none."""
        now, pulling = self._set, bool((self._set.pressure < 0).any())
        new = self._surface.penetrating(now, self._smallest_gap)
        if self._fixed_set or not (pulling or new.size):
            return False
        self._set, dropped = now.changed(new[:0] if pulling and self._cautious else new)
        if not self._circles(now):
            self._surface.follow(now, self._set, dropped)
        return True

    @property
    def displacement(self) -> Array64:
        return self._surface.displacement(self._set) if self._begun else np.zeros(self.problem.num_points)

    @property
    def contact_pressure(self) -> Array64:
        pressure = np.zeros(self.problem.num_points)
        if self._begun:
            pressure[self._set.nodes] = np.maximum(self._set.pressure, 0.0)
        return pressure


def begin(problem: Problem, config: ExecutionConfig) -> ActiveSet | FreeNodes:
    """The active set on a grid, in the form that suits the contact's share of it."""
    layer = problem.layer
    if config.precision == "mixed":  # transforms are few, so those in float32 would save nothing
        config = replace(config, precision="float64")
    much = config.contact_share >= _LEAST and config.precision == "float64"
    free = much and bool(layer.stiffness[1] <= _SHORT_RANGED * layer.stiffness[1:].min())
    symbol = problem.stiffness if free else layer.compliance
    # plans and recorded kernels are a quarter of a small solve's time: they serve the next one with layer and grid, and
    # do not keep the layer's response alive
    key = free, config.precision, config.threads, config.planning, config.backend
    left: list[tuple[Everywhere, GreensFunction]] = layer.made.setdefault(key, [])
    try:
        field, green = left.pop()
    except IndexError:  # all are in use
        field, green = Everywhere(symbol, problem.num_points, config), GreensFunction(weakref.proxy(layer))
    field.begin(problem.height)
    green.begin()
    found: ActiveSet | FreeNodes = (FreeNodes if free else ActiveSet)(problem, config, green, field)
    if problem.num_points <= MOST_POINTS:
        weakref.finalize(found, left.append, (field, green)).atexit = False
    return found


def _bytes_per_point(contact_share: float) -> float:
    # more than the peaks that docs/costs.md has, on 2^23 points and more: by 1.2 (2 % in contact) to 1.7 times (74 %)
    return 120 + min(360 * contact_share, 60 + 100 * contact_share)


KIND = MethodKind(
    name="active-set",
    label="active set",
    begin=begin,
    max_iterations=2_000,
    precisions=("float64", "float32", "mixed"),
    nested=True,
    fallback="mass-weighted-fire",
    bytes_per_point=_bytes_per_point,
    share=0.6,
)
