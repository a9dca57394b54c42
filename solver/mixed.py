"""Mixed precision: float32 work inside, float64 residuals outside, for every method.

In float32 the residual stagnates, because rounding in u comes back multiplied by the stiffest mode. What is rounded
here is the change only: u = base + scale w with base in float64 and w in float32, and

    r = scale (r_0 - K w),   w <= (h - base)/scale,   r_0 = (1 - K base)/scale.

The change has the original problem's form, with another load and another wall, and its rounding is as small as the
change is. From time to time the change is added to the base (iterative refinement, J. H. Wilkinson, Rounding Errors in
Algebraic Processes (1963), chap. 3); velocity and step control go on undisturbed. For the active set: a step along a
direction changes the response by a float32 transform, and the response itself is float64.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import Call, layout
from .active_set import ActiveSet
from .fire import Fire, MassWeightedFire
from .problem import Problem
from .transforms import Transforms

Array = NDArray[Any]
Array64 = NDArray[np.float64]

_FAR = 1e30  # a wall so far away may be anywhere


class _Rebased(Fire):
    """FIRE on the change of a base displacement. The arrays u, v, height and load are those of the change."""

    load: Array
    smallest = 0.1  # residual over the scale at which the change joins the base
    longest = 50  # iterations after which it does in any case
    hopeless = 5  # times in a row that the base's residual did not confirm the change's

    def start(self, displacement: Array64) -> None:
        """Begin at rest from u, shape (N,) [u], put below the wall."""
        self._scale = 1.0
        self._base, self._in_vain, self._best = np.minimum(displacement, self.problem.height), 0, math.inf
        self.v[:] = 0
        self._rebase()

    @property
    def displacement(self) -> Array64:
        """u, shape (N,) [u], in float64; nodes on the wall stand on it exactly."""
        u, height = self.u[: self.num_points], self.problem.height
        with np.errstate(over="ignore", invalid="ignore"):
            sum_ = self._base + self._scale * u
        return np.where(u >= self.height[: self.num_points], height, np.minimum(sum_, height))

    @property
    def residual(self) -> float:
        """As for `Fire`."""
        return super().residual * self._scale

    def step(self) -> None:
        """One iteration; now and then the change joins the base, which is another transform pair."""
        super().step()
        if not super().residual < 1e30:  # diverged
            self.state[layout.FROZEN] = 1.0
        elif self.frozen or super().residual < self.smallest or self.iteration - self._since >= self.longest:
            self._base = self.displacement
            self._rebase()

    def _rebase(self) -> None:
        """A change of 0, scaled so that the base's free residual is 1."""
        n, s = self.num_points, self.state
        if not np.isfinite(self._base).all():  # the last step went beyond all numbers
            s[layout.FROZEN], s[layout.RESIDUAL] = 1.0, math.inf
            return
        gap = self.problem.height - self._base
        force = self.problem.net_force(self._base)
        free = force[(gap > 0) | (force <= 0)]
        residual = math.sqrt(float(free @ free) / max(1, free.size))
        self.transform_pairs += 1
        scale = max(residual, 1e-300)
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            self.v *= self.v.dtype.type(self._scale / scale)
            self.height[:n] = np.minimum(gap / scale, _FAR)
            self.load[:n] = force / scale
        self.u[:] = 0
        self._stop_at_wall()
        self._scale, self._since = scale, self.iteration
        self._judge(residual)

    def _judge(self, residual: float) -> None:
        """Frozen once the base meets the tolerance, or where only the change's residual does, again and again."""
        s = self.state
        if self.frozen:
            self._in_vain = 0 if residual < 0.5 * self._best else self._in_vain + 1
            self._best = min(self._best, residual)
        met = not residual > self.tolerance  # or not a number
        s[layout.FROZEN] = float(met or self._in_vain > self.hopeless)
        s[layout.RESIDUAL], s[layout.TOLERANCE] = residual / self._scale, self.tolerance / self._scale


class MixedMassWeightedFire(_Rebased, MassWeightedFire):
    """Mass-weighted FIRE in mixed precision."""


class MixedFire(_Rebased, Fire):
    """Plain FIRE in mixed precision: the net force has a load that differs from node to node."""

    def _prepare(self) -> None:
        self.force, self.load = self.transforms.buffer(), self.transforms.buffer()
        self.load[:] = 1
        squares, held, power, velocity = sums = self._sums(4)
        self._move = self._replay(
            Call("net_force", (self.load, self.work, self.v), (self.force, squares, held)),
            Call("search_sums", (self.force, self.v), (self.force, power, velocity, squares)),
            Call("fire_control", (*sums, squares), (self.state,)),
            Call("fire_step", (self.force, self.height, self.state), (self.u, self.v)),
        )
        self._limit_step(float(self.problem.stiffness.max()))


class MixedActiveSet(ActiveSet):
    """The active set in mixed precision: directions and their images in float32, response and pressure in float64.

    The response is made anew from the pressure, by float64 transforms, when what the images' rounding may have put
    into the residual comes close to it, and before the end.
    """

    def __init__(self, problem: Problem, transforms: Transforms, tolerance: float, backend: str = "warp") -> None:
        self._exact = Transforms(problem.num_points, "float64", transforms.threads, transforms.planning)
        self._rounding = float(np.finfo(np.float32).eps) * math.sqrt(float(np.mean(problem.stiffness**2)))
        super().__init__(problem, transforms, tolerance, backend)
        self._exact_field = self._exact.buffer()
        self._exact_compliance = self._operator(self._exact, self._exact_field, self._response)

    def _fields(self) -> tuple[Array, Array, Array]:
        return self._exact.buffer(), self._exact.buffer(), self._exact.buffer()

    def _find_response(self) -> None:
        self._scale_to_load()
        field = self._exact_field
        field[:] = 0
        field[self._at] = self._pressure
        for part in self._exact_compliance:
            part()
        self._pairs += 1
        self._drift = 0.0

    def _advance_along(self, r: Array64, z: Array64) -> None:
        super()._advance_along(r, z)
        image = float(self._state[layout.STEP]) * self._work[self._at].astype(np.float64)
        self._drift = math.hypot(self._drift, self._rounding * math.sqrt(float(image @ image) / self._num_points))
