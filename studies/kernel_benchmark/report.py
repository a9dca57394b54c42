"""Tables of the benchmark's times, and the same numbers as JSON.

JSON, schema 2: {"schema": 2, "kind": "kernels", "configuration": {...}, "runs": [...]}, the configuration with what the
times depend on under "identity", the runs with one flat object for each repetition of each measurement: "benchmark",
"precision", "num_points", "repeat", "core" (the number of the core), "rounds", "seconds.V" (median time of a call of
variant V), "ratio.V" (median over the rounds of that over the time of the "yardstick" in the same round),
"seconds.planning.V" and "measured.V" (of transforms: time to plan, and 1 if that was by measuring), "seconds.launch",
"ratio.two_cores", "flops", "bytes.traffic", "bytes.working_set", and "provenance.*". Ratios are dimensionless.
"""

import math
from collections.abc import Iterable, Iterator, Sequence

from rich import box
from rich.console import RenderableType
from rich.table import Table

from ..files.records import plain
from ..files.study_files import StudyFile
from .benchmark import PRECISIONS
from .cells import Cell, Key, Run, Scatter, cells, machine

KIND = "kernels"
"""Name of the study."""
FIGURES = ("", "-roofline", "-transforms")
"""Endings of the figures' names."""
SCHEMA = 2
GOAL = 1.1
"""Of C's time, in which a kernel should be done."""
GOAL_FROM = 2**14
"""Number of points from which that is asked for."""
SHOWN = (2**14, 2**18, 2**22)
"""Numbers of points with a table; all of them where none of these was measured."""
SHIPPED = ("warp", "c", "element", "numpy", "copy", "roof", "transforms")
"""Variants with columns of their own."""


def to_json(study: StudyFile) -> Run:
    """The file as one JSON-ready object."""
    runs = [{n: v for n, v in run.items() if v == v} for run in study.runs]  # without NaN
    return {"schema": SCHEMA, "kind": KIND, "configuration": study.configuration, "runs": plain(runs)}


def parts(study: StudyFile) -> Iterator[RenderableType]:
    """What the times are of, the tables, and sentences on what they come to."""
    found, about = list(cells(study.runs).values()), machine(study)
    yield from origin(study)
    for group in ("kernels", "sequences", "iterations"):
        own = [cell for cell in found if cell.benchmark.group == group]
        sizes = sorted({cell.key.num_points for cell in own})
        for size in [size for size in SHOWN if size in sizes] or sizes:
            yield size_table([cell for cell in own if cell.key.num_points == size], group, size, Scatter(found, "warp"))
    for name in dict.fromkeys(cell.key.benchmark for cell in found if cell.benchmark.group == "transforms"):
        yield transform_table([cell for cell in found if cell.key.benchmark == name], name)
    yield from memory_table([cell for cell in found if cell.benchmark.group == "roofs"], about)
    yield from sentences(found, about)


def origin(study: StudyFile) -> Iterator[str]:
    """What was measured, on what, and whether the tree had changes."""
    identity, some = study.configuration["identity"], study.runs[0]
    commit = str(some.get("provenance.commit", "none"))
    dirty = ", with changes that are not committed" if commit.endswith("+dirty") else ""
    yield f"Source {identity['source']}, commit {commit.removesuffix('+dirty')}{dirty}; chunks of {identity['chunk']}."
    yield f"{identity['processor']}, {identity['caches']}, {identity['instructions']}; core {some['core']}."
    yield f"Flags of the kernels: {identity['flags']}"
    yield f"C: {identity['compiler']}"


