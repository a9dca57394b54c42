"""Arguments of the command line as dataclasses: values, errors, help, and what is known from the source alone."""

import importlib
import re
import subprocess
import sys
from dataclasses import MISSING, dataclass
from pathlib import Path
from typing import ClassVar, Literal, Optional

import pytest
from linecontact.solver import Layer, PowerIndenter, RoughIndenter
from linecontact.studies import STUDIES
from linecontact.studies.command_line import main, plot, solve
from linecontact.studies.scenes import kinds
from linecontact.studies.terminal import arguments, declarations
from linecontact.studies.terminal.options import one_of, options_of

WORDED = [f"{kind.__module__}:{kind.__name__}" for kind in kinds.titled().values()]
OWN = [f"{__name__}:{name}" for name in ("Base", "Every", "Positional")]
WORDS = {"one": 1, "two": 2}


@dataclass(frozen=True)
class Base:
    """What the others have in common."""

    folder: Path | None = None
    """Where it goes."""
    workers: int = 2


@dataclass(frozen=True)
class Every(Base):
    """Every type of option, 100 % of them.

    More is said here.

    ratio: of two lengths, which is
        a long story.
    share: of something

    workers: of the base class, which says nothing.
    """

    name: ClassVar[str] = "every"
    ratio: float = 0.5
    limit: int | None = None
    optional: Optional[float] = None  # noqa: UP045
    text: str = "none"
    quick: bool = False
    """Be quick."""
    unit: Literal["m", "mm"] = "m"
    word: str | None = one_of(WORDS, None)
    pair: tuple[Path, Path] | None = None
    share: float = 0.1
    two_words: float = 1.0


@dataclass(frozen=True)
class Positional:
    """A command on a file."""

    file: Path
    level: int = 0


def parse(*words):
    return arguments.parse(Every, words, "prog")


def test_values_of_every_type():
    assert parse() == Every()
    words = "--folder f --workers 3 --ratio -1e-3 --limit 1_0 --optional inf --text= --quick --unit mm --word two"
    expected = Every(Path("f"), 3, -1e-3, 10, float("inf"), "", True, "mm", "two", (Path("a"), Path("b")), 0.1, 2.0)
    assert parse(*words.split(), "--pair", "a", "b", "--two-words=2") == expected
    assert parse("--optional", "Infinity").optional == float("inf")
    assert [parse("--limit", text).limit for text in ("1e5", "1.5E3", "2^10", "-2e0")] == [100_000, 1500, 1024, -2]
    assert parse("--ratio", "-0.0e-400").ratio == 0
    assert [parse("--ratio", text).ratio for text in ("2^-9", "-2^2", "1.5^2")] == [2**-9, -4, 2.25]
    assert parse("--two_words", "2", "--workers", "5") == Every(two_words=2.0, workers=5)
    assert parse("--folder=--odd_name").folder == Path("--odd_name")
    assert arguments.parse(Positional, ["--level", "-3", "some file"], "prog") == Positional(Path("some file"), -3)
    assert arguments.parse(Positional, ["--", "--level"], "prog") == Positional(Path("--level"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--ratio abc", "ratio is 'abc'; allowed: a number"),
        *(
            (f"--limit {text}", f"limit is '{text}'; allowed: an integer, in digits or like 2^10 or 1e6")
            for text in ("1.5e0", "1e-3", "1e17", "1e", "2^1e1", "3.0", "inf", "None")
        ),
        ("--unit km", "unit is 'km'; allowed: m, mm"),
        ("--limit --quick", "limit has no value; allowed: an integer, in digits or like 2^10 or 1e6"),
        ("--ratio 0,002", "ratio is '0,002'; allowed: a number with a decimal point, like 0.002"),
        ("--ratio 1e400", "ratio is '1e400'; allowed: a number of 4.9e-324 to 1.8e+308 in size"),
        ("--pair a", "pair has too few values; allowed: 2 values, each a path"),
        ("--quick=yes", "quick has a value; allowed: --quick alone"),
        ("yes", "'yes' is no option; allowed: the options of `prog --help`"),
        ("--ratoi 3", "option --ratoi is unknown, perhaps meant as --ratio; allowed: the options of `prog --help`"),
        ("--colour=red", "option --colour is unknown; allowed: the options of `prog --help`"),
        ("-q", "option -q is unknown; allowed: the options of `prog --help`"),
        ("--ratio 0.1 --quick --ratio=-0.2", "--ratio is given twice: 0.1, -0.2; allowed: once"),
        ("--two-words 1 --two_words 2 --two-words 3", "--two-words is given 3 times: 1, 2, 3; allowed: once"),
        ("--pair a b --pair c d", "--pair is given twice: a b, c d; allowed: once"),
    ],
)
def test_wrong_words_name_the_option_the_value_and_what_is_allowed(words, message):
    with pytest.raises(ValueError, match=rf"^{re.escape(message)}$"):
        parse(*words.split())


