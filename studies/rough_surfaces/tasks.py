"""The tasks of the study of rough surfaces: solves on layers, and Persson's prediction beside them.

The same surfaces (common seeds) are taken for every Hurst exponent H, Poisson's ratio and thickness, so that kappa_d is
compared with kappa_inf of the same surface. Every solve starts cold, on nested grids: measured, that takes 0.4 to 1.1
of the time of a start from the solution for a neighbouring thickness, and leaves the tasks independent.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import ClassVar

import numpy as np
from linecontact.solver import Layer, RoughIndenter, Scene, solve
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods import DEFAULT, Progress
from linecontact.solver.reference import closed_forms

from ..files.records import run_record
from ..runner.study import Plan
from ..runner.tasks import Record

FIGURES: Mapping[str, str] = {
    "": "After Zhou and Yang (2022), Figure 5. Means over the realisations, with standard errors.",
    "-patches": "Above: the slope over the number of patches; one parabolic patch has 2 sqrt(3). Below: that number.",
    "-area": "What counting nodes adds to the area.",
}
"""Endings of the figures' names, with captions for a report."""


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the study; lengths in units of the period, pressures of E*."""

    num_points: int = 2**18
    """Grid points of every solve."""
    cut_off_ratio: float = 1 / 512
    """lambda_s/lambda_r (dimensionless); 512/N keeps 64 grid points to the shortest wave, with lambda_r = L/8."""
    pressure: float = 0.01
    """Mean pressure p/E* (dimensionless)."""
    hursts: tuple[float, ...] = (0.3, 0.5, 0.8)
    """Hurst exponents H (dimensionless)."""
    poisson_ratios: tuple[float, ...] = (0.0, 0.25, 0.45, 0.49)
    """Of the layers (dimensionless)."""
    thicknesses: tuple[float, ...] = tuple(float(f"{d:.4g}") for d in np.geomspace(0.1, 1e-7, 13))
    """d/L of the layers, from thick to thin (dimensionless); the half-space is always there, too."""
    realisations: int = 32
    """Surfaces for every point."""
    tolerance: float = 1e-8
    """Of the solves: rms equilibrium residual over p (dimensionless)."""
    method: str = DEFAULT.name
    """Of the solves."""


QUICK = Configuration(
    num_points=2**14, cut_off_ratio=1 / 32, realisations=8, thicknesses=Configuration.thicknesses[:11]
)


@dataclass(frozen=True)
class Task:
    """One solve of one rough surface on one layer."""

    kind: ClassVar[str] = "linecontact.studies.rough.Task"

    num_points: int
    """Grid points."""
    cut_off_ratio: float
    """lambda_s/lambda_r (dimensionless)."""
    pressure: float
    """Mean pressure p/E* (dimensionless)."""
    hurst: float
    """Hurst exponent H."""
    poisson_ratio: float
    """Of the layer (dimensionless)."""
    thickness: float
    """d/L; inf for the half-space."""
    seed: int
    """Of the surface."""
    tolerance: float
    """Rms equilibrium residual over p to stop at (dimensionless)."""
    method: str
    """Of the solve."""

    def scene(self) -> Scene:
        """The scene to solve."""
        indenter = RoughIndenter(self.hurst, self.seed, cut_off_ratio=self.cut_off_ratio)
        return Scene(Layer(self.thickness, self.poisson_ratio), indenter, self.pressure, num_points=self.num_points)

    def run(self, report: Progress | None) -> Record:
        """The solution's record."""
        return run_record(solve(self.scene(), method=self.method, tolerance=self.tolerance, progress=report))


@dataclass(frozen=True)
class PerssonLine:
    """Persson's prediction over the thickness, for the spectrum and the rms gradient of the whole surface."""

    kind: ClassVar[str] = "linecontact.studies.rough.PerssonLine"

    task: Task
    """A task of the ensemble, for everything but the thickness."""
    thicknesses: tuple[float, ...]
    """d/L of the points of the line."""

    def run(self, _: Progress | None) -> Record:
        """Columns of the line; kappa for the rms gradient 1 of the whole surface."""
        areas = [self._area(d) for d in (*self.thicknesses, math.inf)]
        kappa = [area / self.task.pressure for area in areas]
        return {
            "reduced_thickness": [d / area for d, area in zip(self.thicknesses, areas, strict=False)],
            "kappa_ratio": [k / kappa[-1] for k in kappa[:-1]],
        }

    def _area(self, thickness: float) -> float:
        problem = Problem.from_scene(replace(self.task, thickness=thickness).scene())
        stiffness, height = problem.stiffness * problem.layer.unit, problem.height * problem.length_unit
        return closed_forms.persson_area(self.task.pressure, closed_forms.full_contact_rms_pressure(stiffness, height))


def plan(c: Configuration) -> Plan:
    """The tasks: the half-space once for every surface, every layer for every Poisson's ratio."""

    def task(hurst: float, nu: float, thickness: float, seed: int) -> Task:
        return Task(c.num_points, c.cut_off_ratio, c.pressure, hurst, nu, thickness, seed, c.tolerance, c.method)

    layers = [(0.0, math.inf), *((nu, d) for nu in c.poisson_ratios for d in c.thicknesses)]
    return Plan(
        kind="rough",
        configuration=asdict(c),
        runs=[task(h, *layer, seed) for h in c.hursts for layer in layers for seed in range(c.realisations)],
        lines=lines(c),
        figures=FIGURES,
    )


def lines(c: Configuration) -> dict[str, PerssonLine]:
    """Persson's prediction for every H and Poisson's ratio."""
    thick, thin = c.thicknesses[0] * 2, c.thicknesses[-1]
    line = tuple(float(f"{d:.12g}") for d in np.geomspace(thick, thin, 40))  # last digits differ by machine
    task = Task(c.num_points, c.cut_off_ratio, c.pressure, 0.0, 0.0, math.inf, 0, c.tolerance, c.method)
    return {
        f"persson H={h:g} nu={nu:g}": PerssonLine(replace(task, hurst=h, poisson_ratio=nu), line)
        for h in c.hursts
        for nu in c.poisson_ratios
    }
