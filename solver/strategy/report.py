"""The solution, made from what was found; nothing is solved here any more."""

import math
import time
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import Array64, Mask
from ..endings import Status
from ..grid.certificate import Certificate
from ..grid.observables import Observables, first_node, observe
from ..grid.patch_table import PatchTable
from ..grid.patches import Patches
from ..grid.problem import Problem
from ..scene import Scene
from ..solution import Choice, Solution
from ..transforms.device import device_name, gpu_libraries
from .certification import certify_or_fall_back
from .errors import with_errors
from .run import Run


def finish(run: Run, scene: Scene, problem: Problem) -> Solution:
    """Have the run's state certified, and make the solution.

    scene: the run's, on the grid of the answer; problem: of that scene, which the certificate is for.
    """
    certified = certify_or_fall_back(run, problem)
    if scene.num_points == run.scene.num_points:
        del run.state  # and with it the method's fields, which are most of the memory
    certificate, pressure, contact = certified.certificate, certified.pressure, certified.contact
    displacement = problem.to_length(certified.displacement, contact)
    pressure *= scene.pressure  # in place: it may be large
    observables, patches = observe(problem, displacement, pressure, contact)
    levels = [level for level in run.levels if level.num_points < scene.num_points]
    observables = with_errors(scene, observables, levels, certificate, Patches.of(contact), pressure)
    return make_solution(run, scene, run.kind.name, displacement, pressure, contact, observables, patches, certificate)


def make_solution(
    run: Run,
    scene: Scene,
    method: str,
    displacement: Array64,
    contact_pressure: Array64,
    contact: Mask,
    observables: Observables,
    patches: PatchTable,
    certificate: Certificate | None = None,
) -> Solution:
    """The solution of a scene with all that the run says of it; arguments as in `Solution`."""
    (begin, ready, relaxed, *_), end = run.times, time.perf_counter()
    device, choices = run.config.device, tuple(run.choices)
    if device != "cpu":
        reason = f"as asked, with {gpu_libraries()}; the certificate is computed on the CPU, in float64"
        choices += (Choice("device", device_name(device), reason),)
    return Solution(
        scene=scene,
        method=method,
        tolerance=run.tolerance,
        status=run.status,
        displacement=displacement,
        contact_pressure=contact_pressure,
        contact=contact,
        observables=observables,
        patches=patches,
        certificate=certificate,
        iterations=run.taken,
        transform_pairs=run.points_transformed / scene.num_points,
        seconds={"setup": ready - begin, "solve": relaxed - ready, "certificate": end - relaxed, "total": end - begin},
        threads=run.config.threads,
        planning=run.config.planning,
        backend=run.backend_on(scene.num_points),
        reason=run.reason,
        handed_over=run.handed_over,
        levels=tuple(level for level in run.levels if level.num_points < scene.num_points),
        choices=choices,
        device=device_name(device),
    )


def nothing_touches(scene: Scene) -> bool:
    """Whether the load or the approach of a scene leaves all nodes apart, or just brings the first two together."""
    return scene.pressure == 0 if scene.approach is None else scene.approach <= first_node(scene)


def without_contact(run: Run) -> Solution:
    """The solution of such a scene: the surface flat, its distance from the indenter's lowest point minus the approach.

    Without load that distance may be any, and is 0. p* and kappa are NaN.
    """
    scene = run.scene
    approach, first = scene.approach or 0.0, first_node(scene)
    unseen = 1 / scene.num_points if approach > 0 else 0.0
    if scene.approach is not None:
        unit = scene.length_unit
        why = f"for the approach of {approach:g} [{unit}]: up to {first:g} [{unit}] no node touches"
        run.choices.append(Choice("pressure", "0", why))
        scene = replace(scene, approach=None, pressure=0.0)
    displacement, pressure = np.full(scene.num_points, approach - first), np.zeros(scene.num_points)
    contact = np.zeros(scene.num_points, dtype=bool)
    found, patches = observe(Problem.from_scene(scene), displacement, pressure, contact)
    none: dict[str, Any] = dict.fromkeys(("reduced_pressure", "kappa", "kappa_subgrid", "kappa_error"), math.nan)
    found = replace(
        found,
        contact_area_error=unseen,
        contact_area_edges_error=unseen,
        peak_pressure_sampling=0.0,
        peak_pressure_error=math.inf if unseen else 0.0,
        approach=approach,
        approach_error=0.0,
        kappa_ratio=None if found.kappa_ratio is None else math.nan,
        kappa_edges_error=math.nan,
        **none,
    )
    run.status, run.config = Status.CONVERGED, replace(run.config, device="cpu")
    return make_solution(run, scene, "no contact", displacement, pressure, contact, found, patches)
