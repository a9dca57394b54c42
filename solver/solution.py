"""The answer of a solve."""

import math
import os
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any

from .. import __version__
from . import checks, display
from .arrays import Array64, Mask
from .endings import Reason, Status
from .grid.certificate import Certificate
from .grid.observables import Measured, Observables
from .grid.patch_table import PatchTable
from .provenance import provenance
from .scene import Scene
from .value import Value
from .warnings import SolutionWarning, find_warnings

MOST_ENERGY = 0.1
"""Bound on the energy's error over the elastic energy, at a tolerance that nobody asked for (dimensionless)."""


@dataclass(frozen=True)
class Level(Measured):
    """The results of a coarser grid; on grids before the last coarser one pressures alone tell the edges."""

    num_points: int
    """Its points."""
    iterations: int
    """Iterations on this grid."""
    transform_pairs: float
    """Transform pairs on this grid, in pairs of its own length."""


@dataclass(frozen=True)
class Choice:
    """Something that was chosen for the user."""

    what: str
    """Name of the setting."""
    chosen: str
    """Its value."""
    reason: str
    """Why."""
    error: float = 0.0
    """Estimate of the relative error that it brings into the quantity asked for, or of a pressure that was found
    its own (dimensionless); 0: none."""

    def __repr__(self) -> str:
        error = display.rounded_up(self.error)
        return f"Choice of {self.what}: {self.chosen}, error {error} [-], because {self.reason}"


