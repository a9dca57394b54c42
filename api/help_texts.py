"""The `help` of a public class: its docstring, and the text in the source below each of its fields."""

import textwrap
from typing import Any

_WIDTH = 100


class _WithFields(str):
    """A docstring that goes on with the fields of its class; they are read from the source when somebody asks for it.

    Classes are asked as a descriptor is. Where they have a metaclass of their own, `help` takes the docstring itself,
    and its first step is `expandtabs`.
    """

    __slots__ = ("_kind",)
    _kind: str

    @classmethod
    def of(cls, thing: type) -> "_WithFields":
        """The docstring of a dataclass."""
        made = cls(thing.__doc__ or "")
        made._kind = f"{thing.__module__}:{thing.__qualname__}"
        return made

    def __get__(self, instance: object, owner: type) -> str:
        return self._whole()

    def expandtabs(self, tabsize: Any = 8) -> str:
        return self._whole().expandtabs(tabsize)

    def _whole(self) -> str:
        from .studies.terminal.declarations import read

        declared = read(self._kind)
        if declared is None:  # there is no source
            return str(self)
        fields = (_entry(name, said) for name, said in declared.fields.items())
        return "\n".join([declared.text, "", "Fields:", "", *fields])


def _entry(name: str, said: str) -> str:
    return textwrap.fill(f"{name}: {said}", _WIDTH, initial_indent="  ", subsequent_indent="      ")


def with_fields(thing: Any) -> Any:
    """A dataclass whose help names its fields, and anything else as it is."""
    has_fields = isinstance(thing, type) and hasattr(thing, "__dataclass_fields__")
    if has_fields and not isinstance(vars(thing).get("__doc__"), _WithFields):
        thing.__doc__ = _WithFields.of(thing)
    return thing
