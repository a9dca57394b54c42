"""Scenes, methods, certificates, closed forms and the collocation oracle. Knows no study's files and no plots."""

from .certificate import Certificate, certify
from .fire import Status
from .observables import Observables
from .scene import Layer, PowerIndenter, Scene
from .solve import METHODS, Solution, default_tolerance, solve

__all__ = [
    "METHODS",
    "Certificate",
    "Layer",
    "Observables",
    "PowerIndenter",
    "Scene",
    "Solution",
    "Status",
    "certify",
    "default_tolerance",
    "solve",
]
