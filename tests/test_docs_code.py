"""The code of the pages runs: blocks of Python, commands, and what they print."""

import contextlib
import io
import json
import os
import re
import shlex
import subprocess
import sys
from multiprocessing import get_context
from pathlib import Path

import pytest
from linecontact.studies.command_line import main
from pages import PAGES, ROOT, blocks, command_lines, hand_written, lines, name
from running import PATIENCE, begin, wait_until
from test_explore_server import Server

pytestmark = pytest.mark.once
PRINTED = ROOT / "docs" / "results.md"
TUTORIAL = ROOT / "docs" / "tutorial.md"

COARSE = "--num-points 2^11 --workers 1"
SMOOTH = f"--cut-off-ratio 0.125 {COARSE}"
POOR = f"--standard-error 0.1 {SMOOTH}"
FEW = f"--points 3 {COARSE}"
LITTLE = "--size 2^12 --repeats 2"

MORE = {
    "linecontact study hertz --folder new": "--quick --workers 1",
    "linecontact curve --over poisson_ratio --from 0 --to 0.5 --thickness 0.01": FEW,
    "linecontact curve --over thickness --from 0.001 --to 1 --pressure 2e-3": FEW,
    "linecontact curve --over approach --from 1e-4 --to 1e-2": FEW,
    "linecontact curve --over seed --from 0 --to 9 --profile rough --hurst 0.8 --pressure 0.01": SMOOTH,
    "linecontact curve --profile rough --hurst 0.8 --thickness 0.01": f"--points 3 {SMOOTH}",
    "linecontact ensemble --hurst 0.8 --thickness 0.01 --standard-error 0.01 --folder thin": POOR,
    "linecontact ensemble --profile rough --hurst 0.8 --pressure 0.01 --standard-error 0.002": POOR,
    "linecontact study kernels": f"--kernel plain_sums {LITTLE}",
    "linecontact study kernels --kernel fire_step --size 2^18": LITTLE,
    "linecontact study kernels --variants mine.py --kernel fire_step --size 2^18": LITTLE,
    "linecontact study kernels --kernel fire_step --folder before": LITTLE,
    "linecontact study kernels --kernel fire_step --folder after": LITTLE,
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
    "python3 -m venv .venv && .venv/bin/pip install -q --no-compile -e '.[test,docs]' && .venv/bin/python -m pytest "
    "-n logical --dist loadfile": "these tests, by .ci/run",
    "python3 -m venv .venv-lowest && .venv-lowest/bin/pip install -q --no-compile -e '.[test]' -c tests/lowest.txt && "
    ".venv-lowest/bin/python -m pytest -n logical --dist loadfile -m 'not slow and not once'": "these too, by .ci/run",
    "linecontact study kernels --variants docs/examples/kernel_variants.py --kernel restrict_to_free --size 2^18": "by "
    "test_kernel_study.py",
    "pip install -e '.[explore]'": "by the extra named test",
    "pip install -e '.[cuda]'": "where there is a GPU",
    "linecontact solve --method mass-weighted-fire --device cuda --num-points 2^22": "by test_on_gpu.py",
    "linecontact study gpu": "where there is a GPU",
    "python docs/fill_in.py": "test_what_a_page_shows_is_what_is_stored",
    ".venv/bin/sphinx-build -W docs docs/build": "the last test of test_docs.py",
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
    "README.md": {"docs/examples/scan.csv": "docs/examples/scan.csv"},
    "CONTRIBUTING.md": {"studies/results/hertz.h5": "studies/results/hertz.h5"},
    "docs/results.md": {"studies/results/hertz.h5": "studies/results/hertz.h5"},
    "docs/kernels.md": {"mine.py": VARIANT},
}
"""Files that a page speaks of and does not make itself, and what they are copies of, or their text."""

SCANS = ("scan.csv", "dektak-1.csv")
"""The file that the tutorial makes, and another with its values."""

