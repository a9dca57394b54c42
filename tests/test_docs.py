"""The pages: what they show is what is stored, their examples run, their commands parse, their links lead somewhere."""

import contextlib
import importlib.util
import io
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from linecontact.studies.command_line import main

pytestmark = pytest.mark.once

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
PRINTED = ROOT / "docs" / "results.md"
MOST_LINES = 110


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


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_the_examples_run(page, tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)
    if blocks:
        program = "\n".join(f"exec(compile({block!r}, 'block {k}', 'exec'), {{}})" for k, block in enumerate(blocks))
        done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_code_that_cannot_run_here_is_python_whose_names_there_are(page):
    """Blocks marked py, not python, need what the tests do not have, like MPI."""
    text = page.read_text()
    assert set(re.findall(r"^```(\S+)", text, re.MULTILINE)) <= {
        "python",
        "py",
        "sh",
        "text",
        "{toctree}",
        "{code-cell}",
    }
    for block in re.findall(r"```py\n(.*?)```", text, re.DOTALL):
        compile(block, name(page), "exec")
        exec("\n".join(line for line in block.splitlines() if line.startswith("from linecontact")), {})


def test_the_printed_solution_is_what_is_printed():
    """But for seconds, and for the certificate's numbers, which are rounding."""
    code, shown = re.search(r"```python\n(.*?)```\n\n```\n(.*?)```", PRINTED.read_text(), re.DOTALL).groups()
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


def commands(text, filled_in):
    """The lines in code blocks that call linecontact, as words; not in what others have said."""
    text = filled_in.sub("", text)
    for language, block in re.findall(r"^```(\w*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE):
        for line in block.replace("\\\n", " ").splitlines() if language in ("", "sh") else ():
            command = line.partition("  #")[0].partition(" > ")[0].strip()
            if command.startswith("linecontact ") and "..." not in command:
                yield shlex.split(command)[1:]


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_the_commands_are_understood(page, fill_in, capsys):
    found = list(commands(page.read_text(), fill_in.BLOCK))
    for words in found:
        main.prepare(words)
        assert capsys.readouterr().err == "", words
    assert len(found) >= {"README.md": 5, "docs/how-to.md": 2, "docs/kernels.md": 8}.get(name(page), 0)


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
    gallery = (ROOT / "docs" / "gallery.md").read_text()
    for figure in (ROOT / "studies" / "results").glob("*.png"):
        assert f"(../studies/results/{figure.name})" in gallery, figure.name


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
