"""The end of a solve: its certificate, another attempt where that is bad, and the solution."""

import math
import time
from dataclasses import dataclass

import numpy as np

from .. import display
from ..arrays import Array64, Mask
from ..endings import INTERRUPTED, Cause, Reason, Status
from ..grid.certificate import MEANINGLESS, Certificate, certify
from ..grid.contact import contact_edges
from ..grid.errors import with_errors
from ..grid.observables import Observables, observe
from ..grid.patch_table import PatchTable
from ..grid.problem import Problem, foundation_pressure, rounding_floor
from ..methods import METHODS, MethodKind
from ..scene import Scene
from ..solution import MOST_ENERGY, Choice, Solution
from ..transforms.device import device_name, gpu_libraries
from .run import Run

_NEAR_THE_FLOOR = 100  # times the residual of rounding: below, rounding may be the reason for the residual
_MOST_WORK = 20_000 * 2**16  # iterations times points of a method that goes on where another one failed


def finish(run: Run, scene: Scene, problem: Problem) -> Solution:
    """Have the run's state certified, and make the solution.

    scene: the run's, on the grid of the answer; problem: of that scene, which the certificate is for.
    """
    found = _certify_or_fall_back(run, problem)
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
        backend=run.backend_on(scene.num_points),
        reason=run.reason,
        handed_over=run.handed_over,
        levels=tuple(level for level in run.levels if level.num_points < scene.num_points),
        choices=choices,
        device=device_name(device),
    )


@dataclass(frozen=True)
class _Certified:
    """A displacement with its certificate."""

    certificate: Certificate
    displacement: Array64
    """u, shape (N,) [u]."""
    pressure: Array64
    """Contact pressure by the certificate, shape (N,) [p]."""
    contact: Mask
    """Nodes that the wall carries, shape (N,)."""
    floor: float
    """Equilibrium residual of rounding in the scene's precision, over p (dimensionless)."""

    @property
    def residual(self) -> float:
        """The equilibrium residual over p (dimensionless)."""
        return self.certificate.equilibrium_residual


def _certify_or_fall_back(run: Run, problem: Problem) -> _Certified:
    """Certify a relaxed state; where that fails the method aims at smaller residuals, and then its fallback goes on.

    problem: of the scene, which the certificate is for. The run gets its final status, with the reason, and a default
    tolerance that rounding does not allow becomes the residual that it does allow.
    """
    run.times[2] = time.perf_counter()
    found, begin = _certified(run, problem), time.perf_counter()
    if not _good(run, found):
        found = _tightened(run, problem, found)
        ended = run.status is Status.INTERRUPTED or run.spent or _good(run, found) or _rounded_off(run, found)
        if run.kind.fallback and not ended:
            found = _from_there(run, problem, found, METHODS[run.kind.fallback])
        run.times[2] += time.perf_counter() - begin  # further iterations are part of the solve
    if not _good(run, found) and run.status in (Status.STAGNATED, Status.CONVERGED):
        run.status = Status.STAGNATED  # the method's own precision cannot see the difference
        near = found.residual < min(_NEAR_THE_FLOOR * found.floor, MEANINGLESS)
        if near and not run.own_tolerance and _bounded(run, found):
            run.tolerance = found.residual
    if _good(run, found) and run.status in (Status.STAGNATED, Status.ITERATION_LIMIT):
        run.status = Status.CONVERGED
    run.reason = _reason(run, found)
    return found


def _certified(run: Run, problem: Problem) -> _Certified:
    """The present state with its certificate."""
    state, displacement = run.state, run.state.displacement
    if np.shape(displacement) != (problem.num_points,):
        what = f"displacement of {type(state).__name__} has shape {np.shape(displacement)}"
        raise ValueError(f"{what}; allowed: ({problem.num_points},)")
    if not np.isfinite(displacement).all():  # diverged beyond all numbers
        state.start(np.zeros_like(displacement))
        displacement = state.displacement
    state.rest()
    rounding = "float32" if run.scene.precision == "float32" else "float64"  # of the residual, mixed included
    floor = rounding_floor(problem.stiffness, displacement, rounding)
    certificate, pressure, contact = certify(problem, displacement)
    return _Certified(certificate, displacement, pressure, contact, floor)


