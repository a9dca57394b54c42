"""A scene's options as a text, from which every process makes the same scene, and which can be stored with results."""

import hashlib
import json
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from linecontact.solver import Scene

from .making import Given, make_scene


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
    """The same without the folders of files, as it is stored with the results."""
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
            raise ValueError(f"file {name} is not there, or has changed since the start; allowed: the same contents")
    return make_scene(SimpleNamespace(**told["options"]), given)
