"""linecontact: how large is the true contact of a thin elastic layer under a rigid indenter?

    from linecontact import Layer, Scene, solve

The names below are imported when the first of them is used.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .solver import (
        Certificate,
        Layer,
        MeasuredIndenter,
        Observables,
        PowerIndenter,
        RoughIndenter,
        Scene,
        Solution,
        Status,
    )
    from .solver.solve import solve
    from .studies.files.solution_files import load, save
    from .studies.scans.reading import read_scan

    __version__: str

_ELSEWHERE = {
    "load": "linecontact.studies.files.solution_files",
    "read_scan": "linecontact.studies.scans.reading",
    "save": "linecontact.studies.files.solution_files",
}
"""Modules of the names that are not those of `linecontact.solver`."""

__all__ = [
    "Certificate",
    "Layer",
    "MeasuredIndenter",
    "Observables",
    "PowerIndenter",
    "RoughIndenter",
    "Scene",
    "Solution",
    "Status",
    "__version__",
    "load",
    "read_scan",
    "save",
    "solve",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return _version()
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_ELSEWHERE.get(name, "linecontact.solver")), name)


def __dir__() -> list[str]:
    return __all__


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("linecontact")
    except PackageNotFoundError:
        return "unknown"
