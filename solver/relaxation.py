"""What every method offers, and the loop that drives it."""

import math
import time
from collections.abc import Callable
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .problem import Problem

Array64 = NDArray[np.float64]
Progress = Callable[[int, float], None]
"""Called with (iteration, residual over the mean pressure)."""


class Status(StrEnum):
    """How a solve ended. Only `CONVERGED` is certified at the tolerance, or accurate, as asked."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "iteration limit"
    STAGNATED = "stagnated"
    DIVERGED = "diverged"
    INTERRUPTED = "interrupted"
    INACCURATE = "converged, but less accurate than asked"


class Method(Protocol):
    """State of a method on one grid, in the problem's units; made from (problem, transforms, tolerance, backend)."""

    problem: Problem
    tolerance: float
    backend: str

    def start(self, displacement: Array64) -> None:
        """Begin from a displacement, shape (N,) [u]."""

    def start_from_pressure(self, pressure: Array64) -> None:
        """Begin from a contact pressure, shape (N,) [p], 0 where there is no contact."""

    def step(self) -> None:
        """One iteration."""

    @property
    def iteration(self) -> int:
        """Iterations so far."""

    @property
    def transform_pairs(self) -> float:
        """Forward-inverse pairs of this grid's length so far."""

    @property
    def residual(self) -> float:
        """Error left, over the mean pressure: the rms free force (FIRE), or the rms error of the contact pressure."""

    @property
    def frozen(self) -> bool:
        """Nothing more to do: converged, or no way on."""

    @property
    def patience(self) -> int:
        """Iterations without a new minimum of the residual after which there is no hope."""

    @property
    def displacement(self) -> Array64:
        """u <= h, shape (N,) [u], float64."""

    @property
    def contact_pressure(self) -> Array64:
        """sigma >= 0, shape (N,) [p], float64."""


def relax(state: Method, max_iterations: int, progress: Progress | None = None) -> Status:
    """Step until the residual meets the tolerance, and say how it ended.

    Other ends: `max_iterations`; no new minimum of the residual for long (the limit of the precision); overflow;
    Ctrl-C. The state stays usable after each of them.
    """
    best, best_at, shown = math.inf, 0, time.monotonic()
    try:
        while state.iteration < max_iterations:
            state.step()
            if state.frozen:
                if state.residual <= state.tolerance:
                    return Status.CONVERGED
                return Status.STAGNATED if state.residual < 1e30 else Status.DIVERGED
            if state.residual < 0.99 * best:
                best, best_at = state.residual, state.iteration
            elif state.iteration - best_at > state.patience:
                return Status.STAGNATED
            if progress and time.monotonic() - shown > 0.1:
                shown = time.monotonic()
                progress(state.iteration, state.residual)
    except KeyboardInterrupt:
        return Status.INTERRUPTED
    return Status.ITERATION_LIMIT
