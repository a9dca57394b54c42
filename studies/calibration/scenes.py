"""Random scenes of several families, and finer ones that tell their errors."""

import math
from dataclasses import replace

import numpy as np
from linecontact.solver import (
    CoatedHalfSpace,
    Indenter,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    SlidingLayer,
)
from linecontact.solver.grid.problem import Problem
from linecontact.solver.layers import ElasticLayer

FAMILIES = ("power", "rough", "few nodes", "nearly full", "waves", "unfinished")
UNFINISHED = FAMILIES[-1]
"""Those whose iteration was ended early; the truth is on the same grid."""

_FINER = 16
"""Times the points of a scene that its reference has."""


def draw(family: str, seed: int) -> tuple[Scene, Scene]:
    """A scene, and the one that tells its errors. Raises `ValueError` for one that cannot be solved."""
    rng = np.random.default_rng([FAMILIES.index(family), seed])
    n = int(2 ** rng.integers(10, 14))
    layer = _layer(rng)
    if family in ("power", UNFINISHED) or (family == "few nodes" and rng.random() < 0.3):
        exponent = float(rng.choice([2.0, 1 + 10 ** rng.uniform(-1.5, 0.85)]))
        half = _few(rng, n) if family == "few nodes" else float(10 ** rng.uniform(math.log10(2 / n), -0.4))
        load = math.pi / 4 * half**exponent * _stiffness(layer, 1 / half)
        scene = Scene(layer, PowerIndenter(exponent), load, num_points=n)
        return scene, scene if family == UNFINISHED else scene.on_grid(_FINER * n)
    if family == "waves":
        return _waves(rng, layer, n)
    surface: Indenter = _rough(rng, seed, n)
    if family == "rough":
        load = 10 ** rng.uniform(-3, -0.7) * max(1.0, _stiffness(layer, n / 16) ** 0.5)
    elif family == "few nodes":
        load = _load_of_few(rng, layer, surface, n)
    else:
        if rng.random() < 0.3:
            surface = PowerIndenter(float(rng.uniform(1.05, 5)))
        full = Problem.from_scene(Scene(layer, surface, 1.0, num_points=_FINER * n)).full_contact_pressure
        load = full * (1 - 10 ** rng.uniform(-4, -0.7))
    given = surface
    if rng.random() < 0.4 and not surface.power_law:
        given = MeasuredIndenter(surface.profile(n, 1.0), convention="gap")
    fine = Scene(layer, surface, float(load), num_points=_FINER * n)
    return replace(fine, indenter=given, num_points=n), fine


def _layer(rng: np.random.Generator) -> ElasticLayer:
    kind, thickness = rng.random(), float(10 ** rng.uniform(-4, 0))
    if kind < 0.35:
        return Layer()
    if kind < 0.6:
        return Layer(thickness, float(rng.choice([rng.uniform(-0.5, 0.5), 0.49, 0.5])))
    if kind < 0.85:
        return CoatedHalfSpace(thickness, float(10 ** rng.uniform(-3, 2.5)))
    return SlidingLayer(thickness)


def _stiffness(layer: ElasticLayer, wave: float) -> float:
    """Of a wave number [1/period], over the half-space's (dimensionless)."""
    return float(layer.stiffness(np.array([wave]), 1.0)[0]) * 2 / wave


def _rough(rng: np.random.Generator, seed: int, num_points: int) -> RoughIndenter:
    """A surface with 6 to 128 points to its shortest wave."""
    shortest = max(num_points / 2 ** rng.uniform(2.6, 7), 2.0)
    roll_off = min(1.0, 1 / min(8.0, shortest / 1.01))
    return RoughIndenter(float(rng.uniform(0.2, 0.95)), seed, roll_off, min(1.0, 1 / (roll_off * shortest)))


def _few(rng: np.random.Generator, num_points: int) -> float:
    """Half-width of a contact of a tenth of a node to five [period]."""
    return float(rng.choice([rng.uniform(0.1, 5), 10 ** rng.uniform(-1, 0.5)])) / 2 / num_points


def _load_of_few(rng: np.random.Generator, layer: ElasticLayer, rough: Indenter, num_points: int) -> float:
    """A load under which the lowest summit touches few nodes, by Hertz' law."""
    fine = _FINER * num_points
    h = rough.profile(fine, 1.0)
    lowest = int(h.argmin())
    curvature = (h[(lowest + 1) % fine] + h[lowest - 1] - 2 * h[lowest]) * fine**2
    half = _few(rng, num_points)
    return float(math.pi / 4 * half**2 * curvature * max(1.0, _stiffness(layer, 1 / half)) * 10 ** rng.uniform(0, 0.5))


def _waves(rng: np.random.Generator, layer: ElasticLayer, num_points: int) -> tuple[Scene, Scene]:
    """Heights that are a sum of a few waves; a third of these have a kink."""
    longest = max(2, num_points // int(rng.choice([8, 16, 64])))
    waves, phases = rng.integers(1, longest, 4), rng.random(4)
    depths, kink = 10 ** rng.uniform(-3, -1, 4) / waves, float(rng.choice([0, 0, rng.uniform(-0.1, 0.1)]))

    def heights(n: int) -> MeasuredIndenter:
        x = np.arange(n) / n
        waved = sum(a * np.cos(2 * np.pi * (k * x + b)) for a, k, b in zip(depths, waves, phases, strict=True))
        return MeasuredIndenter(waved + kink * np.abs(x - 0.47), convention="gap")

    load = float(10 ** rng.uniform(-5, -0.5))
    coarse, fine = (Scene(layer, heights(n), load, num_points=n) for n in (num_points, _FINER * num_points))
    return coarse, fine
