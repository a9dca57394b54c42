"""HDF5 files of solutions and studies: written beside their final name and renamed, so never left half written.

A solution file holds the datasets x, profile, displacement and contact_pressure, and everything that the command line's
JSON holds as attributes (nested names joined by dots). A study file holds one dataset per scalar under /runs,
certificate and provenance included, with one value per run; reference curves under /lines; the reasons of failed tasks;
and the study's configuration as an attribute. Before the HDF5 part, as its user block, stands the checksum.
"""

import contextlib
import hashlib
import itertools
import json
import math
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from linecontact.solver import Solution
from numpy.typing import NDArray

from ..terminal import console
from . import confined

UNITS = {
    "x": "length",
    "displacement": "length",
    "contact_pressure": "pressure",
    "thickness": "length",
    "radius": "length",
    "period": "length",
    "approach": "length",
    "peak_pressure": "pressure",
    "pressure": "pressure",
    "contact_modulus": "pressure",
}
"""Units by the last part of a name; 'seconds.*' is in seconds, 'bytes.*' in bytes, everything else dimensionless."""

RESULTS_VERSION = 2
"""To be raised whenever the same task gives other results: they must not be mixed."""

MAX_RUNS = 2**17  # of a study's file
MAX_NAME = 200  # bytes of a file's name: most systems take 255, and others are made of it
_MAX_TEXT = 10_000  # characters of a stored text that are kept
_HEAD = 512  # bytes of HDF5's user block

_sound: set[str] = set()  # checksums of what this process has written or checked

_UMASK = os.umask(0)
os.umask(_UMASK)


class StoreError(ValueError):
    """A file that cannot be read or written as asked; the message names it."""


class DamagedError(StoreError):
    """A file of linecontact that is not what was written."""


def unit(name: str) -> str:
    """Unit of a stored quantity."""
    if name == "profile":  # the heights; scene.profile is the indenter's name
        return "length"
    if name.startswith("bytes."):
        return "byte"
    return "s" if "seconds." in name else UNITS.get(name.rsplit(".", 1)[-1], "1")


def make_folder(folder: Path) -> None:
    """Make `folder` and its parents; raises `StoreError` if that is impossible."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(f"folder {folder} cannot be made ({error.strerror}); allowed: a writable place") from None


def check_target(path: Path, overwrite: bool) -> None:
    """Raise `StoreError` before any work if `path` cannot become a new file."""
    if len(os.fsencode(path.name)) > MAX_NAME:
        raise StoreError(f"file {path} has a name longer than {MAX_NAME} bytes; allowed: a shorter one")
    if path.is_dir():
        raise StoreError(f"file {path} is a folder; allowed: the name of a file")
    if path.exists() and not path.is_file():
        raise StoreError(f"file {path} is not a regular file; allowed: the name of a file")
    if path.exists() and not overwrite:
        raise StoreError(f"file {path} exists; allowed: a new name, or overwriting it by --overwrite")
    if not path.parent.is_dir():
        raise StoreError(f"folder {path.parent} of file {path.name} does not exist; allowed: an existing folder")
    check_folder(path.parent)


def check_folder(folder: Path) -> None:
    """Raise `StoreError` if nothing can be written there."""
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        reason = f"cannot be written to ({error.strerror})"
        raise StoreError(f"folder {folder} {reason}; allowed: a writable folder") from None


@contextlib.contextmanager
def new_file(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file that appears under `path` only when it is complete. Raises `StoreError` if it cannot be written.

    HDF5 builds it in memory, because its library does not survive a full disk.
    """
    with h5py.File(path.name, "w", driver="core", backing_store=False) as file:
        yield file
        file.flush()
        image = file.id.get_file_image()
    digest = hashlib.sha256(image).hexdigest()
    write_bytes(path, _head(digest), image)
    _sound.add(digest)


def write_bytes(path: Path, *parts: bytes) -> None:
    """Write a file beside its final name and rename it; a link is followed. Raises `StoreError`."""
    path = path.resolve()
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
        temporary = Path(name)
        try:
            with os.fdopen(handle, "wb") as target:
                target.writelines(parts)
                target.flush()
                os.fsync(target.fileno())
            temporary.chmod(0o666 & ~_UMASK)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise StoreError(f"file {path} could not be written: {error}") from error


def remove(*paths: Path) -> None:
    """Remove files that may be there. Raises `StoreError` if that is impossible."""
    for path in paths:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise StoreError(f"file {path} cannot be removed ({error.strerror})") from None


