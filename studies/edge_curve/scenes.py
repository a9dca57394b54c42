"""The scenes of the study, as its tasks and its figure know them."""

from typing import Any

import numpy as np
from linecontact.solver import CoatedHalfSpace, Layer, SlidingLayer
from linecontact.solver.arrays import Array64
from linecontact.solver.grid.edge_curves import EdgeCurve
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


def from_two(curve: EdgeCurve, ratio: Array64) -> Array64:
    """How far the edge lies inside the last node, -s to 1 - s, of the shape of ratio [grid spacings].

    ratio: of the last node's pressure to the second last's.
    """
    two = curve.table[0] - ratio * curve.table[1]
    return np.asarray(np.clip(two / (two + ratio * curve.table[0]) - curve.shift, -curve.shift, 1 - curve.shift))


def by_scene(file: StudyFile) -> dict[tuple[Any, ...], list[Record]]:
    """The records of a file by the values of `SCENE`."""
    found: dict[tuple[Any, ...], list[Record]] = {}
    for run in file.runs:
        found.setdefault(tuple(run[name] for name in SCENE), []).append(run)
    return found
