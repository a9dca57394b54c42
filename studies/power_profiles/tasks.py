"""The tasks of a study of one power profile: solves on layers, and collocation's line beside them."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import ClassVar

import numpy as np
from linecontact.solver import Layer, PowerIndenter, Scene, solve
from linecontact.solver.methods import DEFAULT, Progress
from linecontact.solver.reference import collocation

from ..files.records import run_record
from ..runner.study import Plan
from ..runner.tasks import Record

RADIUS = 1.0
"""R in units of the period."""

FIGURES: Mapping[str, str] = {
    "": "After Zhou and Yang (2022), Figures 2 to 4. Symbols: this study, between sub-grid edges; solid lines: "
    "collocation, which uses no grid.",
    "-accuracy": "Errors against collocation.",
}
"""Endings of the figures' names, with captions for a report."""


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies a study; lengths in units of the period, pressures of E*."""

    exponent: float
    """n of the profile h = (R/n) |x/R|^n."""
    published_alpha: float
    """The published study's factor for thin layers (dimensionless)."""
    num_points: int = 2**18
    """Grid points of every solve."""
    pressure: float = 2e-3
    """Mean pressure p/E* (dimensionless)."""
    poisson_ratios: tuple[float, ...] = (0.0, 0.25, 0.4, 0.45, 0.49, 0.5)
    """Of the layers (dimensionless)."""
    reduced_thicknesses: tuple[float, ...] = tuple(round(float(t), 6) for t in np.geomspace(4, 0.008, 13))
    """The wanted d/(a_r L), from thick to thin (dimensionless); the half-space is always there, too."""
    thinnest_incompressible: float = 0.0
    """The least of them for nu = 1/2 (dimensionless)."""
    tolerance: float = 1e-8
    """Of the solves: rms equilibrium residual over p (dimensionless)."""
    method: str = DEFAULT.name
    """Of the solves."""
    line_points: int = 30
    """Points of each of the lines found by collocation."""


@dataclass(frozen=True)
class Task:
    """One solve, with collocation's numbers beside it."""

    kind: ClassVar[str] = "linecontact.studies.asperity.Task"

    exponent: float
    """n of the profile."""
    num_points: int
    """Grid points."""
    pressure: float
    """Mean pressure p/E* (dimensionless)."""
    poisson_ratio: float
    """Of the layer (dimensionless)."""
    reduced_thickness: float
    """The wanted d/(a_r L); inf for the half-space."""
    tolerance: float
    """Rms equilibrium residual over p to stop at (dimensionless)."""
    method: str
    """Of the solve."""

    def run(self, report: Progress | None) -> Record:
        """The solution's record with collocation's numbers beside it."""
        thickness, exact = _collocation(self.pressure, self.exponent, self.reduced_thickness, self.poisson_ratio)
        layer, indenter = Layer(thickness, self.poisson_ratio), PowerIndenter(self.exponent, RADIUS)
        scene = Scene(layer, indenter, self.pressure, num_points=self.num_points)
        solution = solve(scene, method=self.method, tolerance=self.tolerance, progress=report)
        return run_record(solution) | {
            "oracle.contact_area": exact.contact_area,
            "oracle.peak_pressure": exact.peak_pressure,
            "oracle.approach": exact.approach,
            "oracle.kappa_ratio": exact.kappa_ratio,
        }


@dataclass(frozen=True)
class CollocationLine:
    """Collocation's kappa_d/kappa_inf over d/a_r, as a line."""

    kind: ClassVar[str] = "linecontact.studies.asperity.OracleLine"

    exponent: float
    """n of the profile."""
    pressure: float
    """Mean pressure p/E* (dimensionless)."""
    poisson_ratio: float
    """Of the layers (dimensionless)."""
    reduced_thicknesses: tuple[float, ...]
    """d/(a_r L) of the points of the line."""

    def run(self, _: Progress | None) -> Record:
        """Columns of the line."""
        ratios = [
            _collocation(self.pressure, self.exponent, t, self.poisson_ratio)[1].kappa_ratio
            for t in self.reduced_thicknesses
        ]
        return {"reduced_thickness": list(self.reduced_thicknesses), "kappa_ratio": ratios}


def _collocation(
    pressure: float, exponent: float, reduced_thickness: float, poisson_ratio: float
) -> tuple[float, collocation.Asperity]:
    # an odd power's kink takes more nodes: 640 know the area to 3e-4 spacings of 2^18, but the pressure at the tip,
    # which rises like the root of the distance, to 2 % only
    nodes = 160 if exponent % 2 == 0 else 640
    if math.isinf(reduced_thickness):
        return math.inf, collocation.solve_layer(Layer(math.inf, poisson_ratio), pressure, exponent, RADIUS, nodes)
    return collocation.solve_reduced_thickness(pressure, exponent, RADIUS, reduced_thickness, poisson_ratio, nodes)


def plan(kind: str, c: Configuration) -> Plan:
    """The tasks of one study."""
    thick, thin = c.reduced_thicknesses[0] * 1.3, c.reduced_thicknesses[-1] / 1.3
    line = tuple(float(f"{t:.12g}") for t in np.geomspace(thick, thin, c.line_points))  # last digits differ by machine
    every = [(nu, t) for nu in c.poisson_ratios for t in c.reduced_thicknesses]
    wanted = [(0.0, math.inf), *((nu, t) for nu, t in every if nu < 0.5 or t >= c.thinnest_incompressible)]
    return Plan(
        kind=kind,
        configuration=asdict(c),
        runs=[Task(c.exponent, c.num_points, c.pressure, *which, c.tolerance, c.method) for which in wanted],
        lines={f"nu={nu:g}": CollocationLine(c.exponent, c.pressure, nu, line) for nu in c.poisson_ratios},
        figures=FIGURES,
    )


def quick(c: Configuration, num_points: int = 2**14) -> Configuration:
    """The same study in seconds."""
    return replace(c, num_points=num_points, reduced_thicknesses=c.reduced_thicknesses[:12:2], line_points=14)
