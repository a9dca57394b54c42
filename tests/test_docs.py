"""The pages: what they show is what is stored, their code runs, nothing is said twice, links lead somewhere."""

import contextlib
import importlib.util
import io
import json
import re
import shlex
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest
from linecontact.studies.command_line import main
from running import PATIENCE, begin, wait_until
from test_explore_server import Server
from test_imports import IMPORTS

pytestmark = pytest.mark.once

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
PRINTED = ROOT / "docs" / "results.md"
TUTORIAL = ROOT / "docs" / "tutorial.md"
GALLERY = ROOT / "docs" / "gallery.md"
MOST_LINES = 110
LONGEST_RUN = 10
"""So many words in a row stand in one page only."""


@pytest.fixture(scope="module")
def fill_in():
    spec = importlib.util.spec_from_file_location("fill_in", ROOT / "docs" / "fill_in.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def name(page):
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_what_a_page_shows_is_what_is_stored(page, fill_in):
    text = page.read_text()
    assert fill_in.filled(text) == text, f"python docs/fill_in.py writes {name(page)} anew"
    assert text.count("<!-- end -->") == len(fill_in.BLOCK.findall(text))


def test_a_page_that_disagrees_is_written_anew(fill_in):
    text = "before\n<!-- report: soak -->\nold\n<!-- end -->\nafter"
    filled = fill_in.filled(text)
    assert "random scenes" in filled
    assert "old" not in filled
    assert filled.startswith("before\n<!-- report: soak -->\n")
    assert filled.endswith("<!-- end -->\nafter")
    with pytest.raises(ValueError, match="report is 'soak nothing'; allowed"):
        fill_in.filled(text.replace("soak", "soak nothing"))


COARSE = "--num-points 2^11 --workers 1"
SMOOTH = f"--cut-off-ratio 0.125 {COARSE}"
POOR = f"--standard-error 0.1 {SMOOTH}"
FEW = f"--points 3 {COARSE}"
LITTLE = "--size 2^12 --repeats 2"
EXAMPLE = "docs/examples/kernel_variants.py"

MORE = {
    "linecontact study hertz --folder new": "--quick --workers 1",
    "linecontact curve --over poisson_ratio --from 0 --to 0.5 --thickness 0.01": FEW,
    "linecontact curve --over thickness --from 0.001 --to 1 --pressure 2e-3": FEW,
    "linecontact curve --over approach --from 1e-4 --to 1e-2": FEW,
    "linecontact curve --over seed --from 0 --to 9 --profile rough --hurst 0.8 --pressure 0.01": SMOOTH,
    "linecontact curve --profile rough --hurst 0.8 --thickness 0.01": f"--points 3 {SMOOTH}",
    "linecontact ensemble --hurst 0.8 --thickness 0.01 --standard-error 0.01 --folder thin": POOR,
    "linecontact ensemble --profile rough --hurst 0.8 --pressure 0.01 --standard-error 0.002": POOR,
    "linecontact study kernels": f"--kernel count_below {LITTLE}",
    "linecontact study kernels --kernel fire_step --size 2^18": LITTLE,
    "linecontact study kernels --variants mine.py --kernel fire_step --size 2^18": LITTLE,
    "linecontact study kernels --kernel fire_step --folder before": LITTLE,
    "linecontact study kernels --kernel fire_step --folder after": LITTLE,
    f"linecontact study kernels --variants {EXAMPLE} --kernel restrict_to_free --size 2^18": LITTLE,
}
"""Commands that would take longer than a second or two, and options with which they do the same in little, further ones
or in the place of theirs."""

SLOW = {
    "linecontact study kernels --kernel transforms": LITTLE,
    "linecontact study rough --standard-error 0.01 --folder results/rough-0.01": "--quick --standard-error 0.5",
}
"""Those that take half a minute and more even so: pytest -m slow."""

SERVER = "linecontact explore"
CLUSTER = ("dask scheduler", "dask worker tcp://", "linecontact study rough --scheduler tcp://")
"""How the lines begin of programs that do not end by themselves, and of the one that needs them."""

ELSEWHERE = {
    "python3 -m venv .venv && .venv/bin/pip install -q -e . && .venv/bin/linecontact study hertz": "test_project.py",
    "python3 -m venv .venv && .venv/bin/pip install -q -e '.[test,docs]' && .venv/bin/python -m pytest -n 2 "
    "--dist loadfile": "these tests, by .ci/run",
    "python3 -m venv .venv-lowest && .venv-lowest/bin/pip install -q -e '.[test]' -c tests/lowest.txt && "
    ".venv-lowest/bin/python -m pytest -n 2 --dist loadfile -m 'not slow and not once'": "these tests, by .ci/run",
    "pip install -e '.[explore]'": "by the extra named test",
    "python docs/fill_in.py": "test_what_a_page_shows_is_what_is_stored",
    ".venv/bin/sphinx-build -W docs docs/build": "the last test of this file",
}
"""Lines that install, test, or write pages, and where they are run."""

CHANGED = {
    "docs/ensembles.md": {"rough.Options()": "rough.Options(quick=True)", "(plan.tasks,": "(plan.tasks[:8],"},
}
"""What of a page's Python would take minutes, and what is run instead."""

VARIANT = """from linecontact.studies.kernel_benchmark.variants import recompiled
recompiled("fire_step", "mine", chunk=512)
"""
NEEDED = {
    "CONTRIBUTING.md": {"studies/results/hertz.h5": "studies/results/hertz.h5"},
    "docs/results.md": {"studies/results/hertz.h5": "studies/results/hertz.h5"},
    "docs/kernels.md": {"mine.py": VARIANT, EXAMPLE: EXAMPLE},
}
"""Files that a page speaks of and does not make itself, and what they are copies of, or their text."""

SCANS = ("scan.csv", "dektak-1.csv")
"""Copies of the file that the tutorial makes."""

MPI = """from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context


class MPIPoolExecutor(ProcessPoolExecutor):
    def __init__(self):
        super().__init__(2, get_context("spawn"))
"""
"""Stands in for mpi4py.futures, whose executor has the same methods."""

RUNNER = """
import contextlib, json, shlex, subprocess, sys

from linecontact.studies.command_line import main

for language, text in json.load(sys.stdin):
    if language == "python":
        exec(compile(text, "a block of the page", "exec"), {"__name__": "__main__"})
    elif text.startswith("linecontact "):
        command, _, output = text.partition(" > ")
        with contextlib.redirect_stdout(open(output, "w", newline="")) if output else contextlib.nullcontext():
            status = main.main(shlex.split(command)[1:])
        if status and "--compare" not in command:  # with 3 it says that one of two short measurements was slower
            sys.exit(f"status {status}: {text}")
    else:
        subprocess.run(["bash", "-ec", text], check=True)
"""
"""Does what it reads: blocks of Python, each by itself, and commands, all in one process."""


def hand_written(page, fill_in):
    return fill_in.BLOCK.sub("", page.read_text())


def blocks(page, fill_in):
    """Language and text of every block of code that is written by hand, in the order of the page."""
    return re.findall(r"^```(\S*).*?\n(.*?)^```$", hand_written(page, fill_in), re.DOTALL | re.MULTILINE)


def lines(block):
    """The commands of a block, without comments."""
    for line in block.replace("\\\n", " ").splitlines():
        if words := " ".join(re.sub(r"(^|\s)# .*", "", line).split()):
            yield words


def command_lines(page, fill_in):
    return [line for language, block in blocks(page, fill_in) if language == "sh" for line in lines(block)]


def with_options(line, options):
    """A command with these options, in the place of its own of the same names."""
    words = shlex.split(line)
    for name_of_option, *value in re.findall(r"(--\S+)(?: (?!--)(\S+))?", options):
        if name_of_option in words:
            at = words.index(name_of_option)
            del words[at : at + 2]
        words += [name_of_option, *filter(None, value)]
    return shlex.join(words)


def runs_by_itself(line):
    return line not in SLOW and line not in ELSEWHERE and not line.startswith((SERVER, *CLUSTER))


def steps(page, fill_in):
    """What is run of a page in one process: languages and texts."""
    for language, block in blocks(page, fill_in):
        if language == "python":
            for old, new in CHANGED.get(name(page), {}).items():
                block = block.replace(old, new)
            yield language, block
        elif language == "sh":
            for line in filter(runs_by_itself, lines(block)):
                yield language, with_options(line, MORE[line]) if line in MORE else line


def run(steps, folder):
    words = [sys.executable, "-c", RUNNER]
    done = subprocess.run(words, input=json.dumps([*steps]), cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Makes a folder with what a page needs, and enters it; in it there is an MPI."""

    def make(page):
        for file, source in NEEDED.get(name(page), {}).items():
            (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / file).write_bytes(source.encode() if "\n" in source else (ROOT / source).read_bytes())
        if page != TUTORIAL and any(scan in page.read_text() for scan in SCANS):
            (block,) = re.findall(r"```python\n([^`]*savetxt[^`]*)```", TUTORIAL.read_text())
            run([("python", block)], tmp_path)
            shutil.copy(tmp_path / SCANS[0], tmp_path / SCANS[1])
        (tmp_path / "mpi4py").mkdir()
        (tmp_path / "mpi4py" / "futures.py").write_text(MPI)
        monkeypatch.chdir(tmp_path)
        return tmp_path

    return make


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_the_code_of_a_page_runs(page, fill_in, place):
    assert {language for language, _ in blocks(page, fill_in)} <= {"python", "sh", "text", "{toctree}", "{code-cell}"}
    if todo := list(steps(page, fill_in)):
        run(todo, place(page))


def test_what_is_said_of_lines_and_blocks_is_said_of_some(fill_in):
    there = [line for page in PAGES for line in command_lines(page, fill_in)]
    assert {*MORE, *SLOW, *ELSEWHERE} <= set(there)
    for begin_of_line in (SERVER, *CLUSTER):
        assert any(line.startswith(begin_of_line) for line in there)
    for page, changes in CHANGED.items():
        assert all((ROOT / page).read_text().count(old) == 1 for old in changes)


def test_the_page_with_sliders_is_served(fill_in, place):
    page = ROOT / "docs" / "explore.md"
    place(page)
    every = [line for shown in (page, ROOT / "README.md") for line in command_lines(shown, fill_in)]
    found = [shlex.split(line) for line in every if line.startswith(SERVER)]
    for _, _, *words in found:
        with Server(*words) as server:
            assert server.ask()[0] == 200
    assert len(found) == 3


@pytest.mark.slow
@pytest.mark.parametrize("line", SLOW)
def test_a_slow_command_runs(line, tmp_path):
    run([("sh", with_options(line, SLOW[line]))], tmp_path)


@pytest.mark.slow
def test_the_cluster_of_the_page(fill_in, tmp_path):
    scheduler, worker, study = (
        next(line for line in command_lines(ROOT / "docs" / "ensembles.md", fill_in) if line.startswith(begin_of_line))
        for begin_of_line in CLUSTER
    )
    file, here = tmp_path / "scheduler.json", "--host 127.0.0.1"
    programs, dask = [], f"{Path(sys.executable).parent}/"
    try:
        words = shlex.split(f"{dask}{scheduler} {here} --port 0 --scheduler-file {file}")
        programs.append(begin(words, cwd=tmp_path))
        assert wait_until(lambda: file.exists() and file.read_text().endswith("}"), programs[0])
        address = json.loads(file.read_text())["address"]
        worker, study = (line.replace("tcp://host:8786", address) for line in (worker, study))
        programs.append(begin(shlex.split(f"{dask}{worker} {here} --nworkers 2"), cwd=tmp_path))
        run([("sh", f"{study} --quick")], tmp_path)
    finally:
        for program in programs:
            program.terminate()
        for program in programs:
            program.wait(PATIENCE)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_the_commands_in_the_text_are_understood(page, fill_in, capsys):
    """Those in the blocks are run."""
    if page.stem == "CHANGELOG":  # which names options without values
        return
    text = re.sub(r"^```.*?^```$", "", hand_written(page, fill_in), flags=re.DOTALL | re.MULTILINE)
    for command in re.findall(r"`(linecontact [a-z][^`]*)`", text):
        main.prepare(shlex.split(command)[1:])
        assert capsys.readouterr().err == "" or "cosine" in command, command  # which that page has added


def test_the_printed_solution_is_what_is_printed():
    """But for seconds, and for the certificate's numbers, which are rounding."""
    code, shown = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", PRINTED.read_text(), re.DOTALL).groups()
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(code, {})
    pages, now = (
        re.sub(r"seconds [\d.]+", "", text.partition("Certificate")[0]) for text in (shown, printed.getvalue())
    )
    assert pages == now


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_formulas_are_read_as_they_are_meant(page):
    """The site's reader takes all digits that follow for one argument, and the next token for the other."""
    assert not re.findall(r"\\(?:[td]?frac|sqrt)\s*\d.*", page.read_text())


def anchors(page):
    """What a link to a heading of a page may name."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_link_leads_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        path, _, anchor = link.partition("#")
        assert "://" not in link, link
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), link
        assert target.is_relative_to(ROOT), link
        assert not anchor or anchor in anchors(target), link
        if target.suffix == ".png":
            assert target.stat().st_size > 10_000, link


def test_every_page_is_listed():
    listed = (ROOT / "docs" / "index.md").read_text()
    for page in (ROOT / "docs").glob("*.md"):
        assert page.stem == "index" or (f"({page.name})" in listed and f"\n{page.stem}\n" in listed), page.name
    assert len((ROOT / "README.md").read_text().splitlines()) <= MOST_LINES


def test_every_stored_figure_is_in_the_gallery():
    gallery = GALLERY.read_text()
    for figure in (ROOT / "studies" / "results").glob("*.png"):
        assert f"(../studies/results/{figure.name})" in gallery, figure.name


def test_a_figure_is_shown_once():
    """Apart from the gallery, which has them all."""
    pages = [page for page in PAGES if page != GALLERY]
    image = re.compile(r"!\[[^\]]*\]\(([^)]+)\)")
    shown = [(page.parent / path).resolve() for page in pages for path in image.findall(page.read_text())]
    assert len(shown) > 20
    assert sorted(map(str, shown)) == sorted(map(str, set(shown)))


def test_nothing_is_said_twice(fill_in):
    """No command stands in two pages but the gallery, and no run of words, so that no longer sentence does."""
    found, commands = defaultdict(set), defaultdict(list)
    for page in (page for page in PAGES if page.stem != "CHANGELOG"):
        for line in command_lines(page, fill_in):
            commands[line].append(name(page))
        text = re.sub(r"^```.*?^```$", " . ", hand_written(page, fill_in), flags=re.DOTALL | re.MULTILINE)
        text = re.sub(r"\]\([^)]*\)", "]", text)
        words = re.findall(r"[^\W_]+", text.lower())
        for at in range(len(words) - LONGEST_RUN + 1):
            found[" ".join(words[at : at + LONGEST_RUN])].add(name(page))
    assert [(run, pages) for run, pages in found.items() if len(pages) > 1] == []
    assert [(line, pages) for line, pages in commands.items() if len(pages) > 1] == []


def test_the_house_is_drawn_as_it_is_built():
    """Who imports somebody is drawn above him, or his folder is."""
    drawn = re.findall(r'y="([\d.]+)"[^>]*/>\n<text[^>]*>([\w /]+)</text>', (ROOT / "docs" / "house.svg").read_text())
    heights, folder = {}, ""
    for y, label in drawn:
        folder = label.strip("/") if label.endswith("/") else folder
        heights[f"linecontact.{folder}" if label.endswith("/") else f"linecontact.{folder}.{label}"] = float(y)

    def floor(module):
        return max((room for room in heights if f"{module}.".startswith(f"{room}.")), key=len, default="")

    pairs = {(floor(module), floor(other)) for module, others in IMPORTS.items() for other in others}
    rooms = [(above, below) for above, below in pairs if above != below and above.count(".") == below.count(".") == 2]
    assert len(rooms) > 20
    for above, below in rooms:
        assert above.split(".")[1] != below.split(".")[1] or heights[above] < heights[below], (above, below)


def test_the_site_is_built_without_a_warning_and_takes_nothing_from_elsewhere(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-q", "-W", "-d", tmp_path / "trees", ROOT / "docs", tmp_path / "site"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    pages = list((tmp_path / "site").glob("*.html"))
    assert {page.stem for page in pages} >= {page.stem for page in (ROOT / "docs").glob("*.md")}
    for page in pages:
        loaded = re.findall(r"<(?:script|link|img)[^>]*(?:src|href)=\"([^\"]+)\"", page.read_text())
        assert not [link for link in loaded if "://" in link or link.startswith("//")], page.name
    notebook = (tmp_path / "site" / "notebook.html").read_text()
    assert notebook.count("<table") == 2  # a scene and a solution, as their cells have shown them
    assert len(re.findall(r"<img [^>]*_images/", notebook)) == 3
    assert "<math" in (tmp_path / "site" / "physics.html").read_text()
