"""Two stored measurements compared: reading them, other differences between them, and tables of the changes."""

import json
import math
import os
from pathlib import Path
from typing import Any

from linecontact.solver import checks
from linecontact.solver.display import counted
from rich.table import Table

from ..files import hdf5, study_files, writing
from ..runner.tasks import MAX_BYTES
from ..terminal import console
from . import report
from .benchmark import LARGEST
from .cells import cells
from .changes import ROWS, Change, Measurement, between, changes, judge, verdict

EXIT_SLOWER = 3


def read(path: Path) -> Measurement:
    """A stored study, its JSON, or the newest of the studies in a folder. Raises `ValueError` for anything else."""
    allowed = "a study kernels' .h5, its --json saved to a file, or a folder that holds such .h5"
    refusal = f"compare: {path} {{}}; allowed: {allowed}"
    if os.path.isdir(path):
        files = sorted(path.rglob(f"{report.KIND}.h5"), key=lambda file: file.stat().st_mtime)
        if not files:
            raise ValueError(refusal.format(f"holds no {report.KIND}.h5"))
        path = files[-1]
    if path.suffix == ".h5":
        if hdf5.file_kind(path) != report.KIND:
            raise ValueError(refusal.format("is another study's"))
        with writing.expecting(path):
            content = report.to_json(study_files.load_study(path))
    else:
        if not os.path.isfile(path) or path.stat().st_size > MAX_BYTES:  # a pipe would never end
            raise ValueError(refusal.format(f"is no regular file of up to {MAX_BYTES} bytes"))
        try:
            content = json.loads(path.read_text("utf-8"))
        except OSError as error:
            raise ValueError(refusal.format(f"cannot be read ({error.strerror})")) from None
        except (ValueError, RecursionError):
            raise ValueError(refusal.format("is not JSON")) from None
    try:
        return _measurement(content)
    except UnfinishedError as error:
        raise ValueError(refusal.format(f"is of a study with {error} failed tasks, or not finished")) from None
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise ValueError(refusal.format(f"does not follow schema {report.SCHEMA} ({error!r})")) from None


class UnfinishedError(Exception):
    """The number of failed tasks of a study that is not complete."""


def _measurement(content: Any) -> Measurement:
    if content["schema"] != report.SCHEMA:
        raise ValueError(f"schema is {content['schema']!r}")
    if not content["complete"]:
        raise UnfinishedError(len(content["failures"]))
    found = cells(content["runs"])
    for cell in found.values():
        if not 0 < cell.key.num_points <= LARGEST:
            raise ValueError(f"bad row {', '.join(map(str, cell.key))}")
        for variant in cell.variants:
            if not all(0 < value < math.inf for value in (cell.seconds(variant), cell.ratio(variant))):
                raise ValueError(f"bad row {', '.join(map(str, cell.key))} {variant}")
    if not found:
        raise ValueError("no results")
    identity = {str(name): str(value) for name, value in content["configuration"]["identity"].items()}
    return Measurement(identity, str(content["runs"][0].get("provenance.commit", "none")), found)


def differences(old: Measurement, new: Measurement) -> list[str]:
    """Other differences between the two, in sentences; the machine first."""
    names = {"processor": "processors", "caches": "caches", "instructions": "instruction sets"}
    names |= {"compiler": "C compilers", "flags": "flags", "chunk": "chunks"}
    names |= {n: f"versions of {n}" for n in (*old.identity, *new.identity) if n not in (*names, "source", "target")}
    said = []
    for name, text in names.items():
        before, after = (one.identity.get(name, "unknown") for one in (old, new))
        if before != after:
            said.append(f"Different {text}: {before}; then {after}.")
    sources = [f"{one.identity.get('source', 'unknown')} (commit {one.commit})" for one in (old, new)]
    return [*said, f"Source: {sources[0]}; then {sources[1]}."]


def other_yardstick(old: Measurement, new: Measurement) -> bool:
    """Whether C itself is another in the two."""
    return any(old.identity.get(name) != new.identity.get(name) for name in ("processor", "instructions", "compiler"))


def benchmark_table(judged: dict[tuple[str, str], tuple[float, float, str]]) -> Table:
    """A row for every benchmark and precision."""
    caption = (
        "Change: later over earlier ratio to C, geometric mean over all sizes (dimensionless), and its 95 % interval."
    )
    shown = report.new_table(("", "real", "change", "+-", ""), "Warp, later over earlier", caption)
    for (name, precision), (ratio, error, said) in judged.items():
        numbers = f"{ratio:.3f}", f"{1.96 * error * ratio:.3f}"
        shown.add_row(name, precision.removeprefix("float"), *numbers, said)
    return shown


def row_table(marked: list[tuple[Change, str]]) -> Table:
    """The rows that changed."""
    caption = "Ratios to C, or of transforms to FFTW's estimate, in the same round (dimensionless)."
    shown = report.new_table(("", "real", "N", "variant", "old", "new", "change", ""), "Rows that changed", caption)
    for change, said in marked:
        name, precision, size = change.key
        ratios = (f"{ratio:.3g}" for ratio in (change.old, change.new))
        new = f"{change.new / change.old:.2f}"
        shown.add_row(name, precision.removeprefix("float"), report.power(size), change.variant, *ratios, new, said)
    return shown


def command(old: Path, new: Path, threshold: float) -> int:
    """Print the changes; returns 3 if a benchmark is slower over all its sizes, else 0. Raises `ValueError`."""
    checks.real("threshold", threshold, "a number > 1 and <= 10", 1.0, 10.0)
    if os.path.realpath(old) == os.path.realpath(new):
        raise ValueError(f"compare: {old} and {new} are the same; allowed: two measurements")
    before, after = read(old), read(new)
    found = changes(before, after)
    if not found:
        raise ValueError(f"compare: {old} and {new} have no row in common; allowed: such with the same sizes")
    output = console.Output()
    for line in differences(before, after):
        output.print(line, highlight=False, soft_wrap=True)
    judged = judge(found, threshold)
    if judged:
        output.print(benchmark_table(judged))
    marked = []
    for variant in dict.fromkeys(change.variant for change in found):
        own = [change for change in found if change.variant == variant]
        extra = between(own)
        verdicts = [verdict(c.log, math.hypot(c.error, *extra), c.freedom, threshold, ROWS) for c in own]
        marked += [(change, said) for change, said in zip(own, verdicts, strict=True) if said]
    if marked:
        output.print(row_table(marked))
    if other_yardstick(before, after):
        output.print("Ratios to C tell nothing across machines or C compilers: no verdict.", highlight=False)
        return 0
    slower = [f"{name} in {precision}" for (name, precision), (*_, said) in judged.items() if said == "slower"]
    output.print(
        f"{counted(len(found), 'row')}, {len(marked)} changed by more than {threshold:g} and more than chance "
        f"explains; slower over all sizes: {', '.join(slower) or 'none'}.",
        highlight=False,
        soft_wrap=True,
    )
    return EXIT_SLOWER if slower else 0
