"""Tables of the kernels' times, and the same numbers as JSON.

JSON, schema 1: {"schema": 1, "kind": "kernels", "provenance": {name: text}, "compiler": text, "caches_bytes": {"L1":
n}, "results": [...], "iterations": [...]}. A result is one kernel, precision, size and variant: "kernel", "precision",
"log2_points", "variant" (of `candidates.VARIANTS`), "seconds_median", "seconds_min" (of a call),
"nanoseconds_per_point", "bytes" (read and written by a call), "bandwidth_gb_per_s", "copy_bandwidth_gb_per_s" (of a
copy of as large a working set, timed in turn with it), "gflop_per_s", and where C was timed "over_c" (time over C's,
dimensionless). An iteration of plain FIRE: "precision", "log2_points", "ffts_seconds_median", "ffts_seconds_min",
"rest_seconds_median", "rest_seconds_min". All from medians; GB are 1e9 bytes.
"""

import math
from collections.abc import Iterator
from typing import Any

from rich import box
from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from .candidates import VARIANTS
from .measure import ITERATION

KIND = "kernels"
"""Name of the study."""
FIGURES = ("", "-roofline")
"""Endings of the figures' names."""
SCHEMA = 1
LARGE = 18
"""log2 of the points from which the tables show a kernel."""
GOAL = 1.1
"""Of C's time, in which a kernel should be done."""

Run = dict[str, Any]


def seconds(run: Run, variant: str, which: str = "median") -> float:
    """Time of a call of a variant [s]; NaN where it was not measured. which: median or min."""
    return float(run.get(f"seconds.{variant}.{which}", math.nan))


def bandwidth(run: Run, variant: str) -> float:
    """Bytes moved in a second [1e9 byte/s]."""
    moved = run["bytes.copied"] if variant == "copy" else run["bytes.traffic"]
    return float(moved) / seconds(run, variant) / 1e9


def kernel_runs(study: StudyFile) -> list[Run]:
    """All runs but those of the FIRE iteration."""
    return [run for run in study.runs if run["kernel"] != ITERATION]


def loops(study: StudyFile) -> list[Run]:
    """The runs of kernels with a loop over points: all but FIRE's control."""
    return [run for run in kernel_runs(study) if run["flops"]]


def caches(study: StudyFile) -> dict[str, int]:
    """Bytes of the data caches by name, as far as known."""
    first, prefix = study.runs[0] if study.runs else {}, "bytes.cache."
    return {name.removeprefix(prefix): int(first[name]) for name in first if name.startswith(prefix)}


def to_json(study: StudyFile) -> Run:
    """The file as one JSON-ready object."""
    first: Run = study.runs[0] if study.runs else {}
    return {
        "schema": SCHEMA,
        "kind": KIND,
        "provenance": {k.partition(".")[2]: v for k, v in first.items() if k.startswith("provenance.")},
        "compiler": first.get("compiler", ""),
        "caches_bytes": caches(study),
        "results": [_result(run, v) for run in kernel_runs(study) for v in VARIANTS if seconds(run, v) > 0],
        "iterations": [
            {name: run[name] for name in ("precision", "log2_points")}
            | {f"{p.lower()}_seconds_{w}": seconds(run, p, w) for p in ("FFTs", "rest") for w in ("median", "min")}
            for run in study.runs
            if run["kernel"] == ITERATION
        ],
    }


def _result(run: Run, variant: str) -> Run:
    median = seconds(run, variant)
    return (
        {name: run[name] for name in ("kernel", "precision", "log2_points")}
        | {
            "variant": variant,
            "seconds_median": median,
            "seconds_min": seconds(run, variant, "min"),
            "nanoseconds_per_point": math.ldexp(median, -run["log2_points"]) * 1e9,
            "bytes": int(run["bytes.traffic"]),
            "bandwidth_gb_per_s": bandwidth(run, variant),
            "copy_bandwidth_gb_per_s": bandwidth(run, "copy"),
            "gflop_per_s": run["flops"] / median / 1e9,
        }
        | ({"over_c": over_c(run, variant)} if over_c(run, variant) > 0 else {})
    )


def parts(study: StudyFile) -> Iterator[RenderableType]:
    """A table for each large size, one of the iteration, and sentences on what they come to."""
    sizes = sorted({run["log2_points"] for run in loops(study)})
    for size in [size for size in sizes if size >= LARGE] or sizes[-1:]:
        yield size_table(study, size, explained=size == sizes[-1])
    if any(run["kernel"] == ITERATION for run in study.runs):
        yield iteration_table(study)
    yield from lines(study)


