"""How a choice is measured: seconds and errors over several solves.

Times are medians over up to five solves after one that does not count; errors are the rms over these, which are under
slightly different loads, or of different rough surfaces. A solve of half a second and more is done twice, and both
count; one of three seconds and more is done once.
"""

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from linecontact.solver import METHODS, Solution, Status, provenance, solve

from ..files import records
from ..runner.tasks import Record
from . import families

REFUSED = "refused"
"""Status of a choice that the solver does not take."""

_LONG, _SLOW = 3.0, 0.5  # seconds of a solve that is done once, and twice
_ENOUGH, _FEWEST = 0.2, 3  # seconds of all repeats of others; repeats at least


class Found(NamedTuple):
    """One solve."""

    seconds: dict[str, float]
    """Time by stage [s]."""
    errors: Record
    """Relative errors by measure, see `families.MEASURES`."""
    record: Record
    """The rest of its record."""


def measured(family: str, run: Callable[[int], Found]) -> Record:
    """The record of a choice. run: solves the variant of the family whose number it is given."""
    warm_up()
    first = run(0)
    if first.seconds["total"] > _SLOW:
        found = [first] if first.seconds["total"] > _LONG else [first, run(1)]
    else:
        found = []
        for variant in families.variants(family):
            found.append(run(variant))
            if len(found) >= _FEWEST and sum(f.seconds["total"] for f in found) > _ENOUGH:
                break
    seconds = {f"seconds.{k}": float(np.median([f.seconds[k] for f in found])) for k in first.seconds}
    errors = {f"error.{k}": float(np.sqrt(np.mean([f.errors[k] ** 2 for f in found]))) for k in first.errors}
    record = found[0].record | seconds | errors | {"family": family, "repeats": len(found)}
    points = sorted(f.record["scene.num_points"] for f in found if "scene.num_points" in f.record)
    return record | ({"scene.num_points": points[len(points) // 2]} if points else {})


@functools.cache
def warm_up() -> None:
    """Load kernels, tables and imports, once in a process."""
    for precision in ("float64", "float32"):
        for method in (name for name, kind in METHODS.items() if precision in kind.precisions):
            solve(families.make_scene("Hertz, half-space", 13, precision), method=method, tolerance=0.3)


def of_solution(solution: Solution, exact: families.Exact) -> Found:
    """Times and errors of a solution; `KeyboardInterrupt` for one that was interrupted."""
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    o = solution.observables
    errors = exact.errors(
        o.contact_area, o.contact_area_subgrid, o.kappa_subgrid, o.peak_pressure, solution.contact_pressure
    )
    record = {name: v for name, v in records.run_record(solution).items() if not name.startswith("choices.")}
    return Found(solution.seconds, errors, record | {"error.reference": exact.error})


def refused(family: str, error: ValueError) -> Record:
    """The record of a choice that the solver does not take."""
    return {"family": family, "status": REFUSED, "reason": str(error)} | records.flatten(
        {"provenance": provenance.provenance()}
    )
