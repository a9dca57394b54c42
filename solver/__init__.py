"""Scenes, methods, certificates, closed forms and collocation. Knows no study's files and no plots.

From the scene to the solution: `scene` (with `layers` and `indenters`) is a layer under an indenter; `grid` makes
the discrete problem of it, and measures solutions; `methods` solve the problem on one grid; `strategy` chooses method,
grids and precision and has the result certified; `solve` is the way in. `reference` needs no grid.

May import: linecontact.kernels.
"""

from .endings import Reason, Status
from .grid.certificate import Certificate, certify
from .grid.errors import QUANTITIES
from .grid.observables import Observables
from .grid.patch_table import PatchTable
from .indenters import INDENTERS, Indenter, MeasuredIndenter, PowerIndenter, RoughIndenter
from .layers import LAYERS, CoatedHalfSpace, ElasticLayer, Layer, SlidingLayer, TabulatedLayer
from .methods import METHODS, Method, MethodKind
from .scene import Scene
from .solution import Choice, Solution
from .solve import solve
from .strategy.linearised import contact_stiffness

__all__ = [
    "INDENTERS",
    "LAYERS",
    "METHODS",
    "QUANTITIES",
    "Certificate",
    "Choice",
    "CoatedHalfSpace",
    "ElasticLayer",
    "Indenter",
    "Layer",
    "MeasuredIndenter",
    "Method",
    "MethodKind",
    "Observables",
    "PatchTable",
    "PowerIndenter",
    "Reason",
    "RoughIndenter",
    "Scene",
    "SlidingLayer",
    "Solution",
    "Status",
    "TabulatedLayer",
    "certify",
    "contact_stiffness",
    "solve",
]
