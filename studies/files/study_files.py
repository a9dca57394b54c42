"""Files of studies.

A study file holds one dataset per scalar under /runs, certificate and provenance included, with one value per run;
reference curves under /lines; the reasons of failed tasks; and the study's configuration as an attribute.
"""

import json
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .hdf5 import column_of_numbers, file_kind, new_file, open_file, scalar
from .records import RESULTS_VERSION, is_text, plain, renamed, unit
from .writing import DamagedError, StoreError, set_aside

if TYPE_CHECKING:
    import h5py

MAX_RUNS = 2**17
"""Runs that a study's file may hold."""


@dataclass
class StudyFile:
    """Contents of a study file."""

    kind: str
    """Name of the study."""
    configuration: dict[str, Any]
    """The choices of the user, fit for JSON."""
    runs: list[dict[str, Any]] = field(default_factory=list)
    """One flat record for each finished run."""
    lines: dict[str, dict[str, NDArray[np.float64]]] = field(default_factory=dict)
    """Reference curves by name; each has columns by name, shape (number of points,)."""
    failures: dict[str, str] = field(default_factory=dict)
    """Reasons of failed tasks by their hash."""
    complete: bool = False
    """Whether every task is done."""
    version: int = RESULTS_VERSION
    """Version of the results, see `records.RESULTS_VERSION`."""

    def column(self, name: str) -> NDArray[Any]:
        """One quantity over the runs, shape (number of runs,)."""
        return np.array([run[name] for run in self.runs])

    def select(self, name: str, value: Any) -> "StudyFile":
        """The same study with only the runs whose `name` is `value`."""
        runs = [run for run in self.runs if run[name] == value]
        return StudyFile(self.kind, self.configuration, runs, self.lines, self.failures)


def finished(
    path: Path,
    kind: str,
    configuration: Mapping[str, Any],
    adjustable: Collection[str] = (),
    enough: Callable[["StudyFile"], bool] | None = None,
) -> StudyFile | None:
    """The study in `path` if it is complete; None if there is none yet, or only a damaged one, which is set aside.

    adjustable: names in the configuration that may differ; then the study goes on, and the file is replaced, unless
    the complete file is `enough`.

    Raises `StoreError` for a file of another study, configuration or version.
    """
    if not path.exists():
        return None

    def refusal(other: str) -> StoreError:
        return StoreError(
            f"file {path} holds {other}; allowed: --folder and a new name to keep it, --overwrite to replace it"
        )

    try:
        if file_kind(path) != kind:
            raise refusal("another study")
        study = load_study(path)
    except DamagedError:
        set_aside(path)
        return None
    asked = plain(configuration)
    names = asked.keys() | study.configuration.keys()
    differ = {name for name in names if asked.get(name) != study.configuration.get(name)}
    if study.version != RESULTS_VERSION:
        raise refusal(f"results of version {study.version}, not {RESULTS_VERSION}")
    if others := sorted(differ - set(adjustable)):
        raise refusal(f"results made with other options ({', '.join(others)})")
    same = not differ or bool(enough and enough(study))
    return study if study.complete and same else None


def is_complete(path: Path) -> bool:
    """Whether a study's file holds all that its user asked for; raises like `hdf5.open_file`."""
    with open_file(path) as file:
        return bool(file.attrs["complete"])


def save_study(path: Path, study: StudyFile) -> None:
    """Write a study in its present state; an existing file is replaced in one step."""
    with new_file(path) as file:
        file.attrs["kind"] = study.kind
        file.attrs["configuration"] = json.dumps(plain(study.configuration))
        file.attrs["complete"] = study.complete
        file.attrs["results_version"] = study.version
        file.create_group("runs")
        names = dict.fromkeys(name for run in study.runs for name in run)
        for name in names:  # a value that a run does not have is nan, or an empty text
            some = next(run[name] for run in study.runs if name in run)
            _write_column(file["runs"], name, [run.get(name, "" if is_text(some) else math.nan) for run in study.runs])
        for line, columns in study.lines.items():
            for name, values in columns.items():
                file[f"lines/{line}/{name}"] = np.asarray(values, dtype=np.float64)
        file.create_dataset("failures", data=np.bytes_(json.dumps(study.failures)))


def _write_column(group: "h5py.Group", name: str, values: Sequence[Any]) -> None:
    """One value per run: text as text, numbers (infinities among them, 'inf' in JSON) as numbers with a unit."""
    import h5py

    if any(is_text(value) for value in values):
        texts = [str(value).encode() for value in values]  # of fixed length: compresses to nothing where all are equal
        dtype = h5py.string_dtype("utf-8", max(1, *map(len, texts)))
        group.create_dataset(name, data=texts, dtype=dtype, compression="gzip")
        return
    whole = all(isinstance(value, int) for value in values)
    data = np.array(values) if whole else np.array([float(value) for value in values])
    group.create_dataset(name, data=data, compression="gzip", shuffle=True).attrs["unit"] = unit(name)


def load_study(path: Path) -> StudyFile:
    """Read a study file of up to `MAX_RUNS` runs. Raises like `hdf5.open_file`."""
    with open_file(path) as file:
        if "runs" not in file:
            raise StoreError(f"file {path} holds no study; allowed: a file that a study has written")
        columns = renamed({name: _read_column(dataset) for name, dataset in file["runs"].items()})
        length = len(next(iter(columns.values()))) if columns else 0
        if any(len(values) != length for values in columns.values()):
            raise ValueError("its columns are of different lengths")
        configuration, failures = (_object(text) for text in (file.attrs["configuration"], bytes(file["failures"][()])))
        lines = file.get("lines", {})
        return StudyFile(
            kind=str(file.attrs["kind"]),
            configuration=configuration,
            runs=[{name: values[i] for name, values in columns.items()} for i in range(length)],
            lines={line: {n: column_of_numbers(data) for n, data in group.items()} for line, group in lines.items()},
            failures={task: str(reason) for task, reason in failures.items()},
            complete=bool(file.attrs["complete"]),
            version=int(file.attrs["results_version"]),
        )


def _object(text: str | bytes) -> dict[str, Any]:
    value = json.loads(text)
    if not isinstance(value, dict):
        raise ValueError("its JSON is no object")
    return value


def _read_column(dataset: "h5py.Dataset") -> list[Any]:
    import h5py

    if dataset.ndim != 1 or dataset.size > MAX_RUNS:
        raise ValueError(f"{dataset.name} has shape {dataset.shape}; allowed: a column of up to {MAX_RUNS}")
    if h5py.check_string_dtype(dataset.dtype):
        return [scalar(text) for text in dataset.asstr(errors="replace")[:]]
    return list(dataset[:].tolist())
