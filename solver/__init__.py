"""Scenes, methods, certificates, closed forms and the collocation oracle. Knows no study's files and no plots."""

from .certificate import Certificate, certify
from .indenters import MeasuredIndenter, PowerIndenter, RoughIndenter
from .observables import Observables
from .relaxation import Status
from .run import BELOW_FLOOR, METHODS, default_tolerance
from .scene import Layer, Scene
from .solution import Choice, Solution
from .solve import solve

__all__ = [
    "BELOW_FLOOR",
    "METHODS",
    "Certificate",
    "Choice",
    "Layer",
    "MeasuredIndenter",
    "Observables",
    "PowerIndenter",
    "RoughIndenter",
    "Scene",
    "Solution",
    "Status",
    "certify",
    "default_tolerance",
    "solve",
]
