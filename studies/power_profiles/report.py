"""The report of a study of one power profile: its runs beside collocation and the limits of thin layers."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.layers.bonded import edge_shift
from linecontact.solver.reference import closed_forms
from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from ..runner.tasks import Record
from ..terminal import console
from .tasks import RADIUS


def layers(file: StudyFile) -> StudyFile:
    """The runs on layers only."""
    runs = [run for run in file.runs if math.isfinite(run["scene.thickness"])]
    return StudyFile(file.kind, file.configuration, runs, file.lines, file.failures)


def half_space(file: StudyFile) -> Record | None:
    """The run on the half-space."""
    return next((run for run in file.runs if math.isinf(run["scene.thickness"])), None)


def summary(file: StudyFile) -> Table:
    """The closing table: one row per Poisson's ratio, errors against collocation."""
    points, exponent, least = (
        file.configuration[name] for name in ("num_points", "exponent", "thinnest_incompressible")
    )
    table = console.table(
        padding=0,
        title=f"{file.kind} (n = {exponent:g}), {points} points, p = {file.configuration['pressure']:g} E*",
        caption="Errors are against collocation. "
        "ok: runs certified; count, sub-grid: largest |error| of a_r in grid spacings, nodes counted and "
        "between sub-grid edges; peak err: largest |relative error| of the peak pressure; y = "
        "(kappa_d/kappa_inf)/(d/a_r) at the least d/a_r, sub-grid, beside the thin-layer limit to first and second "
        "order; "
        "pairs: transforms in all; s: seconds of solving in all. Row with nu = -: the half-space. All but s "
        "dimensionless."
        + ("" if exponent % 2 == 0 else " Collocation knows the pressure at a sharp tip to 2 % only.")
        + (f" nu = 0.5: only d/a_r of {least:g} and more." if least else ""),
    )
    headings = ("nu", "ok", "count", "sub-\ngrid", "peak\nerr", "y", "y/1st\n- 1", "y/2nd\n- 1")
    for heading in (*headings, "pairs", "s"):
        table.add_column(heading, justify="right", no_wrap=True)
    run = half_space(file)
    if run:
        off = [(run[name] - run["oracle.contact_area"]) * points for name in ("contact_area", "contact_area_subgrid")]
        peak = abs(run["peak_pressure"] / run["oracle.peak_pressure"] - 1)
        numbers = f"{abs(off[0]):.2f}", f"{abs(off[1]):.0e}", f"{peak:.0e}", "", "", ""
        ok = f"{int(run['status'] == 'converged')}/1"
        table.add_row("-", ok, *numbers, f"{run['transform_pairs']:.0f}", f"{run['seconds.total']:.1f}")
    for nu in sorted(set(layers(file).column("scene.poisson_ratio"))):
        part = layers(file).select("scene.poisson_ratio", nu)
        t, ratio = curve(part)
        thin = int(np.argmin(t))
        first, second = (
            closed_forms.thin_layer_kappa_ratio(exponent, nu, t[thin], shift) for shift in (0.0, edge_shift(nu))
        )
        area = np.abs(part.column("contact_area") - part.column("oracle.contact_area")) * points
        subgrid = np.abs(part.column("contact_area_subgrid") - part.column("oracle.contact_area")) * points
        peak = np.abs(part.column("peak_pressure") / part.column("oracle.peak_pressure") - 1)
        table.add_row(
            f"{nu:g}",
            f"{np.sum(part.column('status') == 'converged')}/{len(part.runs)}",
            f"{area.max():.2f}",
            f"{subgrid.max():.0e}",
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
    """A sentence on the effect of images in the neighbouring periods on kappa on the half-space."""
    run, c = half_space(file), file.configuration
    if run is None:
        return ""
    lone = closed_forms.kappa_half_space(c["exponent"])
    area = closed_forms.periodic_half_space_area(c["exponent"], RADIUS, c["pressure"])
    exact = closed_forms.kappa_from_area(c["exponent"], area, RADIUS, c["pressure"])
    return (
        f"Half-space: a_r = {run['contact_area_subgrid']:.8f} (exactly {area:.8f}), kappa/kappa_inf = "
        f"{run['kappa_subgrid'] / lone:.4f} (exactly {exact / lone:.4f}): the difference "
        "from 1 is due to the indenter's images in the neighbouring periods. All dimensionless."
    )


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """For each study a table, and a sentence on the half-space."""
    return [part for file in files.values() for part in (summary(file), images(file))]
