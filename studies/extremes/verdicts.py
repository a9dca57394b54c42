"""The verdict on a cell: certified, refused for a reason that it names, or a defect.

Certified is a converged solution that passes a second look: the certificate made again from the stored displacement
alone, in the user's units, which must give the stored pressure, contact and load; the area, and its estimated error,
beside a closed form, collocation, or a finer grid where one of these knows it (power profiles and roughness in partial
contact, to a tenth of a grid spacing); and up to `_REFERENCE_TO` points the same to the last bit in other
units. Only numbers that the documentation names may be infinite.
"""

import math
import re
import time
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
from linecontact.solver import Scene, Solution, Status, certify, solve
from linecontact.solver.grid.problem import Problem, rounding_floor
from linecontact.solver.reference import closed_forms, collocation

from ..files import records
from ..runner.tasks import Record
from .cells import Cell

CERTIFIED, REFUSED, DEFECT = "certified", "refused", "defect"
GRID_FREE = ("collocation", "winkler-foundation")
"""Methods whose fields are sampled, or which solve another model: their areas are judged, not their residuals."""

_REASON = re.compile(r"\S+ is .+; allowed: .+", re.DOTALL)
_ASKED = ("tolerance", "accuracy")
_ERRORS = {"kappa_error", "kappa_edges_error", "peak_pressure_error", "peak_pressure_sampling", "approach_error"}
_INFINITE = _ERRORS | {"thickness", "reduced_thickness", "reduced_pressure", "contact_stiffness"}
_COARSE = 0.1  # tolerance from which the area may be anything (`inf`)
_OTHER_UNITS = 2.0**-60, 2.0**80  # times those of length and pressure: ratios are the same to the last bit
_MOST_ENERGY = 0.1  # of the bound over the elastic energy, where no tolerance was asked for
_MOST_PASSED = 5.0  # times that the estimated error may be passed
_HALF_SPACE_FROM = 10.0  # periods
_LONGEST = 20.0  # half-widths over thicknesses, for collocation in a fraction of a second
_KNOWN = 0.1  # grid spacings to which a reference must know the area
_FINER, _REFERENCE_TO = 4, 4096  # times the points of a reference on a grid, and up to how many
_FIELD_POINTS = 2**15  # of such a reference for collocation


class DefectError(Exception):
    """Something that must not happen; the message names it."""


def judge(cell: Cell) -> Record:
    """The record of a cell: verdict, reason, and results. Nothing but Ctrl-C is raised, whatever the cell does."""
    begin = time.perf_counter()
    record: Record = {"verdict": DEFECT, "why": "", "asked": any(name in cell.options for name in _ASKED)}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            _judge(cell, record)
    except Exception as error:
        kind = "" if isinstance(error, DefectError) else f"{type(error).__name__}: "
        record |= {"verdict": DEFECT, "why": f"{kind}{error}"}
    return record | {"seconds.cell": time.perf_counter() - begin}


def _judge(cell: Cell, record: Record) -> None:
    """Fill the record of a cell. Raises `DefectError`, or whatever the cell makes the solver raise."""
    scene = cell.in_units(cell.length, cell.stress)
    try:
        solution = solve(scene, initial=_initial(cell, scene), **cell.options)
    except ValueError as error:
        _refused(record, str(error))
        return
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    record |= _numbers(solution)
    if solution.status is not Status.CONVERGED:
        _refused(record, str(solution.reason))
        return
    _look_again(solution, bool(record["asked"]))
    _look_at_area(cell, solution, record)
    _in_other_units(cell, solution)
    record["verdict"] = CERTIFIED


def _refused(record: Record, reason: str) -> None:
    record["why"] = reason
    if not _REASON.match(reason):
        raise DefectError(f"refused for a reason that does not name a parameter and its allowed values: {reason}")
    record["verdict"] = REFUSED


def _initial(cell: Cell, scene: Scene) -> np.ndarray[Any, Any] | None:
    """A displacement that has nothing to do with the scene."""
    if cell.initial is None:
        return None
    rng = np.random.default_rng(cell.initial)
    return scene.period * 10 ** rng.uniform(-15, 3) * rng.standard_normal(scene.num_points)


def _numbers(solution: Solution) -> Record:
    """The stored numbers of a solution. Raises `DefectError` for NaN, or infinity where none may be."""
    record = solution.to_dict()
    infinite = _INFINITE | ({"contact_area_error"} if solution.tolerance > _COARSE else set())
    for name, value in _walk(record):
        number = float(value) if isinstance(value, (float, str)) and not records.is_text(value) else 0.0
        converged = solution.status is Status.CONVERGED  # else there may be no contact
        if math.isnan(number) or (math.isinf(number) and converged and name.rpartition(".")[2] not in infinite):
            raise DefectError(f"{name} is {value}")
    for field in (solution.displacement, solution.contact_pressure):
        if not np.isfinite(field).all():
            raise DefectError("a field is not finite")
    names = ("contact_area", "contact_area_subgrid", "contact_area_error", "num_patches", "iterations")
    kept: Record = {name: record[name] for name in (*names, "transform_pairs", "tolerance", "handed_over")}
    kept["outcome"] = record["status"]
    told = record["certificate"].keys() & {"equilibrium_residual", "energy_error_bound"}  # collocation has none
    return kept | {f"certificate.{name}": record["certificate"][name] for name in sorted(told)}


def _walk(record: Record, prefix: str = "") -> list[tuple[str, Any]]:
    pairs: list[tuple[str, Any]] = []
    for name, value in record.items():
        pairs += _walk(value, f"{prefix}{name}.") if isinstance(value, dict) else [(prefix + name, value)]
    return pairs


