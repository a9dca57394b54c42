"""Write into the pages text from elsewhere: stored results; help texts, signatures and docstrings.

    python docs/fill_in.py            # fills in every page anew
    python docs/fill_in.py --check    # names the pages that disagree, exit status 1

A page says where a text from stored results is to stand, and which one, by two lines around it:

    <!-- report: peers -->  ...  <!-- end -->

One line, `<!-- help -->` or `<!-- names -->`, says where the site has texts of the program itself (`made`).

`report: NAME` is the report of a study on its results in studies/results; with patterns behind the name, parted by
bars, only the tables whose titles match one of them, and for `sentences` all but tables; NAME=FILE is its report on
FILE.h5 there. `statements: NAME` are the statements of others beside those of the study paper or pressure, `compare`
is a small table beside other programs. `help` are the help texts of all commands, `names` the public Python names.
"""

import dataclasses
import enum
import functools
import importlib
import inspect
import io
import math
import os
import re
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from linecontact.studies.command_line import main
from linecontact.studies.files import study_files
from linecontact.studies.paper import markdown
from linecontact.studies.paper import statements as paper
from linecontact.studies.peers import areas
from linecontact.studies.peers import report as peers
from linecontact.studies.peers.solvers import OURS
from linecontact.studies.pressure.findings import findings
from linecontact.studies.runner import study
from linecontact.studies.terminal import declarations
from rich.console import Console

ROOT = Path(__file__).parent.parent
RESULTS = ROOT / "studies" / "results"
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"(<!-- (report|statements|compare)(?:: ([^>]*?))? -->\n).*?(<!-- end -->)", re.DOTALL)
MADE = re.compile(r"<!-- (help|names) -->\n")
WIDTH = 80


def report(words: str) -> str:
    """A study's report on its stored results, or the parts of it that were asked for."""
    name, _, wanted = words.partition(" ")
    parts = [part for part in _parts(name) if _chosen(part, wanted)]
    if not parts:
        raise ValueError(f"report is {words!r}; allowed: a study with stored results, and titles of its tables")
    return "```\n" + "\n\n".join(_text(part) for part in parts) + "\n```\n"


@functools.cache
def _parts(name: str) -> list[object]:
    """All parts of a study's report, or with "study=other" of that on another one's results."""
    name, _, other = name.partition("=")
    found = study.find(name)
    kinds = [other] if other else [name, *(plan.kind for plan in found.planned(found.options()))]
    kinds += [areas.KIND] if name == "peers" else []  # which is planned only where ASPHER is installed
    paths = {kind: RESULTS / f"{kind}.h5" for kind in kinds}
    return list(found.report({kind: _stored(kind) for kind, path in paths.items() if path.exists()}, RESULTS))


@functools.cache
def _stored(kind: str) -> study_files.StudyFile:
    return study_files.load_study(RESULTS / f"{kind}.h5")


def _chosen(part: object, wanted: str) -> bool:
    title = "sentences" if isinstance(part, str) else str(getattr(part, "title", ""))
    return not wanted or any(fnmatch(title, pattern) for pattern in wanted.split("|"))


def _text(part: object) -> str:
    if isinstance(part, str):
        return textwrap.fill(part, WIDTH, break_long_words=False, break_on_hyphens=False)
    output = io.StringIO()
    Console(width=WIDTH, file=output, force_terminal=False, highlight=False, markup=False).print(part)
    return "\n".join(line.rstrip() for line in output.getvalue().rstrip().splitlines())


def command_help() -> str:
    """The output of `linecontact --help` and of `linecontact COMMAND --help`, each under its heading."""
    return _help() + "".join(f"\n## {command}\n\n{_help(command)}" for command in main.COMMANDS)


def _help(*command: str) -> str:
    plain = os.environ | {"COLUMNS": str(WIDTH), "NO_COLOR": "1", "TERM": "dumb"}
    words = [sys.executable, "-m", "linecontact.studies", *command, "--help"]
    said = subprocess.run(words, capture_output=True, text=True, check=True, env=plain).stdout
    return "```\n" + said.rstrip() + "\n```\n"


def names() -> str:
    """The public names: signature, docstring, and of a class its members."""
    package = importlib.import_module("linecontact")
    return "\n".join(_name(name, getattr(package, name)) for name in package.__all__ if not name.startswith("__"))


def _name(name: str, thing: Any) -> str:
    fields = dataclasses.fields(thing) if dataclasses.is_dataclass(thing) else ()
    declared = declarations.read(f"{thing.__module__}:{thing.__qualname__}") if fields else None
    if isinstance(thing, enum.EnumType):
        given, members = "", [f"| `{member.name}` | '{member.value}' |" for member in thing]
    elif declared:
        named = sorted({*inspect.signature(thing).parameters} - {f.name for f in fields})  # which are not kept
        given = f"({', '.join([*(f.name + _default(f) for f in fields if f.init), *['*'][: len(named)], *named])})"
        members = [f"| `{field}` | {_cell(said)} |" for field, said in declared.fields.items()]
        members += [f"| `{member}` | {_cell(inspect.getdoc(value))} |" for member, value in _methods(thing)]
    else:
        given, members = _signature(thing), []
    text = declared.text if declared else inspect.getdoc(thing)
    table = ["", "| name | what |", "|---|---|", *members] if members else []
    return "\n".join([f"## {name}", "", f"```text\n{name}{given}\n```", "", f"```text\n{text}\n```", *table, ""])


