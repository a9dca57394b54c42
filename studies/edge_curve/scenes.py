"""The scenes of the study, as its tasks and its figure know them."""

from typing import Any

from linecontact.solver import CoatedHalfSpace, Layer, SlidingLayer
from linecontact.solver.layers import ElasticLayer

from ..files.study_files import StudyFile
from ..runner.tasks import Record

SCENE = ("exponent", "layer", "spacings", "poisson_ratio", "base_modulus")
"""Numbers that tell the scenes of the study apart, as columns of its file."""


def layer_of(kind: str, thickness: float, poisson_ratio: float, base_modulus: float) -> ElasticLayer:
    """The layer of a task; thickness: over the period, base_modulus: over E* (dimensionless)."""
    if kind == "coated":
        return CoatedHalfSpace(thickness, base_modulus, poisson_ratio)
    return SlidingLayer(thickness) if kind == "sliding" else Layer(thickness, poisson_ratio)


def by_scene(file: StudyFile) -> dict[tuple[Any, ...], list[Record]]:
    """The records of a file by the values of `SCENE`."""
    found: dict[tuple[Any, ...], list[Record]] = {}
    for run in file.runs:
        found.setdefault(tuple(run[name] for name in SCENE), []).append(run)
    return found
