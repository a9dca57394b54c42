"""Words of a command line as dataclasses, whose fields are the options (see `options_of`).

A field without a default of a command's own dataclass is a positional argument. The help text of a field is read
from the source, see `declarations`. Words that are wrong raise `ValueError` with one line that names the option, what
was given, and what is allowed.
"""

import argparse
import difflib
import re
import textwrap
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import MISSING
from typing import Any, TypeVar

from . import declarations
from .options import Option, flag, options_of

Kind = TypeVar("Kind")

_HELP = {"-h", "--help"}
_WIDTH = 100  # columns of --help
_NOTHING = declarations.Declaration("", {})


def parse(kind: type[Kind], words: Sequence[str], prog: str) -> Kind:
    """Words of the command line as an instance of a dataclass; prog: the command, as it is called."""
    return kind(**given(words, {"": kind}, prog)[""])


def given(words: Sequence[str], kinds: Mapping[str, type], prog: str) -> dict[str, dict[str, Any]]:
    """The fields that the words of a command line give, by name, for each of the dataclasses.

    kinds: the dataclasses by the titles that --help gives their options. The first is the command's own: its fields
        without a default are positional arguments and must be given. A field that several have is one option.
    prog: the command, as it is called.
    """
    groups = {title: options_of(kind) for title, kind in kinds.items()}
    every = {name: option for group in reversed(groups.values()) for name, option in group.items()}
    required = [name for name, option in next(iter(groups.values())).items() if option.default is MISSING]
    words = _plain(words)
    if _HELP & set(words):
        print(_parser(prog, groups, required, kinds).format_help(), flush=True)  # a closed pipe is noticed here
        raise SystemExit(0)
    _check_names(words, every, prog)
    try:
        found, more = _parser(prog, groups, required, {}).parse_known_args(words)
    except argparse.ArgumentError as error:
        option = next((option for option in every.values() if flag(option.name) == error.argument_name), None)
        if option is None:
            raise ValueError("help has a value; allowed: --help alone") from None
        name = option.name.rstrip("_")
        if option.count:
            few = "no value" if option.count == 1 else "too few values"
            raise ValueError(f"{name} has {few}; allowed: {option.allowed}") from None
        raise ValueError(f"{name} has a value; allowed: {flag(option.name)} alone") from None
    if more:
        raise ValueError(f"{more[0]!r} is no option; allowed: the options of `{prog} --help`")
    for name in required:
        if name not in found:
            raise ValueError(f"{name} is missing; allowed: {every[name].allowed}")
    _check_once(vars(found), required)
    values = {name: every[name].value(value if name in required else value[0]) for name, value in vars(found).items()}
    return {title: {name: values[name] for name in group if name in values} for title, group in groups.items()}


def _check_once(found: Mapping[str, Any], positional: Collection[str]) -> None:
    """Raise `ValueError` for an option that is given more than once: which of its values was meant?"""
    for name, values in found.items():
        if name not in positional and len(values) > 1:
            often = "twice" if len(values) == 2 else f"{len(values)} times"
            texts = [" ".join(value) if isinstance(value, list) else str(value) for value in values]
            told = "" if values[0] is True else f": {', '.join(texts)}"
            raise ValueError(f"{flag(name)} is given {often}{told}; allowed: once")


def _check_names(words: Sequence[str], names: Iterable[str], prog: str) -> None:
    """Raise `ValueError` for an option that is none of these names."""
    known = _HELP | {flag(name) for name in names}
    for word in words[: words.index("--")] if "--" in words else words:
        name = word.partition("=")[0]
        if name.startswith("-") and name != "-" and not _is_number(name) and name not in known:
            meant = _nearest(name, known)
            raise ValueError(f"option {name} is unknown{meant}; allowed: the options of `{prog} --help`")


def choose(
    what: str, words: Sequence[str], names: Collection[str], prog: str, about: str, tell: Callable[[str], str]
) -> tuple[str, list[str]]:
    """The first word, which must be one of the names, and the words after it.

    what: the thing to choose, for messages.
    about: help text of the choice, and tell: of each name.
    """
    if not words:
        raise ValueError(f"{what} is missing; allowed: {', '.join(names)}")
    name, *rest = words
    if name in _HELP:
        print(f"usage: {prog} {what.upper()} [OPTIONS]\n\n{about}\n")
        for one in names:
            print(textwrap.fill(f"  {one:<12}{tell(one)}", _WIDTH, subsequent_indent=" " * 14))
        raise SystemExit(0)
    if name not in names:
        raise ValueError(f"{what} is {name!r}{_nearest(name, names)}; allowed: {', '.join(names)}")
    return name, rest


