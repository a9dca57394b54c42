"""One power profile on layers of any thickness: the published study's Figures 2 (Hertz), 3 (sharp) and 4 (blunt).

kappa_d/kappa_inf over d/a_r for p = 2e-3 E*, R = L = E* = 1. The thicknesses are those at which the collocation oracle
finds the wanted d/a_r, and the oracle's area and peak pressure are stored beside each run's.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from linecontact.solver import Layer, PowerIndenter, Scene, closed_forms, collocation, solve
from linecontact.solver.relaxation import Progress
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.table import Table

from ..files import records
from ..files.study_files import StudyFile
from ..runner import ensemble
from ..runner.tasks import Record
from ..terminal import console

Array64 = NDArray[np.float64]

RADIUS = 1.0


@dataclass(frozen=True)
class Configuration:
    """What identifies a study.

    exponent: n; published_alpha: the published study's thin-layer factor (dimensionless).
    reduced_thicknesses: the wanted d/(a_r L), from thick to thin (dimensionless); the half-space is always there.
    thinnest_incompressible: the least of them for nu = 1/2.
    """

    exponent: float
    published_alpha: float
    num_points: int = 2**18
    pressure: float = 2e-3
    poisson_ratios: tuple[float, ...] = (0.0, 0.25, 0.4, 0.45, 0.49, 0.5)
    reduced_thicknesses: tuple[float, ...] = tuple(round(float(t), 6) for t in np.geomspace(4, 0.008, 13))
    thinnest_incompressible: float = 0.0
    tolerance: float = 1e-8
    method: str = "active-set"
    line_points: int = 30


@dataclass(frozen=True)
class Task:
    """One run: a Poisson's ratio and a reduced thickness, inf for the half-space."""

    exponent: float
    num_points: int
    pressure: float
    poisson_ratio: float
    reduced_thickness: float
    tolerance: float
    method: str

    def run(self, report: Progress | None) -> Record:
        """The solution's record with the oracle's numbers beside it."""
        thickness, exact = _oracle(self.pressure, self.exponent, self.reduced_thickness, self.poisson_ratio)
        layer, indenter = Layer(thickness, self.poisson_ratio), PowerIndenter(self.exponent, RADIUS)
        scene = Scene(layer, indenter, self.pressure, num_points=self.num_points)
        solution = solve(scene, method=self.method, tolerance=self.tolerance, progress=report)
        return records.run_record(solution) | {
            "oracle.contact_area": exact.contact_area,
            "oracle.peak_pressure": exact.peak_pressure,
            "oracle.approach": exact.approach,
            "oracle.kappa_ratio": exact.kappa_ratio,
        }


@dataclass(frozen=True)
class OracleLine:
    """The oracle's kappa_d/kappa_inf over d/a_r, as a line."""

    exponent: float
    pressure: float
    poisson_ratio: float
    reduced_thicknesses: tuple[float, ...]

    def run(self, _: Progress | None) -> Record:
        """Columns of the line."""
        ratios = [
            _oracle(self.pressure, self.exponent, t, self.poisson_ratio)[1].kappa_ratio
            for t in self.reduced_thicknesses
        ]
        return {"reduced_thickness": list(self.reduced_thicknesses), "kappa_ratio": ratios}


def _oracle(
    pressure: float, exponent: float, reduced_thickness: float, poisson_ratio: float
) -> tuple[float, collocation.Asperity]:
    # an odd power's kink takes more nodes: 640 know the area to 3e-4 spacings of 2^18, but the pressure at the tip,
    # which rises like the root of the distance, to 2 % only
    nodes = 160 if exponent % 2 == 0 else 640
    if math.isinf(reduced_thickness):
        return math.inf, collocation.solve_load(pressure, exponent, RADIUS, math.inf, poisson_ratio, nodes)
    return collocation.solve_reduced_thickness(pressure, exponent, RADIUS, reduced_thickness, poisson_ratio, nodes)


def study(kind: str, c: Configuration) -> ensemble.Study:
    """The tasks of one study."""
    line = tuple(np.geomspace(c.reduced_thicknesses[0] * 1.3, c.reduced_thicknesses[-1] / 1.3, c.line_points).tolist())
    every = [(nu, t) for nu in c.poisson_ratios for t in c.reduced_thicknesses]
    wanted = [(0.0, math.inf), *((nu, t) for nu, t in every if nu < 0.5 or t >= c.thinnest_incompressible)]
    return ensemble.Study(
        kind=kind,
        configuration=asdict(c),
        runs=[Task(c.exponent, c.num_points, c.pressure, *which, c.tolerance, c.method) for which in wanted],
        lines={f"nu={nu:g}": OracleLine(c.exponent, c.pressure, nu, line) for nu in c.poisson_ratios},
        figures=("", "-accuracy"),
    )


def layers(file: StudyFile) -> StudyFile:
    """The runs on layers only."""
    runs = [run for run in file.runs if math.isfinite(run["scene.thickness"])]
    return StudyFile(file.kind, file.configuration, runs, file.lines, file.failures)


def half_space(file: StudyFile) -> Record | None:
    """The run on the half-space."""
    return next((run for run in file.runs if math.isinf(run["scene.thickness"])), None)


