"""The header of a text: one line of labels is understood, and no other word of it may contradict what is known.

Labels stand above the rows and are parted as they are: `name`, `name [unit]` or `name (unit)` for each column, or names
in one line and units in the next. Everything else is for the user to say. A unit, a slope, a voltage or a depth in
other words is quoted where it contradicts the user, or where something is missing.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from .units import plain, unit_of

_LONGEST = 1000  # characters of a line that is looked at
_NEAR = 3  # lines above the rows, in which labels are looked for
_COMMENT = "#%*;!/\"' \t"
_LABEL = re.compile(r"([^\[\]()]*?)\s*(?:[\[(]\s*([^\[\]()]*?)\s*[\])])?")
_ROLES = {
    "index": r"index|idx|no|nr|n|i|#|points?|samples?|num|number|row",
    "z": r"z|h|heights?|profile?|raw|topography|elevation|vertical|level(?:l?ed)?|filtered|h\u00f6he|hoehe|hauteur",
    "x": r"x|lateral|positions?|pos|distance|dist|length|scan|horizontal|track|travel|weg|abstand",
}
_DEPTH = (
    r"depth|tief|profond|profun|creux|penetrat|indentation|spalt|invert|flipped|\bdown|\bgap\b|separation|clearance"
    r"|positive into|valleys? (?:are )?(?:positive|up)"
)
_DEEP = re.compile(_DEPTH, re.I)
_DEEP_LABEL = re.compile(_DEPTH + r"|(?:^|\()\s*[-\u2013]\s*\w|\bz\s*-\s*$", re.I)
"""Heights under such words may grow into the valleys."""
_NO_HEIGHT = re.compile(
    r"slope|gradient|steigung|curvature|angle|winkel|volt|spannung|phase|force|kraft|current|intensity|deflection|psd"
    r"|spe[ck]tr|density|correlation|\bln\b|\blog|sqrt|wurzel|squared|divided|multiplied|range|cut-?off|tolerance"
    r"|resolution|spacing|radius|\bper\s|\bdb\b|fft|\bbits?\b|counts?\b|lsb|[*^\u00b1]|(?!^x\d$)\bx\s?\d",
    re.I,
)
"""Columns under such a name are no positions or heights, or something made of them."""
_OTHER_UNIT = re.compile(
    r"[munkM\u03bc]?(?:V|A|N|Pa|rad|s|Hz|K)|volts?|deg\w*|\u00b0C?|sec|counts?|px|pixels?|%|a\.?u\.?|lsb|bits?"
    r"|\w+\s?(?:/|\^|per)\s?\w+",
    re.I,
)
_BRACKET = r"[\[({<]\s*(?:in\s+|units?\s*:\s*)?([^\[\](){}<>]*?)\s*[\])}>]"
_QUANTITY = re.compile(r"[\d.]\s*[\[(]?\s*([^\W\d]+)(?:\s*/\s*\w+)?|[\[(]?([^\W\d]+)[\])]?\s*[:=,;\t ]\s*[-+]?\d")
"""A number and its unit, or a unit and the number in it: the value of a parameter."""
_UNIT_LINE = re.compile(r"unit|einheit", re.I)


class Label(NamedTuple):
    """The label of a column: its name, and its unit as it is written in brackets, empty without one."""

    name: str
    bracket: str = ""

    @property
    def text(self) -> str:
        return f"{self.name} [{self.bracket}]" if self.bracket else self.name

    @property
    def is_depth(self) -> bool:
        return bool(_DEEP_LABEL.search(self.name))

    @property
    def role(self) -> str:
        """'x', 'z', 'index', or empty if its words say two things, or none."""
        words = re.findall(r"[^\W\d_]+|#", self.name.lower())
        said = {role for role, known in _ROLES.items() if any(re.fullmatch(known, word) for word in words)}
        said = said - {"index"} if len(said) > 1 else said  # "sample position"
        return "z" if self.is_depth else said.pop() if len(said) == 1 else ""

    @property
    def bare(self) -> str:
        """A unit in it without brackets; empty without one."""
        return next(filter(None, (unit_of(word, expected=False) for word in re.findall(r"[^\W\d_]+", self.name))), "")

    @property
    def no_length(self) -> str:
        """The part of it that names something else than lengths in a known unit; empty without one."""
        other = _NO_HEIGHT.search(self.name)
        return other[0].strip() if other else "" if unit_of(self.bracket) else self.bracket


@dataclass(frozen=True)
class Header:
    """What a header says: the labels of all columns, if there are any, and its other lines."""

    labels: Sequence[Label] = ()
    rest: Sequence[str] = ()

    def depth(self) -> str:
        """The first of the other lines that speaks of depths; empty without one."""
        return next(filter(_DEEP.search, self.rest), "")

    def units(self) -> Iterator[tuple[str, str, str]]:
        """Units of length in the other lines, each with its line and the role of its clause.

        Where labels have units, only lines that speak of units count.
        """
        every = not any(label.bracket for label in self.labels)
        for line in self.rest:
            about = bool(_UNIT_LINE.search(line))
            bare = _QUANTITY.sub(lambda found: " " if unit_of(found[1] or found[2]) else found[0], line)
            for clause in re.split(r"[,;\t]|\band\b", bare) if about or every else ():
                for found in re.finditer(rf"{_BRACKET}|([^\W\d_]+)", clause):
                    if unit := unit_of(found[1] or found[2] or "", expected=found[2] is None or about):
                        yield unit, line, Label(clause).role

    def no_length(self) -> tuple[str, str]:
        """Something near the rows that is no length, with its line, where there are no labels; else empty."""
        for line in () if self.labels else self.rest[-_NEAR:]:
            brackets = re.findall(_BRACKET, line)
            found = _NO_HEIGHT.search(line) if brackets else None
            if other := next(filter(_OTHER_UNIT.fullmatch, brackets), found[0].strip() if found else ""):
                return other, line
        return "", ""


def cells(line: str, delimiter: str | None) -> list[str]:
    """The cells of a line; delimiter: None for spaces. None in a line of over 1000 characters."""
    if len(line) > _LONGEST:
        return []
    if delimiter is None:
        return line.replace('"', " ").split()
    quoted = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), []) if '"' in line else None
    return [cell.strip() for cell in (line.split(delimiter) if quoted is None else quoted)]


def read(lines: Sequence[str], delimiter: str | None, count: int, least: int) -> Header:
    """The labels of the columns of a table in the lines above it, and the lines that are none.

    delimiter: of the rows; count: of all columns; least: of those that must have labels.
    """
    lines = [line.replace("\u00b2", "^2").replace("\u00b3", "^3") for line in lines if len(line) <= _LONGEST]
    kept = [line for line in (plain(line).strip(_COMMENT) for line in lines) if line]
    for i in range(len(kept) - 1, max(-1, len(kept) - 1 - _NEAR), -1):
        labels, above = (_labels(line, delimiter, count, least) for line in (kept[i], kept[i - 1] if i else ""))
        under = [label.bracket or label.name for label in labels if label.text]
        if any(label.name for label in above) and under and all(unit_of(u) or _OTHER_UNIT.fullmatch(u) for u in under):
            both = zip(above, labels, strict=True)
            merged = [
                Label(a.name, ",".join(dict.fromkeys(filter(None, (a.bracket, b.bracket or b.name))))) for a, b in both
            ]
            return Header(merged, kept[: i - 1] + kept[i + 1 :])
        if any(label.bracket or label.role for label in labels):
            return Header(labels, kept[:i] + kept[i + 1 :])
    return Header((), kept)


def _labels(line: str, delimiter: str | None, count: int, least: int) -> list[Label]:
    """The labels in a line if it is one, parted as the rows are, else nothing."""
    parts = [line] if count == 1 else cells(line, delimiter)
    if delimiter is None and len(parts) != count:
        parts = re.findall(r"[^\[\]()]*[\[(][^\])]*[\])]", line)  # names of several words, with units
    while len(parts) > count and not parts[-1]:
        parts.pop()
    parts += [""] * (count - len(parts)) if len(parts) >= least else []
    found = [_LABEL.fullmatch(part.strip("\"' ,;")) for part in parts]
    return [Label(label[1], label[2] or "") for label in found if label] if len(found) == count and all(found) else []