@contextlib.contextmanager
def open_file(path: Path) -> Iterator[h5py.File]:
    """Read an HDF5 file; raises `StoreError` for a missing or foreign one, `DamagedError` for a damaged one.

    Damaged is also what does not hold what the reader looks for. A checksum keeps no malice away: what this process has
    not written is read by another one first (`confined`).
    """
    if not os.path.isfile(path):  # Path's own raises for some names
        what = "is no regular file" if os.path.lexists(path) else "does not exist"
        raise StoreError(f"file {path} {what}; allowed: an HDF5 file")
    try:
        digest = _verify(path)
        if digest not in _sound:
            confined.check_result(path)
            _sound.add(digest)
        with h5py.File(path, "r") as file:
            yield file
    except StoreError:
        raise
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise DamagedError(f"file {path} is damaged or not one of linecontact's HDF5 files, {reason}") from error


@contextlib.contextmanager
def expecting(where: Path) -> Iterator[None]:
    """Whatever goes wrong with what files hold, a checksum or not, is theirs to answer for: raises `StoreError`."""
    try:
        yield
    except (StoreError, OSError):
        raise
    except Exception as error:
        reason = f"does not hold what linecontact writes there, {type(error).__name__}: {error}"
        raise StoreError(f"{where} {reason}; allowed: another one, or to make it anew") from error


def _verify(path: Path) -> str:
    """The checksum, if it fits, before HDF5 sees the file."""
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD)
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise StoreError(f"file {path} cannot be read ({error.strerror})") from None
    if head == _head(digest):
        return digest
    expected = _head("")[:40]
    alike = sum(a == b for a, b in zip(head, expected, strict=False))
    if any(head) and alike < min(len(head), len(expected)) - 2:  # zeros or a few flipped bits make no stranger of it
        raise StoreError(f"file {path} is not one of linecontact's HDF5 files; allowed: another name")
    raise DamagedError(f"file {path} is damaged: its checksum does not fit")


def _head(digest: str) -> bytes:
    return f"linecontact, SHA-256 of all but these {_HEAD} bytes: {digest}\n".encode().ljust(_HEAD, b"\0")


def set_aside(path: Path) -> None:
    """Rename a damaged file and say so. Raises `StoreError` if that is impossible."""
    ends = itertools.chain([".damaged"], (f".damaged.{k}" for k in itertools.count(2)))
    aside = next(aside for end in ends if not (aside := path.with_name(path.name + end)).exists())
    try:
        path.replace(aside)
    except OSError as error:
        raise StoreError(f"file {path} is damaged and cannot be set aside ({error.strerror})") from None
    console.errors.print(f"file {path} is damaged; it is set aside as {aside.name}, its part is done again")


def flatten(record: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested dictionaries as one, names joined by dots."""
    flat: dict[str, Any] = {}
    for name, value in record.items():
        if isinstance(value, Mapping):
            flat |= flatten(value, f"{prefix}{name}.")
        else:
            flat[prefix + name] = value
    return flat


def plain(value: Any) -> Any:
    """The same value for JSON: tuples as lists, infinities as text."""
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def run_record(solution: Solution) -> dict[str, Any]:
    """Flat record of a study's run: the JSON without the coarser grids, which differ in number."""
    return flatten({name: value for name, value in solution.to_dict().items() if name != "levels"})


def save_solution(path: Path, solution: Solution) -> None:
    """Write one solution; an existing file is replaced."""
    fields = {
        "x": solution.scene.x,
        "profile": solution.scene.profile,
        "displacement": solution.displacement,
        "contact_pressure": solution.contact_pressure,
    }
    with new_file(path) as file:
        file.attrs["kind"] = "solution"
        for name, value in flatten(solution.to_dict()).items():
            file.attrs[name] = value
        for name, values in fields.items():
            dataset = file.create_dataset(name, data=values)
            dataset.attrs["unit"] = unit(name)


def load_solution(path: Path) -> tuple[dict[str, NDArray[np.float64]], dict[str, Any]]:
    """Fields, shape (N,) each, N >= 2, and attributes of a solution file. Raises like `open_file`."""
    with open_file(path) as file:
        fields = {name: _numbers(file[name]) for name in ("x", "profile", "displacement", "contact_pressure")}
        if len({values.size for values in fields.values()}) > 1 or fields["x"].size < 2:
            raise ValueError("its fields are of different lengths, or shorter than 2")
        return fields, {name: _scalar(value) for name, value in file.attrs.items()}


def _numbers(dataset: h5py.Dataset) -> NDArray[np.float64]:
    if dataset.ndim != 1 or dataset.dtype.kind != "f":
        raise ValueError(f"{dataset.name} is no column of numbers")
    return np.asarray(dataset[:], dtype=np.float64)


def _scalar(value: Any) -> Any:
    """Text as the terminal and figures can show it, up to `_MAX_TEXT` characters."""
    value = value.item() if isinstance(value, np.generic) else value
    value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
    return console.printable(value[:_MAX_TEXT]) if isinstance(value, str) else value


@dataclass
class StudyFile:
    """Contents of a study file.

    kind: the study's name; configuration: what the user chose, JSON-ready; runs: one flat record per finished run;
    lines: reference curves by name, columns by name; failures: reasons of failed tasks by hash; complete: all done;
    version: of the results.
    """

    kind: str
    configuration: dict[str, Any]
    runs: list[dict[str, Any]] = field(default_factory=list)
    lines: dict[str, dict[str, NDArray[np.float64]]] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)
    complete: bool = False
    version: int = RESULTS_VERSION

    def column(self, name: str) -> NDArray[Any]:
        """One quantity over the runs, shape (number of runs,)."""
        return np.array([run[name] for run in self.runs])

    def select(self, name: str, value: Any) -> "StudyFile":
        """The same study with only the runs whose `name` is `value`."""
        runs = [run for run in self.runs if run[name] == value]
        return StudyFile(self.kind, self.configuration, runs, self.lines, self.failures)