def _bounded(run: Run, found: _Certified) -> bool:
    """Whether the energy's error is bounded well enough."""
    bound = found.certificate.energy_error_bound
    return math.isfinite(bound) if run.own_tolerance else bound <= MOST_ENERGY


def _good(run: Run, found: _Certified) -> bool:
    return found.residual <= run.tolerance and _bounded(run, found)


def _rounded_off(run: Run, found: _Certified) -> bool:
    """Whether rounding keeps the residual above the tolerance; no other method knows a way below that."""
    return run.tolerance < 2 * found.floor and found.residual < _NEAR_THE_FLOOR * found.floor


def _tightened(run: Run, problem: Problem, found: _Certified) -> _Certified:
    """The result of the same method aiming at smaller residuals, unless that makes them larger."""
    while run.status is Status.CONVERGED and not _good(run, found) and run.state.tighten():
        residual, pressure = found.residual, run.state.contact_pressure
        run.status = run.relax(run.state)
        found = _certified(run, problem)
        if not _good(run, found) and not found.residual < residual:  # rounding may have changed the set: go back
            run.state.start_from_pressure(pressure)
            return _certified(run, problem)
    return found


def _from_there(run: Run, problem: Problem, found: _Certified, kind: MethodKind) -> _Certified:
    """The result of a method that starts at the end of the last one; the better of the two, with its status."""
    before, status = run.state, run.status
    run.handed_over = True
    run.allow(min(kind.max_iterations, _MOST_WORK // problem.num_points))
    run.state = run.begin(problem, run.tolerance, kind)
    if found.residual < MEANINGLESS:
        run.state.start(found.displacement)
    else:  # then the displacement may be anything
        longest = float(problem.stiffness[1])
        run.state.start_from_pressure(foundation_pressure(problem, longest))
    run.status = run.relax(run.state)
    other = _tightened(run, problem, _certified(run, problem))
    if _good(run, other) or other.residual < found.residual:
        return other
    run.state = before
    if run.status is not Status.INTERRUPTED and not run.spent:
        run.status = status
    return found


def _reason(run: Run, found: _Certified) -> Reason | None:
    """The reason why the solve ended short of its goal, with a way out."""
    if run.status is Status.CONVERGED:
        return None
    residual, tolerance, scene = found.residual, run.tolerance, run.scene
    other = ", or precision mixed or float64" if scene.precision == "float32" else ""
    looser = f", or tolerance above {display.rounded_up(residual)} (it is {tolerance:g})"
    if not tolerance < residual < MEANINGLESS:
        looser = ""
    match run.status:
        case Status.INTERRUPTED:
            return INTERRUPTED
        case Status.ITERATION_LIMIT:
            return Reason(Cause.ITERATIONS, "max_iterations", f"reached after {run.taken}", f"more{looser}")
        case _ if residual <= tolerance:
            off = f"the energy may be off by {found.certificate.energy_error_bound:.2g} of itself"
            return Reason(Cause.ENERGY, "tolerance", f"{tolerance:.2g}, at which {off}", f"a smaller one{other}")
        case Status.STAGNATED if _rounded_off(run, found):
            leaves = f"rounding in {scene.precision} leaves"
            if residual < MEANINGLESS:
                allowed = f"above {display.rounded_up(residual)}, which {leaves}{other}"
                return Reason(Cause.ROUNDING, "tolerance", f"{tolerance:g}", allowed)
            where = f"{scene.num_points}, where {leaves} a residual of {residual:.2g}"
            return Reason(Cause.ROUNDING, "num_points", where, f"fewer{other}")
    what = f"{run.kind.name} in precision {scene.precision}, which does not settle here"
    return Reason(Cause.METHOD, "method", what, f"another{other}{looser}")
