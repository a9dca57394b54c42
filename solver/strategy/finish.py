"""The end of a solve: observables of its certified state, and the solution."""

import time

from ..arrays import Array64, Mask
from ..grid.certificate import Certificate
from ..grid.contact import contact_edges
from ..grid.errors import with_errors
from ..grid.observables import Observables, observe
from ..grid.patch_table import PatchTable
from ..grid.problem import Problem
from ..scene import Scene
from ..solution import Choice, Solution
from ..transforms.device import device_name, gpu_libraries
from .run import Run, certify_or_fall_back


def finish(run: Run, scene: Scene, problem: Problem) -> Solution:
    """Have the run's state certified, and make the solution.

    scene: the run's, on the grid of the answer; problem: of that scene, which the certificate is for.
    """
    found = certify_or_fall_back(run, problem)
    if scene.num_points == run.scene.num_points:
        del run.state  # and with it the method's fields, which are most of the memory
    pressure = found.pressure
    displacement = problem.to_length(found.displacement, found.contact)
    pressure *= scene.pressure  # in place: it may be large
    contact = contact_edges(problem, pressure, displacement)
    observables, patches = observe(contact, displacement)
    levels = [level for level in run.levels if level.num_points < scene.num_points]
    observables = with_errors(scene, observables, levels, found.certificate, contact)
    fields = displacement, pressure, found.contact
    return make_solution(run, scene, run.kind.name, fields, observables, patches, found.certificate)


def make_solution(
    run: Run,
    scene: Scene,
    method: str,
    fields: tuple[Array64, Array64, Mask],
    observables: Observables,
    patches: PatchTable,
    certificate: Certificate | None = None,
) -> Solution:
    """The solution of a scene with all that the run says of it. fields: displacement, contact pressure and contact; the
    other arguments as in `Solution`.
    """
    (begin, ready, relaxed, *_), end = run.times, time.perf_counter()
    device, choices = run.config.device, tuple(run.choices)
    if device != "cpu":
        reason = f"as asked, with {gpu_libraries()}; the certificate is computed on the CPU, in float64"
        choices += (Choice("device", device_name(device), reason),)
    return Solution(
        scene,
        method,
        run.tolerance,
        run.status,
        *fields,
        observables=observables,
        patches=patches,
        certificate=certificate,
        iterations=run.taken,
        transform_pairs=run.points_transformed / scene.num_points,
        seconds={"setup": ready - begin, "solve": relaxed - ready, "certificate": end - relaxed, "total": end - begin},
        threads=run.config.threads,
        planning=run.config.planning,
        backend=run.config.backend,
        reason=run.reason,
        handed_over=run.handed_over,
        levels=tuple(level for level in run.levels if level.num_points < scene.num_points),
        choices=choices,
        device=device_name(device),
    )
