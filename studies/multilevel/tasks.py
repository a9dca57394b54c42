"""The tasks of an ensemble: batches of surfaces, planned from the results of the ones before."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from linecontact.solver import Scene
from linecontact.solver.display import rounded_up
from linecontact.solver.methods import Progress

from ..files.study_files import StudyFile
from ..runner.study import Plan
from ..runner.tasks import ROWS, Record, Task
from ..scenes.described import base_scene, shown
from . import samples
from .allocation import State, Wanted, grid_sizes, levels, share_done, state, stored_levels
from .samples import Batch, Row

KIND = "ensemble"


@dataclass(frozen=True)
class BatchTask:
    """A batch of surfaces; its record holds a row for each solve."""

    kind: ClassVar[str] = "linecontact.studies.multilevel.BatchTask"

    scene: str
    """The scene of every surface, see `scenes.described`."""
    batch: Batch
    """Which surfaces, on which grids."""

    def run(self, report: Progress | None) -> Record:
        """The rows of all solves."""
        return {ROWS: list(samples.rows(base_scene(self.scene), self.batch, report))}


def plan(description: str, scene: Scene, wanted: Wanted) -> Plan:
    """The first tasks, and how the others follow from them."""
    grids, sizes, seed = grid_sizes(scene), levels(scene), scene.indenter.seed  # type: ignore[attr-defined]

    def rows(records: Mapping[Task, Record]) -> list[Row]:
        return [row for record in records.values() for row in record[ROWS]]

    def more(records: Mapping[Task, Record]) -> Sequence[Task]:
        return [BatchTask(description, batch) for batch in state(rows(records), sizes, wanted, seed).batches]

    def outlook(records: Mapping[Task, Record]) -> tuple[float, str]:
        known = rows(records)
        now = state(known, sizes, wanted, seed)
        means = (
            f"{name} {found.mean:.5g} +- {rounded_up(found.standard_error)} [{samples.unit_of(name)}], "
            f"{wanted.error(found):.2g} wanted"
            for name, found in now.estimates.items()
        )
        return share_done([(known, now)]), ", ".join(means) or "first surfaces"

    def enough(file: StudyFile) -> bool:
        has = set(wanted.observables) <= set(file.configuration["observables"])
        return has and state(file.runs, stored_levels(file.runs, grids), wanted, seed).done

    configuration: dict[str, Any] = {
        "scene": shown(description),
        "numbers": {name: value for name, value in scene.to_dict().items() if name not in ("seed", "num_points")},
        "sizes": grids,
        "seed": seed,
        "observables": wanted.observables,
        "standard_error": wanted.standard_error,
        "relative": wanted.relative,
        "max_seconds": wanted.max_seconds,
        "max_samples": wanted.max_samples,
    }
    adjustable = ("observables", "standard_error", "relative", "max_seconds", "max_samples")
    return Plan(
        KIND,
        configuration,
        list(more({})),
        adjustable=adjustable,
        enough=enough,
        more=more,
        outlook=outlook,
        num_points=scene.num_points,
    )


def found(file: StudyFile) -> tuple[Wanted, State]:
    """The request, and how far a stored ensemble is."""
    c = file.configuration
    wanted = Wanted(
        tuple(c["observables"]), c["standard_error"], c["relative"], float(c["max_seconds"]), c["max_samples"]
    )
    return wanted, state(file.runs, stored_levels(file.runs, c["sizes"]), wanted, c["seed"])
