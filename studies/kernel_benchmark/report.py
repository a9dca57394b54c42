"""Tables of the benchmark's times, and the same numbers as JSON.

JSON, schema 2: {"schema": 2, "kind": "kernels", "complete": true if every task is done, "failures": {task: reason},
"configuration": {...}, "runs": [...]}. The configuration holds the choices ("sizes", "repeats", "variants": hash of
the file of variants) and the source and machine ("identity"). The runs are one flat object for each repetition of
each measurement: "benchmark", "precision", "num_points", "repeat", "core" (the number of the core), "rounds",
"seconds.V" (median time of a call of variant V), "ratio.V" (median over the rounds of that over the time of the
"yardstick" in the same round), "seconds.planning.V" and "measured.V" (of transforms: time to plan, and 1 if that was by
measuring), "ratio.two_cores", "flops", "bytes.traffic", "bytes.working_set", "task" (its hash) and "provenance.*".
Ratios are dimensionless.
"""

import functools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from statistics import median

from rich import box
from rich.console import RenderableType
from rich.table import Table

from ..files.records import plain
from ..files.study_files import StudyFile
from ..terminal.tables import Whole
from .benchmark import PRECISIONS
from .cells import GROUPED, Cell, Key, Run, Scatter, cells, machine, own_names

KIND = "kernels"
"""Name of the study."""
SCHEMA = 2
GOAL = 1.1
"""Of C's time, in which a kernel should be done."""
GOAL_FROM = 2**14
"""Number of points from which that is asked for."""
SHOWN = (2**14, 2**18, 2**22)
"""Numbers of points with a table; all of them where none of these was measured."""


def to_json(study: StudyFile) -> Run:
    """The file as one JSON-ready object."""
    runs = [{n: v for n, v in run.items() if v == v} for run in study.runs]  # without NaN
    about = {"complete": study.complete, "failures": study.failures, "configuration": study.configuration}
    return {"schema": SCHEMA, "kind": KIND} | about | {"runs": plain(runs)}


def parts(study: StudyFile) -> Iterator[RenderableType]:
    """The origin of the times, the tables, and sentences on both."""
    found, about = list(cells(study.runs).values()), machine(study)
    yield from origin(study)
    scatter, grouped = Scatter(found, "warp"), [cell for cell in found if cell.benchmark.group in GROUPED]
    shown = [(group, size) for group in GROUPED for size in _shown(grouped, group)]
    for group, size in shown:
        own = [cell for cell in grouped if (cell.benchmark.group, cell.key.num_points) == (group, size)]
        yield size_table(own, group, size, scatter, explained=(group, size) == shown[-1])
    if about:
        yield kernel_table(found, about)
    yield from own_tables(grouped, functools.cache(lambda variant: Scatter(found, variant)))
    for name in dict.fromkeys(cell.key.benchmark for cell in found if cell.benchmark.group == "transforms"):
        yield transform_table([cell for cell in found if cell.key.benchmark == name], name)
    yield from memory_table([cell for cell in found if cell.benchmark.group == "roofs"], about)
    yield from sentences(found, about)


def _shown(found: list[Cell], group: str) -> list[int]:
    """Numbers of points of a group that have a table."""
    sizes = sorted({cell.key.num_points for cell in found if cell.benchmark.group == group})
    return [size for size in SHOWN if size in sizes] or sizes


def origin(study: StudyFile) -> Iterator[str]:
    """The source, the machine, and whether the tree had changes."""
    identity, some = study.configuration["identity"], study.runs[0]
    commit = str(some.get("provenance.commit", "none"))
    dirty = ", with changes that are not committed" if commit.endswith("+dirty") else ""
    yield f"Source {identity['source']}, commit {commit.removesuffix('+dirty')}{dirty}; chunks of {identity['chunk']}."
    yield f"{identity['processor']}, {identity['caches']}, {identity['instructions']}; core {some['core']}."
    yield f"Flags of the kernels: {identity['flags']}"
    yield f"C: {identity['compiler']}"


def new_table(headings: Sequence[str], title: str, caption: str) -> Table:
    """An empty table."""
    table = Whole(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), title=title, caption=caption, caption_justify="left")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