def new_table(headings: Sequence[str], title: str, caption: str) -> Table:
    """An empty table."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), title=title, caption=caption, caption_justify="left")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


_COLUMNS = (
    "us: median of a call of the recorded kernels, as the program runs them, one of many in a graph; roof: time of a "
    "loop in C that moves the same memory, over that; /C: time over C's in the same round, with its 95 % interval, of "
    "Warp, of one thread for each point (elem.), of the NumPy twins; 2 cores: time with another core at the same work "
    "over that alone; bits: widest vectors in the object code. Ratios dimensionless."
)


def size_table(found: list[Cell], group: str, size: int, scatter: Scatter) -> Table:
    """A table of a group of benchmarks on one number of points. scatter: of the ratios to C."""
    own = list(dict.fromkeys(v for cell in found for v in cell.variants if v not in SHIPPED))
    alone = group == "kernels"
    headings = [
        "",
        "real",
        "us",
        "GB/s",
        *(["roof"] if alone else []),
        "Warp\n/C",
        "+-",
        *(["elem.\n/C"] if alone else []),
    ]
    headings += [
        "NumPy\n/C",
        "2\ncores",
        *(["FFT\nshare"] if group == "iterations" else []),
        *(f"{v}\n/C" for v in own),
    ]
    table = new_table(headings, f"{group.capitalize()} on {power(size)} points", _COLUMNS)
    for cell in found:
        row = [cell.key.benchmark, cell.key.precision.removeprefix("float"), microseconds(cell.seconds("warp"))]
        row.append(number(cell.bandwidth("warp"), 0))
        row += [number(cell.seconds("roof") / cell.seconds("warp"))] if alone else []
        row += [number(cell.ratio("warp")), number(scatter.half_width(cell, "warp"))]
        row += [number(cell.ratio("element"), 1)] if alone else []
        row += [number(cell.ratio("numpy"), 1), number(cell.value("ratio.two_cores"))]
        if group == "iterations":
            row.append(number(cell.seconds("transforms") / cell.seconds("warp")))
        table.add_row(*row, *(number(cell.ratio(v)) for v in own))
    return table


def number(value: float, digits: int = 2) -> str:
    """A number as text; a dash where there is none."""
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def power(count: int) -> str:
    """A count as a power of two, where it is one."""
    return f"2^{count.bit_length() - 1}" if count & (count - 1) == 0 else str(count)


def microseconds(value: float) -> str:
    """A time in s, as text in us."""
    return "-" if math.isnan(value) else f"{value * 1e6:.0f}" if value > 1e-4 else f"{value * 1e6:.3g}"


_TRANSFORMS = (
    "us: FFTW's plans by estimate, made without wisdom; the others over that in the same round: plans that FFTW "
    "measured, or found patiently, in 20 s each at most, estimated plans on 2 threads, other libraries; plan: time to "
    "plan (in brackets: from wisdom of an earlier run). Ratios dimensionless."
)


def transform_table(found: list[Cell], name: str) -> Table:
    """A table of one transform over the numbers of points."""
    variants = [v for v in dict.fromkeys(v for cell in found for v in cell.variants) if v != "estimate"]
    efforts = [v for v in ("measure", "patient") if v in variants]
    headings = [
        "N",
        "real",
        "estimate\n(us)",
        *(v.replace("-", "\n") for v in variants),
        *(f"plan (s)\n{v}" for v in efforts),
    ]
    table = new_table(headings, name.replace("_", " "), _TRANSFORMS)
    for cell in found:
        planning = []
        for effort in efforts:
            text = number(cell.runs[0].get(f"seconds.planning.{effort}", math.nan), 1)
            planning.append(text if cell.runs[0].get(f"measured.{effort}") else f"({text})")
        row = (
            power(cell.key.num_points),
            cell.key.precision.removeprefix("float"),
            microseconds(cell.seconds("estimate")),
        )
        table.add_row(*row, *(number(cell.ratio(v)) for v in variants), *planning)
    return table


def memory_table(found: list[Cell], about: Run) -> Iterator[RenderableType]:
    """What the memory gives to C's loops over N, and the processor to multiply-adds."""
    if not found:
        return
    names = list(dict.fromkeys(cell.key.benchmark for cell in found))
    by_key = {cell.key: cell for cell in found}
    rates = [f"{about.get(f'peak.{p}', math.nan) / 1e9:.0f} in {p}" for p in PRECISIONS]
    caption = (
        f"Reading alone to changing in place, one core. Multiply-adds in registers: {', '.join(rates)} [1e9 flop/s]."
    )
    table = new_table(["N", "real", *names], "Memory, C's loops [1e9 byte/s]", caption)
    for size in sorted({cell.key.num_points for cell in found}):
        for precision in PRECISIONS:
            rows = [by_key[Key(name, precision, size)].bandwidth("c") for name in names]
            table.add_row(power(size), precision.removeprefix("float"), *(number(rate, 0) for rate in rows))
    yield table


def sentences(found: Iterable[Cell], about: Run) -> Iterator[str]:
    """On launches, compiling, the widths of vectors, and on what misses the goal."""
    cells_ = list(found)
    launches = sorted(v for cell in cells_ if (v := cell.value("seconds.launch")) > 0)
    if launches:
        yield f"A recorded sequence costs {launches[len(launches) // 2] * 1e6:.2g} us to start (median)."
    if "seconds.compile.cold" in about:
        cold, warm = (about[f"seconds.compile.{name}"] for name in ("cold", "warm"))
        yield f"Compiling all kernels takes {cold:.1f} s once, loading them {warm:.2f} s."
    widths = {
        name.removeprefix("width."): int(bits)
        for name, bits in about.items()
        if name.startswith("width.") and bits == bits
    }
    for bits in sorted(set(widths.values()), reverse=True):
        own = [name for name, value in widths.items() if value == bits]
        text = f"all but {len(widths) - len(own)}" if len(own) > len(widths) / 2 else ", ".join(own)
        yield f"Vectors of {bits} bits: {text}." if bits else f"No vectors: {text}."
    judged = [c for c in cells_ if c.benchmark.group in ("kernels", "sequences") and c.key.num_points >= GOAL_FROM]
    judged = [cell for cell in judged if cell.ratio("warp") > 0 and cell.runs[0]["yardstick"] == "c"]
    late = [cell for cell in judged if cell.ratio("warp") > GOAL]
    if judged:
        names = [f"{c.key.benchmark} {c.key.precision} {power(c.key.num_points)} {c.ratio('warp'):.2f}" for c in late]
        text = f"Within {GOAL} of C on {power(GOAL_FROM)} points and more: {len(judged) - len(late)} of {len(judged)}"
        yield text + (f"; beyond: {', '.join(names)}." if names else ".")
