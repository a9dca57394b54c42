"""What becomes of a cell: certified, refused for a reason that it names, or a defect.

Certified is what converged and stands up to a second look that shares nothing with the solver's first: every number
finite, the certificate made again from the stored displacement alone, load and wall obeyed, the area between sub-grid
edges no worse than counting nodes by more than a grid spacing an edge, and the same iterations in other units.
"""

import math
import re
import time
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
from linecontact.solver import (
    PowerIndenter,
    RoughIndenter,
    Scene,
    Solution,
    Status,
    certify,
    closed_forms,
    collocation,
    solve,
)
from linecontact.solver.problem import Problem, rounding_floor

from ..tasks import Record
from .cells import Cell

CERTIFIED, REFUSED, DEFECT = "certified", "refused", "defect"

_REASON = re.compile(r"\S+ is .+; allowed: .+", re.DOTALL)
_ASKED = ("tolerance", "accuracy")
_OTHER_UNITS = 2.0**-60, 2.0**80  # times those of length and pressure: ratios are the same to the last bit
_MOST_ENERGY = 0.1
_HALF_SPACE_FROM = 10.0  # periods
_LONGEST = 20.0  # half-widths over thicknesses, for collocation in a fraction of a second
_KNOWN = 0.1  # grid spacings to which a reference must know the area
_FINER, _REFERENCE_TO = 4, 4096  # times the points of a rough surface's reference, and up to how many


class DefectError(Exception):
    """Something that must not happen; the message says what."""


def judge(cell: Cell) -> Record:
    """The record of a cell: verdict, why, and what was found. Never raises, whatever the cell does."""
    begin = time.perf_counter()
    record: Record = {"verdict": DEFECT, "why": "", "asked": any(name in cell.options for name in _ASKED)}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            record |= _judge(cell)
    except ValueError as error:
        record["why"] = f"{error}"
        if _REASON.match(str(error)):
            record["verdict"] = REFUSED
    except Exception as error:
        record["why"] = f"{type(error).__name__}: {error}"
    return record | {"seconds.cell": time.perf_counter() - begin}


def _judge(cell: Cell) -> Record:
    scene = cell.in_units(cell.length, cell.stress)
    solution = solve(scene, initial=_initial(cell, scene), **cell.options)
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    record = _numbers(solution)
    if solution.status is not Status.CONVERGED:
        if not _REASON.match(solution.reason):
            raise DefectError(f"{solution.status}, for no reason that names a parameter and what is allowed")
        return record | {"verdict": REFUSED, "why": solution.reason}
    try:
        _look_again(solution)
        record |= _edges(cell, solution)
        _in_other_units(cell, solution)
    except DefectError as defect:
        return record | {"why": str(defect)}
    return record | {"verdict": CERTIFIED}


def _initial(cell: Cell, scene: Scene) -> np.ndarray[Any, Any] | None:
    """A displacement that has nothing to do with the scene."""
    if cell.initial is None:
        return None
    rng = np.random.default_rng(cell.initial)
    return scene.period * 10 ** rng.uniform(-15, 3) * rng.standard_normal(scene.num_points)


def _numbers(solution: Solution) -> Record:
    """What is kept of a solution. Raises `DefectError` for a number that is none."""
    record = solution.to_dict()
    for name, value in _walk(record):
        if value == "nan" or (isinstance(value, float) and math.isnan(value)):
            raise DefectError(f"{name} is not a number")
    for field in (solution.displacement, solution.contact_pressure):
        if not np.isfinite(field).all():
            raise DefectError("a field is not finite")
    names = ("contact_area", "contact_area_subgrid", "contact_area_error", "num_patches", "iterations")
    kept: Record = {name: record[name] for name in (*names, "transform_pairs", "tolerance", "handed_over")}
    kept["outcome"] = record["status"]
    return kept | {f"certificate.{name}": value for name, value in record["certificate"].items()}


def _walk(record: Record, prefix: str = "") -> list[tuple[str, Any]]:
    pairs: list[tuple[str, Any]] = []
    for name, value in record.items():
        pairs += _walk(value, f"{prefix}{name}.") if isinstance(value, dict) else [(prefix + name, value)]
    return pairs


