"""Indenters: their common members (`indenter`), and one file for each kind of indenter.

Whoever adds an indenter writes one file here and adds one line to `INDENTERS`.

May import: arrays, calibration, checks, display, transforms, reference, units, value.
"""

from .indenter import Indenter
from .measured import MeasuredIndenter
from .power import PowerIndenter
from .rough import RoughIndenter

INDENTERS: dict[str, type[Indenter]] = {kind.name: kind for kind in (PowerIndenter, RoughIndenter, MeasuredIndenter)}
"""The one list of indenters, by name; the first is the default."""

__all__ = ["INDENTERS", "Indenter", "MeasuredIndenter", "PowerIndenter", "RoughIndenter"]
