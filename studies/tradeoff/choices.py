"""The choices, each a task: one solve, timed, with its errors (`measuring`)."""

import math
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from linecontact.solver import Solution, Status, solve
from linecontact.solver.grid.cached import forget
from linecontact.solver.methods import Progress

from ..iterations.study import pair_seconds
from ..peers import solvers as peers
from ..runner.tasks import Record
from . import families
from .measuring import Found, measured, of_solution, refused, warm_up

_SAMPLES = 2**12  # of collocation's field
_COARSER = 1e-5  # tolerance on the coarser grid
_ITERATIONS = 100  # over which a single one is timed


@dataclass(frozen=True)
class Choice:
    """A solve with everything chosen by hand."""

    kind: ClassVar[str] = "linecontact.studies.tradeoff.choices.Choice"

    family: str
    """Of scenes, see `families.FAMILIES`."""
    method: str
    """Of the solve."""
    precision: str
    """Of the iteration."""
    tolerance: float | None
    """Rms equilibrium residual over p to stop at (dimensionless); None for the default."""
    log2_points: int
    """log2 of the number of grid points."""
    threads: int
    """Of the transforms."""
    nested: bool
    """Whether to start from the solution on coarser grids."""
    reference: int
    """Points of the reference, see `families.exact`."""

    def run(self, report: Progress | None) -> Record:
        """Errors and times; a tolerance that the precision cannot reach is refused."""

        def run(variant: int) -> Found:
            exact = families.exact(self.family, variant, self.reference)
            scene = families.make_scene(self.family, self.log2_points, self.precision, variant)
            method, nested, tolerance, threads = self.method, self.nested, self.tolerance, self.threads
            forget()
            return of_solution(
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
    """A solve with everything chosen by the solver, for a relative error of the area."""

    kind: ClassVar[str] = "linecontact.studies.tradeoff.choices.Accuracy"

    family: str
    """Of scenes, see `families.FAMILIES`."""
    accuracy: float
    """The relative error asked for (dimensionless)."""
    log2_points: int
    """log2 of the points of the finest grid allowed."""
    reference: int
    """Points of the reference, see `families.exact`."""

    def run(self, report: Progress | None) -> Record:
        """Errors and times, with the time of a transform pair at 2^18 taken beside them."""

        def run(variant: int) -> Found:
            exact = families.exact(self.family, variant, self.reference)
            scene = families.make_scene(self.family, self.log2_points, variant=variant)
            forget()
            found = of_solution(solve(scene, accuracy=self.accuracy, progress=report), exact)
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
class Collocation:
    """A smooth scene by collocation at a given number of nodes; the field is sampled, outside of the time."""

    kind: ClassVar[str] = "linecontact.studies.tradeoff.choices.Oracle"

    family: str
    """Of scenes, see `families.FAMILIES`."""
    num_nodes: int
    """Of the collocation."""

    def run(self, _: Progress | None) -> Record:
        """Errors and times."""

        def run(variant: int) -> Found:
            begin = time.perf_counter()
            found = families.asperity(self.family, variant, self.num_nodes, 0.0)
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

    kind: ClassVar[str] = "linecontact.studies.tradeoff.choices.Peer"

    family: str
    """Of scenes, see `families.FAMILIES`."""
    peer: str
    """Its name."""
    log2_points: int
    """log2 of the number of grid points."""
    tolerance: float
    """The peer's own (dimensionless)."""
    reference: int
    """Points of the reference, see `families.exact`."""

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
    """The precisions in turn, on one scene."""

    kind: ClassVar[str] = "linecontact.studies.tradeoff.choices.Precisions"

    family: str
    """Of scenes, see `families.FAMILIES`."""
    method: str
    """Of the solves."""
    log2_points: int
    """log2 of the number of grid points."""
    tolerance: float | None
    """None: an iteration is timed. Else a solve to this tolerance, and the solves before it on coarser grids, which are
    always in float64."""
    rounds: int = 5
    """How often they take turns."""

    def run(self, report: Progress | None) -> Record:
        """Seconds and transform pairs by precision, medians over the rounds, and whether all were certified."""
        warm_up()
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
        """Solve in one of the precisions, or on the coarser grids alone."""
        coarser, limited = name == "coarser", self.tolerance is None
        size, precision = self.log2_points - 2 * coarser, "float64" if coarser else name
        forget()
        solution = solve(
            families.make_scene(self.family, size, precision),
            method=self.method,
            nested=not limited,
            tolerance=_COARSER if coarser else self.tolerance,
            max_iterations=_ITERATIONS if limited else None,
            progress=report,
        )
        if solution.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        return solution
