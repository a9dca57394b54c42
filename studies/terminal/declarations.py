"""The declarations of a dataclass, read from the source of its module: its fields and their descriptions.

The module itself is not imported, nor are those that its base classes come from: all studies together take seconds, and
can be listed without them.

A class is named as "module:Class". Its description of a field is in the string below it, or in the class's docstring
on a line of its own: "name: text", continued on lines that are indented.
"""

import ast
import importlib.util
import inspect
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.machinery import ModuleSpec

_ENTRY = re.compile(r"^\w+: .*(?:\n[ ]+\S.*)*", re.MULTILINE)
"""The description of a field in a docstring."""


@dataclass(frozen=True)
class Declaration:
    """A dataclass as its source declares it.

    text: its docstring, without descriptions of fields.
    fields: each field's description, its base classes' fields included, by name and in order; empty where nothing is.
    """

    text: str
    fields: dict[str, str]

    @property
    def summary(self) -> str:
        """The first paragraph of the docstring, in one line."""
        return _one_line(self.text.split("\n\n")[0])


def read(kind: str) -> Declaration | None:
    """The declaration of a class, named as "module:Class"; None if it cannot be known from the source alone."""
    found = _find(*kind.split(":"))
    if found is None:
        return None
    module, node = found
    if module == "typing":  # its classes have no fields, and since Python 3.12 not all have a source
        return Declaration("", {})
    text = ast.get_docstring(node) or ""
    fields: dict[str, str] = {}
    for base in reversed(node.bases):
        inherited = read(f"{module}:{ast.unparse(base)}")
        if inherited is None:
            return None
        fields |= inherited.fields
    own = _own_fields(node) if any("dataclass" in ast.unparse(one) for one in node.decorator_list) else {}
    for entry in _ENTRY.findall(text):
        name, _, said = entry.partition(": ")
        if name in own:
            own[name] = own[name] or said
            text = text.replace(entry, "")
    for name, said in own.items():
        fields[name] = _one_line(said) or fields.get(name, "")
    return Declaration(re.sub(r"\n\n\n+", "\n\n", text).strip(), fields)


def summary(kind: str) -> str:
    """The first paragraph of a class's docstring; empty if the source does not tell."""
    declared = read(kind)
    return declared.summary if declared else ""


def _own_fields(node: ast.ClassDef) -> dict[str, str]:
    """The strings below the fields that the class itself declares, by name; empty where there is none."""
    own: dict[str, str] = {}
    for statement, following in zip(node.body, [*node.body[1:], None], strict=True):
        if not isinstance(statement, ast.AnnAssign) or not isinstance(statement.target, ast.Name):
            continue
        if "ClassVar" not in ast.unparse(statement.annotation):
            below = following.value if isinstance(following, ast.Expr) else None
            own[statement.target.id] = str(below.value) if isinstance(below, ast.Constant) else ""
    return own


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _find(module: str, name: str) -> tuple[str, ast.ClassDef] | None:
    """The module and the source of a class that `module` calls `name`, like `Options` or `base.Options`.

    It may be imported there from elsewhere.
    """
    parsed = _parse(module)
    first, _, rest = name.partition(".")
    for node in parsed[0].body if parsed else ():
        if isinstance(node, ast.ClassDef) and node.name == name:
            return module, node
        if isinstance(node, ast.ImportFrom):
            names = [alias.name for alias in node.names if (alias.asname or alias.name) == first]
            if names and parsed:
                origin = importlib.util.resolve_name("." * node.level + (node.module or ""), parsed[1])
                return _find(f"{origin}.{names[0]}", rest) if rest else _find(origin, names[0])
    return None


@cache
def _parse(module: str) -> tuple[ast.Module, str] | None:
    """A module's source and the package that it is in; None if there is no source."""
    loaded, spec = sys.modules.get(module), _spec(module)
    try:
        if loaded is not None:
            return ast.parse(inspect.getsource(loaded)), loaded.__package__ or ""
        source = spec.loader.get_source(module) if spec else None  # type: ignore[union-attr]
    except (AttributeError, ImportError, OSError, TypeError):
        return None
    return (ast.parse(source), spec.parent or "") if spec and source is not None else None


def _spec(module: str) -> ModuleSpec | None:
    """Where a module is; unlike `importlib.util.find_spec` without importing the packages that it is in."""
    if module in sys.modules:
        return sys.modules[module].__spec__
    package = module.rpartition(".")[0]
    inside = _spec(package) if package else None
    if package and (inside is None or inside.submodule_search_locations is None):
        return None
    path: Sequence[str] | None = inside.submodule_search_locations if inside else None
    found = (finder.find_spec(module, path) for finder in sys.meta_path)
    return next((spec for spec in found if spec is not None), None)
