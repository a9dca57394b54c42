"""What is known of single random surfaces: values of the observables by grid and seed, and what they took."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from linecontact.solver import Scene, Status, solve
from linecontact.solver.methods import Progress
from linecontact.solver.units import unit

OBSERVABLES = {
    "kappa": "kappa_subgrid",
    "contact-area": "contact_area_subgrid",
    "peak-pressure": "peak_pressure",
    "approach": "approach",
    "mean-gap": "mean_gap",
}
"""What a mean can be taken of, with the names of the solution's observables."""

TOLERANCE = 1e-5
"""Rms free residual over p of the solves (dimensionless); it leaves kappa an error of 1e-5, far below the scatter."""

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
    """Points of the grids."""


def unit_of(observable: str) -> str:
    """The unit of an observable, in words."""
    known = unit(OBSERVABLES[observable])
    return "dimensionless" if known == "1" else known


def rows(scene: Scene, batch: Batch, report: Progress | None = None) -> Iterator[dict[str, Any]]:
    """Solve a batch: a row for each surface and grid. scene: with a random indenter, on any grid."""
    for seed in range(batch.first, batch.first + batch.count):
        for size in batch.sizes:
            indenter = replace(scene.indenter, seed=seed)  # type: ignore[type-var]
            solution = solve(replace(scene, indenter=indenter, num_points=size), tolerance=TOLERANCE, progress=report)
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
                "version": found["version"],
                "commit": found["provenance"]["commit"],
            }


class Samples:
    """Values of one observable by grid and seed, of the surfaces whose solves converged."""

    def __init__(self, rows: Iterable[Row], observable: str) -> None:
        self.values: dict[int, dict[int, float]] = defaultdict(dict)
        """By the number of grid points, and by seed."""
        self._seconds: dict[int, list[float]] = defaultdict(list)
        for row in rows:
            if row["status"] == "converged":
                size = int(row["num_points"])
                self.values[size][int(row["seed"])] = float(row[OBSERVABLES[observable]])
                self._seconds[size].append(float(row["seconds.total"]))

    def seconds(self, size: int) -> float:
        """Time of a solve on a grid of that many points, median [s]: the first one of a process takes longer."""
        return float(np.median(self._seconds[size]))

    def seeds(self, *sizes: int) -> list[int]:
        """Surfaces that are solved on all these grids."""
        return sorted(set.intersection(*(set(self.values[size]) for size in sizes)))
