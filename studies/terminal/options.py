"""A dataclass's fields as options of the command line: its defaults are theirs, its types give the allowed values.

A field may be a number, text, a path, a flag (a bool, False by default), one of a few words (`Literal` or `one_of`), a
tuple of paths, numbers or text, or None where nothing is given.
"""

from collections.abc import Callable, Iterable
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from .text import IN_RANGE, number, pointed

_TYPES = {int: "an integer, in digits or like 2^10 or 1e6", float: "a number", str: "some text", Path: "a path"}
"""The word for a value of each type."""

PRESSURE = "a number alone, or each pressure and modulus with its unit (Pa, kPa, MPa, GPa), like 0.1MPa"
_EXACT = 2.0**53  # up to here a float holds every integer


def one_of(allowed: Iterable[str], default: Any) -> Any:
    """A field that takes one of the words of a list, or one of the names in a mapping, which may still grow."""
    return field(default=default, metadata={"allowed": allowed})


def text(said: str, default: Any) -> Any:
    """A field that takes a text. said: the allowed values, for messages."""
    return field(default=default, metadata={"said": said})


def refused() -> Any:
    """A field that is there to be refused with a reason, and that --help does not offer."""
    return field(default=None, metadata={"refused": True})


@dataclass(frozen=True)
class Option:
    """A field of a dataclass as it is given on the command line."""

    name: str
    """Name of the field."""
    type: type
    """Type of one value."""
    count: int
    """How many values there are to give; 0 for a flag."""
    choices: tuple[str, ...]
    """The words that are allowed; empty where others are."""
    default: Any
    """The value if the option is not given; `dataclasses.MISSING` if it must be."""
    dimension: str
    """'length' or 'pressure' where it is one of a scene, which may have its unit; empty for all else."""
    said: str
    """The allowed values where there are no choices; empty for a flag."""
    refused: bool = False
    """Whether whatever is given is refused, with a reason."""

    @property
    def _one(self) -> str:
        """The allowed values of one."""
        return ", ".join(self.choices) or self.said

    @property
    def allowed(self) -> str:
        """The allowed values, for messages."""
        return self._one if self.count == 1 else f"{self.count} values, each {self._one}"

    @property
    def placeholder(self) -> str | tuple[str, ...]:
        """The word for the value, or for each of several, in --help."""
        word = f"{{{','.join(self.choices)}}}" if self.choices else _TYPES[self.type].split()[1].strip(",").upper()
        return word if self.count == 1 else (word,) * self.count

    def value(self, words: str | list[str] | bool) -> Any:
        """The value that a word stands for, or several; True is a flag that is given. Raises `ValueError`.

        A length or pressure that is no number alone stays a text, until it is known in which units the scene is.
        """
        if isinstance(words, bool):
            return words
        if isinstance(words, list):
            return tuple(self.value(word) for word in words)
        allowed = self._one
        if words in self.choices or not self.choices:
            try:
                return _READ.get(self.type, self.type)(words)
            except OverflowError:
                allowed = IN_RANGE if self.type is float else allowed
            except ValueError:
                if self.dimension:
                    return words
                allowed = (pointed(words) if self.type is float else "") or allowed
        raise ValueError(f"{self.name} is {words!r}; allowed: {allowed}")


def _integer(words: str) -> int:
    """The integer that words stand for, in digits, or as 2^18 or 1e6. Raises `ValueError` for any other text."""
    if "^" in words:
        return _power(words)
    if "e" not in words.lower():
        return int(words)
    found = number(words)
    if not (found.is_integer() and abs(found) <= _EXACT):
        raise ValueError(f"{words} is too large, or not an integer")
    return int(found)


def _power(words: str) -> int:
    """The integer that 2^18 stands for. Raises `ValueError` for any other text."""
    base, exponent = map(int, words.split("^"))
    if not (0 < base < 1000 and 0 <= exponent <= 100):
        raise ValueError(f"{words} is too large, or not an integer")
    return int(base**exponent)


def _path(words: str) -> Path:
    """The path that words name. Raises `ValueError` for no words, which would be the folder that one is in."""
    if not words:
        raise ValueError("a path is empty")
    return Path(words)


_READ: dict[type, Callable[[str], Any]] = {float: number, int: _integer, Path: _path}
"""How a value of a type is read that its class does not read as it should."""


def flag(name: str) -> str:
    """The name of a field as it is written on the command line; `from_`, which Python needs, is --from there."""
    return f"--{name.rstrip('_').replace('_', '-')}"


def told(name: str, value: Any) -> str:
    """An option that is given and its value, for messages."""
    return f"{flag(name)} is given" if value is True else f"{name} is {value}"


def options_of(kind: type) -> dict[str, Option]:
    """The options that a dataclass stands for, by name and in order. Raises `TypeError` for a field that cannot be."""
    hints = get_type_hints(kind)
    return {entry.name: _option(entry, hints[entry.name]) for entry in fields(kind) if entry.init}


def _option(entry: Field[Any], hint: Any) -> Option:
    from linecontact.solver.units import unit  # takes its time, and is not needed to refuse a mistyped option

    parts = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    kind, *others = (part for part in parts if part is not NoneType)
    values = get_args(kind) if get_origin(kind) is tuple else (kind,)
    default = entry.default if entry.default_factory is MISSING else entry.default_factory()
    words = get_args(kind) if get_origin(kind) is Literal else ()
    choices = tuple(entry.metadata.get("allowed", words))
    value = str if choices else values[0]
    possible = value in _TYPES or (value is bool and default is False)
    if not possible or others or len(set(values)) > 1:
        allowed = "a number, text, a path, words, or a flag that is False by default"
        raise TypeError(f"field {entry.name} is of type {hint}; allowed for an option: {allowed}")
    count = 0 if value is bool else len(values)
    known = {unit(entry.name), unit(f"profile_{entry.name}")} if value is float else set()
    dimension = next((one for one in ("length", "pressure") if one in known), "")
    called = PRESSURE if dimension == "pressure" else _TYPES.get(value, "")
    said, no = entry.metadata.get("said", called), entry.metadata.get("refused", False)
    return Option(entry.name, value, count, choices, default, dimension, said, no)