def _look_again(solution: Solution) -> None:
    """Raises `DefectError` unless the fields alone show that the claim is true."""
    scene, u, pressure, o = solution.scene, solution.displacement, solution.contact_pressure, solution.observables
    if not 0 < o.contact_area <= 1 or not 0 < o.contact_area_subgrid <= 1 + 1e-12:
        raise DefectError(f"a_r is {o.contact_area}, between the edges {o.contact_area_subgrid}")
    if (pressure < 0).any() or (pressure[~solution.contact] > 0).any():
        raise DefectError("pressure below 0, or off the contact")
    if (u > scene.profile).any():
        raise DefectError("the displacement is above the wall")
    if not solution.certificate:
        return
    problem = Problem.from_scene(scene)
    u = np.where(solution.contact, problem.height, u / problem.length_unit)
    again, _, _ = certify(problem, u)
    single = scene.precision == "float32"
    allowed = 2 * solution.tolerance + 10 * rounding_floor(problem.stiffness, u, "float32" if single else "float64")
    if not again.free_residual <= allowed:
        raise DefectError(
            f"free residual {again.free_residual:.2g} at the second look, {solution.tolerance:.2g} claimed"
        )
    if not again.energy_error_bound <= _MOST_ENERGY:
        raise DefectError(f"the energy may be off by {again.energy_error_bound:.2g} of itself")
    if not again.force_balance <= allowed * math.sqrt(scene.num_points):
        raise DefectError(f"the load is off by {again.force_balance:.2g}")


def _edges(cell: Cell, solution: Solution) -> Record:
    """Distances of both areas from the true one, per edge [grid spacings], where that is known."""
    o, n = solution.observables, solution.scene.num_points
    known = _true_area(cell, solution) if solution.certificate else None
    if not known or known[1] * n > _KNOWN:
        return {}
    edges = 2 * max(1, o.num_patches)
    subgrid, counted = ((area - known[0]) * n / edges for area in (o.contact_area_subgrid, o.contact_area))
    record = {"off.subgrid": subgrid, "off.counted": counted, "off.claimed": o.contact_area_error * n / edges}
    if abs(subgrid) > abs(counted) + 1 + _KNOWN:
        raise DefectError(f"sub-grid edges are off by {subgrid:.2g} spacings, counted ones by {counted:.2g}")
    return record


def _true_area(cell: Cell, solution: Solution) -> tuple[float, float] | None:
    """a_r and its error from elsewhere: closed forms, collocation, or a finer grid."""
    scene, o = cell.scene, solution.observables
    power, thickness, nu = scene.indenter, scene.layer.thickness, scene.layer.poisson_ratio
    if o.contact_area > 0.97:  # the profile's kink at the period's end is another one on every grid
        return None
    if isinstance(power, PowerIndenter):
        if thickness > _HALF_SPACE_FROM:
            return closed_forms.periodic_half_space_area(power.exponent, power.radius, scene.pressure), 1e-9
        guess = collocation.guessed_half_width(scene.pressure, power.exponent, power.radius, thickness, nu)
        if guess < _LONGEST * thickness and power.exponent >= 1.5:
            try:
                shape = power.exponent, power.radius, thickness, nu
                found, error = collocation.solve_to_accuracy(scene.pressure, *shape, 1e-5)
            except ValueError:
                return None
            return found.contact_area, error * found.contact_area
        return None
    if isinstance(power, RoughIndenter) and scene.num_points <= _REFERENCE_TO and cell.initial is None:
        fine = solve(replace(scene, num_points=_FINER * scene.num_points, precision="float64"))
        if fine.status is Status.CONVERGED:
            return fine.observables.contact_area_subgrid, fine.observables.contact_area_error
    return None


def _in_other_units(cell: Cell, solution: Solution) -> None:
    """Raises `DefectError` if the same scene in other units takes another number of iterations."""
    if cell.initial is not None or cell.scene.num_points > _REFERENCE_TO:
        return
    length, stress = cell.length * _OTHER_UNITS[0], cell.stress * _OTHER_UNITS[1]
    other = solve(cell.in_units(length, stress), **cell.options)
    if other.iterations != solution.iterations:
        raise DefectError(f"{solution.iterations} iterations, in other units {other.iterations}")