def new_table(headings: tuple[str, ...], title: str, caption: str, gap: int = 1) -> Table:
    """An empty table. gap: further blanks between its columns."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, gap, 0, 0), title=title, caption=caption, caption_justify="left")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


_COLUMNS = (
    "us to roof: the recorded kernel, median of a call; GB/s: bytes read and written; roof: that over the bandwidth of "
    "a copy of as much memory in the same run (reading alone can be faster); /C: time over C's in the same round, "
    "median, of the recorded kernel, by wp.launch, with one thread per element, of the NumPy twin. Ratios "
    "dimensionless."
)


def size_table(study: StudyFile, size: int, explained: bool = True) -> Table:
    """A table of every kernel on 2^size points. explained: whether its caption says what the columns are."""
    table = new_table(
        ("kernel", "bits", "us", "ns/\npoint", "GB/s", "roof", "Warp\n/C", "launch\n/C", "elem.\n/C", "NumPy\n/C"),
        f"Kernels on 2^{size} points, one thread",
        _COLUMNS if explained else "",
    )
    for run in loops(study):
        if run["log2_points"] != size:
            continue
        graph, copy = bandwidth(run, "warp-graph"), bandwidth(run, "copy")
        table.add_row(
            run["kernel"],
            run["precision"].removeprefix("float"),
            microseconds(seconds(run, "warp-graph")),
            f"{math.ldexp(seconds(run, 'warp-graph'), -size) * 1e9:.3f}",
            f"{graph:.0f}",
            f"{graph / copy:.2f}",
            *(_ratio(over_c(run, variant)) for variant in ("warp-graph", "warp-launch", "warp-element", "numpy")),
        )
    return table


def microseconds(value: float) -> str:
    """A time in s, as text in us."""
    return f"{value * 1e6:.0f}" if value > 1e-4 else f"{value * 1e6:.3g}"


def over_c(run: Run, variant: str) -> float:
    """Median over the rounds of the time over C's in the same round; NaN without C."""
    return float(run.get(f"over_c.{variant}", math.nan))


def _ratio(ratio: float) -> str:
    return "-" if math.isnan(ratio) else f"{ratio:.2f}" if ratio < 10 else f"{ratio:.1f}"


def iteration_table(study: StudyFile) -> Table:
    """A table of the parts of plain FIRE's iteration."""
    table = new_table(
        ("bits", "N", "FFTs\nmin (us)", "FFTs\nmedian (us)", "rest\nmin (us)", "rest\nmedian (us)", "rest/FFTs"),
        "An iteration of plain FIRE",
        "FFTs: one pair; rest: everything else; the ratio, of medians, is dimensionless.",
    )
    for run in study.runs:
        if run["kernel"] == ITERATION:
            table.add_row(
                run["precision"].removeprefix("float"),
                f"2^{run['log2_points']}",
                *(microseconds(seconds(run, part, w)) for part in ("FFTs", "rest") for w in ("min", "median")),
                f"{seconds(run, 'rest') / seconds(run, 'FFTs'):.2f}",
            )
    return table


def lines(study: StudyFile) -> Iterator[str]:
    """Sentences on the time of FIRE's control, on the kernels that miss the goal, and on the compiler."""
    control = [run for run in kernel_runs(study) if run["kernel"] == "fire_control"]
    if control:
        run = max(control, key=lambda run: (run["log2_points"] <= LARGE, run["log2_points"]))
        times = [f"{seconds(run, v) * 1e6:.3g} us {w}" for v, w in _WORDS.items()]
        yield f"fire_control, one thread, for 2^{run['log2_points']} points, time of a call: {', '.join(times)}."
    large = [run for run in loops(study) if run["log2_points"] >= LARGE and over_c(run, "warp-graph") > 0]
    late = [run for run in large if over_c(run, "warp-graph") > GOAL]
    if large:
        names = [f"{r['kernel']} {r['precision']} 2^{r['log2_points']} {_ratio(over_c(r, 'warp-graph'))}" for r in late]
        text = f"Within {GOAL} of C at 2^{LARGE} and more points: {len(large) - len(late)} of {len(large)}"
        yield text + (f"; beyond: {', '.join(names)}." if names else ".")
    yield f"C: {study.runs[0]['compiler']}" + (
        "" if any(over_c(run, "c") > 0 for run in loops(study)) else "; left out."
    )


_WORDS = {"warp-graph": "recorded", "warp-launch": "by wp.launch", "numpy": "by NumPy"}
