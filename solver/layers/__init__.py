"""Elastic layers: their common members (`layer`), and one file for each kind of layer.

Whoever adds a layer writes one file here and adds one line to `LAYERS`.

May import: arrays, checks, display, value.
"""

from .bonded import Layer
from .coated import CoatedHalfSpace
from .layer import ElasticLayer
from .sliding import SlidingLayer
from .tabulated import TabulatedLayer

LAYERS: dict[str, type[ElasticLayer]] = {
    kind.name: kind for kind in (Layer, SlidingLayer, CoatedHalfSpace, TabulatedLayer)
}
"""The one list of layers, by name; the first is the default."""

__all__ = ["LAYERS", "CoatedHalfSpace", "ElasticLayer", "Layer", "SlidingLayer", "TabulatedLayer"]
