"""The pages, and the code that is written in them by hand."""

import importlib.util
import re
from pathlib import Path

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]


def _read_fill_in():
    spec = importlib.util.spec_from_file_location("fill_in", ROOT / "docs" / "fill_in.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


fill_in = _read_fill_in()
"""What writes into the pages, as a module."""


def name(page):
    return str(page.relative_to(ROOT))


def hand_written(page):
    return fill_in.BLOCK.sub("", page.read_text())


def blocks(page):
    """Language and text of every block of code that is written by hand, in the order of the page."""
    return re.findall(r"^```(\S*).*?\n(.*?)^```$", hand_written(page), re.DOTALL | re.MULTILINE)


def lines(block):
    """The commands of a block, without comments."""
    for line in block.replace("\\\n", " ").splitlines():
        if words := " ".join(re.sub(r"(^|\s)# .*", "", line).split()):
            yield words


def command_lines(page):
    return [line for language, block in blocks(page) if language == "sh" for line in lines(block)]
