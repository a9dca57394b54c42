"""What the tests of prose share: stored results, and numbers as the pages write them."""

from pathlib import Path

import numpy as np
from linecontact.studies.files import study_files

ROOT = Path(__file__).parent.parent


def stored(name):
    return study_files.load_study(ROOT / "studies" / "results" / f"{name}.h5")


def column(runs, name):
    return np.array([run[name] for run in runs])


def digits(value, count=2):
    return f"{value:.{count}g}"


def span(values, count=2):
    least, most = digits(min(values), count), digits(max(values), count)
    return least if least == most else f"{least} to {most}"


def words_of(page):
    """The text of a page on one line, without emphasis."""
    return " ".join((ROOT / f"{page}.md").read_text().replace("**", "").replace("\\*", "*").split())
