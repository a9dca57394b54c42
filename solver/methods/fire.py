"""Plain FIRE, the published study's method, as a choice, and FIRE in mixed precision; `fire_state` is how it works.

Mixed precision: float32 work inside, float64 residuals outside.

In float32 the residual stagnates, because rounding in u comes back multiplied by the stiffest mode. Only the change is
rounded here: u = base + scale w with base in float64 and w in float32, and

    r = scale (r_0 - K w),   w <= (h - base)/scale,   r_0 = (1 - K base)/scale.

The change has the original problem's form, with another load and another wall, and its rounding is as small as the
change is. From time to time the change is added to the base (iterative refinement, J. H. Wilkinson, Rounding Errors in
Algebraic Processes (1963), chap. 3); velocity and step control go on undisturbed.
"""

import math
from collections.abc import Callable

import numpy as np

from ...kernels import layout
from ..arrays import Array64
from ..grid.problem import Problem
from ..transforms.planned import plan_transforms
from .fire_state import LOOK_AFTER, Fire
from .method import OVERFLOWING, ExecutionConfig, Method, MethodKind

_JOINS_BELOW = 0.1  # residual over the scale at which the change joins the base


class RebasedFire(Method):
    """FIRE, plain or mass-weighted, on the change of a base displacement."""

    def __init__(self, fire: Fire, net_force: Callable[[Array64], Array64]) -> None:
        """fire: works in float32, with a load of its own; its u, v, height and load become those of the change.

        net_force: `Problem.net_force` where FIRE works.
        """
        self.problem, self.tolerance, self.fire = fire.problem, fire.tolerance, fire
        self._net_force = net_force
        self._height = fire.transforms.take(fire.problem.height)
        self._rebasings = 0
        self.start(np.zeros(fire.num_points))

    def start(self, displacement: Array64) -> None:
        self._scale = 1.0
        self._base = np.minimum(self.fire.transforms.take(displacement), self._height)
        self.fire.v[:] = 0
        self._rebase()

    @property
    def displacement(self) -> Array64:
        return self.fire.transforms.fetch(self._displacement())

    def _displacement(self) -> Array64:
        """u, shape (N,) [u], where FIRE works."""
        n, height = self.fire.num_points, self._height
        u = self.fire.u[:n]
        with np.errstate(over="ignore", invalid="ignore"):
            whole = self._base + self._scale * u
        return np.where(u >= self.fire.height[:n], height, np.minimum(whole, height))

    @property
    def transform_pairs(self) -> float:
        return self.fire.transform_pairs + self._rebasings

    @property
    def iteration(self) -> int:
        return self.fire.iteration

    @property
    def residual(self) -> float:
        return self.fire.residual * self._scale

    @property
    def stopped(self) -> bool:
        return self.fire.stopped

    @property
    def patience(self) -> int | None:
        return self.fire.patience

    def step(self) -> None:
        """One iteration; now and then the change joins the base, which is another transform pair."""
        self.steps(1)

    def steps(self, most: int) -> None:
        fire = self.fire
        fire.steps(min(most, self._since + LOOK_AFTER - fire.iteration))
        if not fire.residual < OVERFLOWING:  # diverged
            fire.state[layout.STOPPED] = 1.0
        elif fire.stopped or fire.residual < _JOINS_BELOW or fire.iteration - self._since >= LOOK_AFTER:
            self._base = self._displacement()
            self._rebase()

    def _rebase(self) -> None:
        """A change of 0, scaled so that the base's equilibrium residual is 1."""
        fire = self.fire
        n, s = fire.num_points, fire.state
        if not np.isfinite(self._base).all():  # the last step went beyond all numbers
            s[layout.STOPPED], s[layout.RESIDUAL] = 1.0, math.inf
            return
        gap = self._height - self._base
        force = self._net_force(self._base)
        free = force[(gap > 0) | (force <= 0)]
        residual = math.sqrt(float(free @ free) / max(1, free.size))
        self._rebasings += 1  # a transform pair each
        scale = max(residual, 1e-300)
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            fire.v *= fire.v.dtype.type(self._scale / scale)
            fire.height[:n] = np.minimum(gap / scale, OVERFLOWING)  # a wall so far away may be anywhere
            fire.load[:n] = force / scale
        fire.u[:] = 0
        fire.stop_at_wall()
        self._scale, self._since = scale, fire.iteration
        s[layout.STOPPED] = float(not residual > self.tolerance)  # or not a number
        s[layout.RESIDUAL], s[layout.TOLERANCE] = residual / scale, self.tolerance / scale


def begin_fire(kind: type[Fire], problem: Problem, config: ExecutionConfig) -> Method:
    """FIRE of a kind on a grid; in mixed precision on the change of a displacement in float64."""
    if config.device != "cpu":
        from .fire_on_gpu import begin  # its imports only a GPU needs

        state, net_force = begin(kind, problem, config)
    else:
        how = config.working_precision, config.threads, config.planning, config.backend
        transforms, net_force = plan_transforms(problem.num_points, *how), problem.net_force
        state = kind(problem, transforms, config.tolerance, own_load=config.precision == "mixed")
    return RebasedFire(state, net_force) if config.precision == "mixed" else state


KIND = MethodKind(
    name="fire",
    label="plain FIRE",
    begin=lambda problem, config: begin_fire(Fire, problem, config),
    max_iterations=200_000,
    precisions=("float64", "float32", "mixed"),
    devices=("cpu", "cuda"),
    grows=True,
    share=0.15,
)
