"""`linecontact study`: which study is meant. Its own module does the rest."""

from collections.abc import Sequence

from .. import STUDIES as EVERY
from ..terminal import arguments, declarations

ABOUT = "Run a study: data, figures and a table in one folder."

STUDIES = {name: module for name, module in EVERY.items() if name not in ("curve", "ensemble")}
"""Those of this command; a curve and an ensemble are commands by themselves."""


def choose(words: Sequence[str], prog: str) -> tuple[str, list[str]]:
    """The name of the study, and the words after it. Raises `ValueError`."""
    return arguments.choose("study", words, STUDIES, prog, ABOUT, _summary)


def _summary(name: str) -> str:
    return declarations.summary(f"{STUDIES[name]}:Options")