def _plain(words: Sequence[str]) -> list[str]:
    """The words with hyphens for underscores in options' names, and negative numbers tied to their options by "="."""
    plain: list[str] = []
    for place, word in enumerate(words):
        before = plain[-1] if plain else ""
        if word == "--":
            return [*plain, *words[place:]]
        if word.startswith("--"):
            name, equals, value = word.partition("=")
            plain.append(name.replace("_", "-") + equals + value)
        elif word.startswith("-") and _is_number(word) and before.startswith("--") and "=" not in before:
            plain[-1] = f"{before}={word}"
        else:
            plain.append(word)
    return plain


def _is_number(word: str) -> bool:
    """Whether a word with a hyphen first is a number, perhaps with a unit or more numbers behind it, and no option."""
    return re.match(r"-(\d|\.\d|inf|nan)", word, re.IGNORECASE) is not None


def _nearest(word: str, names: Collection[str]) -> str:
    bare = {name.strip("-"): name for name in sorted(names)}
    near = difflib.get_close_matches(word.strip("-"), bare, 1)
    return f", perhaps meant as {bare[near[0]]}" if near else ""


def _parser(
    prog: str, groups: Mapping[str, Mapping[str, Option]], required: Sequence[str], told: Mapping[str, type]
) -> argparse.ArgumentParser:
    """A parser that tells the words of the options apart and leaves the values as they are.

    told: the dataclasses of the groups, for the help texts of their fields; empty where nobody asks.
    """
    usage = " ".join([prog, *map(str.upper, required), "[OPTIONS]"])
    parser = argparse.ArgumentParser(
        prog, usage, add_help=False, allow_abbrev=False, exit_on_error=False, formatter_class=_formatter
    )
    parser.add_argument("-h", "--help", action="store_true", default=argparse.SUPPRESS, help="Show this.")
    added = set[str]()
    refused = {name for name, option in next(iter(groups.values())).items() if option.refused}  # by the whole command
    for title, group in groups.items():
        declared = _declaration(told[title]) if told else _NOTHING
        if not title:
            parser.description = declared.text
        offered = {name: option for name, option in group.items() if not option.refused and name not in refused}
        shared = [f"{flag(name)} ({_default(option)})" for name, option in offered.items() if name in added]
        also = f" It takes {', '.join(shared)}, too." if shared and told else ""
        about = textwrap.fill(declared.summary + also, _WIDTH - 2)
        section = parser.add_argument_group(title, about) if title else parser
        for name, option in group.items():
            if name not in added:
                said = declared.fields.get(name, "") if name in offered else argparse.SUPPRESS
                _add(section, option, name in required, said)
        added |= set(group)
    return parser


def _default(option: Option) -> str:
    if option.default is None:
        return "not needed"
    missing = option.default is MISSING or option.default != option.default
    return "must be given" if missing else f"default: {option.default}"


def _declaration(kind: type) -> declarations.Declaration:
    declared = declarations.read(f"{kind.__module__}:{kind.__qualname__}")
    return declared or _NOTHING


def _add(section: Any, option: Option, positional: bool, said: str) -> None:
    """Add an option to a parser or a group of it."""
    hidden = option.default is None or option.default is False or _default(option) == "must be given"
    text = (said if hidden or "Default: " in said else f"{said} (default: {option.default})".strip()).replace("%", "%%")
    common = {"default": argparse.SUPPRESS, "help": text}
    if option.count == 0:
        section.add_argument(flag(option.name), dest=option.name, action="append_const", const=True, **common)
    elif positional:
        section.add_argument(option.name, nargs="?", metavar=option.name.upper(), **common)
    else:
        count = option.count if option.count > 1 else None
        shown = {"dest": option.name, "metavar": option.placeholder}
        section.add_argument(flag(option.name), action="append", nargs=count, **shown, **common)


def _formatter(prog: str) -> argparse.HelpFormatter:
    return argparse.RawDescriptionHelpFormatter(prog, max_help_position=28, width=_WIDTH)