def summary(file: StudyFile) -> Table:
    """The closing table: one row per Poisson's ratio, errors against the oracle."""
    points, exponent, least = (
        file.configuration[name] for name in ("num_points", "exponent", "thinnest_incompressible")
    )
    table = console.table(
        title=f"{file.kind} (n = {exponent:g}), {points} points, p = {file.configuration['pressure']:g} E*, "
        "against the oracle",
        caption="ok: runs certified; count, sub-grid: largest |error| of a_r in grid spacings, nodes counted and "
        "between sub-grid edges; peak err: largest |relative error| of the peak pressure; y = "
        "(kappa_d/kappa_inf)/(d/a_r) at the least d/a_r, sub-grid, beside the thin-layer limit to first and second "
        "order; "
        "pairs: transforms in all; s: seconds of solving in all. Row with nu = -: the half-space. All but s "
        "dimensionless."
        + ("" if exponent % 2 == 0 else " The oracle knows the pressure at a sharp tip to 2 % only.")
        + (f" nu = 0.5: only d/a_r of {least:g} and more." if least else ""),
    )
    headings = ("nu", "ok", "count", "sub-\ngrid", "peak\nerr", "y", "y/1st\n- 1", "y/2nd\n- 1")
    for heading in (*headings, "pairs", "s"):
        table.add_column(heading, justify="right", no_wrap=True)
    run = half_space(file)
    if run:
        off = [(run[name] - run["oracle.contact_area"]) * points for name in ("contact_area", "contact_area_subgrid")]
        peak = abs(run["peak_pressure"] / run["oracle.peak_pressure"] - 1)
        numbers = f"{abs(off[0]):.2f}", f"{abs(off[1]):.1g}", f"{peak:.0e}", "", "", ""
        ok = f"{int(run['status'] == 'converged')}/1"
        table.add_row("-", ok, *numbers, f"{run['transform_pairs']:.0f}", f"{run['seconds.total']:.1f}")
    for nu in sorted(set(layers(file).column("scene.poisson_ratio"))):
        part = layers(file).select("scene.poisson_ratio", nu)
        t, ratio = curve(part)
        thin = int(np.argmin(t))
        first, second = (
            closed_forms.thin_layer_kappa_ratio(exponent, nu, t[thin], shift)
            for shift in (0.0, closed_forms.edge_shift(nu))
        )
        area = np.abs(part.column("contact_area") - part.column("oracle.contact_area")) * points
        subgrid = np.abs(part.column("contact_area_subgrid") - part.column("oracle.contact_area")) * points
        peak = np.abs(part.column("peak_pressure") / part.column("oracle.peak_pressure") - 1)
        table.add_row(
            f"{nu:g}",
            f"{np.sum(part.column('status') == 'converged')}/{len(part.runs)}",
            f"{area.max():.2f}",
            f"{subgrid.max():.1g}",
            f"{peak.max():.0e}",
            f"{ratio[thin] / t[thin]:.4g}",
            f"{ratio[thin] / first - 1:+.0e}",
            f"{ratio[thin] / second - 1:+.0e}",
            str(int(part.column("transform_pairs").sum())),
            f"{part.column('seconds.total').sum():.1f}",
        )
    return table


def curve(file: StudyFile) -> tuple[Array64, Array64]:
    """d/a_r and kappa_d/kappa_inf of the runs, between sub-grid edges, shape (runs,) each."""
    thickness, area = file.column("scene.thickness"), file.column("contact_area_subgrid")
    kappa = file.column("kappa_subgrid") / closed_forms.kappa_half_space(file.configuration["exponent"])
    return thickness / area, np.asarray(kappa, dtype=np.float64)


def images(file: StudyFile) -> str:
    """What the images in the neighbouring periods do to the half-space's value."""
    run, c = half_space(file), file.configuration
    if run is None:
        return ""
    lone = closed_forms.kappa_half_space(c["exponent"])
    area = closed_forms.periodic_half_space_area(c["exponent"], RADIUS, c["pressure"])
    exact = closed_forms.kappa_from_area(c["exponent"], area, RADIUS, c["pressure"])
    return (
        f"Half-space: a_r = {run['contact_area_subgrid']:.8f} (exactly {area:.8f}), kappa/kappa_inf = "
        f"{run['kappa_subgrid'] / lone:.4f} (exactly {exact / lone:.4f}): what it is "
        "below 1 is due to the indenter's images in the neighbouring periods. All dimensionless."
    )


def closing(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """Table and a sentence on the half-space, for each study."""
    return [part for file in files.values() for part in (summary(file), images(file))]


@dataclass(frozen=True)
class Options(ensemble.Options):
    """What the three studies can be asked for."""

    quick: bool = False
    """2^14 points and fewer thicknesses, in seconds."""


def command(kind: str, configuration: Configuration, options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    folder = Path(f"results/{kind}-quick" if options.quick else f"results/{kind}")
    return ensemble.command(
        [study(kind, quick(configuration) if options.quick else configuration)], options, folder, closing
    )


def quick(c: Configuration, num_points: int = 2**14) -> Configuration:
    """The same study in seconds."""
    return replace(c, num_points=num_points, reduced_thicknesses=c.reduced_thicknesses[:12:2], line_points=14)
