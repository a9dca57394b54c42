"""What a solve returns."""

import math
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .certificate import Certificate
from .indenters import MeasuredIndenter
from .nested import Level
from .observables import Observables
from .provenance import package_version, provenance
from .relaxation import Status
from .scene import Scene

Array64 = NDArray[np.float64]


MOST_ACCURACY = 0.1
"""Coarsest relative error of a_r that may be asked for (dimensionless)."""

MEANINGLESS = 0.2
"""Of a residual over the mean pressure; where there is more left, there is no solution."""

MOST_ENERGY = 0.1
"""Of the bound on the energy's error over the elastic energy, at a tolerance that nobody asked for."""


@dataclass(frozen=True)
class Choice:
    """Something that was chosen for the user, and why.

    error: estimate of the relative error of a_r that it brings (dimensionless); 0 where it brings none.
    """

    what: str
    chosen: str
    reason: str
    error: float = 0.0


@dataclass(frozen=True)
class Solution:
    """A displacement, what it means, how it was found and how wrong it can be.

    displacement, contact_pressure: shape (N,) [length], [pressure]; contact: shape (N,), nodes the wall carries.
    status: only `Status.CONVERGED` is certified at `tolerance`; what no iteration found (`method` says so) is as
        accurate as asked, and `tolerance` is the error of a_r that was allowed.
    handed_over: the active set could not certify its result, and mass-weighted FIRE went on from there.
    certificate: None where there was no discrete problem to solve.
    accuracy: the relative error of a_r asked for, if any, and choices: what was chosen for it, and why.
    rounded_off: rounding is what keeps the residual above the tolerance.
    levels: the coarser grids, from coarse to fine; empty without nested grids. iterations: on all grids.
    transform_pairs: forward-inverse pairs in units of a pair on the finest grid, short and coarse ones by their length.
    seconds: wall time by stage ('setup', 'solve', 'certificate', 'total') [s].
    """

    scene: Scene
    method: str
    tolerance: float
    status: Status
    displacement: Array64
    contact_pressure: Array64
    contact: NDArray[np.bool_]
    observables: Observables
    certificate: Certificate | None
    iterations: int
    transform_pairs: float
    seconds: dict[str, float]
    threads: int
    planning: str
    backend: str
    handed_over: bool = False
    levels: tuple[Level, ...] = field(default_factory=tuple)
    accuracy: float | None = None
    choices: tuple[Choice, ...] = field(default_factory=tuple)
    rounded_off: bool = False

    @property
    def reason(self) -> str:
        """Why the status is not `CONVERGED`: the parameter that it depends on, and what is allowed. Empty if it is."""
        residual = self.certificate.free_residual if self.certificate else math.inf
        points, precision = self.scene.num_points, self.scene.precision
        other = ", or precision mixed or float64" if precision == "float32" else ""
        looser = ""
        if self.tolerance < residual < MEANINGLESS:
            looser = f", or tolerance above {residual:.2g} (it is {self.tolerance:g})"
        match self.status:
            case Status.CONVERGED:
                return ""
            case Status.INTERRUPTED:
                return "it was interrupted"
            case Status.ITERATION_LIMIT:
                return f"max_iterations is reached after {self.iterations}; allowed: more{looser}"
            case Status.INACCURATE:
                o = self.observables
                known = o.contact_area_error / o.contact_area_subgrid if o.contact_area_subgrid else math.inf
                above = f"above {known:.2g}, or " if known < MOST_ACCURACY else ""
                heights = " (and heights)" if isinstance(self.scene.indenter, MeasuredIndenter) else ""
                return f"accuracy is {self.accuracy:g}; allowed: {above}more num_points{heights} than {points}"
            case _ if self.accuracy:
                takes = f"takes a residual of {self.tolerance:.2g} and got {residual:.2g}"
                return f"accuracy is {self.accuracy:g}, which {takes}; allowed: a larger one"
            case _ if residual <= self.tolerance and self.certificate:
                off = f"the energy may be off by {self.certificate.energy_error_bound:.2g} of itself"
                return f"tolerance is {self.tolerance:.2g}, at which {off}; allowed: a smaller one{other}"
            case _ if self.rounded_off:
                leaves = f"rounding in {precision} leaves"
                if residual < MEANINGLESS:
                    return f"tolerance is {self.tolerance:g}; allowed: above {residual:.2g}, which {leaves}{other}"
                return f"num_points is {points}, where {leaves} a residual of {residual:.2g}; allowed: fewer{other}"
            case _:
                method = f"method is {self.method} in precision {precision}, which does not settle here"
                return f"{method}; allowed: another{looser}"

    def to_dict(self) -> dict[str, Any]:
        """Everything but the fields that has a meaning, JSON-ready: numbers, text, flat objects; infinite: 'inf'."""
        record: dict[str, Any] = {"status": str(self.status)}
        if self.reason:
            record["reason"] = self.reason
        observables = asdict(self.observables).items()
        record |= {name: _plain(value) for name, value in observables if value is not None}
        return record | {
            "iterations": self.iterations,
            "transform_pairs": round(self.transform_pairs, 3),
            "handed_over": self.handed_over,
            "levels": {
                str(level.num_points): {name: _plain(value) for name, value in level.to_dict().items()}
                for level in self.levels
            },
            **({"accuracy": self.accuracy} if self.accuracy else {}),
            "choices": {
                choice.what: {"chosen": choice.chosen, "reason": choice.reason, "error": _plain(choice.error)}
                for choice in self.choices
            },
            "seconds": dict(self.seconds),
            "certificate": {name: _plain(value) for name, value in asdict(self.certificate).items()}
            if self.certificate
            else {},
            "method": self.method,
            "precision": self.scene.precision,
            "tolerance": self.tolerance,
            "threads": self.threads,
            "planning": self.planning,
            "backend": self.backend,
            "scene": self.scene.to_dict(),
            "version": package_version(),
            "provenance": provenance(),
        }


def _plain(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)
