"""Frozen dataclasses that are their fields: equal where these are, and made anew where they are copied or pickled."""

import inspect
from abc import ABC
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from . import display, units


class Value:
    """A dataclass of its own equality, in which NaN equals NaN and arrays are compared value by value.

    A copy comes from the constructor, which checks it and makes its arrays read-only as it did with the first one's.
    A dataclass that can still be changed has no hash: nothing that is kept by it may outlive a change.
    """

    _remade: ClassVar[Mapping[str, Any]] = {}
    """Values of the `InitVar`s, for the constructor of a copy."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        for name, own in (("__eq__", _equal), ("__hash__", _hash), ("__repr__", _line)):
            if name not in cls.__dict__:  # a dataclass would make its own, and that of numbers without units
                setattr(cls, name, own)

    def __reduce_ex__(self, protocol: Any) -> Any:
        if not is_dataclass(self):
            return super().__reduce_ex__(protocol)
        # a default is left to the constructor, which knows it from a number that is given
        given = {f.name: v for f in fields(self) if f.init and (v := getattr(self, f.name)) is not f.default}
        return _made, (type(self), {**given, **self._remade})


def _made(kind: type, given: dict[str, Any]) -> Any:
    return kind(**given)


def _equal(one: Any, other: Any) -> Any:
    if one is other:
        return True
    if type(one) is not type(other) or not is_dataclass(one):
        return NotImplemented
    return all(_same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one) if f.compare)


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    return one is other or bool(one == other) or (one != one and other != other)


def _hash(one: Any) -> int:
    """Raises `TypeError` for an object that can be changed."""
    known = getattr(one, "__dataclass_params__", None)
    if known is None or not known.frozen:
        raise TypeError(f"unhashable: {type(one).__name__}, which is no frozen dataclass")
    return hash(tuple(_looked_at(getattr(one, f.name)) for f in fields(one) if f.compare and f.hash is not False))


def _looked_at(value: Any) -> Any:
    if not isinstance(value, np.ndarray):
        return None if isinstance(value, float) and value != value else value
    if value.flags.writeable:
        raise TypeError("unhashable: an array that can be written to")
    return value.shape  # equality tells arrays of one shape apart


def _line(instance: Any) -> str:
    return display.line(instance) if is_dataclass(instance) else object.__repr__(instance)


class Kind(Value, ABC):
    """A kind of layer or of indenter: numbers with units.

    Making such a class raises `ValueError` like `units.declare`.
    """

    name: ClassVar[str]
    """Its name on the command line and in stored results."""
    part: ClassVar[str]
    """Under which name that stands in its description: 'layer' or 'profile'."""
    units: ClassVar[Mapping[str, str]] = {}
    """Units of its fields by name: 'length', 'pressure' or 'pressure/length'. A field that is not named here has the
    unit that the program has for its name, as for `thickness` and `radius`, and is dimensionless if it has none."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        # annotations may be texts; a class variable is no number of a layer or an indenter
        numbers = [name for name, of in inspect.get_annotations(cls).items() if "ClassVar" not in str(of)]
        units.declare(cls.__dict__.get("units", {}), numbers)

    def to_dict(self) -> dict[str, Any]:
        """Flat, JSON-ready description under the command line's names: numbers, texts, truth values, or lists of them;
        its name as 'layer' or 'profile', and by default the fields that are not None.
        """
        return {self.part: self.name} | self._given()

    def ratios(self, period: float) -> dict[str, float]:
        """The dimensionless numbers, by name, that must be neither too large nor too small to compute with."""
        return {}

    def in_units(self, length: float, pressure: float = 1.0) -> Self:
        """The same in other units: lengths are multiplied by `length`, pressures by `pressure`."""
        sizes = {"length": length, "pressure": pressure, "pressure/length": pressure / length}
        given = self._given()
        names = {name: self.units.get(name) or units.unit(name) for name in given}
        scaled = {name: given[name] * sizes[of] for name, of in names.items() if of in sizes}
        return replace(self, **scaled, **self._remade) if scaled else self  # type: ignore[type-var]

    def _given(self) -> dict[str, Any]:
        """Its fields that are not None. Raises `ValueError` for a class without fields."""
        if not is_dataclass(self):
            kind = type(self).__name__
            raise ValueError(f"{kind} is not a dataclass; allowed: one, as its fields describe it, or its own to_dict")
        known = {f.name: getattr(self, f.name) for f in fields(self)}
        return {name: value for name, value in known.items() if value is not None}