def _look_again(solution: Solution, asked: bool) -> None:
    """Raise `DefectError` unless the fields alone show that the solution is as good as it says."""
    scene, u, pressure, o = solution.scene, solution.displacement, solution.contact_pressure, solution.observables
    if not 0 < o.contact_area <= 1 or not 0 < o.contact_area_subgrid <= 1 + 1e-12:
        raise DefectError(f"a_r is {o.contact_area}, between the edges {o.contact_area_subgrid}")
    if ((pressure > 0) != solution.contact).any() or (pressure < 0).any():
        raise DefectError("pressure below 0 or off the contact, or none on it")
    if (u > scene.profile).any():
        raise DefectError("the displacement is above the wall")
    problem = Problem.from_scene(scene)
    u = np.where(solution.contact, problem.height, u / problem.length_unit)
    rounding = 10 * rounding_floor(problem.stiffness, u, "float64")
    load = abs(float(pressure.mean()) / scene.pressure - 1)
    if not load <= 1e-9 + rounding + solution.tolerance:
        raise DefectError(f"the load is off by {load:.2g}")
    if solution.method in GRID_FREE:
        return
    again, force, _ = certify(problem, u)
    if not again.equilibrium_residual <= 2 * solution.tolerance + rounding:
        said = f"the solution says {solution.tolerance:.2g}"
        raise DefectError(f"equilibrium residual {again.equilibrium_residual:.2g} at the second look, {said}")
    if not asked and not again.energy_error_bound <= 1.01 * _MOST_ENERGY:  # units round
        raise DefectError(f"the energy may be off by {again.energy_error_bound:.2g} of itself")
    off = float(np.sqrt(np.mean((pressure / scene.pressure - force) ** 2)))
    if not off <= 1e-9 + rounding:
        raise DefectError(f"the pressure is off by {off:.2g}")
    if (o.contact_area, o.peak_pressure) != (float(solution.contact.mean()), float(pressure.max())):
        raise DefectError("a_r or the peak pressure are not those of the fields")


def _look_at_area(cell: Cell, solution: Solution, record: Record) -> None:
    """Add the distances of both areas from the true one, per edge [grid spacings], where that is known.

    Raises `DefectError` if the sub-grid area is worse than counting by more than a spacing an edge, or its error far
    beyond the estimated one.
    """
    o, n = solution.observables, solution.scene.num_points
    known = _true_area(cell, solution)
    if not known or known[1] * n > _KNOWN:
        return
    edges = 2 * max(1, o.num_patches)
    off, counted = abs(o.contact_area_subgrid - known[0]), abs(o.contact_area - known[0])
    estimated = o.contact_area_error
    distances = {"subgrid": off, "counted": counted, "claimed": estimated, "known": known[1]}
    record |= {f"off.{name}": value * n / edges for name, value in distances.items()}
    if solution.method not in GRID_FREE and (off - counted - known[1]) * n / edges > 1:
        raise DefectError(f"sub-grid edges are off by {off * n:.2g} spacings in all, counted ones by {counted * n:.2g}")
    if off > _MOST_PASSED * estimated + known[1]:
        raise DefectError(f"a_r is off by {off:.2g}, estimated error {estimated:.2g}, one grid spacing is {1 / n:.2g}")


def _true_area(cell: Cell, solution: Solution) -> tuple[float, float] | None:
    """a_r and its error from elsewhere: closed forms, collocation, or a finer grid."""
    scene, o = cell.scene, solution.observables
    if o.contact_area > 0.97:  # the profile's kink at the period's end is another one on every grid
        return None
    if scene.indenter.power_law and scene.layer.bonded:
        return _true_area_of_a_power(scene, solution.method)
    known_between = scene.indenter.given_points is None  # the same surface on a finer grid
    if known_between and scene.num_points <= _REFERENCE_TO and cell.initial is None:
        return _on_a_grid(scene, _FINER * scene.num_points)
    return None


def _true_area_of_a_power(scene: Scene, method: str) -> tuple[float, float] | None:
    """The same for a power profile on a bonded layer."""
    assert scene.indenter.power_law is not None
    assert scene.layer.bonded is not None
    (exponent, radius), thickness = scene.indenter.power_law, scene.layer.thickness
    if thickness > _HALF_SPACE_FROM:
        return closed_forms.periodic_half_space_area(exponent, radius, scene.pressure), 1e-9
    if method in GRID_FREE:
        return _on_a_grid(scene, _FIELD_POINTS)
    shape = scene.pressure, exponent, radius
    if exponent < 1.5 or closed_forms.guessed_half_width(*shape, scene.layer) >= _LONGEST * thickness:
        return None
    try:
        found, errors = collocation.solve_to_accuracy(scene.layer, *shape, 1e-5)
    except ValueError:
        return None
    return found.contact_area, errors["contact_area"] * found.contact_area


def _on_a_grid(scene: Scene, num_points: int) -> tuple[float, float] | None:
    fine = solve(replace(scene, num_points=num_points, precision="float64"))
    o = fine.observables
    return (o.contact_area_subgrid, _MOST_PASSED * o.contact_area_error) if fine.status is Status.CONVERGED else None


def _in_other_units(cell: Cell, solution: Solution) -> None:
    """Raise `DefectError` unless the same scene in other units takes the same iterations to the same numbers."""
    if cell.initial is not None or cell.scene.num_points > _REFERENCE_TO:
        return
    length, stress = _OTHER_UNITS
    other = solve(cell.in_units(cell.length * length, cell.stress * stress), **cell.options)
    if other.iterations != solution.iterations:
        raise DefectError(f"{solution.iterations} iterations, in other units {other.iterations}")
    same = np.array_equal(other.displacement / length, solution.displacement)
    if not same or not np.array_equal(other.contact_pressure / stress, solution.contact_pressure):
        raise DefectError("in other units the fields are others")