_COLUMNS = (
    "us: median of a call of the recorded kernels, as the program runs them, one of many in a graph; roof: time of a "
    "loop in C that moves the same memory, over that; /C: time over C's in the same round, with its 95 % interval, of "
    "Warp, of one thread for each point (elem.), of the reference kernels; 2 cores: time with another core at the same "
    "work over that alone. Ratios dimensionless."
)
_SHARE = " FFT share: of the transforms, which FFTW plans by estimate without wisdom."


def size_table(found: list[Cell], group: str, size: int, scatter: Scatter, explained: bool) -> Table:
    """A table of a group of benchmarks on one number of points.

    scatter: of the ratios to C; explained: whether its caption explains the columns.
    """
    alone, last = group == "kernels", ["FFT\nshare"] if group == "iterations" else []
    headings = ["", "real", "us", "GB/s", *(["roof"] if alone else []), "Warp\n/C", "+-"]
    headings += [*(["elem.\n/C"] if alone else []), "NumPy\n/C", "2\ncores", *last]
    caption = _COLUMNS + (_SHARE if last else "") if explained else ""
    table = new_table(headings, f"{group.capitalize()} on {power(size)} points", caption)
    for cell in found:
        row = [cell.key.benchmark, cell.key.precision.removeprefix("float"), microseconds(cell.seconds("warp"))]
        row.append(number(cell.bandwidth("warp"), 0))
        row += [number(cell.seconds("roof") / cell.seconds("warp"))] if alone else []
        row += [number(cell.ratio("warp")), number(scatter.half_width(cell, "warp"))]
        row += [number(cell.ratio("element"), 1)] if alone else []
        row += [number(cell.ratio("numpy"), 1), number(cell.value("ratio.two_cores"))]
        if group == "iterations":
            row.append(number(cell.seconds("transforms") / cell.seconds("warp")))
        table.add_row(*row)
    return table


_KERNEL = (
    "flop, bytes: for each point; bits: widest vectors in the object code; launch: time on 2^10 points beyond C's, "
    "as one of many launches in a recorded graph (us)."
)


def kernel_table(found: list[Cell], about: Run) -> Table:
    """A table of the properties of a kernel, whatever the number of points, for both precisions."""
    pairs = [f"{what}\n{p.removeprefix('float')}" for what in ("bytes", "bits", "launch") for p in PRECISIONS]
    table = new_table(["", "flop", *pairs], "Kernels", _KERNEL)
    own = {cell.key: cell for cell in found if cell.benchmark.group == "kernels"}
    for name in dict.fromkeys(key.benchmark for key in own):
        some = [next((cell for key, cell in own.items() if key[:2] == (name, p)), None) for p in PRECISIONS]
        small = [own.get(Key(name, p, 2**10)) for p in PRECISIONS]
        flops = max(cell.value("flops") / cell.key.num_points for cell in some if cell)
        row = [cell.value("bytes.traffic") / cell.key.num_points if cell else math.nan for cell in some]
        row += [float(about.get(f"width.{name}.{p}", math.nan)) for p in PRECISIONS]
        launches = [(cell.seconds("warp") - cell.seconds("c")) * 1e6 if cell else math.nan for cell in small]
        table.add_row(name, number(flops, 0), *(number(value, 0) for value in row), *map(number, launches))
    return table


def own_tables(found: list[Cell], scatters: Callable[[str], Scatter]) -> Iterator[Table]:
    """Tables of users' variants beside Warp's ratio to C, so many columns in each that it stays narrow.

    scatters: of the ratios to C, by variant.
    """
    own = own_names(found)
    for some in (own[i : i + _OWN_COLUMNS] for i in range(0, len(own), _OWN_COLUMNS)):
        columns = [column for v in some for column in (v.replace("-", "\n").replace("_", "\n") + "\n/C", "+-")]
        table = new_table(["", "real", "N", "Warp\n/C", "+-", *columns], "Variants of your own", _OWN)
        for cell in [cell for cell in found if set(some) & set(cell.variants)]:
            row = [cell.key.benchmark, cell.key.precision.removeprefix("float"), power(cell.key.num_points)]
            for v in ("warp", *some):
                row += [number(cell.ratio(v)), number(scatters(v).half_width(cell, v))]
            table.add_row(*row)
        yield table


