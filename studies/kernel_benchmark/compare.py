"""What changed from one measurement to another, judged on ratios that were taken in the same round.

A time changes with whatever else the machine does; its ratio to C's in the same round much less. What is left scatters
from repetition to repetition (`cells.Scatter`), and between two processes, whose memory lies elsewhere, a little more,
which is seen in the changes themselves (`between`). Transforms are listed and not judged.
"""

import json
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from linecontact.solver import checks
from numpy.typing import NDArray
from rich.table import Table

from ..files import hdf5, study_files, writing
from ..runner.tasks import MAX_BYTES
from ..terminal import console
from . import report
from .cells import Cell, Key, Scatter, cells, quantile

EXIT_SLOWER = 3
JUDGED = "warp"
"""The variant that the program runs, which decides on the exit status."""
BOTH = "both"
"""Stands for a precision where both are judged together, which finds what neither shows alone."""
ROWS, BENCHMARKS_ = 0.002, 0.002
"""Probability that a row which did not change is marked, and that any benchmark of a comparison is."""


@dataclass(frozen=True)
class Change:
    """One benchmark, precision, size and variant in both measurements."""

    key: Key
    """What was measured."""
    variant: str
    """The way in which it was done."""
    old: float
    """Ratio to the yardstick in the earlier measurement (dimensionless)."""
    new: float
    """In the later one."""
    error: float
    """Standard error of the logarithm of the change, from the repetitions."""
    freedom: int
    """Degrees of freedom of that."""

    @property
    def log(self) -> float:
        """Logarithm of the later ratio over the earlier one."""
        return math.log(self.new / self.old)


@dataclass(frozen=True)
class Measurement:
    """A stored measurement."""

    identity: dict[str, str]
    """What its times depend on."""
    commit: str
    """Of the checkout, with '+dirty'."""
    cells: dict[Key, Cell]
    """Repetitions by what was measured."""


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
        for variant in cell.variants:
            if not all(0 < value < math.inf for value in (cell.seconds(variant), cell.ratio(variant))):
                raise ValueError(f"bad row {', '.join(map(str, cell.key))} {variant}")
    if not found:
        raise ValueError("no results")
    identity = {str(name): str(value) for name, value in content["configuration"]["identity"].items()}
    return Measurement(identity, str(content["runs"][0].get("provenance.commit", "none")), found)


def changes(old: Measurement, new: Measurement) -> list[Change]:
    """What both have measured, against the same yardstick."""
    found = []
    variants = dict.fromkeys(v for cell in new.cells.values() for v in cell.variants)
    for variant in variants:
        scatters = [Scatter(one.cells.values(), variant) for one in (old, new)]
        for key, cell in new.cells.items():
            before = old.cells.get(key)
            yardsticks = {one.runs[0]["yardstick"] for one in (cell, before) if one}
            if before is None or len(yardsticks) > 1 or variant in yardsticks:
                continue
            ratios = before.ratio(variant), cell.ratio(variant)
            errors = [s.error(one, variant) for s, one in zip(scatters, (before, cell), strict=True)]
            if all(ratio > 0 for ratio in ratios) and not math.isnan(sum(errors)):
                freedom = sum(s.freedom(one) for s, one in zip(scatters, (before, cell), strict=True))
                found.append(Change(key, variant, *ratios, math.hypot(*errors), freedom))
    return found


def between(found: list[Change]) -> tuple[float, float]:
    """Standard deviations of logarithms of changes that nobody made, beyond what the repetitions explain.

    The first is of single sizes, seen in how far they are from the mean of their benchmark; the second of these means,
    for what a process has in common for all sizes, seen in how they scatter. Where there are too few to see it, both
    are what identical runs have shown.
    """
    groups: dict[tuple[str, str], list[Change]] = {}
    for change in found:
        groups.setdefault((change.key.benchmark, change.key.precision), []).append(change)
    several = [np.array([change.log for change in own]) for own in groups.values() if len(own) > 1]
    apart = [(logs - logs.mean()) * math.sqrt(logs.size / (logs.size - 1)) for logs in several]
    single = _beyond(np.concatenate(apart), [c.error for c in found]) if len(apart) >= _ENOUGH else _USUAL
    means, errors = zip(*(_mean(own, single) for own in groups.values()), strict=True) if groups else ((), ())
    from_median = np.array(means) - np.median(means) if groups else np.zeros(0)
    return single, _beyond(from_median, list(errors)) if len(means) >= _ENOUGH else _USUAL


def _mean(own: list[Change], single: float) -> tuple[float, float]:
    """Mean logarithm of some changes, the surer ones counting more, and its standard error.

    Where the changes differ by more than their errors tell, the error is what they differ by: a change at one size only
    may come from what else the machine did just then.
    """
    logs, weights = np.array([c.log for c in own]), np.array([1 / (c.error**2 + single**2) for c in own])
    mean = float(weights @ logs / weights.sum())
    differ = float(weights @ (logs - mean) ** 2 / weights.sum()) / max(1, logs.size - 1)
    return mean, math.sqrt(max(1 / float(weights.sum()), differ))


_ENOUGH, _USUAL = 8, 0.02


def _beyond(deviations: NDArray[np.float64], explained: list[float]) -> float:
    """Standard deviation of what is seen (from the median of the magnitudes) beyond what is explained."""
    seen = 1.4826 * float(np.median(np.abs(deviations)))
    return math.sqrt(max(0.0, seen**2 - float(np.median(explained)) ** 2))


def verdict(log: float, error: float, freedom: int, threshold: float, chance: float) -> str:
    """'slower' or 'faster' for a change beyond the threshold that chance makes rarely; empty for any other."""
    limit = max(math.log(threshold), quantile(1 - chance / 2, freedom) * error)
    return "" if abs(log) <= limit else "slower" if log > 0 else "faster"


def judge(found: list[Change], threshold: float) -> dict[tuple[str, str], tuple[float, float, str]]:
    """Benchmarks over all their sizes, by name and precision or `BOTH`: mean change, its standard error, verdict."""
    own = [change for change in found if change.variant == JUDGED]
    groups: dict[tuple[str, str], list[Change]] = {}
    for change in own:
        for precision in (change.key.precision, BOTH):
            groups.setdefault((change.key.benchmark, precision), []).append(change)
    groups = {
        name: rows for name, rows in groups.items() if name[1] != BOTH or len({r.key.precision for r in rows}) > 1
    }
    judged, (single, common) = {}, between(own)
    for name, rows in groups.items():
        mean, error = _mean(rows, single)
        error = math.hypot(error, common)
        freedom = sum(change.freedom for change in rows)
        judged[name] = math.exp(mean), error, verdict(mean, error, freedom, threshold, BENCHMARKS_ / len(groups))
    return judged


def differences(old: Measurement, new: Measurement) -> list[str]:
    """What else differs between the two, in sentences; the machine first."""
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
    """Print what changed; returns 3 if a benchmark is slower over all its sizes, else 0. Raises `ValueError`."""
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
        f"{len(found)} rows, {len(marked)} changed by more than {threshold:g} and more than chance explains; "
        f"slower over all sizes: {', '.join(slower) or 'none'}.",
        highlight=False,
        soft_wrap=True,
    )
    return EXIT_SLOWER if slower else 0
