"""Layers and profiles that `linecontact solve` knows: dataclasses, named as "module:Class", whose fields are options.

Imports nothing: a mistyped option is refused before any of them is imported.
"""

LAYER = "linecontact.solver.scene:Layer"
"""The layer: its fields are options without more ado."""

PROFILES: dict[str, str] = {
    "power": "linecontact.solver.indenters:PowerIndenter",
    "rough": "linecontact.solver.indenters:RoughIndenter",
    "file": "linecontact.studies.scans:Options",
}
"""By what --profile calls them, one line for each: indenters, and how to read one from a file."""


def titles() -> dict[str, str]:
    """All of them, by the titles that their options have in --help."""
    return {"layer": LAYER, **{title("profile", name): kind for name, kind in PROFILES.items()}}


def title(what: str, name: str) -> str:
    """The title of the options that belong to one kind; what: the option that chooses it by its name."""
    return f"only with --{what} {name}"
