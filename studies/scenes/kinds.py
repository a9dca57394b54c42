"""Layers and profiles that `linecontact solve` knows: the solver's own lists, whose fields are options."""

CHOICES = ("layer", "profile")
"""The choices, by the name of its option."""


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
