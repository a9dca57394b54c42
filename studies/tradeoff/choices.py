"""What can be chosen, each a task: one solve, timed, with its errors.

Times are medians over up to five solves after one that does not count; errors are the rms over these, which are under
slightly different loads, or of different rough surfaces. A solve of half a second and more is done twice, and both
count; one of three seconds and more is done once.
"""

import functools
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from linecontact.solver import Solution, Status, provenance, solve
from linecontact.solver.relaxation import Progress
from linecontact.solver.run import COARSE_TOLERANCE

from ..files import records
from ..iterations.study import pair_seconds
from ..peers import solvers as peers
from ..runner.tasks import Record
from . import families

REFUSED = "refused"

_LONG, _SLOW = 3.0, 0.5  # seconds of a solve that is done once, and twice
_ENOUGH, _FEWEST = 0.2, 3  # seconds of all repeats of others; repeats at least
_SAMPLES = 2**12  # of the oracle's field
_ITERATIONS = 100  # over which a single one is timed


class Found(NamedTuple):
    """One solve: seconds by stage, errors by measure, and the rest of its record."""

    seconds: dict[str, float]
    errors: Record
    record: Record


def measured(family: str, run: Callable[[int], Found]) -> Record:
    """The record of a choice; run: solves one of the family's variants."""
    _warm_up()
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
def _warm_up() -> None:
    """Kernels, tables and imports, once in a process."""
    for precision in ("float64", "float32"):
        for method in ("active-set", "mass-weighted-fire", "fire"):
            solve(families.make_scene("Hertz, half-space", 13, precision), method=method, tolerance=0.3)


def _of_solution(solution: Solution, exact: families.Exact) -> Found:
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


@dataclass(frozen=True)
class Choice:
    """A solve with everything chosen by hand. tolerance: None for the default; reference: see `families.exact`."""

    kind: ClassVar[str] = "choice of the trade-off"

    family: str
    method: str
    precision: str
    tolerance: float | None
    log2_points: int
    threads: int
    nested: bool
    reference: int

    def run(self, report: Progress | None) -> Record:
        """Errors and times; a tolerance that the precision cannot reach is refused."""

        def run(variant: int) -> Found:
            exact = families.exact(self.family, variant, self.reference)
            scene = families.make_scene(self.family, self.log2_points, self.precision, variant)
            method, nested, tolerance, threads = self.method, self.nested, self.tolerance, self.threads
            return _of_solution(
                solve(scene, method=method, nested=nested, tolerance=tolerance, threads=threads, progress=report),
                exact,
            )

        asked = {
            "kind": "choice",
            "method": self.method,
            "precision": self.precision,
            "tolerance.asked": "default" if self.tolerance is None else f"{self.tolerance:g}",
            "log2_points": self.log2_points,
            "threads": self.threads,
            "nested": self.nested,
        }
        try:
            return measured(self.family, run) | asked
        except ValueError as error:
            if self.precision != "float32":
                raise
            return refused(self.family, error) | asked


@dataclass(frozen=True)
class Accuracy:
    """Everything chosen by the solver for a relative error of the area; log2_points: of the finest grid allowed."""

    kind: ClassVar[str] = "accuracy of the trade-off"

    family: str
    accuracy: float
    log2_points: int
    reference: int

    def run(self, report: Progress | None) -> Record:
        """Errors and times, with the time of a transform pair at 2^18 taken beside them."""

        def run(variant: int) -> Found:
            exact = families.exact(self.family, variant, self.reference)
            scene = families.make_scene(self.family, self.log2_points, variant=variant)
            found = _of_solution(solve(scene, accuracy=self.accuracy, progress=report), exact)
            if found.record["method"] == "collocation":
                found.errors["area_counted"] = math.nan  # nothing is counted
            return found

        asked = {"kind": "accuracy", "accuracy": self.accuracy}
        try:
            record = measured(self.family, run)
        except ValueError as error:
            return refused(self.family, error) | asked
        points = int(record["scene.num_points"])
        return record | asked | {"log2_points": points.bit_length() - 1, "seconds.pair": pair_seconds(2**18)}


