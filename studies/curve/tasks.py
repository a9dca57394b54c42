"""The tasks of a curve: one solve for each value of the number that is varied."""

from dataclasses import dataclass
from typing import ClassVar

from linecontact.solver import Scene, Status, solve
from linecontact.solver.methods import Progress
from linecontact.solver.units import named, shown, unit

from ..files.records import run_record, warnings
from ..files.study_files import StudyFile
from ..runner.tasks import Record
from ..scenes.described import base_scene
from . import number


def column(over: str) -> str:
    """The column of a curve's file that holds the number that is varied."""
    return over if over == "approach" else f"scene.{over}"


def unit_in(file: StudyFile, name: str) -> str:
    """The unit of a quantity of the scenes in a curve's file, '-' where it is dimensionless."""
    return shown(unit(name), named(file.runs[0] if file.runs else {}, "scene."))


@dataclass(frozen=True)
class Task:
    """One point of a curve."""

    kind: ClassVar[str] = "linecontact.studies.curve.Task"

    scene: str
    """The common part of all points, see `scenes.described`."""
    over: str
    """Name of the number that is varied."""
    value: float
    """Its value here, in its own unit."""
    accuracy: float | None
    """Relative error wanted (dimensionless); None: solved on the scene's grid to the default residual."""
    accuracy_of: str
    """The quantity that it is wanted of."""

    def run(self, report: Progress | None) -> Record:
        """The solution's record, with the contact stiffness."""
        return point(self.point, self.accuracy, self.accuracy_of, report)

    @property
    def point(self) -> Scene:
        """The scene of this value."""
        return number.put(base_scene(self.scene), self.over, self.value)


def point(scene: Scene, accuracy: float | None, accuracy_of: str, report: Progress | None = None) -> Record:
    """The record of a curve's scene, with the contact stiffness and the kinds of its warnings."""
    solution = solve(scene, accuracy=accuracy, accuracy_of=accuracy_of, progress=report)
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    told = {"contact_stiffness": solution.contact_stiffness, "warnings": warnings(solution)}
    return run_record(solution) | told
