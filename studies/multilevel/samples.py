"""Results of single random surfaces: values of the observables by grid and seed, and their times."""

import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from linecontact.solver import Scene, Status, provenance, solve
from linecontact.solver.methods import Progress
from linecontact.solver.units import unit

from ..files.records import warnings
from . import foundation

OBSERVABLES = {
    "kappa": "kappa_subgrid",
    "contact-area": "contact_area_subgrid",
    "peak-pressure": "peak_pressure",
    "approach": "approach",
    "mean-gap": "mean_gap",
}
"""The quantities that a mean can be taken of, with the names of the solution's observables."""

TOLERANCE = 1e-5
"""Equilibrium residual over p of the solves (dimensionless); it leaves kappa an error of 1e-5, below the scatter."""

FOUNDATION = 0
"""In place of the points of a grid: the surface is on a Winkler foundation, see `foundation`."""

_ROUNDING = 1e-9  # relative differences between foundations that say nothing
_WAVE_POINTS = 4  # of the coarsest grid to the shortest wave
_FEWEST = 2**8  # points of the coarsest grid

Row = Mapping[str, Any]
"""One solve of one surface on one grid."""


@dataclass(frozen=True)
class Batch:
    """Surfaces to be solved, each on the same grids."""

    first: int
    """Their first seed."""
    count: int
    """How many, with consecutive seeds."""
    sizes: tuple[int, ...]
    """Points of the grids, or `FOUNDATION`."""


def unit_of(observable: str) -> str:
    """The unit of an observable, in words."""
    known = unit(OBSERVABLES[observable])
    return "dimensionless" if known == "1" else known


def name_of(size: int) -> str:
    """The grid of so many points, or the foundation, in a word."""
    return str(size) if size != FOUNDATION else "foundation"


def on_grids(rows: Iterable[Row]) -> list[Row]:
    """The rows of solves, without those on a foundation."""
    return [row for row in rows if row["num_points"] != FOUNDATION]


def on_finest(rows: Iterable[Row]) -> list[Row]:
    """The rows of solves on the finest grid that any is on."""
    known = on_grids(rows)
    finest = max((row["num_points"] for row in known), default=0)
    return [row for row in known if row["num_points"] == finest]


def fewest_points(scene: Scene) -> int:
    """Points that a grid has to have to hold the surface."""
    return max(_FEWEST, _WAVE_POINTS * scene.indenter.shortest_wave(scene.num_points))


def rows(scene: Scene, batch: Batch, report: Progress | None = None) -> Iterator[dict[str, Any]]:
    """Solve a batch: a row for each surface and grid. scene: with a random indenter, on any grid."""
    for seed in range(batch.first, batch.first + batch.count):
        surface = replace(scene, indenter=replace(scene.indenter, seed=seed))  # type: ignore[type-var]
        for size in batch.sizes:
            if size == FOUNDATION:
                yield _on_foundation(surface, seed)
                continue
            solution = solve(replace(surface, num_points=size), tolerance=TOLERANCE, progress=report)
            if solution.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            found = solution.to_record()
            kept = {name: found[name] for name in (*OBSERVABLES.values(), "contact_area_error", "num_patches")}
            yield {
                "status": found["status"],
                "seed": seed,
                "num_points": size,
                "seconds.total": solution.seconds["total"],
                **kept,
                "warnings": warnings(solution),
                "version": found["version"],
                "commit": found["provenance"]["commit"],
            }


def _on_foundation(scene: Scene, seed: int) -> dict[str, Any]:
    begin = time.perf_counter()
    found = foundation.press(scene, fewest_points(scene))
    seconds, source = time.perf_counter() - begin, provenance.provenance()
    about = {"status": Status.CONVERGED.value, "seed": seed, "num_points": FOUNDATION, "seconds.total": seconds}
    return about | found | {"version": source["version"], "commit": source["commit"]}


class Samples:
    """Values of one observable by grid and seed, of the surfaces whose solves converged.

    Those on a foundation are multiplied by the slope of the straight line that tells the others from them best (a
    control variate: B. L. Nelson, Operations Research 38, 974 (1990)).
    """

    def __init__(self, rows: Iterable[Row], observable: str) -> None:
        self.observable = observable
        self.values: dict[int, dict[int, float]] = defaultdict(dict)
        """By the number of grid points, and by seed."""
        self._seconds: dict[int, list[float]] = defaultdict(list)
        for row in rows:
            if row["status"] == "converged":
                size = int(row["num_points"])
                self.values[size][int(row["seed"])] = float(row[OBSERVABLES[observable]])
                self._seconds[size].append(float(row["seconds.total"]))
        if FOUNDATION in self.values:
            slope = self._slope()
            self.values[FOUNDATION] = {seed: slope * value for seed, value in self.values[FOUNDATION].items()}

    def _slope(self) -> float:
        """By least squares, on the grid on which most surfaces are solved that are on the foundation, too; 1 if there
        is none, 0 if nothing scatters.
        """
        grids = [size for size in sorted(self.values) if size != FOUNDATION]
        shared = {size: self.seeds(FOUNDATION, size) for size in grids}
        size = max(grids, key=lambda size: (len(shared[size]), size), default=FOUNDATION)
        if size == FOUNDATION or len(shared[size]) < 2:
            return 1.0
        on, solved = (np.array([self.values[which][seed] for seed in shared[size]]) for which in (FOUNDATION, size))
        if float(np.ptp(on)) <= _ROUNDING * float(np.abs(on).max()):  # all in contact, for instance
            return 0.0
        return float(np.mean((on - on.mean()) * solved) / np.var(on))

    def seconds(self, size: int) -> float:
        """Time of a solve on a grid of that many points, median [s]: the first one of a process takes longer."""
        return float(np.median(self._seconds[size]))

    def seeds(self, *sizes: int) -> list[int]:
        """Surfaces that are solved on all these grids."""
        return sorted(set.intersection(*(set(self.values[size]) for size in sizes)))
