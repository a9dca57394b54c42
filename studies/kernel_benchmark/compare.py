"""Two measurements of the kernels, as ratios of the later's times over the earlier's."""

import json
import math
import os
from pathlib import Path
from typing import Any, NamedTuple

from linecontact.solver import checks
from rich.table import Table

from ..files import hdf5, study_files, writing
from ..runner.tasks import MAX_BYTES
from ..terminal import console
from . import report
from .candidates import VARIANTS

EXIT_SLOWER = 3
JUDGED = "warp-graph"
"""The variant that the solver runs, which decides on the exit status."""

Key = tuple[str, str, int, str]


class Timing(NamedTuple):
    """How long a call of a kernel takes, and how fast the machine copied at that time."""

    seconds: float
    """Median time of a call [s]."""
    copy: float
    """Bandwidth of a copy of as much memory [1e9 byte/s]."""


class Ratio(NamedTuple):
    """One kernel, precision, size and variant in both measurements."""

    key: Key
    """Kernel, precision, log2 of the points and variant."""
    old: Timing
    """The earlier measurement."""
    new: Timing
    """The later measurement."""

    @property
    def raw(self) -> float:
        """Later over earlier time (dimensionless)."""
        return self.new.seconds / self.old.seconds

    @property
    def normalised(self) -> float:
        """The same in units of the time that a copy takes, so that a slower machine alone changes nothing."""
        return self.raw * self.new.copy / self.old.copy

    def verdict(self, threshold: float) -> str:
        """'slower' or 'faster' where both ratios say so: one alone may come from the machine or from the copy."""
        if min(self.raw, self.normalised) > threshold:
            return "slower"
        return "faster" if max(self.raw, self.normalised) < 1 / threshold else ""


def read(path: Path) -> dict[Key, Timing]:
    """Timings of a stored study, or of its JSON. Raises `ValueError` for anything else."""
    refusal = f"compare: file {path} {{}}; allowed: a study kernels' .h5, or its --json saved to a file"
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
        return _timings(content)
    except (LookupError, TypeError, ValueError, ArithmeticError) as error:
        raise ValueError(refusal.format(f"does not follow schema {report.SCHEMA} ({error!r})")) from None


def _timings(content: Any) -> dict[Key, Timing]:
    if content["schema"] != report.SCHEMA:
        raise ValueError(f"schema is {content['schema']!r}")
    found = {}
    for row in content["results"]:
        key = (str(row["kernel"]), str(row["precision"]), int(row["log2_points"]), str(row["variant"]))
        timing = Timing(float(row["seconds_median"]), float(row["copy_bandwidth_gb_per_s"]))
        if not all(0 < value < math.inf for value in timing) or row["variant"] not in VARIANTS or key in found:
            raise ValueError(f"bad or double row {', '.join(map(str, key))}")
        found[key] = timing
    if not found:
        raise ValueError("no results")
    return found


def table(ratios: list[Ratio], threshold: float) -> Table:
    """One row per kernel, precision, size and variant."""
    shown = report.new_table(
        ("kernel", "bits", "N", "variant", "old\n(us)", "new\n(us)", "ratio", "norm.", ""),
        "Times of the later measurement over the earlier's",
        f"Medians; norm.: times the copy bandwidths' ratio; marked where both are beyond {threshold:g} or its inverse. "
        "Ratios dimensionless.",
        gap=0,
    )
    for ratio in ratios:
        kernel, precision, size, variant = ratio.key
        times = (report.microseconds(timing.seconds) for timing in (ratio.old, ratio.new))
        shown.add_row(
            kernel,
            precision.removeprefix("float"),
            f"2^{size}",
            variant,
            *times,
            f"{ratio.raw:.2f}",
            f"{ratio.normalised:.2f}",
            ratio.verdict(threshold),
        )
    return shown


def command(old: Path, new: Path, threshold: float) -> int:
    """Print the ratios; returns 3 if a recorded kernel is slower beyond the threshold, else 0. Raises `ValueError`."""
    checks.real("threshold", threshold, "a finite number > 1", 1.0)
    before, after = read(old), read(new)
    ratios = [Ratio(key, before[key], after[key]) for key in before if key in after]
    if not ratios:
        raise ValueError(f"compare: files {old} and {new} have no row in common; allowed: such with the same sizes")
    output = console.Output()
    output.print(table(ratios, threshold))
    alone = len(before.keys() ^ after.keys())
    slower = [r for r in ratios if r.verdict(threshold) == "slower"]
    judged = [r for r in slower if r.key[-1] == JUDGED]
    output.print(
        f"{len(ratios)} rows, {len(slower)} slower by more than {threshold:g}, {len(judged)} of them {JUDGED}; "
        f"{alone} rows in one file only.",
        highlight=False,
    )
    return EXIT_SLOWER if judged else 0
