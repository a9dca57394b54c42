"""The tables of `linecontact solve`: the results, with units, and the choices made for the user."""

import math
from collections.abc import Iterator
from typing import Any

from linecontact.solver import METHODS, Solution, Status
from linecontact.solver.display import rounded_up
from linecontact.solver.reference.closed_forms import kappa_half_space
from linecontact.solver.units import shown

from ..scans.preparation import mirrored
from ..terminal.tables import Whole

Row = tuple[str, Any, str]
"""A quantity, its value and its unit."""


def solution_table(solution: Solution) -> Whole:
    """The results of a solve, with units."""
    record = solution.to_dict()
    handed = f", handed over to {METHODS[solution.method].fallback}" if solution.handed_over else ""
    area, error = solution.observables.contact_area_subgrid, solution.observables.contact_area_error
    relative = f" (relative {rounded_up(error / area)})" if area and math.isfinite(error) else ""
    how = "converged on its grid" if solution.status is Status.CONVERGED and solution.certificate else solution.status
    known = f"+- {rounded_up(error)} numerical error{relative}" if math.isfinite(error) else "(error not known)"
    title = f"{solution.method}{handed}, {record['precision']}: {how},\na_r = {area:.6g} {known}"
    table = Whole(title=title)
    table.add_column("quantity")
    table.add_column("value", justify="right", no_wrap=True)
    table.add_column("unit")
    names = solution.scene.units
    for rows in (_contact(solution), _of_nodes(solution), _movement(solution, record), _effort(record)):
        for name, value, unit in rows:
            told = f"{value:.7g}" if isinstance(value, float) else str(value)
            table.add_row(name, told, shown(unit, names))
        table.add_section()
    return table


def _contact(solution: Solution) -> Iterator[Row]:
    """The contact between its sub-grid edges."""
    scene, found = solution.scene, solution.observables
    area, kappa = found.contact_area_subgrid, found.kappa_subgrid
    alone = solution.certificate and not solution.levels and math.isfinite(found.contact_area_error)
    own = " (edges only)" if alone else ""
    width, gaps, power = solution.contact_width, found.unseen_gap_area, scene.indenter.power_law
    yield "contact area a_r", f"{area:.10g}", "-"
    yield f"  its numerical error, estimated{own}", _error(found.contact_area_error), "-"
    if gaps:
        yield "  gaps and patches that no node shows", rounded_up(gaps), "-"
    yield "contact width a_r L", width, "length"
    yield f"contact patches{', mirror image too' * mirrored(scene.to_dict())}", found.num_patches, "-"
    if found.num_unresolved_patches:
        yield "  with ends not known, nodes counted", found.num_unresolved_patches, "-"
    yield "mean pressure p", scene.pressure, "pressure"
    yield "contact modulus E*", scene.layer.contact_modulus, "pressure"
    yield "rms gradient in contact g_c", found.rms_gradient_subgrid, "-"
    yield "reduced pressure p* = p/(E* g_c)", area / kappa if kappa else math.inf, "-"
    yield "kappa = a_r/p*", kappa, "-"
    yield "  its numerical error, estimated", _error(found.kappa_error), "-"
    if power:
        yield "kappa over kappa_inf of the half-space", kappa / kappa_half_space(power[0]), "-"
    yield "thickness over width d/(a_r L)", scene.layer.thickness / width if width else math.inf, "-"


def _of_nodes(solution: Solution) -> Iterator[Row]:
    """The contact by counting nodes, as the published study has it."""
    if solution.certificate:
        yield "by counting nodes: a_r", f"{solution.observables.contact_area:.8g}", "-"
        yield "  one node more or less", f"{1 / solution.scene.num_points:.1e}", "-"
        yield "by counting nodes: kappa", solution.observables.kappa, "-"


def _movement(solution: Solution, record: dict[str, Any]) -> Iterator[Row]:
    """Approach, gap, stiffness and the largest pressure."""
    found = solution.observables
    unknown = "" if "contact_stiffness" in record else " (needs a result as asked)"
    stiffness = record.get("contact_stiffness", "not computed")
    yield "approach", found.approach, "length"
    yield "  its numerical error, estimated", _error(found.approach_error), "length"
    yield "mean gap", found.mean_gap, "length"
    yield f"contact stiffness dp/d(approach){unknown}", stiffness, "pressure/length"
    yield "peak pressure", found.peak_pressure, "pressure"
    yield "  its numerical error, estimated", _error(found.peak_pressure_error), "pressure"


def _effort(record: dict[str, Any]) -> Iterator[Row]:
    """Iterations, times and the certificate."""
    yield "iterations", record["iterations"], "-"
    yield "transform pairs", record["transform_pairs"], "-"
    for stage, seconds in record["seconds"].items():
        yield f"time: {stage}", f"{seconds:.3f}", "s"
    for name, value in record["certificate"].items():
        yield f"certificate: {name.replace('_', ' ')}", value, "-"


def _error(value: float) -> str:
    """An estimated error, in words where there is none."""
    return rounded_up(value) if math.isfinite(value) else "not known"


def choices_table(solution: Solution) -> Whole:
    """The choices made for the user."""
    of = "the " * (solution.accuracy_of != "kappa") + solution.accuracy_of.replace("-", " ")
    own = "; that of the pressure is its own" * any(choice.what == "pressure" for choice in solution.choices)
    table = Whole(
        title="chosen" + (f" for an accuracy of {solution.accuracy:g} of {of}" if solution.accuracy else ""),
        caption=f"error: estimate of the relative error that it brings into {of}{own} (dimensionless)",
    )
    for heading in ("what", "chosen", "error", "because"):
        table.add_column(heading, no_wrap=heading == "error")
    for choice in solution.choices:
        error = rounded_up(choice.error) if choice.error else ""
        chosen = f"{choice.chosen} [{solution.scene.units['pressure']}]" if choice.what == "pressure" else choice.chosen
        table.add_row(choice.what, chosen, error, choice.reason)
    return table
