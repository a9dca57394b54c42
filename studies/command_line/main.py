"""From the arguments of `linecontact` to the command that is meant, its options, and its run.

Only the module of the command, or of the study, that is asked for is imported.
"""

import importlib
import sys
from collections.abc import Callable, Sequence

from ... import __version__
from .. import STUDIES
from ..scenes import kinds
from ..terminal import arguments, declarations, text
from . import study

PROG = "linecontact"
ABOUT = f"""How large is the true contact of an indenter and an elastic layer, and how wrong can the answer be?

{PROG} COMMAND --help lists the options of a command, {PROG} --version shows the version."""
COMMANDS = ("solve", "curve", "ensemble", "explore", "study", "plot", "export", "info")
"""Each has a module of its name beside this one, but for studies that are commands by themselves."""

SCENES = ("solve", "curve", "ensemble", "explore")
"""Those that take the options of layers and profiles."""

BAD_INPUT = 2
"""The exit status where the words mean nothing."""


def main(words: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    return prepare(words)()


def prepare(words: Sequence[str] | None = None) -> Callable[[], int]:
    """Import the command that is asked for. The function returned runs it, and returns the exit status."""
    try:
        return _command(list(sys.argv[1:] if words is None else words))
    except ValueError as error:
        if not text.is_refusal(error):
            raise
        text.complain(error)
        return lambda: BAD_INPUT


def _command(words: list[str]) -> Callable[[], int]:
    """The command that the words ask for, ready to run. Raises `ValueError`."""
    if words[:1] == ["--version"]:
        print(PROG, __version__)
        return lambda: 0
    name, words = arguments.choose("command", words, COMMANDS, PROG, ABOUT, _summary)
    prog, module = f"{PROG} {name}", _module(name)
    if name == "study":
        name, words = study.choose(words, prog)
        prog, module = f"{prog} {name}", STUDIES[name]
    if module in STUDIES.values():
        from ..runner.study import find

        find(name)  # refuses a module that is no study
    found = importlib.import_module(module)
    classes = {"": found.Options}
    if name in SCENES:
        classes |= kinds.titled()
    given = arguments.given(words, classes, prog)
    options = classes[""](**given.pop(""))
    others = [given] if given else []  # options given of the layer and the profiles

    from ..terminal import console

    kept = console.KEPT if module in STUDIES.values() else ""
    return lambda: console.guard(lambda: int(found.command(options, *others)), kept)


def _module(name: str) -> str:
    return STUDIES.get(name, f"{__package__}.{name}")


def _summary(name: str) -> str:
    return study.ABOUT if name == "study" else declarations.summary(f"{_module(name)}:Options")