def finished(path: Path, kind: str, configuration: Mapping[str, Any]) -> StudyFile | None:
    """The study in `path` if it is complete; None if there is none yet, or only a damaged one, which is set aside.

    Raises `StoreError` for a file of another study, configuration or version.
    """
    if not path.exists():
        return None
    other = "another study, configuration or version; allowed: --overwrite, or a new --folder"
    refusal = StoreError(f"file {path} holds {other}")
    try:
        if file_kind(path) != kind:
            raise refusal
        study = load_study(path)
    except DamagedError:
        set_aside(path)
        return None
    if (study.configuration, study.version) != (plain(configuration), RESULTS_VERSION):
        raise refusal
    return study if study.complete else None


def save_study(path: Path, study: StudyFile) -> None:
    """Write a study in its present state; an existing file is replaced in one step."""
    with new_file(path) as file:
        file.attrs["kind"] = study.kind
        file.attrs["configuration"] = json.dumps(plain(study.configuration))
        file.attrs["complete"] = study.complete
        file.attrs["results_version"] = study.version
        file.create_group("runs")
        names = dict.fromkeys(name for run in study.runs for name in run)
        for name in names:  # what a run does not have is nan, or an empty text
            some = next(run[name] for run in study.runs if name in run)
            _write_column(file["runs"], name, [run.get(name, "" if _is_text(some) else math.nan) for run in study.runs])
        for line, columns in study.lines.items():
            for name, values in columns.items():
                file[f"lines/{line}/{name}"] = np.asarray(values, dtype=np.float64)
        file.create_dataset("failures", data=np.bytes_(json.dumps(study.failures)))


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and value not in ("inf", "-inf", "nan")


def _write_column(group: h5py.Group, name: str, values: Sequence[Any]) -> None:
    """One value per run: text as text, numbers (infinities among them, 'inf' in JSON) as numbers with a unit."""
    if any(_is_text(value) for value in values):
        texts = [str(value).encode() for value in values]  # of fixed length: compresses to nothing where all are equal
        dtype = h5py.string_dtype("utf-8", max(1, *map(len, texts)))
        group.create_dataset(name, data=texts, dtype=dtype, compression="gzip")
        return
    whole = all(isinstance(value, int) for value in values)
    data = np.array(values) if whole else np.array([float(value) for value in values])
    group.create_dataset(name, data=data, compression="gzip", shuffle=True).attrs["unit"] = unit(name)


def load_study(path: Path) -> StudyFile:
    """Read a study file of up to `MAX_RUNS` runs. Raises like `open_file`."""
    with open_file(path) as file:
        columns = {name: _read_column(dataset) for name, dataset in file["runs"].items()}
        length = len(next(iter(columns.values()))) if columns else 0
        if any(len(values) != length for values in columns.values()):
            raise ValueError("its columns are of different lengths")
        configuration, failures = (_object(text) for text in (file.attrs["configuration"], bytes(file["failures"][()])))
        lines = file.get("lines", {})
        return StudyFile(
            kind=str(file.attrs["kind"]),
            configuration=configuration,
            runs=[{name: values[i] for name, values in columns.items()} for i in range(length)],
            lines={line: {n: _numbers(data) for n, data in group.items()} for line, group in lines.items()},
            failures={task: str(reason) for task, reason in failures.items()},
            complete=bool(file.attrs["complete"]),
            version=int(file.attrs["results_version"]),
        )


def _object(text: str | bytes) -> dict[str, Any]:
    value = json.loads(text)
    if not isinstance(value, dict):
        raise ValueError("its JSON is no object")
    return value


def _read_column(dataset: h5py.Dataset) -> list[Any]:
    if dataset.ndim != 1 or dataset.size > MAX_RUNS:
        raise ValueError(f"{dataset.name} has shape {dataset.shape}; allowed: a column of up to {MAX_RUNS}")
    if h5py.check_string_dtype(dataset.dtype):
        return [_scalar(text) for text in dataset.asstr(errors="replace")[:]]
    return list(dataset[:].tolist())


def file_kind(path: Path) -> str:
    """'solution' or the study's name."""
    with open_file(path) as file:
        return str(file.attrs["kind"])
