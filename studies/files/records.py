"""Records: the stored part of a solution or a task, as one flat dictionary of numbers and texts that fits into JSON.

JSON has no infinity and no NaN. In a record they are the texts 'inf', '-inf' and 'nan'; `plain` makes these texts, and
`is_text` tells them from other texts.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from linecontact.solver import Solution
from linecontact.solver.checks import NOT_FINITE, plain
from linecontact.solver.units import unit

__all__ = ["RESULTS_VERSION", "flatten", "is_text", "plain", "renamed", "run_record", "unit", "warnings", "warnings_in"]

RESULTS_VERSION = 2
"""To be raised whenever the same task gives other results: they must not be mixed."""

_RENAMED = {
    "adhesion": "tensile_violation",
    "free_residual": "equilibrium_residual",
    "num_counted_patches": "num_unresolved_patches",
}
"""Names in older files, between dots, and those of today."""


def flatten(record: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested dictionaries as one, names joined by dots."""
    flat: dict[str, Any] = {}
    for name, value in record.items():
        if isinstance(value, Mapping):
            flat |= flatten(value, f"{prefix}{name}.")
        else:
            flat[prefix + name] = value
    return flat


def renamed(record: Mapping[str, Any]) -> dict[str, Any]:
    """A stored record with the names of today."""
    return {".".join(_RENAMED.get(part, part) for part in name.split(".")): value for name, value in record.items()}


def is_text(value: Any) -> bool:
    """Whether a value is a text, and not an infinity or NaN that `plain` has made a text of."""
    return isinstance(value, str) and value not in NOT_FINITE


def run_record(solution: Solution) -> dict[str, Any]:
    """The flat record of a solution in a study, see `Solution.to_record`."""
    return flatten(solution.to_record())


def warnings(solution: Solution) -> str:
    """The kinds of a solution's warnings, separated by commas, for a record of it."""
    return ", ".join(str(warning.kind) for warning in solution.warnings)


def warnings_in(runs: Iterable[Mapping[str, Any]]) -> str:
    """The kinds of warnings in some records, and in how many of them; empty where there are none."""
    kinds = [kind for run in runs for kind in str(run.get("warnings", "")).split(", ") if kind]
    return ", ".join(f"{kind} ({kinds.count(kind)})" for kind in dict.fromkeys(kinds))
