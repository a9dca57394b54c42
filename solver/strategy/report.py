"""The solution, made from what was found; nothing is solved here any more."""

from collections.abc import Sequence

import numpy as np

from ..grid.observables import observe
from ..grid.patches import Patches
from ..grid.problem import Problem
from ..scene import Scene
from ..solution import Choice, Level, Solution
from ..transforms.device import device_name, gpu_libraries
from .certification import Certified
from .effort import Effort
from .unfinished import with_errors


def make_solution(
    scene: Scene, problem: Problem, certified: Certified, levels: Sequence[Level], effort: Effort
) -> Solution:
    """The solution of a scene on its grid, without the times that it took.

    scene: as the user gave it, or on the grid of the answer; problem: that was certified; certified: its arrays become
    the solution's; levels: coarser grids.
    """
    profile = problem.profile if scene.period == 1 else scene.period * problem.profile
    contact = certified.contact
    displacement, pressure = certified.displacement, certified.pressure  # in place: they may be large
    displacement *= problem.length_unit
    np.minimum(displacement, profile, out=displacement)  # units round
    displacement[contact] = profile[contact]
    pressure *= scene.pressure
    observables, patches = observe(scene, profile, displacement, pressure, contact)
    del profile
    observables = with_errors(scene, observables, levels, certified.certificate, Patches.of(contact), pressure)
    return Solution(
        scene=scene,
        method=effort.kind.name,
        tolerance=certified.tolerance,
        status=certified.status,
        displacement=displacement,
        contact_pressure=pressure,
        contact=contact,
        observables=observables,
        patches=patches,
        certificate=certified.certificate,
        iterations=effort.iterations,
        transform_pairs=effort.points_transformed / scene.num_points,
        seconds={},
        threads=effort.means.threads,
        planning=effort.means.planning,
        backend=effort.backend_on(scene.num_points),
        reason=certified.reason,
        handed_over=certified.handed_over,
        levels=tuple(levels),
        choices=certified.choices + _device(effort),
        device=device_name(effort.means.device),
    )


def _device(effort: Effort) -> tuple[Choice, ...]:
    """That a GPU was used; nothing of the CPU, which every solve uses."""
    device = effort.means.device
    if device == "cpu":
        return ()
    reason = f"as asked, with {gpu_libraries()}; the certificate is computed on the CPU, in float64"
    return (Choice("device", device_name(device), reason),)


def stages(begin: float, ready: float, relaxed: float, end: float) -> dict[str, float]:
    """Seconds by stage, from the times at which they ended."""
    return {"setup": ready - begin, "solve": relaxed - ready, "certificate": end - relaxed, "total": end - begin}
