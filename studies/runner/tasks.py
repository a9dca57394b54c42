"""Tasks and their records on disk: one small file for every finished task, and one user of a folder at a time.

A record's file is a line with the SHA-256 of the rest, then JSON. It is written beside its final name and renamed, so
it is there whole or not at all; one that does not fit its checksum is set aside, and the task counts as not done.
"""

import contextlib
import hashlib
import json
import reprlib
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any, ClassVar, Protocol

import filelock
from linecontact.solver.methods import Progress

from ..files import records, writing

Record = dict[str, Any]

ROWS = "rows"
"""Name under which a task's record holds several."""

MAX_BYTES = 2**26
"""Largest size of a task's file."""


class Task(Protocol):
    """A frozen dataclass of plain values on which its record depends, and on nothing else."""

    kind: ClassVar[str]
    """Name of the class, unique over all studies and never changed: part of a task's identity, wherever its module
    is. Classes older than this rule keep the name that they had then, which was the path of their module, so that
    unfinished runs of that time go on.
    """

    def run(self, report: Progress | None) -> Record:
        """The task's record: flat, JSON-ready; lists for curves. Or several such records in a list, under the name
        `ROWS`. Runs in any process.
        """

    def __hash__(self) -> int: ...


def identity(task: Task) -> str:
    """Hash of a task: 16 hexadecimal digits of the SHA-256 of its class's `kind`, its fields and the results' version.

    Raises `ValueError` for a class that has no kind of its own: with an inherited one, two classes would share records.
    """
    kind = vars(type(task)).get("kind")
    if not isinstance(kind, str):
        raise ValueError(
            f"task class {type(task).__qualname__} has no kind of its own; allowed: a class with "
            "`kind: ClassVar[str]`, a name unique over all studies"
        )
    text = json.dumps([records.RESULTS_VERSION, kind, _fields(task)], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _fields(task: Task) -> Record:
    return dict(records.plain(asdict(task)))  # type: ignore[call-overload]


def _record(body: bytes) -> Record | None:
    """The record in a task's JSON; None if neither it nor its rows are flat, or no JSON at all."""
    try:
        record = json.loads(body)["record"]
    except (ValueError, LookupError, TypeError, RecursionError):
        return None
    rows = record.get(ROWS) if isinstance(record, dict) else None
    if isinstance(rows, list):
        return {ROWS: [records.renamed(row) for row in rows]} if all(map(_is_flat, rows)) else None
    return records.renamed(record) if _is_flat(record) else None


def check_record(found: object) -> None:
    """Raise `ValueError` for the result of a task, if it is neither a flat record nor several."""
    try:
        kept = _record(json.dumps({"record": records.plain(found)}).encode())
        why = "not flat" if kept is None else ""
    except (TypeError, ValueError, RecursionError) as error:
        why = str(error)
    if why:
        allowed = f"a flat record of numbers, texts and lists of numbers, or under {ROWS!r} a list of such records"
        raise ValueError(f"run of the task gave {reprlib.repr(found)} ({why}); allowed: {allowed}")


def _is_flat(record: object) -> bool:
    return isinstance(record, dict) and all(map(_flat, record.values()))


def _flat(value: Any) -> bool:
    if isinstance(value, list):
        return all(isinstance(item, (int, float)) for item in value)
    return isinstance(value, (str, float)) or (isinstance(value, int) and abs(value) < 2**63)


class TaskFolder:
    """Records of finished tasks, and reasons of failed ones, by the task's hash."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        writing.make_folder(folder)

    def _path(self, task: Task) -> Path:
        return self.folder / f"{identity(task)}.json"

    def load(self, task: Task) -> Record | None:
        """The record of a finished task; None if there is none, or only a damaged one, which is set aside."""
        path = self._path(task)
        if not path.exists():
            return None
        if not path.is_file() or path.stat().st_size > MAX_BYTES:
            raise writing.StoreError(
                f"file {path} is no regular file of up to {MAX_BYTES} bytes; allowed: another --folder"
            )
        try:
            head, _, body = path.read_bytes().partition(b"\n")
        except OSError as error:
            raise writing.StoreError(f"file {path} cannot be read ({error.strerror})") from None
        record = _record(body) if hashlib.sha256(body).hexdigest().encode() == head else None
        if record is None:
            writing.set_aside(path)
        return record

    def save(self, task: Task, record: Record) -> None:
        """Keep a record. Raises `StoreError` if that is impossible, on a full disk for instance."""
        path, body = self._path(task), json.dumps({"task": _fields(task), "record": records.plain(record)}).encode()
        writing.remove(path.with_suffix(".failed"))
        writing.write_bytes(path, [hashlib.sha256(body).hexdigest().encode() + b"\n", body])

    def save_failure(self, task: Task, reason: str) -> None:
        """Keep the reason of a failure, for people to read; the task counts as not done."""
        text = json.dumps({"task": _fields(task), "reason": reason}, indent=1)
        writing.write_bytes(self._path(task).with_suffix(".failed"), [text.encode()])

    def forget(self, tasks: Iterable[Task]) -> None:
        """Remove the records of these tasks."""
        for task in tasks:
            writing.remove(self._path(task), self._path(task).with_suffix(".failed"))


@contextlib.contextmanager
def lock(folder: Path) -> Iterator[None]:
    """Keep the folder for this process; it is free again when the process ends, however that happens.

    Raises `StoreError` if another one has it.
    """
    guard = filelock.FileLock(folder / ".lock")
    try:
        guard.acquire(blocking=False)
    except filelock.Timeout:
        raise writing.StoreError(
            f"folder {folder} is in use by another run; allowed: another --folder, or waiting for that run"
        ) from None
    except OSError as error:
        raise writing.StoreError(f"folder {folder} cannot be written to ({error.strerror})") from None
    try:
        yield
    finally:
        guard.release()
