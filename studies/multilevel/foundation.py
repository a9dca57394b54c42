"""A surface on the Winkler foundation that its layer is for long waves: it takes about a hundredth of a solve, and on
thin layers surfaces differ there nearly as they do on the layer.
"""

import math

import numpy as np
from linecontact.solver import Scene
from linecontact.solver.grid.indenter_on_grid import indenter_on_grid
from linecontact.solver.grid.problem import foundation_level


def is_one(scene: Scene) -> bool:
    """Whether the layer is a foundation for long waves: neither a half-space nor incompressible."""
    return 0 < scene.foundation_modulus < math.inf


def press(scene: Scene, num_points: int) -> dict[str, float]:
    """The observables of the scene on a grid, by their names, if the pressure were k_W times the depth at every node.

    num_points: of the grid, which has to hold the surface.
    """
    indenter, modulus = indenter_on_grid(scene.indenter, num_points, scene.period), scene.foundation_modulus
    heights = scene.period * indenter.profile
    level = foundation_level(heights, modulus / scene.pressure)
    contact = heights < level
    area = float(contact.mean())
    return {
        "kappa_subgrid": area * math.sqrt(float(indenter.squared_slope[contact].mean())) / scene.reduced_load,
        "contact_area_subgrid": area,
        "peak_pressure": modulus * (level - float(heights.min())),
        "approach": level,
        "mean_gap": float(np.maximum(heights - level, 0).mean()),
    }
