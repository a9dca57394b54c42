"""The interface of a method: its state on one grid, and the properties of its kind.

`relax` is the loop that drives every method.
"""

import math
import time
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from ..arrays import Array64
from ..endings import Status
from ..grid.problem import Problem

Progress = Callable[[int, float], None]
"""Called with (iteration, residual over the mean pressure)."""

PATIENCE = 1000
"""Iterations without a new minimum of the residual, or steps that count as none, after which there is no hope."""

OVERFLOWING = 1e30
"""Residual over the mean pressure; a larger one is on its way to overflow."""


class Method(Protocol):
    """The state of a method on one grid, in the problem's units; made by `MethodKind.begin`."""

    problem: Problem
    tolerance: float
    """On the rms free force over the mean pressure, or on the estimate of it that the method has (dimensionless)."""

    @abstractmethod
    def start(self, displacement: Array64) -> None:
        """Begin at rest from a displacement, shape (N,) [u], which is put below the wall."""

    def start_from_pressure(self, pressure: Array64) -> None:
        """Begin from a contact pressure, shape (N,) [p], which is 0 where there is no contact."""
        self.start(self.problem.displacement_under(pressure))

    @abstractmethod
    def step(self) -> None:
        """One iteration."""

    def steps(self, most: int) -> None:
        """One iteration, or some up to `most` where it takes longer to look at each than to do it."""
        self.step()

    @property
    @abstractmethod
    def iteration(self) -> int:
        """Iterations so far."""

    @property
    @abstractmethod
    def transform_pairs(self) -> float:
        """Pairs of a forward and an inverse transform of this grid's length so far; shorter ones by their length."""

    @property
    @abstractmethod
    def residual(self) -> float:
        """The error left, over the mean pressure: the rms free force, or an estimate of the rms error of the contact
        pressure.
        """

    @property
    @abstractmethod
    def stopped(self) -> bool:
        """Nothing more to do: converged, or no way on."""

    @property
    @abstractmethod
    def displacement(self) -> Array64:
        """u <= h, shape (N,) [u], in float64; nodes on the wall stand on it exactly."""

    @property
    def contact_pressure(self) -> Array64:
        """sigma >= 0, shape (N,) [p], in float64."""
        return self.problem.wall_pressure(self.displacement)

    @property
    def patience(self) -> int | None:
        """Iterations without a new minimum of the residual after which there is no hope; None: it ends by itself."""
        return PATIENCE

    def tighten(self) -> bool:
        """Aim at a smaller residual, after the certificate found too large a force; False: it cannot."""
        return False

    def rest(self) -> None:
        """Give back arrays that can be made anew, to leave room for the certificate or a finer grid; the state stays
        usable.
        """
        return


@dataclass(frozen=True)
class ExecutionConfig:
    """Configuration of a solve, and of a method on one grid."""

    tolerance: float = 1e-8
    """See `Method`."""
    precision: str = "float64"
    """'float64', 'float32' or 'mixed'."""
    fixed_set: bool = False
    """Whether the contact nodes stay those of the start; the active set's only."""
    contact_share: float = 0.0
    """Share of the nodes in contact on the next coarser grid; 0 where that is not known (dimensionless)."""
    threads: int = 1
    """Threads of the transforms."""
    planning: str = "estimate"
    """FFTW's planning effort."""
    backend: str = "warp"
    """The kernels: 'warp', or 'numpy' for the reference kernels."""
    device: str = "cpu"
    """Where the method works: 'cpu', or 'cuda' for a GPU, on which threads, planning and backend have no effect."""
    progress: Progress | None = None
    """Called about ten times a second with (iteration, residual)."""

    @property
    def working_precision(self) -> str:
        """Of the transforms inside: 'float64' or 'float32'."""
        return "float64" if self.precision == "float64" else "float32"


@dataclass(frozen=True)
class MethodKind:
    """A method as a choice."""

    name: str
    """On the command line and in stored results."""
    label: str
    """In sentences and figures."""
    begin: Callable[[Problem, ExecutionConfig], Method]
    """Makes the method's state on a grid, at its own starting point."""
    max_iterations: int
    """Limit of iterations where none is given."""
    precisions: tuple[str, ...] = ("float64",)
    """Precisions that it takes."""
    devices: tuple[str, ...] = ("cpu",)
    """Where it can work, see `ExecutionConfig.device`."""
    nested: bool = False
    """Whether it starts from the solution on coarser grids unless told otherwise."""
    grows: bool = False
    """Whether its iterations grow with the number of points, so that it takes long on large grids."""
    fallback: str | None = None
    """The method that takes over where it did not settle or its result could not be certified."""
    bytes_per_point: Callable[[float], float] = field(default=lambda contact_share: 160)
    """Memory that a solve takes at its peak by the share of the nodes in contact [bytes a point]."""
    share: float = 0.1
    """How often studies of random scenes try it, compared with the other methods (dimensionless)."""


def relax(state: Method, max_iterations: int, progress: Progress | None = None) -> Status:
    """Step until the residual meets the tolerance, and say how it ended.

    Other ends: `max_iterations`; no new minimum of the residual for long; overflow; Ctrl-C. The state stays usable.
    Raises `ValueError` for a method whose steps do not count.
    """
    best, best_at, shown = math.inf, 0, time.monotonic()
    counted, idle = state.iteration, 0
    try:
        while state.iteration < max_iterations:
            state.steps(max_iterations - state.iteration)
            idle = idle + 1 if state.iteration == counted else 0
            counted = state.iteration
            if idle > PATIENCE:
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
