"""What the header of a text says of its columns: which holds positions, which heights, and in which units.

A label is a cell of the lines above the table ("Lateral um", "Height [nm]", "z / mm"). Units also stand in lines of
their own ("X Unit: um", "x in mm, z in nm"). What is written there is taken at its word; what contradicts itself, or
names something else than a length, is for the user to decide.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from .units import plain, unit_of

Role = Literal["x", "z", "depth", "index", ""]

_WORDS: dict[Role, str] = {
    "index": r"index|idx|no|nr|n|i|#|points?|samples?|num|number|row",
    "depth": r"depths?|tiefe|gaps?",
    "z": r"z|heights?|profile|raw|topography|elevation|vertical|amplitude|level(?:l?ed)?|filtered|h\u00f6he|hoehe",
    "x": r"x|lateral|positions?|pos|distance|dist|length|scan|abscissa|horizontal|track|travel|traverse|weg",
}
_VALUE = re.compile(r"(?:^|[\s:=])[-+]?[\d.,]*\d(?:[eE][-+]?\d+)?\s*(?:$|[\[({<]|[^\W\d]+$)")
"""A number at the end of a cell, or one with a unit: the value of a parameter, and no label."""
_LINES = 2  # above the table, that may label its columns: names, and units below them
_AXIS = r"x|lateral|horizontal|positions?|z|heights?|vertical"
_BOTH = r"lengths|coordinates|data|columns|both"
_UNIT_LINE = re.compile(
    rf"(?:({_AXIS})[\s_-]*(?:axis[\s_-]*)?|length\s+|data\s+)?(?:units?|einheit)\b[\"'\s]*[:=,;\t](.*)", re.I
)
"""A line that names units: "X Unit: um", "Units,um"."""
_CLAUSE = re.compile(rf"(?:all\s+)?(?:({_AXIS})|{_BOTH})\s+(?:is\s+|are\s+|given\s+)*in\s+(\S+?)\.?", re.I)
"""Part of a line that names one: "x in mm", "all lengths in um"."""
_FACTOR = re.compile(r"(?<=\s)[x*\u00d7]\s*10")


@dataclass(frozen=True)
class Label:
    """What is written above a column."""

    text: str
    """As it stands there."""
    role: Role
    """What the column holds; empty if the label does not say."""
    unit: str
    """Unit of length; empty if the label names none."""
    unknown: str = ""
    """What stands where a unit is expected and is no unit of length."""


def labels(lines: Sequence[str], delimiter: str | None, count: int) -> list[Label]:
    """Labels of the `count` columns of a table from the lines above it; empty if there are none."""
    found: list[Label] = []
    while lines and not lines[-1].strip():
        lines = lines[:-1]
    for line in lines[: -_LINES - 1 : -1]:
        cells = _cells(line, delimiter, count)
        if not cells or any(map(_VALUE.search, cells)):
            break
        read = [_label(cell) for cell in cells]
        named = (
            any(label.unit or label.unknown for label in read) or len({label.role for label in read} - {""}) == count
        )
        if delimiter is None and not named:
            break  # a title of as many words
        if any(label.role and label.unit for label in found):
            break  # names and units in one line
        found = [_merged(above, below) for above, below in zip(read, found, strict=True)] if found else read
    if count == 1 and found and found[0].role not in ("z", "depth") and found[0].text != found[0].unit:
        return []  # the last line of a header of anything
    return found if any(label.role or label.unit or label.unknown for label in found) else []


def stated_units(lines: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Units named by lines of their own: the axis 'x' or 'z', the unit (empty unless it is one of length), the line."""
    for line in map(plain, lines):
        bare = line.lstrip("#%*;\"' ")
        if match := _UNIT_LINE.fullmatch(bare):
            found = [(match[1], set(re.findall(r"[^\s,;=:\"']+", match[2])))]
        else:
            clauses = [_CLAUSE.fullmatch(clause.strip()) for clause in re.split(r"[,;]|\band\b", bare)]
            found = [(clause[1], {clause[2]}) for clause in clauses if clause]
        for axis, words in found:
            unit = (unit_of(words.pop()) or "") if len(words) == 1 else ""
            along = axis and (axis[0].lower() in "xlp" or axis.lower() == "horizontal")
            for name in "xz" if not axis else "x" if along else "z":
                yield name, unit, line.strip()


def _cells(line: str, delimiter: str | None, count: int) -> list[str]:
    """The cells of a line if they are as many as the table has columns, else nothing."""
    line = plain(line).lstrip("#%").strip()
    bracketed = re.findall(r"[^\[\](){}]*[\[(][^\])]*[\])]", line)
    ways = [line.split(delimiter)] if delimiter else [re.split(r"\s{2,}|\t|,|;", line), bracketed, line.split()]
    for cells in ways if count > 1 else [[line]]:
        cells = [cell.strip().strip("\"'").strip() for cell in cells]
        while cells and not cells[-1]:
            cells.pop()
        if len(cells) == count and all(cells):
            return cells
    return []


def _label(text: str) -> Label:
    """What one cell says."""
    brackets = list(re.finditer(r"[\[({<]\s*(?:in\s+)?([^\])}>]*?)\s*[\])}>]", text))
    bracket = next((found for found in reversed(brackets) if unit_of(found[1])), brackets[-1] if brackets else None)
    stated = bracket or re.search(r"\s(?:in\s+|/\s*)(\S+)$|(?<=\w)/(\S+)$", text)
    name, unit, unknown = text, "", ""
    if stated:
        word = next(group for group in (*stated.groups(), "") if group is not None)
        name, unit = text[: stated.start()] + text[stated.end() :], unit_of(word) or ""
        unknown = "" if unit else word
    else:
        *words, last = re.split(r"[\s_,:=.]+", text)
        alone = unit_of(last, expected=not words)
        if alone:
            name, unit = " ".join(words), alone
    if unit and _FACTOR.search(name):
        unit, unknown = "", text  # "x10 nm"
    return Label(text, _role(re.sub(r"[\[\](){}<>]", " ", name)), unit, unknown)


def _role(name: str) -> Role:
    """What the words of a label say that its column holds; empty if they say two things, or none."""
    words = [word for word in re.split(r"[\s_,:.\-]+", name.lower()) if word]
    said = {role for role, pattern in _WORDS.items() if any(re.fullmatch(pattern, word) for word in words)}
    if len(said) > 1:
        said -= {"index"}  # "sample position"
    if "depth" in said:
        said -= {"z"}
    return said.pop() if len(said) == 1 else ""


def _merged(above: Label, below: Label) -> Label:
    """One label from two lines, names above units."""
    text = f"{above.text} {below.text}"
    role, unit, unknown = below.role or above.role, below.unit or above.unit, below.unknown or above.unknown
    if above.unit and below.unit and above.unit != below.unit:
        unit, unknown = "", text
    return Label(text, role, unit, unknown)
