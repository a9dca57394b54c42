"""The tasks of a curve: one solve for each value of the number that is varied."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

from linecontact.solver import Scene, Status, solve
from linecontact.solver.methods import Progress
from linecontact.solver.units import SCENE, unit

from ..files.records import run_record
from ..files.study_files import StudyFile
from ..runner.tasks import Record
from ..scenes.making import Given, make_scene
from . import number


def column(over: str) -> str:
    """The column of a curve's file that holds the number that is varied."""
    return over if over == "approach" else f"scene.{over}"


def unit_in(file: StudyFile, name: str) -> str:
    """The unit of a quantity of the scenes in a curve's file, '-' where it is dimensionless."""
    known = str(file.runs[0].get("scene.profile_length_unit", SCENE)) if file.runs else SCENE
    own = "-" if unit(name) == "1" else unit(name)
    return own if known == SCENE else own.replace("length", known)


def described(options: Mapping[str, Any], given: Given) -> str:
    """A scene's options as a text from which every process makes the same scene; of a file's contents the SHA-256.

    options: as `make_scene` takes them, by name.
    """
    groups = {title: {name: _plain(value) for name, value in group.items()} for title, group in given.items()}
    files = {str(value) for group in given.values() for value in group.values() if isinstance(value, Path)}
    sums = {name: hashlib.sha256(Path(name).read_bytes()).hexdigest() for name in sorted(files) if Path(name).is_file()}
    return json.dumps({"options": options, "given": groups, "files": sums}, sort_keys=True)


def _plain(value: Any) -> Any:
    return {"path": str(value.resolve())} if isinstance(value, Path) else value


def _as_given(value: Any) -> Any:
    return Path(value["path"]) if isinstance(value, Mapping) else value


def shown(description: str) -> str:
    """The same without the folders of files: what is stored with the results."""
    told = json.loads(description)
    files = told.pop("files")
    groups = {title: {name: _name(v) for name, v in group.items()} for title, group in told["given"].items()}
    sums = {Path(name).name: known for name, known in files.items()}
    return json.dumps(told | {"given": groups, "files": sums}, sort_keys=True)


def _name(value: Any) -> Any:
    return Path(value["path"]).name if isinstance(value, Mapping) else value


@lru_cache(maxsize=1)
def base_scene(description: str) -> Scene:
    """The scene that `described` has put down. Raises `ValueError`, also for a file that has changed since."""
    told = json.loads(description)
    given = {title: {name: _as_given(v) for name, v in group.items()} for title, group in told["given"].items()}
    for name, known in told["files"].items():
        if not Path(name).is_file() or hashlib.sha256(Path(name).read_bytes()).hexdigest() != known:
            raise ValueError(f"file {name} is not there, or not what it was at the start; allowed: the same contents")
    return make_scene(SimpleNamespace(**told["options"]), given)


@dataclass(frozen=True)
class Task:
    """One point of a curve."""

    kind: ClassVar[str] = "linecontact.studies.curve.Task"

    scene: str
    """What all points have in common, see `described`."""
    over: str
    """Name of the number that is varied."""
    value: float
    """Its value here, in its own unit."""
    accuracy: float | None
    """Relative error wanted of a_r (dimensionless); None: solved on the scene's grid to the default residual."""

    def run(self, report: Progress | None) -> Record:
        """The solution's record, with the contact stiffness."""
        return point(self.point, self.accuracy, report)

    @property
    def point(self) -> Scene:
        """The scene of this value."""
        return number.put(base_scene(self.scene), self.over, self.value)


def point(scene: Scene, accuracy: float | None, report: Progress | None = None) -> Record:
    """The record of a curve's scene, with the contact stiffness and the kinds of its warnings."""
    solution = solve(scene, accuracy=accuracy, progress=report)
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    warned = ", ".join(str(warning.kind) for warning in solution.warnings)
    return run_record(solution) | {"contact_stiffness": solution.contact_stiffness, "warnings": warned}
