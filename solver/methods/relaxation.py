"""The loop that drives every method on one grid."""

import math
import time
from collections.abc import Callable

from ..endings import Status
from .method import Method

Progress = Callable[[int, float], None]
"""Called with (iteration, residual over the mean pressure)."""

_IDLE = 1000
"""Steps in a row that need not count as iterations."""

OVERFLOWING = 1e30
"""Residual over the mean pressure; a larger one is on its way to overflow."""


def relax(state: Method, max_iterations: int, progress: Progress | None = None) -> Status:
    """Step until the residual meets the tolerance, and say how it ended.

    Other ends: `max_iterations`; no new minimum of the residual for long (the limit of the precision); overflow;
    Ctrl-C. The state stays usable after each of them. Raises `ValueError` for a method whose steps do not count.
    """
    best, best_at, shown = math.inf, 0, time.monotonic()
    counted, idle = state.iteration, 0
    try:
        while state.iteration < max_iterations:
            state.steps(max_iterations - state.iteration)
            idle = idle + 1 if state.iteration == counted else 0
            counted = state.iteration
            if idle > _IDLE:
                what = f"iteration of {type(state).__name__} is {counted} after {idle} more steps"
                raise ValueError(f"{what}; allowed: a number that grows with the steps")
            if state.stopped:
                if state.residual <= state.tolerance:
                    return Status.CONVERGED
                return Status.STAGNATED if state.residual < OVERFLOWING else Status.DIVERGED
            if state.residual < 0.99 * best:
                best, best_at = state.residual, state.iteration
            elif state.patience is not None and state.iteration - best_at > state.patience:
                return Status.STAGNATED
            if progress and time.monotonic() - shown > 0.1:
                shown = time.monotonic()
                progress(state.iteration, state.residual)
    except KeyboardInterrupt:
        return Status.INTERRUPTED
    return Status.ITERATION_LIMIT