MPI = """from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context


class MPIPoolExecutor(ProcessPoolExecutor):
    def __init__(self):
        super().__init__(2, get_context("spawn"))
"""
"""Stands in for mpi4py.futures, whose executor has the same methods."""

FORKS = get_context("forkserver")
FORKS.set_forkserver_preload([__name__, "h5py", "matplotlib.figure", "warp"])  # each imported once for all


def do(steps, folder):
    """In a process of its own and in a folder: blocks of Python, each by itself, and commands."""
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    said = os.open("said", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(said, 1)
    os.dup2(said, 2)
    for language, text in steps:
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


def run(steps, folder):
    process = FORKS.Process(target=do, args=([*steps], folder))
    process.start()
    process.join()
    assert process.exitcode == 0, (folder / "said").read_text()


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


def steps(page):
    """What is run of a page in one process: languages and texts."""
    for language, block in blocks(page):
        if language == "python":
            for old, new in CHANGED.get(name(page), {}).items():
                block = block.replace(old, new)
            yield language, block
        elif language == "sh":
            for line in filter(runs_by_itself, lines(block)):
                yield language, with_options(line, MORE[line]) if line in MORE else line


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Makes a folder with what a page needs, and enters it; in it there is an MPI."""

    def make(page):
        for file, source in NEEDED.get(name(page), {}).items():
            (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / file).write_bytes(source.encode() if "\n" in source else (ROOT / source).read_bytes())
        if page not in (TUTORIAL, ROOT / "README.md") and any(scan in page.read_text() for scan in SCANS):
            (block,) = re.findall(r"```python\n([^`]*savetxt[^`]*)```", TUTORIAL.read_text())
            run([("python", block)], tmp_path)
            scan = (tmp_path / SCANS[0]).read_text().replace("# x [um],z [nm]", "Lateral um,Raw Micrometer")
            (tmp_path / SCANS[1]).write_text(scan)  # the labels of its instrument
        (tmp_path / "mpi4py").mkdir()
        (tmp_path / "mpi4py" / "futures.py").write_text(MPI)
        monkeypatch.chdir(tmp_path)
        return tmp_path

    return make


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_the_code_of_a_page_runs(page, place):
    assert {language for language, _ in blocks(page)} <= {"python", "sh", "text", "{toctree}", "{code-cell}"}
    if todo := list(steps(page)):
        run(todo, place(page))


def test_what_is_said_of_lines_and_blocks_is_said_of_some():
    there = [line for page in PAGES for line in command_lines(page)]
    assert {*MORE, *SLOW, *ELSEWHERE} <= set(there)
    for begin_of_line in (SERVER, *CLUSTER):
        assert any(line.startswith(begin_of_line) for line in there)
    for page, changes in CHANGED.items():
        assert all((ROOT / page).read_text().count(old) == 1 for old in changes)


def test_the_page_with_sliders_is_served(place):
    page = ROOT / "docs" / "explore.md"
    place(page)
    found = [line for shown in (page, ROOT / "README.md") for line in command_lines(shown) if line.startswith(SERVER)]
    for line in found:
        with Server(*shlex.split(line)[2:]) as server:
            assert server.ask()[0] == 200
    assert len(found) == 3


@pytest.mark.slow
@pytest.mark.parametrize("line", SLOW)
def test_a_slow_command_runs(line, tmp_path):
    run([("sh", with_options(line, SLOW[line]))], tmp_path)


@pytest.mark.slow
def test_the_cluster_of_the_page(tmp_path):
    scheduler, worker, study = (
        next(line for line in command_lines(ROOT / "docs" / "ensembles.md") if line.startswith(begin_of_line))
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
def test_the_commands_in_the_text_are_understood(page, capsys):
    """Those in the blocks are run."""
    if page.stem == "CHANGELOG":  # which names options without values
        return
    text = re.sub(r"^```.*?^```$", "", hand_written(page), flags=re.DOTALL | re.MULTILINE)
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
