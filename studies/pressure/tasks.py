"""The tasks of the study pressure: solves over the load, and Persson's theory beside the rough ones.

The same surfaces (common seeds) are taken for every Hurst exponent, layer and load. At large loads a solve takes
longer, and on the half-space the surfaces differ less: so fewer of them are taken.
"""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from itertools import product
from typing import ClassVar

import numpy as np
from linecontact.solver import Layer, PowerIndenter, Scene, solve
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods import DEFAULT, Progress
from linecontact.solver.reference import closed_forms

from ..files.records import run_record
from ..power_profiles.tasks import RADIUS
from ..rough_surfaces.tasks import Task as RoughTask
from ..runner.study import Plan
from ..runner.tasks import Record

FIGURES = {
    "": "kappa of rough surfaces over the load; means over the surfaces with standard errors.",
    "-collapse": "The same over the half-space's, over the thickness.",
    "-profiles": "kappa of power profiles over the load, as a share of the lone asperity's on the half-space.",
}
"""Endings of the figures' names, with captions."""


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the study; lengths in units of the period, pressures of E*."""

    num_points: int = 2**18
    """Grid points of every solve."""
    cut_off_ratio: float = 1 / 512
    """lambda_s/lambda_r of the rough surfaces (dimensionless)."""
    hursts: tuple[float, ...] = (0.3, 0.5, 0.8)
    """Hurst exponents H (dimensionless)."""
    exponents: tuple[float, ...] = (1.5, 2.0, 4.0)
    """n of the power profiles (dimensionless)."""
    poisson_ratios: tuple[float, ...] = (0.0, 0.25, 0.45)
    """Of the layers (dimensionless)."""
    thicknesses: tuple[float, ...] = (0.1, 1e-2, 1e-3, 1e-4, 1e-5)
    """d/L of the layers, from thick to thin (dimensionless); the half-space is always there, too."""
    pressures: tuple[float, ...] = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 1.3, 1.6)
    """Mean pressures p/E* on rough surfaces (dimensionless)."""
    realisations: tuple[int, ...] = (32, 32, 32, 32, 16, 8, 4, 4, 4, 4)
    """Surfaces at each of these."""
    half_space_areas: tuple[float, ...] = (0.003, 0.01, 0.03, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 0.99)
    """The loads of power profiles, by the a_r that they make on the half-space (dimensionless)."""
    tolerance: float = 1e-8
    """Of the solves: rms equilibrium residual over p (dimensionless)."""


CONFIGURATION = Configuration()
QUICK = replace(
    CONFIGURATION,
    num_points=2**14,
    cut_off_ratio=1 / 32,
    poisson_ratios=(0.25,),
    thicknesses=(0.1, 1e-2, 1e-3),
    realisations=(8, 8, 8, 8, 8, 4, 2, 2, 2, 2),
)


@dataclass(frozen=True)
class ProfileTask:
    """One solve of one power profile on one layer."""

    kind: ClassVar[str] = "linecontact.studies.pressure.ProfileTask"

    num_points: int
    """Grid points."""
    exponent: float
    """n of the profile h = (R/n) |x/R|^n, R = L."""
    half_space_area: float
    """a_r that the load makes on the half-space (dimensionless)."""
    poisson_ratio: float
    """Of the layer (dimensionless)."""
    thickness: float
    """d/L; inf for the half-space."""
    tolerance: float
    """Rms equilibrium residual over p to stop at (dimensionless)."""

    @property
    def pressure(self) -> float:
        """p/E* (dimensionless), by the closed form of the periodic half-space."""
        return closed_forms.periodic_line_load(self.half_space_area / 2, lambda x: (x / RADIUS) ** (self.exponent - 1))

    def run(self, report: Progress | None) -> Record:
        """The solution's record, with the area on the half-space."""
        layer, indenter = Layer(self.thickness, self.poisson_ratio), PowerIndenter(self.exponent, RADIUS)
        scene = Scene(layer, indenter, self.pressure, num_points=self.num_points)
        solution = solve(scene, tolerance=self.tolerance, progress=report)
        return run_record(solution) | {"half_space_area": self.half_space_area}


@dataclass(frozen=True)
class PerssonLine:
    """Persson's theory over the load, for the spectrum of the surfaces of one Hurst exponent on one layer."""

    kind: ClassVar[str] = "linecontact.studies.pressure.PerssonLine"

    task: RoughTask
    """A task of the ensemble, for everything but the load."""
    pressures: tuple[float, ...]
    """p/E* of the points of the line (dimensionless)."""

    def run(self, _: Progress | None) -> Record:
        """Columns of the line."""
        problem = Problem.from_scene(self.task.scene())
        stiffness, height = problem.stiffness * problem.layer.unit, problem.height * problem.length_unit
        rms = closed_forms.full_contact_rms_pressure(stiffness, height)
        areas = [closed_forms.persson_area(p, rms) for p in self.pressures]
        return {"pressure": list(self.pressures), "contact_area": areas}


def line_name(hurst: float, poisson_ratio: float, thickness: float) -> str:
    """Name of Persson's line for a Hurst exponent and a layer."""
    return f"persson H={hurst:g} nu={poisson_ratio:g} d={thickness:g}"


def layers(c: Configuration) -> list[tuple[float, float]]:
    """(nu, d/L) of the half-space and of every layer."""
    return [(0.0, math.inf), *product(c.poisson_ratios, c.thicknesses)]


def plan(c: Configuration) -> Plan:
    """The tasks."""

    def rough(hurst: float, layer: tuple[float, float], pressure: float, seed: int) -> RoughTask:
        return RoughTask(c.num_points, c.cut_off_ratio, pressure, hurst, *layer, seed, c.tolerance, DEFAULT.name)

    def runs() -> Iterator[RoughTask | ProfileTask]:
        for n, (nu, d), area in product(c.exponents, layers(c), c.half_space_areas):
            yield ProfileTask(c.num_points, n, area, nu, d, c.tolerance)
        # the loads of a surface one after the other: it is made once
        for hurst, layer, seed in product(c.hursts, layers(c), range(max(c.realisations))):
            for pressure, count in zip(c.pressures, c.realisations, strict=True):
                if seed < count:
                    yield rough(hurst, layer, pressure, seed)

    smooth = (float(f"{p:.6g}") for p in np.geomspace(c.pressures[0], c.pressures[-1], 60))
    line = tuple(sorted({*smooth, *c.pressures}))  # exact where the surfaces are
    return Plan(
        kind="pressure",
        configuration=asdict(c),
        runs=list(runs()),
        lines={
            line_name(h, *layer): PerssonLine(rough(h, layer, c.pressures[0], 0), line)
            for h, layer in product(c.hursts, layers(c))
        },
        figures=FIGURES,
    )
