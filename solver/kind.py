"""What layers and indenters have in common: numbers with units, which they show when they are printed."""

import inspect
from collections.abc import Mapping
from dataclasses import is_dataclass
from typing import Any, ClassVar, Protocol

from . import display, units
from .value import Value


class Kind(Value, Protocol):
    """A kind of layer or of indenter. Making such a class raises `ValueError` like `units.declare`."""

    units: ClassVar[Mapping[str, str]] = {}
    """Units of its fields by name: 'length', 'pressure' or 'pressure/length'. A field that is not named here has the
    unit that the program has for its name, as for `thickness` and `radius`, and is dimensionless if it has none."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        # annotations may be texts; what belongs to the class is no number of a layer or an indenter
        numbers = [name for name, of in inspect.get_annotations(cls).items() if "ClassVar" not in str(of)]
        units.declare(cls.__dict__.get("units", {}), numbers)
        if "__repr__" not in cls.__dict__:  # a dataclass would make its own, without units
            cls.__repr__ = _line  # type: ignore[assignment]


def _line(instance: Any) -> str:
    return display.line(instance) if is_dataclass(instance) else object.__repr__(instance)
