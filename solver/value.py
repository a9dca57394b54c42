"""Frozen dataclasses that are their fields: equal where these are, and made anew where they are copied or pickled."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, ClassVar, Protocol

import numpy as np


class Value(Protocol):
    """A dataclass of its own equality, in which NaN equals NaN and arrays are compared value by value.

    A copy comes from the constructor, which checks it and makes its arrays read-only as it did with the first one's.
    A dataclass that can still be changed has no hash: nothing that is kept by it may outlive a change.
    """

    _remade: ClassVar[Mapping[str, Any]] = {}
    """Values of the `InitVar`s, for the constructor of a copy."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        for name, own in (("__eq__", _equal), ("__hash__", _hash)):
            if name not in cls.__dict__:  # a dataclass would make its own
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
    """Raises `TypeError` for what can be changed."""
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
