"""The pages: what they show is what is stored, nothing is said twice, links lead somewhere, and the site is built."""

import re
import subprocess
import sys
from collections import defaultdict

import pytest
from pages import PAGES, ROOT, command_lines, fill_in, hand_written, name
from test_imports import read_project

pytestmark = pytest.mark.once
LONGEST_RUN = 10
"""So many words in a row stand in one page only."""


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_what_a_page_shows_is_what_is_stored(page):
    text = page.read_text()
    assert fill_in.filled(text) == text, f"python docs/fill_in.py writes {name(page)} anew"
    assert text.count("<!-- end -->") == len(fill_in.BLOCK.findall(text))
    # the site's reader takes all digits that follow for one argument
    assert not re.findall(r"\\(?:[td]?frac|sqrt)\s*\d.*", text)


def test_a_page_that_disagrees_is_written_anew():
    text = "before\n<!-- report: soak -->\nold\n<!-- end -->\nafter"
    assert re.fullmatch(text.replace("old", "[^<]*random scenes[^<]*"), fill_in.filled(text))
    with pytest.raises(ValueError, match="report is 'soak nothing'; allowed"):
        fill_in.filled(text.replace("soak", "soak nothing"))


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


def test_every_page_and_every_figure_is_listed():
    listed = (ROOT / "docs" / "index.md").read_text()
    for page in (ROOT / "docs").glob("*.md"):
        assert page.stem == "index" or (f"({page.name})" in listed and f"\n{page.stem}\n" in listed), page.name
    gallery = (ROOT / "docs" / "gallery.md").read_text()
    for figure in (ROOT / "studies" / "results").glob("*.png"):
        assert f"(../studies/results/{figure.name})" in gallery, figure.name


def test_nothing_is_said_twice():
    """No command stands in two pages but the gallery, and no run of words, so that no longer sentence does."""
    found, commands = defaultdict(set), defaultdict(list)
    for page in (page for page in PAGES if page.stem != "CHANGELOG"):
        for line in command_lines(page):
            commands[line].append(name(page))
        text = re.sub(r"^```.*?^```$", " . ", hand_written(page), flags=re.DOTALL | re.MULTILINE)
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

    _, _, graph = read_project()
    pairs = {(floor(module), floor(other)) for module, others in graph.items() for other in others}
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