@dataclass(frozen=True)
class Solution(Value):
    """A displacement, its meaning, how it was found and how wrong it can be."""

    scene: Scene
    """The scene that was solved, on the grid of the fields."""
    method: str
    """Name of the method; of the smaller model where no iteration was needed."""
    tolerance: float
    """On the equilibrium residual over p; where no iteration was needed, the error that was allowed (dimensionless)."""
    status: Status
    """Only `Status.CONVERGED` is certified at `tolerance`, or is as accurate as was asked for."""
    displacement: Array64
    """u, shape (N,) [length]."""
    contact_pressure: Array64
    """sigma, shape (N,) [pressure]."""
    contact: Mask
    """Nodes that the wall carries, shape (N,)."""
    observables: Observables
    """Contact area, kappa and other measured numbers."""
    patches: PatchTable
    """The contact patches, a `PatchTable`: their ends, widths, loads and largest pressures."""
    certificate: Certificate | None
    """How wrong the displacement is; None where there was no discrete problem to solve."""
    iterations: int
    """Iterations on all grids together."""
    transform_pairs: float
    """Forward-inverse pairs in units of a pair on the finest grid, short and coarse ones by their length."""
    seconds: dict[str, float]
    """Wall time by stage: 'setup', 'solve', 'certificate', 'total' [s]."""
    threads: int
    """Threads of the transforms."""
    planning: str
    """FFTW's planning effort."""
    backend: str
    """The backend of the kernels."""
    reason: Reason | None = None
    """Why the status is not `CONVERGED`, and what would help; None if it is."""
    handed_over: bool = False
    """The method did not settle or could not have its result certified, and another one went on from there."""
    levels: tuple[Level, ...] = field(default_factory=tuple)
    """The coarser grids, from coarse to fine; empty without nested grids."""
    accuracy: float | None = None
    """The relative error asked for, if any (dimensionless)."""
    accuracy_of: str = "contact-area"
    """Of which quantity: one of `QUANTITIES`."""
    choices: tuple[Choice, ...] = field(default_factory=tuple)
    """The choices made for the user, and why."""
    device: str = "cpu"
    """Where the method worked: 'cpu', or the name of the GPU."""

    def __repr__(self) -> str:
        """The results, in a few lines with units, and the scene; arrays are left out."""
        rows = self._rows()
        told = [display.sentence("Solution", rows[:4]), display.sentence("found, +- numerical errors", rows[4:])]
        warned = [f"warning, {warning.kind}: {warning.text}" for warning in self.warnings]
        return "\n".join([*told, *warned, repr(self.scene)]).replace("\n", "\n  ")

    def _repr_html_(self) -> str:
        """The same as a table, for a notebook."""
        warned = [display.Row(f"warning, {warning.kind}", warning.text, "") for warning in self.warnings]
        return display.html_table("Solution", [*self._rows(), *warned, *self.scene.rows()])

    def _rows(self) -> list[display.Row]:
        """The results as they are shown: how it ended and its cost first."""
        found, units = self.observables, self.scene.units
        return [
            display.Row("status", str(self.status), ""),
            display.Row("method", self.method, ""),
            display.Row("transform_pairs", f"{self.transform_pairs:.3g}", "-"),
            display.Row("seconds", f"{self.seconds.get('total', 0.0):.3g}", "s"),
            _measured("contact_area_subgrid", found.contact_area_subgrid, "-", found.contact_area_error),
            display.row("contact_width", self.contact_width, units),
            display.row("num_patches", found.num_patches),
            _measured("peak_pressure", found.peak_pressure, units["pressure"], found.peak_pressure_error),
            _measured("kappa_subgrid", found.kappa_subgrid, "-", found.kappa_error),
            _measured("approach", found.approach, units["length"], found.approach_error),
        ]

    @cached_property
    def warnings(self) -> tuple[SolutionWarning, ...]:
        """Doubts, also if the solve converged: its grid, the smallness of strains, the resolution of a scan."""
        return tuple(find_warnings(self.scene, self.observables, self.patches, self.displacement))

    @property
    def contact_width(self) -> float:
        """Width of the contact, all patches together: a_r between sub-grid edges times the period [length]."""
        return self.observables.contact_area_subgrid * self.scene.period

    @cached_property
    def contact_stiffness(self) -> float:
        """dp/d(approach) [pressure/length], computed on first use; see `linecontact.contact_stiffness`."""
        import linecontact  # the package's front knows the levels above a solution, here and below

        return linecontact.contact_stiffness(self)

    def save(self, path: str | os.PathLike[str], overwrite: bool = False) -> None:
        """Write everything to an HDF5 file, for `linecontact.load`.

        overwrite: whether an existing file may be replaced. Raises `ValueError` for a file that cannot be written.
        """
        import linecontact

        linecontact.save(self, path, overwrite)

    def plot(self, path: str | os.PathLike[str] | None = None, overwrite: bool = False) -> Any:
        """The figure of the solution, as a Matplotlib `Figure`; see `linecontact.plot`.

        path: where to write it, too, for instance as .png or .pdf. overwrite: whether a file may be replaced that is no
        figure of linecontact's. Raises `ValueError` for a file that cannot be written.
        """
        import linecontact

        return linecontact.plot(self, path, overwrite)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the fields that has a meaning, JSON-ready: numbers, text, flat objects; infinite: 'inf'."""
        known = {"contact_stiffness": self.contact_stiffness} if self.status is Status.CONVERGED else {}
        levels = {str(level.pop("num_points")): level for level in map(asdict, self.levels)}
        warnings = {str(warning.kind): warning.text for warning in self.warnings}
        return self.to_record() | dict(checks.plain({**known, "levels": levels, "warnings": warnings}))

    def to_record(self) -> dict[str, Any]:
        """As `to_dict`, but for the coarser grids and the warnings, whose number differs from solution to solution."""
        certified = asdict(self.certificate) if self.certificate else {}
        found = {
            "status": str(self.status),
            **({"reason": str(self.reason)} if self.reason else {}),
            **{name: value for name, value in asdict(self.observables).items() if value is not None},
            "contact_width": self.contact_width,
            "iterations": self.iterations,
            "transform_pairs": round(self.transform_pairs, 3),
            "handed_over": self.handed_over,
            **({"accuracy": self.accuracy, "accuracy_of": self.accuracy_of} if self.accuracy else {}),
            "choices": {c.what: {"chosen": c.chosen, "reason": c.reason, "error": c.error} for c in self.choices},
            "seconds": dict(self.seconds),
            "certificate": {name: value for name, value in certified.items() if value is not None},
            "method": self.method,
            "precision": self.scene.precision,
            **{name: getattr(self, name) for name in ("tolerance", "threads", "planning", "backend")},
            **({"device": self.device} if self.device != "cpu" else {}),
            "scene": self.scene.to_dict(),
            "version": __version__,
            "provenance": provenance(),
        }
        return dict(checks.plain(found))


def _measured(name: str, value: float, unit: str, error: float) -> display.Row:
    told = f" +- {display.rounded_up(error)}" if error < math.inf else ""
    return display.Row(name, display.number(value) + told, unit)
