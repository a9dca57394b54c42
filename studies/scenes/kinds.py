"""Layers and profiles that `linecontact solve` knows: the solver's own lists, whose fields are options."""

from ..terminal import declarations

CHOICES = {"layer": "linecontact.solver.layers:LAYERS", "profile": "linecontact.solver.indenters:INDENTERS"}
"""What there is to choose, by the name of its option, and the list that it is chosen from."""

READERS = ("linecontact.studies.scans.reading:Options", "linecontact.studies.scenes.stiffness_file:Options")
"""How heights and a layer's stiffness are read from a file; they stand for the indenter and the layer that are given
point by point."""


def declared() -> list[str]:
    """All of them as "module:Class", without importing any."""
    return [*(kind for listed in CHOICES.values() for kind in declarations.members(listed)), *READERS]


def classes(choice: str) -> dict[str, type]:
    """The dataclasses that an option chooses from, by name."""
    from linecontact.solver import INDENTERS, LAYERS, MeasuredIndenter, TabulatedLayer

    from ..scans import reading
    from . import stiffness_file

    if choice == "layer":
        return dict(LAYERS) | {TabulatedLayer.name: stiffness_file.Options}
    return dict(INDENTERS) | {MeasuredIndenter.name: reading.Options}


def title(choice: str, name: str) -> str:
    """The title of the options that belong to one kind."""
    return f"only with --{choice} {name}"


def titled() -> dict[str, type]:
    """All of them, by the titles that their options have in --help."""
    return {title(choice, name): kind for choice in CHOICES for name, kind in classes(choice).items()}
