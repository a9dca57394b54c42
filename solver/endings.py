"""How a solve can end, and why: every ending that is not a success carries its reason from the place that knows it."""

from dataclasses import dataclass
from enum import StrEnum


class Status(StrEnum):
    """How a solve ended. Only `CONVERGED` is certified at the tolerance, or is as accurate as was asked for."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "iteration limit"
    STAGNATED = "stagnated"
    DIVERGED = "diverged"
    INTERRUPTED = "interrupted"
    INACCURATE = "converged, but less accurate than asked"


class Cause(StrEnum):
    """The cause that keeps a solve from its goal."""

    INTERRUPTION = "interruption"
    """Ctrl-C."""
    ITERATIONS = "iterations"
    """The limit of iterations came first."""
    ROUNDING = "rounding"
    """The precision leaves a larger residual than asked for."""
    ENERGY = "energy"
    """The residual is small enough, but the bound on the energy's error says that this means little here."""
    METHOD = "method"
    """The method does not settle on this scene."""
    GRID = "grid"
    """The grid is too coarse for the accuracy asked for."""


@dataclass(frozen=True)
class Reason:
    """Why a solve did not reach its goal, and what would help."""

    cause: Cause
    """The kind of reason."""
    parameter: str
    """The parameter of `solve` or `Scene` that it depends on."""
    found: str
    """The parameter's value, or an event that ended the solve."""
    allowed: str
    """Values or settings that may reach the goal."""

    def __str__(self) -> str:
        return f"{self.parameter} is {self.found}; allowed: {self.allowed}" if self.parameter else self.found