_OWN_COLUMNS = 2
_OWN = "Times over C's in the same round, with their 95 % intervals (dimensionless)."


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
    "measured, or found patiently, in 10 s each at most, estimated plans on 2 threads, other libraries; four step: the "
    "program's own, with its multiplication in between; plan: time to plan (in brackets: from wisdom of an earlier "
    "run). Ratios dimensionless."
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
    table.padding = (0, 0, 0, 0)  # every library that is installed is a column
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
    """The rates of C's loops over N, and of the processor's multiply-adds."""
    if not found:
        return
    names = list(dict.fromkeys(cell.key.benchmark for cell in found))
    by_key = {cell.key: cell for cell in found}
    rates = [f"{rate / 1e9:.0f} in {p}" for p in PRECISIONS if (rate := about.get(f"peak.{p}", math.nan)) > 0]
    caption = "Reading alone to changing in place, one core."
    if rates:
        caption += f" Multiply-adds in registers: {', '.join(rates)} [1e9 flop/s]."
    table = new_table(["N", "real", *names], "Memory, C's loops [1e9 byte/s]", caption)
    for size in sorted({cell.key.num_points for cell in found}):
        for precision in PRECISIONS:
            rows = [by_key[Key(name, precision, size)].bandwidth("c") for name in names]
            table.add_row(power(size), precision.removeprefix("float"), *(number(rate, 0) for rate in rows))
    yield table


def sentences(found: Iterable[Cell], about: Run) -> Iterator[str]:
    """On launches, compiling, and on kernels that miss the goal."""
    cells_ = list(found)
    scatter = Scatter(cells_, "warp")
    launch = launch_seconds(cells_)
    if launch > 0:
        yield f"A kernel's launch inside a recorded sequence takes {launch * 1e6:.2f} us (median of the kernels)."
    if "seconds.compile.cold" in about:
        cold, warm = (about[f"seconds.compile.{name}"] for name in ("cold", "warm"))
        yield f"Compiling all kernels takes {cold:.1f} s once, loading them {warm:.2f} s."
    judged = [c for c in cells_ if c.benchmark.group in ("kernels", "sequences") and c.key.num_points >= GOAL_FROM]
    judged = [cell for cell in judged if cell.ratio("warp") > 0 and cell.runs[0]["yardstick"] == "c"]
    late = [cell for cell in judged if cell.ratio("warp") > GOAL]
    if judged:
        yield f"Within {GOAL} of C on {power(GOAL_FROM)} points and more: {len(judged) - len(late)} of {len(judged)}."
    short = [cell for cell in late if not _slow_code(cell, launch)]
    if short:
        yield f"Beyond only for the time of their launches: {_listed(short, scatter)}."
    if len(late) > len(short):
        yield f"Beyond for their code: {_listed([cell for cell in late if cell not in short], scatter)}."


def launch_seconds(found: Iterable[Cell]) -> float:
    """The time of a launch beside its work [s]: of the kernels, by how much Warp is slower than C on the fewest points.

    NaN unless 2^10 points were measured, where the work is little.
    """
    smallest = [c for c in found if c.benchmark.group == "kernels" and c.key.num_points == 2**10 and c.ratio("c") > 0]
    return median(c.seconds("warp") - c.seconds("c") for c in smallest) if smallest else math.nan


def _slow_code(cell: Cell, launch: float) -> bool:
    """Whether a benchmark would miss the goal without the time of its launches."""
    launches = len(cell.benchmark.parts) or 1
    work = cell.seconds("warp") - (0.0 if math.isnan(launch) else launches * launch)
    return cell.ratio("warp") * work / cell.seconds("warp") > GOAL


def _listed(found: Iterable[Cell], scatter: Scatter) -> str:
    return ", ".join(
        f"{c.key.benchmark} {c.key.precision} {power(c.key.num_points)} {c.ratio('warp'):.2f} +- "
        f"{scatter.half_width(c, 'warp'):.2f}"
        for c in found
    )
