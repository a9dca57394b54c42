"""The header of a text: one line of labels is understood, and no other word of it may contradict it.

Labels are parted as the rows are: `name`, `name [unit]` or `name (unit)` for each column, or names above units. Other
units, slopes, voltages and depths are quoted where they contradict the user, or where something is missing.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..terminal.units import plain, unit_of

_LONGEST = 10_000  # characters of a line
_NEAR = 3  # lines above the rows, in which labels are looked for
_POWERS = str.maketrans({"\u00b2": "^2", "\u00b3": "^3"})
_COMMENT = "#%*;!/\"' \t"
_LABEL = re.compile(r"(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]|([^\[\]()]*)")
_ROLES = {
    "index": r"index|idx|no|nr|n|i|#|points?|samples?|num|number|row",
    "z": r"z|h|heights?|profile?|raw|topography|elevation|vertical|level(?:l?ed)?|filtered|h\u00f6he|hoehe|hauteur",
    "x": r"x|lateral|positions?|pos|distance|dist|length|scan|horizontal|track|travel|weg|abstand",
}
_FURTHER = r"units?|of|the|in|data|values?|axis|coordinates?|surface|primary|roughness|waviness|measured|mean"
_KNOWN = re.compile("|".join((*_ROLES.values(), _FURTHER)))
# heights under such words may grow into the valleys
DEEP = re.compile(
    r"(?i)depth|tief|diepte|profond|profun|creux|g\u0142\u0119bok|\u0433\u043b\u0443\u0431|\u6df1|penetrat|indentation|spalt|recess|below|bulk"
    r"|negativ|\bneg\b|invert|flipped|\bdown(?:wards?)?\b(?!\s*\d)|positive into|valleys? (?:are )?(?:positive|up)"
    r"|\bgaps?\b(?! gauge)|separation|clearance|(?:^|\()\s*-\s*[^\W\d]|\bz\s*-\s*$"
)
# columns under such a name are no positions or heights, or something made of them
_NO_HEIGHT = re.compile(
    r"(?i)slope|gradient|steigung|curvature|\bangle|winkel|volt|spannung|phase|\bforce\b|kraft|\bcurrent$|intensity"
    r"|deflection|psd|spe[ck]tr|density|correlation|\bln\b|\blog(?:\d|\b)|sqrt|wurzel|squared|divided|multiplied"
    r"|\brange\b|cut-?off|tolerance|resolution$|spacing|radius|\bper\s|\bdb\b|fft|\bbits?\b|counts?\b|lsb|[*^\u00b1]|/\s*\d|^\d+[a-z]|(?!^x\d$)\bx\s?\d"
)
_OTHER_UNIT = re.compile(
    r"(?i)[munkM\u03bc]?(?:V|A|N|Pa|rad|s|Hz|K)|volts?|deg\w*|\u00b0C?|sec|counts?|px|pixels?|%|a\.?u\.?|lsb|bits?"
    r"|\w+\s?(?:/|\^|per)\s?\w+"
)
# a number that may have to be applied
_FACTOR = re.compile(r"(?i)(?:^|[^a-z])[xyzvh]?[\s_-]?(?:scal|factor|bit2|lsb|gain|multiplier)\w*\W+([-+]?\d\S*)")
_BRACKET = r"[\[({<]\s*(?:in\s+|units?\s*:\s*)?([^\[\](){}<>]*?)\s*[\])}>]"
_CELL = r"(?:^|[,;\t=:])\s*\"?[-+]?[\d.]+\"?\s*[,;\t]\s*\"?"  # a number alone, before the cell of its unit
# a number and its unit, or a unit and the number in it: the value of a parameter
_QUANTITY = re.compile(
    rf"(?:{_CELL}|[\d.]\s*[\[(]?)\s*([^\W\d]+)(?:\s*/\s*\w+)?|[\[(]?([^\W\d]+)(?=[\])]?\s*[:=,;\t ]\s*[-+]?\d)"
)
# a line that tells a unit, perhaps that of a subject
_UNIT_LINE = re.compile(
    r"(?i:(axis|achse|ordinate|signal|channel))|(?:^|[^a-z])[Uu]nits?(?![a-z])|UNIT|[Ee]inheit|[Uu]nit\u00e9"
    r"|(?:in|en) \[?\w+\]?$|lengths? in\b"
)


class Label(NamedTuple):
    """The label of a column: its name, and its unit as it is written in brackets; both may be empty."""

    name: str
    bracket: str = ""

    @property
    def text(self) -> str:
        return f"{self.name} [{self.bracket}]" if self.bracket else self.name

    @property
    def role(self) -> str:
        """'x', 'z', 'index', or empty if its words say two things, or none, or if one of them is unknown."""
        words = re.findall(r"[^\W\d_]+|#", self.name.lower())
        said = {role for role, known in _ROLES.items() if any(re.fullmatch(known, word) for word in words)}
        if DEEP.search(self.name):
            said.add("z")
        elif not all(_KNOWN.fullmatch(word) or unit_of(word) for word in words):
            return ""
        said = said - {"index"} if len(said) > 1 else said  # "sample position"
        return said.pop() if len(said) == 1 else ""

    @property
    def asks(self) -> bool:
        """Whether nothing in it goes unsaid: it is empty, or its depth or another quantity is asked about."""
        return not self.text or bool(DEEP.search(self.name) or self.no_length)

    @property
    def bare(self) -> str:
        """A unit in it without brackets; empty without one."""
        return next(filter(None, (unit_of(word, expected=False) for word in re.findall(r"[^\W\d_]+", self.name))), "")

    @property
    def no_length(self) -> str:
        """The part of it that names something else than lengths in a known unit; empty without one."""
        other, unit = _NO_HEIGHT.search(self.name), unit_of(self.bracket)
        known = unit and self.bare in ("", unit)
        return other[0].strip() if other else "" if known else self.bracket and (self.bare or self.bracket)


class Header(NamedTuple):
    """The labels of all columns, empty ones where there are none, and the other lines of a header."""

    labels: Sequence[Label]
    rest: Sequence[str] = ()

    def said(self) -> Iterator[tuple[str, list[str], str]]:
        """Each of the other lines, the units of length in it, and something that is no length, or a factor."""
        without = not any(label.bracket for label in self.labels)  # else only lines that tell a unit count, and factors
        for line in self.rest:
            factor = _FACTOR.search(line)
            applied = factor[0].strip() if factor and not re.match(r"\+?1(?:[.,]0*)?(?![\w:/^*-])", factor[1]) else ""
            about = _UNIT_LINE.search(line)
            near = re.findall(_BRACKET, line) if line in self.rest[-_NEAR:] else []
            words = re.split(r"[\s:=,;\"]+", line[about.start() :])[1:] if about else []
            quantity = _NO_HEIGHT.search(line) if near or (about and about[1]) else None
            other = next(filter(_OTHER_UNIT.fullmatch, [*near, *words]), quantity[0].strip() if quantity else "")
            bare = _QUANTITY.sub(lambda found: " " if unit_of(found[1] or found[2]) else found[0], line)
            parts = re.findall(rf"{_BRACKET}|(?!in\b)([^\W\d_]+)", bare) if about or without else []
            known = (unit_of(inside or word, expected=bool(inside or about)) for inside, word in parts)
            yield line, list(dict.fromkeys(filter(None, known))), applied or other * without


def cells(line: str, delimiter: str | None) -> list[str]:
    """The cells of a line; delimiter: None for spaces."""
    if delimiter is None:
        return line.replace('"', " ").split()
    if '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    return [cell.strip() for cell in line.split(delimiter)]


def read(lines: Sequence[str], delimiter: str | None, count: int, least: int) -> Header:
    """The labels of `count` columns, of which the first `least` must have one, in the lines above; and the others."""
    if (longest := max(map(len, lines), default=0)) > _LONGEST:
        raise ValueError(f"a line above the rows has {longest} characters; allowed: up to {_LONGEST}")
    kept = [*filter(None, (plain(line.translate(_POWERS)).strip(_COMMENT) for line in lines))]
    for i in reversed(range(len(kept))[-_NEAR:]):
        labels, above = (_labels(line, delimiter, count, least) for line in (kept[i], kept[i - 1] if i else ""))
        under = [label.bracket or label.name for label in labels]
        alone = not any(label.name and label.bracket for label in labels) and any(under)
        units = alone and all(not unit or unit_of(unit) or _OTHER_UNIT.fullmatch(unit) for unit in under)
        if units and any(label.name for label in above):
            pairs = zip(above, under, strict=True)
            merged = [Label(a.name, ",".join(dict.fromkeys(filter(None, (a.bracket, unit))))) for a, unit in pairs]
            return Header(merged, kept[: i - 1] + kept[i + 1 :])
        if any(label.bracket or label.role for label in labels):
            return Header(labels, kept[:i] + kept[i + 1 :])
    return Header([Label("")] * count, kept)


def _labels(line: str, delimiter: str | None, count: int, least: int) -> list[Label]:
    """The labels in a line if it is one, parted as the rows are, else nothing."""
    parts = [line] if count == 1 else cells(line, delimiter)
    if delimiter is None and len(parts) != count:
        parts = re.findall(r"[^\[\]()]*[\[(][^\])]*[\])]", line)  # names of several words, with units
    while len(parts) > count and not parts[-1]:
        parts.pop()
    parts += [""] * (count - len(parts)) if len(parts) >= least else []
    found = [_LABEL.fullmatch(part.strip("\"' ,;")) for part in parts]
    good = len(found) == count and all(found)
    return [Label(label[1] or label[3] or "", label[2] or "") for label in found if label] if good else []
