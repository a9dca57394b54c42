"""The scenes of the study: one for every time that is taken, and random ones on which CPU and GPU are to agree."""

import math

import numpy as np
from linecontact.solver import Layer, PowerIndenter, RoughIndenter, Scene


def timed_scene(log2_num_points: int, precision: str = "float64") -> Scene:
    """A rough surface on a layer; its shortest wave is L/1024, so that every grid holds it whole."""
    indenter = RoughIndenter(0.8, 0, 1 / 8, 1 / 128)
    return Scene(Layer(0.1), indenter, 1e-2, num_points=2**log2_num_points, precision=precision)


def random_scene(seed: int) -> Scene:
    """Some 2^8 to 2^16 points: a power profile or a rough surface on a layer, or on the half-space."""
    rng = np.random.default_rng(seed)
    thickness = math.inf if rng.random() < 0.2 else float(10 ** rng.uniform(-2.5, 0))
    num_points = round(2 ** rng.uniform(8, 16))
    if rng.random() < 0.5:
        indenter: PowerIndenter | RoughIndenter = PowerIndenter(float(rng.choice([1.5, 2, 4])))
    else:
        indenter = RoughIndenter(0.8, seed, 1 / 4, 1 / 16, 0.1)
    layer, pressure = Layer(thickness, float(rng.uniform(0, 0.49))), float(10 ** rng.uniform(-4, -2))
    return Scene(layer, indenter, pressure, num_points=num_points)
