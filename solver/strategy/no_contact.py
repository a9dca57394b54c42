"""Where no node touches there is nothing to solve: without load, and up to the approach of the first node."""

import math
from dataclasses import replace

import numpy as np

from ..endings import Status
from ..grid.observables import first_node, observe
from ..scene import Scene
from ..solution import Choice, Solution
from .effort import Means

NAME = "no contact"


def nothing_touches(scene: Scene) -> bool:
    """Whether the load or the approach of a scene leaves all nodes apart, or just brings the first two together."""
    return scene.pressure == 0 if scene.approach is None else scene.approach <= first_node(scene)


def without_contact(scene: Scene, means: Means) -> Solution:
    """The solution of such a scene: the surface flat, its distance from the indenter's lowest point minus the approach.

    Without load that distance may be any, and is 0. p* and kappa are NaN.
    """
    approach, first = scene.approach or 0.0, first_node(scene)
    unseen = 1 / scene.num_points if approach > 0 else 0.0
    choices: tuple[Choice, ...] = ()
    if scene.approach is not None:
        unit = scene.length_unit
        why = f"for the approach of {approach:g} [{unit}]: up to {first:g} [{unit}] no node touches"
        choices = (Choice("pressure", "0", why),)
        scene = replace(scene, approach=None, pressure=0.0)
    displacement, pressure = np.full(scene.num_points, approach - first), np.zeros(scene.num_points)
    contact = np.zeros(scene.num_points, dtype=bool)
    found, patches = observe(scene, scene.profile, displacement, pressure, contact)
    found = replace(
        found,
        contact_area_error=unseen,
        contact_area_edges_error=unseen,
        peak_pressure_sampling=0.0,
        peak_pressure_error=math.inf if unseen else 0.0,
        approach=approach,
        approach_error=0.0,
        reduced_pressure=math.nan,
        kappa=math.nan,
        kappa_ratio=None if found.kappa_ratio is None else math.nan,
        kappa_subgrid=math.nan,
        kappa_error=math.nan,
        kappa_edges_error=math.nan,
    )
    return Solution(
        scene=scene,
        method=NAME,
        tolerance=0.0,
        status=Status.CONVERGED,
        displacement=displacement,
        contact_pressure=pressure,
        contact=contact,
        observables=found,
        patches=patches,
        certificate=None,
        iterations=0,
        transform_pairs=0.0,
        seconds=dict.fromkeys(("setup", "solve", "certificate", "total"), 0.0),
        threads=means.threads,
        planning=means.planning,
        backend=means.backend,
        choices=choices,
    )
