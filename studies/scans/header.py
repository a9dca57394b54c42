"""What the header of a text says of its columns: which holds positions, which heights, and in which units.

A label is a cell of the lines above the table ("Lateral um", "Height [nm]", "z / mm"). Units also stand in lines of
their own ("X Unit: um", "x in mm, z in nm"). What is written there is taken at its word; what contradicts itself, or
names something else than a length, is for the user to decide.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from .units import plain, unit_of

Role = Literal["x", "z", "depth", "index", ""]

_WORDS: dict[Role, str] = {
    "index": r"index|idx|no|nr|n|i|#|points?|samples?|num|number|row",
    "z": r"z|heights?|profile|raw|topography|elevation|vertical|amplitude|level(?:l?ed)?|filtered|h\u00f6he|hoehe",
    "x": r"x|lateral|positions?|pos|distance|dist|length|scan|abscissa|horizontal|track|travel|traverse|weg",
}
_DOWNWARDS = re.compile(
    r"depth|tiefe|invert|_inv\b|flipped|down|gap|separation|clearance|profond|into|minus|negative"
    r"|(?:^|\()\s*[-\u2013]\s*\(?(?:z|h)|\bz\s*-\s*(?:$|[\[(])|\*\s*\(?-\s*1"
)
"""Heights under such a name may grow into the valleys."""
_SAID_DOWNWARDS = re.compile(
    r"\b(?:values|heights|data|z|profile)\b\s*(?:are|is|axis)?\s*:?\s*(?:points\s+)?(?:depths?|inverted|down)"
    r"|positive\s+(?:down|into)|\binverted\s*[:=]\s*[yt1]|\bgap\s+between"
)
_VALUE = re.compile(r"(?:^|[\s:=<>~\u00b1\u2013-])[-+]?[\d.,]*\d(?:[eE][-+]?\d+)?\s*(?:$|[\[({<]|[^\W\d]+$)")
"""A number at the end of a cell, or one with a unit: the value of a parameter, and no label."""
_COUNTED = re.compile(
    rf"\b(profile|line|channel|ch|trace|curve)[\s_#]*\d+\b|^(\W*(?:{_WORDS['x']}|{_WORDS['z']}))\d(?=[\W_]*$)", re.I
)
"""One of several columns of a kind, `Profile 12` or `z2`: its number is no value."""
_PARAMETER = re.compile(
    r"\b(?:range|resolution|spacing|size|cut-?off|filter|radius|speed|force|pitch|limits?|tolerance|stage|offset|width)\b"
)
"""Names of numbers that describe a scan; with a unit they are no label of a column."""
_OF_ANOTHER = re.compile(
    r"^\W*(?:log|log10|ln|lg|sqrt)\b|\bper\s+(?!line|trace|scan|profile)"
    r"|\b(?:divided|multiplied|times|bits?|counts?|squared|logarithm\w*|wurzel|racine)\b"
    r"|\b(?:psd|fft|db|spe[ck]tr\w*|density|\w*correlation)\b"
    r"|\b(?:slope|gradient|curvature)\b(?!\W*(?:corrected|removed|compensated|subtracted|free))"
)
"""What stands beside a unit where the numbers are not lengths in it, but something made of them."""
_NEUTRAL = {"data", "values", "axis", "surface", "total"}
_LINES = 2  # above the table, that may label its columns: names, and units below them
_LONGEST = 1000  # characters of a line that is looked at
_AXIS = r"x|lateral|horizontal|positions?|z|heights?|vertical"
_BOTH = r"lengths|coordinates|data|columns|both"
_UNIT_LINE = re.compile(
    rf"(?:({_AXIS})[\s_-]*(?:axis[\s_-]*)?)?(?:units?|einheit|unit[e\u00e9])\b(?:\s+({_AXIS})\b)?[\"'\s]*[:=,;\t](.*)",
    re.I,
)
"""A line that names units: "X Unit: um", "Units,um", "Einheit X: mm"."""
_CLAUSE = re.compile(rf"(?:all\s+)?(?:({_AXIS})|{_BOTH})\s+(?:is\s+|are\s+|given\s+)*in\s+(\S+?)\.?", re.I)
"""Part of a line that names one: "x in mm", "all lengths in um"."""


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
    bare: bool = False
    """Whether its unit stands without brackets or another sign of one."""

    @property
    def names_unit(self) -> bool:
        """Whether it names a unit, of length or not."""
        return bool(self.unit or self.unknown)


def labels(lines: Sequence[str], delimiter: str | None, count: int) -> list[Label]:
    """Labels of the `count` columns of a table from the lines above it; empty if there are none."""
    found: list[Label] = []
    while lines and not lines[-1].strip():
        lines = lines[:-1]
    for line in lines[: -_LINES - 1 : -1]:
        cells = _cells(line, delimiter, count)
        if not cells and not found and line.lstrip().startswith(("#", "%")):
            continue  # a comment below the labels
        values = any(_VALUE.search(_uncounted(cell)) or _PARAMETER.search(cell.lower()) for cell in cells)
        if not cells or values or any(label.role and label.unit for label in found):
            break
        read = _row(cells)
        if delimiter is None and count > 1 and not _any_unit(read):
            break  # a title of as many words
        found = [_merged(above, below) for above, below in zip(read, found, strict=True)] if found else read
    if count == 1 and found and found[0].role not in ("z", "depth") and not unit_of(found[0].text.strip("[]()<>")):
        return []  # the last line of a header of anything
    return found if any(label.role for label in found) or _any_unit(found) else []


def like_labels(lines: Sequence[str], delimiter: str | None, count: int) -> str:
    """The line right above a table without labels, where its cells name units all the same; else empty."""
    line = next((line.strip() for line in reversed(lines) if line.strip()), "")
    return line if any(_label(cell).names_unit for cell in _cells(line, delimiter, count)) else ""


def is_downwards(lines: Sequence[str]) -> bool:
    """Whether a header says anywhere that its heights may grow into the valleys."""
    return any(_SAID_DOWNWARDS.search(plain(line[:_LONGEST]).lower()) for line in lines)


def stated_units(lines: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Units named by lines of their own: the axis 'x' or 'z', the unit (empty unless it is one of length), the line."""
    for line in (plain(line) for line in lines if len(line) <= _LONGEST):
        bare = line.lstrip("#%*;\"' ")
        if match := _UNIT_LINE.fullmatch(bare):
            found = [(match[1] or match[2], set(re.findall(r"[^\s,;=:\"']+", match[3])))]
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
    if len(line) > _LONGEST:
        return []
    line = plain(line.replace("\u00b2", "^2").replace("\u00b3", "^3")).lstrip("#%").strip()
    if count == 1:
        ways = [[line]]
    elif delimiter:
        ways = [next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    else:
        bracketed = re.findall(r"[^\[\](){}]*[\[(][^\])]*[\])]", line)
        ways = [re.split(r"\s{2,}|\t|,|;", line), bracketed, line.split()]
    for cells in ways:
        cells = [cell.strip().strip("\"'").strip() for cell in cells]
        while cells and not cells[-1]:
            cells.pop()
        if len(cells) == count and any(cells):
            return cells
    return []


def _row(cells: Sequence[str]) -> list[Label]:
    """What the cells of one line say: units alone in all of them, or labels."""
    alone = [unit_of(cell.strip("[](){}<> ")) or "" for cell in cells]
    if all(unit or not cell for cell, unit in zip(cells, alone, strict=True)):
        return [Label(cell, "", unit) for cell, unit in zip(cells, alone, strict=True)]
    row = [_label(cell) for cell in cells]
    strangers = any(label.text and not (label.role or label.names_unit) for label in row)
    if strangers and any(label.bare for label in row):
        return [Label(cell, "", "") for cell in cells]  # a title, and something that ends like a unit
    return row


def _any_unit(row: Sequence[Label]) -> bool:
    return any(label.names_unit for label in row)


def _label(text: str) -> Label:
    """What one cell says."""
    brackets = list(re.finditer(r"[\[({<]\s*(?:in\s+|units?\s*:\s*)?([^\])}>]*?)\s*[\])}>]", text))
    bracket = next((found for found in reversed(brackets) if unit_of(found[1])), brackets[-1] if brackets else None)
    stated = bracket or re.search(r"\s(?:in\s+|/\s*)(\S+)$|(?<=\w)/(\S+)$", text)
    name, unit, unknown = text, "", ""
    if stated:
        word = next(group for group in (*stated.groups(), "") if group is not None)
        name, unit = f"{text[: stated.start()]} {text[stated.end() :]}", unit_of(word) or ""
        unknown = "" if unit else word
    else:
        *words, last = re.split(r"[\s_,:=.]+", text)
        alone = unit_of(last, expected=False)
        if alone and words and all(word.lower() in _NEUTRAL or _role(word) for word in words):
            name, unit = " ".join(words), alone
    others = {unit_of(found[1]) for found in brackets} | {unit_of(word, expected=False) for word in name.split()}
    over = stated and re.match(r"/\s*\w", text[stated.end() :])  # "Height (nm)/bit"
    changed = re.search(r"[\d^]", _uncounted(name)) or _OF_ANOTHER.search(name.lower()) or over
    if unit and (changed or others - {None, unit}):
        unit, unknown = "", text  # a factor, "x10 nm", or two units
    return Label(text, _role(name), unit, unknown, bool(unit) and not stated)


def _uncounted(text: str) -> str:
    """The same without the numbers of columns."""
    return _COUNTED.sub(r"\1\2", text)


def _role(name: str) -> Role:
    """What the words of a label say that its column holds; empty if they say two things, or none."""
    if _DOWNWARDS.search(name.lower()):
        return "depth"
    words = re.findall(r"[^\s_,:.()\[\]{}<>\-]+", _uncounted(name).lower())
    said = {role for role, pattern in _WORDS.items() if any(re.fullmatch(pattern, word) for word in words)}
    if len(said) > 1:
        said -= {"index"}  # "sample position"
    return said.pop() if len(said) == 1 else ""


def _merged(above: Label, below: Label) -> Label:
    """One label from two lines, names above units."""
    text = f"{above.text} {below.text}"
    role, unit, unknown = below.role or above.role, below.unit or above.unit, below.unknown or above.unknown
    if (above.unit and below.unit and above.unit != below.unit) or (unit and _OF_ANOTHER.search(text.lower())):
        unit, unknown = "", text
    return Label(text, role, unit, unknown)
