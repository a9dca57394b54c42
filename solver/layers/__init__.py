"""Elastic layers: what a layer must offer (`layer`), and one file for each kind of layer.

Whoever adds a layer writes one file here and adds one line to `LAYERS`.

May import: arrays, checks, display, quadrature.
"""

from .bonded import Layer
from .layer import EdgeSymbol, ElasticLayer

LAYERS: dict[str, type[ElasticLayer]] = {kind.name: kind for kind in (Layer,)}
"""The one list of layers, by name; the first is the default."""

__all__ = ["LAYERS", "EdgeSymbol", "ElasticLayer", "Layer"]