def _default(field: "dataclasses.Field[Any]") -> str:
    if field.default_factory is not dataclasses.MISSING:
        return f"={type(field.default_factory()).__name__}()"
    return "" if field.default is dataclasses.MISSING else f"={field.default!r}"


def _methods(thing: type) -> Iterator[tuple[str, Any]]:
    """The methods and properties of a class, in the order of its source, with its bases.

    Those that only describe the members that a class must have are left out.
    """
    bases = [base for base in thing.__mro__ if base is thing or not getattr(base, "__abstractmethods__", ())]
    members = {name: value for base in reversed(bases) for name, value in vars(base).items()}
    for name, value in members.items():
        inner = getattr(value, "func", value)
        if not name.startswith("_") and inspect.getdoc(value) and not isinstance(value, str | int | float | dict):
            called = inspect.isfunction(value) or isinstance(value, classmethod)
            yield name + (_signature(getattr(thing, name)) if called else ""), inner


def _signature(thing: Any) -> str:
    found = inspect.signature(thing)
    plain = [p.replace(annotation=p.empty) for p in found.parameters.values() if p.name != "self"]
    return str(found.replace(parameters=plain, return_annotation=found.empty))


def _cell(text: str | None) -> str:
    return " ".join((text or "").replace("|", "\\|").split())


def statements(study_name: str) -> str:
    """The table of the statements of others beside the measurements, by the study paper or the study pressure."""
    kinds = {"paper": ("sharp", "hertz", "blunt", "rough"), "pressure": ("pressure",)}[study_name]
    files = {kind: _stored(kind) for kind in kinds}
    found = findings(files["pressure"]) if study_name == "pressure" else paper.statements(files)
    rows = [(s.text, s.published, s.measured, s.verdict) for s in found]
    return markdown.table(("statement", "published", "measured", "verdict"), rows) + "\n"


def compare(_: str) -> str:
    """A small table of times and errors beside other programs."""
    lines = peers.comparisons(_stored("peers"))
    n = max(c.ours["scene.num_points"] for c in lines)
    solvers = dict.fromkeys(name for c in lines for name in c.solvers)
    rows = []
    wanted = [("Hertz", math.inf), ("H=0.8", math.inf), ("H=0.8", 0.01)]
    largest = [c for c in lines if c.ours["scene.num_points"] == n]
    for c in (c for c in largest if (c.ours["name"], c.ours["scene.thickness"]) in wanted):
        depth = "half-space" if math.isinf(c.ours["scene.thickness"]) else f"d = {c.ours['scene.thickness']:g} L"
        times = [c.peers.get(name, c.ours)["seconds.total"] for name in solvers]
        kind = c.ours["name"] if c.ours["name"] == "Hertz" else f"rough, {c.ours['name']}"
        rows.append([f"{kind}, {depth}: time [s]", *(f"{time:.2g}" for time in times), "-"])
    hertz = next(c for c in largest if c.ours["name"] == "Hertz")
    off = [f"{abs(hertz.peers[name]['spacings_off.counted']):.1f}" for name in hertz.peers]
    best = f"{abs(hertz.ours['spacings_off.subgrid']):.0e}"
    rows.append(["Hertz, half-space: error of a_r [grid spacings]", best, *off, "-"])
    rows += _time_of_a_point(len(hertz.peers))
    return markdown.table((f"2^{round(math.log2(n))} points, one thread", *solvers, "ASPHER (areas)"), rows) + "\n"


def _time_of_a_point(others: int) -> list[list[str]]:
    known = (RESULTS / f"{areas.KIND}.h5").exists()
    found = peers.times_of_a_point(_stored(areas.KIND)) if known else {}
    for n, times in found.items():
        theirs = [times[name] for name in areas.PRECISIONS if name in times]
        if theirs and OURS in times:
            label = f"rough, 8 points to the shortest wave, half-space: time of a point at 2^{round(math.log2(n))} [us]"
            return [[label, f"{times[OURS]:.2g}", *["-"] * others, f"{min(theirs):.2g}"]]
    return []


SOURCES: dict[str, Callable[[str], str]] = {
    "report": report,
    "statements": statements,
    "compare": compare,
}


def filled(text: str) -> str:
    """A page's text with everything from stored results made anew."""
    return BLOCK.sub(lambda found: found[1] + SOURCES[found[2]](found[3] or "") + found[4], text)


def made(text: str) -> str:
    """A page's text with help texts and names, as the site has it."""
    return MADE.sub(lambda found: {"help": command_help, "names": names}[found[1]](), text)


def _main() -> int:
    """Fill in all pages, or check them; the exit status."""
    stale = [page for page in PAGES if page.read_text() != filled(page.read_text())]
    for page in stale:
        if "--check" in sys.argv:
            print(f"{page.relative_to(ROOT)} differs from its sources; python docs/fill_in.py writes it anew")
        else:
            page.write_text(filled(page.read_text()))
            print(page.relative_to(ROOT))
    return 1 if stale and "--check" in sys.argv else 0


if __name__ == "__main__":
    sys.exit(_main())
