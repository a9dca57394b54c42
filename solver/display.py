"""Scenes and solutions as they are printed: a few lines with units, and a table in a notebook."""

import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import fields
from decimal import ROUND_CEILING, Context
from html import escape
from typing import Any, NamedTuple

import numpy as np

from .units import named, shown, unit

_WIDTH = 100  # columns of a printed line, and characters of a text in it


class Row(NamedTuple):
    """A quantity as it is shown."""

    name: str
    """Its name."""
    value: str
    """Its value, numbers with up to six digits, errors with two."""
    unit: str
    """Its unit; '-' where it is dimensionless, empty for a text."""


def row(name: str, value: Any, names: Mapping[str, str] | None = None) -> Row:
    """A quantity by its name in results. names: of the scene's units, as `units.named` tells them."""
    if name.rpartition(".")[2] == "thickness" and str(value) == "inf":
        return Row(name, "half-space", "")
    if isinstance(value, str):
        return Row(name, textwrap.shorten(value, _WIDTH, placeholder=" ..."), "")
    told = rounded_up(value) if name.endswith("_error") else number(value)
    return Row(name, told, shown(unit(name), names or named({})))


_UP = Context(prec=2, rounding=ROUND_CEILING)


def rounded_up(value: float) -> str:
    """A number with two digits that are not below it, whatever its sign: an estimated error, or a bound."""
    return f"{float(_UP.create_decimal(repr(float(value)))):.2g}"


def counted(count: int, noun: str) -> str:
    """A count with its noun, like '1 line' or '2 lines'."""
    return f"{count} {noun}" + "s" * (count != 1)


def number(value: Any) -> str:
    """A number with up to six digits; of an array, how many values it holds."""
    if isinstance(value, np.ndarray):
        return counted(value.size, "value")
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def line(instance: Any) -> str:
    """The fields of a dataclass in a line or a few, those left out that are None."""
    values = ((field.name, getattr(instance, field.name)) for field in fields(instance))
    return sentence(type(instance).__name__, (row(name, value) for name, value in values if value is not None))


def sentence(title: str, rows: Iterable[Row]) -> str:
    """Quantities in a line, wrapped where it would be too long."""
    told = [
        found.value if found.value == "half-space" else f"{found.name} {found.value}" + bracketed(found.unit)
        for found in rows
    ]
    kept = (text.replace(" ", "\0") for text in told)  # a line does not end inside of a quantity
    return textwrap.fill(
        f"{title}: {', '.join(kept)}", _WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
    ).replace("\0", " ")


def bracketed(unit: str) -> str:
    """A unit in brackets after a space; empty for no unit."""
    return f" [{unit}]" if unit else ""


def html_table(title: str, rows: Iterable[Row]) -> str:
    """A small table for a notebook; whatever the texts hold is shown as it is."""
    cells = "".join(
        f'<tr><td style="text-align: left">{escape(found.name)}</td>'
        f'<td style="text-align: right">{escape(found.value)}</td>'
        f'<td style="text-align: left">{escape("dimensionless" if found.unit == "-" else found.unit)}</td></tr>'
        for found in rows
    )
    head = '<tr><th style="text-align: left">quantity</th><th>value</th><th style="text-align: left">unit</th></tr>'
    return f"<table><caption>{escape(title)}</caption><thead>{head}</thead><tbody>{cells}</tbody></table>"