def test_a_positional_argument_must_be_given():
    with pytest.raises(ValueError, match=r"^file is missing; allowed: a path$"):
        arguments.parse(Positional, ["--level", "3"], "prog")
    with pytest.raises(ValueError, match=r"^'b' is no option"):
        arguments.parse(Positional, ["a", "b"], "prog")


def test_only_what_is_given_goes_to_each_of_several_dataclasses():
    kinds = {"": Base, "every": Every, "positional": Positional}
    given = arguments.given(["--workers", "4", "--file", "f"], kinds, "prog")
    assert given == {"": {"workers": 4}, "every": {"workers": 4}, "positional": {"file": Path("f")}}


def test_help_shows_what_is_said_what_is_allowed_and_the_default(capsys):
    with pytest.raises(SystemExit, match=r"^0$"):
        arguments.given(["--ratio", "abc", "--help"], {"": Every, "more of it": Positional}, "prog study")
    said = " ".join(capsys.readouterr().out.split())
    assert said.startswith("usage: prog study [OPTIONS] Every type of option, 100 % of them. More is said here.")
    for text in (
        "--folder PATH Where it goes. --workers INTEGER (default: 2)",
        "--ratio NUMBER of two lengths, which is a long story. (default: 0.5)",
        "--quick Be quick. --unit {m,mm} (default: m)",
        "--word {one,two} --pair PATH PATH --share NUMBER of something (default: 0.1)",
        "more of it: A command on a file. --file PATH --level INTEGER (default: 0)",
    ):
        assert text in said
    assert "--name" not in said
    for name in ("solve", "explore"):  # which takes no accuracy
        with pytest.raises(SystemExit, match=r"^0$"):
            main.main([name, "--help"])
        said = " ".join(capsys.readouterr().out.split())
        assert "only with --profile file: A scan or another profile from a file." in said
        assert ("--accuracy" in said) == (name == "solve")


@pytest.mark.parametrize(
    "hint", [list[str], int | str, dict[str, int], bool | None, tuple[int, str], bytes, tuple[bool, bool]]
)
def test_types_that_no_option_has_are_refused(hint):
    kind = dataclass(type("Odd", (), {"__annotations__": {"odd": hint}, "odd": None}))
    with pytest.raises(TypeError, match="field odd is of type"):
        options_of(kind)


@pytest.mark.parametrize("name", ["linecontact.studies.files.writing:Options", "no.such.module:Kind", "sys:Kind"])
def test_what_the_source_does_not_tell_is_none(name):
    assert declarations.read(name) is None


@pytest.mark.parametrize("name", [*OWN, *WORDED, *(f"{module}:Options" for module in STUDIES.values())])
def test_every_class_that_is_named_has_options_that_its_source_tells(name):
    module, _, own = name.partition(":")
    kind = getattr(importlib.import_module(module), own)
    declared = declarations.read(name)
    assert list(declared.fields) == list(options_of(kind))
    assert declared.summary


def test_the_solvers_defaults_are_those_of_the_command_line():
    given = {title: {} for title in kinds.titled()}
    scene = solve.make_scene(solve.Options(), given)
    assert (scene.layer, scene.indenter) == (Layer(), PowerIndenter())
    assert scene == type(scene)()
    rough = solve.make_scene(solve.Options(profile="rough"), given)
    assert rough.indenter == RoughIndenter()
    assert options_of(plot.Options)["file"].default is MISSING


def imported(program, words, slow):
    """The status of a program, and those of these modules that it has imported."""
    program += f"\nimport sys\nprint(status, [name for name in {slow} if name in sys.modules])"
    result = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True, timeout=60)
    return result.stdout.splitlines()[-1]


@pytest.mark.parametrize(("words", "status"), [("--version", 0), ("stdy", 2), ("study hetz", 2), ("study --help", 0)])
def test_what_needs_nothing_imports_nothing_that_takes_time(words, status):
    program = (
        "from linecontact.studies import __main__ as entry\n"
        "try: status = entry.main()\n"
        "except SystemExit as stop: status = stop.code"
    )
    slow = "numpy", "scipy", "dask", "matplotlib", "warp", "h5py", "rich", "pyfftw", "linecontact.solver"
    assert imported(program, words.split(), slow) == f"{status} []"


def test_a_solve_needs_neither_scipy_nor_matplotlib():
    program = "from linecontact.studies.command_line.main import main\nstatus = main(['solve', '--accuracy', '1e-4'])"
    assert imported(program, [], ("scipy", "dask", "matplotlib")) == "0 []"