@dataclass(frozen=True)
class Oracle:
    """A smooth scene by collocation at a given number of nodes; the field is sampled, outside of the time."""

    kind: ClassVar[str] = "oracle of the trade-off"

    family: str
    num_nodes: int

    def run(self, _: Progress | None) -> Record:
        """Errors and times."""

        def run(variant: int) -> Found:
            begin = time.perf_counter()
            found = families.oracle(self.family, variant, self.num_nodes, 0.0)
            seconds = time.perf_counter() - begin
            field = families.sample(found, _SAMPLES)
            areas = math.nan, found.contact_area
            errors = families.exact(self.family, variant, 0).errors(*areas, found.kappa, found.peak_pressure, field)
            record = {"status": str(Status.CONVERGED), "contact_area_subgrid": found.contact_area}
            return Found({"total": seconds}, errors, record)

        asked = {"kind": "oracle", "method": "collocation", "num_nodes": self.num_nodes}
        try:
            return measured(self.family, run) | asked
        except ValueError as error:  # the edge layers are not resolved
            return refused(self.family, error) | asked


@dataclass(frozen=True)
class Peer:
    """Another code on the same grid, at a tolerance of its own."""

    kind: ClassVar[str] = "peer of the trade-off"

    family: str
    peer: str
    log2_points: int
    tolerance: float
    reference: int

    def run(self, report: Progress | None) -> Record:
        """Errors and times; contact areas are counted, its set-up is part of the total time."""

        def run(variant: int) -> Found:
            exact = families.exact(self.family, variant, self.reference)
            scene = families.make_scene(self.family, self.log2_points, variant=variant)
            found = peers.solve(self.peer, scene, self.tolerance, report)
            pressure = found.contact_pressure
            counted = np.count_nonzero(pressure > 0) / pressure.size
            errors = exact.errors(counted, math.nan, math.nan, float(pressure.max()), pressure)
            seconds = {"solve": found.seconds, "total": found.seconds + found.setup_seconds}
            record = {"status": str(Status.CONVERGED), "contact_area": counted, "iterations": found.iterations}
            return Found(seconds, errors, record | {"version": found.version})

        asked = {"kind": "peer", "method": self.peer, "log2_points": self.log2_points, "threads": 1}
        return measured(self.family, run) | asked | {"tolerance": self.tolerance}


@dataclass(frozen=True)
class Precisions:
    """The precisions in turn, on one scene. tolerance: None for the time of an iteration, else that of a solve, and of
    what comes before it on coarser grids, always in float64.
    """

    kind: ClassVar[str] = "precisions of the trade-off"

    family: str
    method: str
    log2_points: int
    tolerance: float | None
    rounds: int = 5

    def run(self, report: Progress | None) -> Record:
        """Seconds and transform pairs by precision, medians over the rounds, and whether all were certified."""
        _warm_up()
        limited = self.tolerance is None
        names = ("float64", "mixed", "float32") if limited else ("float64", "mixed", "coarser")
        seconds: dict[str, list[float]] = {name: [] for name in names}
        pairs: dict[str, float] = {}
        certified = True
        for _ in range(self.rounds):
            for name in names:
                solution = self._solve(name, report)
                certified &= limited or solution.status is Status.CONVERGED
                pairs[name] = solution.transform_pairs
                seconds[name].append(solution.seconds["solve"] / (solution.iterations if limited else 1))
        found = {f"seconds.{name}": float(np.median(values)) for name, values in seconds.items()}
        found |= {f"pairs.{name}": value for name, value in pairs.items()}
        return found | {
            "kind": "precisions",
            "family": self.family,
            "status": str(Status.CONVERGED if certified else Status.STAGNATED),
            "method": self.method,
            "log2_points": self.log2_points,
            "tolerance.asked": "iteration" if limited else f"{self.tolerance:g}",
        }

    def _solve(self, name: str, report: Progress | None) -> Solution:
        """One of them."""
        coarser, limited = name == "coarser", self.tolerance is None
        size, precision = self.log2_points - 2 * coarser, "float64" if coarser else name
        solution = solve(
            families.make_scene(self.family, size, precision),
            method=self.method,
            nested=not limited,
            tolerance=COARSE_TOLERANCE if coarser else self.tolerance,
            max_iterations=_ITERATIONS if limited else None,
            progress=report,
        )
        if solution.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        return solution
