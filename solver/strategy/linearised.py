"""The contact stiffness: what a small change of the load does, by the problem linearised on the contact that was found.

While no node joins or leaves the contact, the gap there stays 0: d sigma/dp is the pressure under a flat punch of the
contact's shape that carries the mean pressure 1, and du/dp the surface's displacement under it, 0 on the contact. The
contact stiffness is one over d(approach)/dp, the mean of du/dp and the layer's mean compression 1/k_W.
"""

import math
from dataclasses import replace

import numpy as np

from ..arrays import Mask
from ..grid.observables import foundation_modulus
from ..grid.problem import Problem
from ..methods import active_set, relax
from ..methods.method import Setting
from ..scene import Scene
from ..solution import Solution
from .effort import SMALLEST_WARP

_TOLERANCE = 1e-7  # on the punch's pressure; the stiffness then has eight digits
_MOST_ITERATIONS = 500
_WORTHLESS = 1e-3  # residual beyond which nothing is known


def contact_compliance(scene: Scene, contact: Mask) -> float:
    """d(approach)/dp on an unchanged contact [length/pressure]; NaN where rounding leaves nothing of it.

    contact: nodes that the wall carries, shape (N,), one of them at least.
    """
    modulus = foundation_modulus(scene)
    compression = 1 / modulus if modulus else 0.0
    if contact.all():  # the surface stays where it is, and the layer below is compressed
        return compression
    problem = Problem.from_scene(scene)
    punch = replace(problem, height=np.where(contact, 0.0, problem.reach))
    # as many nodes as there are may be wrong: the set stays as it is
    backend = "warp" if problem.num_points >= SMALLEST_WARP else "numpy"
    method = active_set.begin(punch, Setting(_TOLERANCE, wrong_nodes_per_patch=math.inf, backend=backend))
    method.start_from_pressure(contact.astype(np.float64))
    relax(method, _MOST_ITERATIONS, None)
    if not method.residual < _WORTHLESS:
        return math.nan
    return float(method.displacement.mean()) * problem.length_unit / scene.pressure + compression


def contact_stiffness(solution: Solution) -> float:
    """dp/d(approach) of a solution [pressure/length], exact for its grid and contact; 0 where nothing touches.

    For a half-space, whose approach is the mean of u by convention, it is infinite at full contact, as it is for an
    incompressible layer. It takes a quarter of the time of the solve.
    """
    if not solution.contact.any():
        return 0.0
    compliance = contact_compliance(solution.scene, solution.contact)
    return 1 / compliance if compliance else math.inf
