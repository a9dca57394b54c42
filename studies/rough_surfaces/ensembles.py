"""The study of rough surfaces to a standard error: an ensemble of its own for every point of Figure 5.

Every point, a layer under a kind of roughness, gets as many surfaces as its kappa and its contact area need, most of
them on coarse grids (see `linecontact.studies.multilevel`). All points take the same surfaces first.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

from linecontact.solver.methods import Progress

from ..files.study_files import StudyFile
from ..multilevel import samples
from ..multilevel.allocation import State, Wanted, grid_sizes, levels, share_done, state, stored_levels
from ..multilevel.estimator import Estimate
from ..multilevel.mean import MOST_SAMPLES, check_wanted
from ..multilevel.samples import Batch, Row
from ..runner.study import Plan
from ..runner.tasks import ROWS, Record
from ..runner.tasks import Task as AnyTask
from .means import Mean, Point
from .tasks import Configuration, Task, lines

FIGURES: Mapping[str, str] = {"": "After Zhou and Yang (2022), Figure 5, every mean to the standard error asked for."}
"""Endings of the figures' names, with captions for a report."""

_OBSERVABLES = ("kappa", "contact-area")
_FINEST = 4
"""Times the published grid's points, the most that a bias may ask for."""

Key = tuple[float, float, float]
"""H, Poisson's ratio and d/L of a point; inf for the half-space."""


@dataclass(frozen=True)
class PointBatch:
    """A batch of surfaces of one point; its record holds a row for each solve."""

    kind: ClassVar[str] = "linecontact.studies.rough_surfaces.ensembles.PointBatch"

    task: Task
    """The point; its seed and tolerance are not used, its grid is the finest that may be."""
    batch: Batch
    """Which surfaces, on which grids."""

    @property
    def key(self) -> Key:
        """Of the point."""
        return self.task.hurst, self.task.poisson_ratio, self.task.thickness

    def run(self, report: Progress | None) -> Record:
        """The rows of all solves."""
        names = ("scene.hurst", "scene.poisson_ratio", "scene.thickness")
        own = dict(zip(names, self.key, strict=True))
        return {ROWS: [own | row for row in samples.rows(self.task.scene(), self.batch, report)]}


def plan(c: Configuration, standard_error: float) -> Plan:
    """The first tasks, and how the others follow from them. Raises `ValueError`.

    standard_error: of kappa and of the contact area at every point, over their means.
    """
    wanted = _wanted(standard_error)
    task = Task(_FINEST * c.num_points, c.cut_off_ratio, c.pressure, 0.5, 0.0, math.inf, 0, c.tolerance, c.method)
    layers = [(0.0, math.inf), *((nu, d) for nu in c.poisson_ratios for d in c.thicknesses)]
    points = [replace(task, hurst=h, poisson_ratio=nu, thickness=d) for h in c.hursts for nu, d in layers]

    def every(records: Mapping[AnyTask, Record]) -> Iterator[tuple[Task, list[Row], State]]:
        """Every point, with its rows and how far it is."""
        rows: dict[Key, list[Row]] = {}
        for done, record in records.items():
            if isinstance(done, PointBatch):
                rows.setdefault(done.key, []).extend(record[ROWS])
        for point in points:
            own = rows.get((point.hurst, point.poisson_ratio, point.thickness), [])
            yield point, own, state(own, levels(point.scene()), wanted, 0)

    def more(records: Mapping[AnyTask, Record]) -> Sequence[AnyTask]:
        return [PointBatch(point, batch) for point, _, now in every(records) for batch in now.batches]

    def outlook(records: Mapping[AnyTask, Record]) -> tuple[float, str]:
        now = [(rows, found) for _, rows, found in every(records)]
        reached = sum(found.done for _, found in now)
        asked = f"to a standard error of {standard_error:g} over the mean"
        return share_done(now), f"{reached} of {len(now)} points {asked}"

    def enough(file: StudyFile) -> bool:
        found = states(file, standard_error)
        return len(found) == len(points) and all(point.done for point in found.values())

    unused = ("realisations", "tolerance", "method")
    configuration: dict[str, Any] = {name: value for name, value in asdict(c).items() if name not in unused}
    configuration |= {"sizes": grid_sizes(task.scene()), "standard_error": standard_error}
    return Plan(
        "rough",
        configuration,
        list(more({})),
        lines(c),
        FIGURES,
        adjustable=("standard_error",),
        enough=enough,
        more=more,
        outlook=outlook,
    )


def _wanted(standard_error: float) -> Wanted:
    return check_wanted(list(_OBSERVABLES), standard_error, True, math.inf, MOST_SAMPLES)


def is_one(file: StudyFile) -> bool:
    """Whether a file of the study is to a standard error."""
    return "standard_error" in file.configuration


def states(file: StudyFile, standard_error: float | None = None) -> dict[Key, State]:
    """How far every point is; standard_error: wanted over the means, by default the file's."""
    asked = file.configuration["standard_error"] if standard_error is None else standard_error
    wanted, grids = _wanted(asked), file.configuration["sizes"]
    rows: dict[Key, list[Row]] = {}
    for run in file.runs:
        key = (run["scene.hurst"], run["scene.poisson_ratio"], run["scene.thickness"])
        rows.setdefault(key, []).append(run)
    return {key: state(own, stored_levels(own, grids), wanted, 0) for key, own in rows.items()}


def points(found: Mapping[Key, State]) -> Iterator[Point]:
    """Every point that is known together with its half-space; numbers that are no mean of an ensemble are NaN."""
    unknown = Mean(math.nan, math.nan)
    for (hurst, nu, thickness), point in found.items():
        reference = kappa_inf(found, hurst)
        if math.isinf(thickness) or reference is None or not point.estimates:
            continue
        kappa, area = (point.estimates[name] for name in _OBSERVABLES)
        errors = [estimate.standard_error / estimate.mean for estimate in (kappa, area, reference)]
        ratio = kappa.mean / reference.mean
        yield Point(
            hurst,
            nu,
            thickness,
            reduced_thickness=Mean(thickness / area.mean, thickness / area.mean * errors[1]),
            per_width=unknown,
            kappa_ratio=Mean(ratio, ratio * math.hypot(errors[0], errors[2])),
            slope=Mean(ratio * area.mean / thickness, ratio * area.mean / thickness * math.hypot(*errors)),
            patches=unknown,
            per_patch=unknown,
            bias=unknown,
        )


def kappa_inf(found: Mapping[Key, State], hurst: float) -> Estimate | None:
    """kappa on the half-space; None as long as it is not known."""
    half_space = found.get((hurst, 0.0, math.inf))
    return half_space.estimates["kappa"] if half_space and half_space.estimates else None
