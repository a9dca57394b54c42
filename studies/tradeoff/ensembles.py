"""Means over random surfaces: the standard error over the seconds of solving, on one grid and on several."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from linecontact.solver import Layer, RoughIndenter, Scene
from linecontact.solver.methods import Progress

from ..multilevel import samples
from ..multilevel.allocation import levels, state
from ..multilevel.estimator import bias, term
from ..multilevel.mean import check_wanted
from ..multilevel.samples import FOUNDATION, Row, Samples
from ..runner.tasks import ROWS, Record
from .measuring import warm_up

ENSEMBLES = {
    "H = 0.8, half-space": (0.8, float("inf")),
    "H = 0.8, d = 0.001 L": (0.8, 1e-3),
    "H = 0.3, half-space": (0.3, float("inf")),
}
"""Hurst exponent and thickness over the period of the published study's surfaces, by name."""

OBSERVABLE = "kappa"
MANY, ALONE = "ensemble", "one grid"
"""Kinds of rows: how far the ensemble was after each round, and the cost and the use of one surface on a grid."""


@dataclass(frozen=True)
class Ensemble:
    """The mean of kappa over random surfaces, to a standard error."""

    kind: ClassVar[str] = "linecontact.studies.tradeoff.ensembles.Ensemble"

    family: str
    """One of `ENSEMBLES`."""
    cut_off_ratio: float
    """lambda_s/lambda_r (dimensionless)."""
    log2_points: int
    """log2 of the points of the finest grid that may be used."""
    standard_error: float
    """Wanted, over the mean (dimensionless)."""

    def scene(self) -> Scene:
        """The scene of every surface."""
        hurst, thickness = ENSEMBLES[self.family]
        indenter = RoughIndenter(hurst, 0, 1 / 8, self.cut_off_ratio)
        return Scene(Layer(thickness), indenter, 0.01, num_points=2**self.log2_points)

    def run(self, report: Progress | None) -> Record:
        """A row for each round, and one for each grid."""
        warm_up()
        return {ROWS: [{"family": self.family, "status": "converged"} | row for row in self._rows(report)]}

    def _rows(self, report: Progress | None) -> Iterator[dict[str, Any]]:
        scene, wanted = self.scene(), check_wanted([OBSERVABLE], self.standard_error, True, 1e6, 10**6)
        sizes, rows, began = levels(scene), list[Row](), time.perf_counter()
        while (now := state(rows, sizes, wanted, 0)).batches:
            rows += [row for batch in now.batches for row in samples.rows(scene, batch, report)]
            found = state(rows, sizes, wanted, 0).estimates.get(OBSERVABLE)
            if found:
                yield {
                    "kind": MANY,
                    "seconds.total": sum(float(row["seconds.total"]) for row in rows),
                    "seconds.elapsed": time.perf_counter() - began,
                    "mean": found.mean,
                    "standard_error": found.standard_error,
                    "bias": found.bias,
                    "scene.num_points": found.terms[-1].num_points,
                }
        known = Samples(rows, OBSERVABLE)
        grids = sorted(known.values.keys() - {FOUNDATION})
        for number, size in enumerate(grids, start=1):
            own = term(known, size, None)
            yield {
                "kind": ALONE,
                "scene.num_points": size,
                "seconds.total": own.seconds,
                "std": own.variance**0.5,
                "bias": bias(known, grids[:number]),
                "surfaces": own.count,
            }
