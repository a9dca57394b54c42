"""One solve, as it is passed along: its configuration and its iterations, the certificate at their end, and another
attempt where the certificate is bad.

Which method works on a grid, and when a grid is fine enough, is said elsewhere.
"""

import math
import time
from dataclasses import dataclass, field, replace

import numpy as np

from .. import display
from ..arrays import Array64, Mask
from ..endings import Cause, Reason, Status
from ..grid.certificate import MEANINGLESS, Certificate, certify
from ..grid.contact import Contact
from ..grid.problem import Problem, foundation_pressure, rounding_floor
from ..methods import METHODS, ExecutionConfig, Method, MethodKind, relax
from ..scene import Scene
from ..solution import MOST_ENERGY, Choice, Level

_NEAR_THE_FLOOR = 100  # times the residual of rounding: below, rounding may be the reason for the residual
_MOST_WORK = 20_000 * 2**16  # iterations times points of a method that goes on where another one failed


@dataclass
class Run:
    """One solve."""

    scene: Scene
    """To be solved; its grid is the finest."""
    kind: MethodKind
    """The method that was chosen."""
    config: ExecutionConfig
    """Precision, threads, planning, kernels and device."""
    limit: int | None = None
    """Of iterations on all grids and by all methods together; None: each method has its own."""
    left: int = 0
    """Iterations before the present attempt ends."""
    taken: int = 0
    """Iterations on all grids."""
    points_transformed: float = 0.0
    """Transform pairs on all grids times the points of each grid."""
    tolerance: float = 0.0
    """Of the certificate, on the equilibrium residual over p (dimensionless)."""
    own_tolerance: bool = False
    """Whether that was asked for. Any other gives way to the residual of rounding."""
    levels: list[Level] = field(default_factory=list)
    """Of the grids, from coarse to fine."""
    choices: list[Choice] = field(default_factory=list)
    """Made for the user, with reasons."""
    handed_over: bool = False
    """Whether another method than the chosen one went on."""
    state: Method = field(init=False)
    """The method on the present grid."""
    status: Status = Status.ITERATION_LIMIT
    """How the present attempt ended; in the end, how the solve did."""
    reason: Reason | None = None
    """Why it did not converge; None if it did."""
    contact: Contact | None = None
    """On the last grid that was measured, where a finer one begins."""
    memory: int | None = None
    """That was free before any grid was made [bytes]; None: not known."""
    times: list[float] = field(default_factory=lambda: [time.perf_counter()] * 3)
    """When the solve began, when it was set up, and when it was iterated to the end [s]."""

    def __post_init__(self) -> None:
        self.allow(self.kind.max_iterations, last=self.kind.fallback is None)

    @property
    def spent(self) -> bool:
        """Whether the limit allows nothing more."""
        return self.limit is not None and self.taken >= self.limit

    def allow(self, iterations: int, last: bool = True) -> None:
        """Give the next attempt so many iterations; the last one gets all that is left of a limit that was given."""
        left = iterations if self.limit is None else self.limit - self.taken
        self.left = left if last else min(left, iterations)

    @property
    def contact_share(self) -> float:
        """Share of the nodes that are in contact, 0 where that is not known (dimensionless)."""
        return self.contact.patches.nodes.size / self.contact.pressure.size if self.contact else 0.0

    def begin(self, problem: Problem, tolerance: float, kind: MethodKind | None = None) -> Method:
        """A method on a grid; by default the one that was chosen.

        Coarser grids than the scene's cost little in float64, and float32's residual would not tell their errors.
        """
        size = problem.num_points
        precision = self.scene.precision if size == self.scene.num_points else "float64"
        config = replace(self.config, tolerance=tolerance, precision=precision, contact_share=self.contact_share)
        return (kind or self.kind).begin(problem, config)

    def relax(self, state: Method) -> Status:
        """Relax, and count the iterations and transforms."""
        iterations, pairs = state.iteration, state.transform_pairs
        status = relax(state, iterations + self.left, self.config.progress)
        self.left -= state.iteration - iterations
        self.taken += state.iteration - iterations
        self.points_transformed += (state.transform_pairs - pairs) * state.problem.num_points
        return status


@dataclass(frozen=True)
class Certified:
    """A displacement with its certificate."""

    problem: Problem
    certificate: Certificate
    displacement: Array64
    """u, shape (N,) [u]."""
    pressure: Array64
    """Contact pressure by the certificate, shape (N,) [p]."""
    contact: Mask
    """Nodes that the wall carries, shape (N,)."""

    @property
    def residual(self) -> float:
        """The equilibrium residual over p (dimensionless)."""
        return self.certificate.equilibrium_residual

    @property
    def floor(self) -> float:
        """Equilibrium residual of rounding in the scene's precision, over p (dimensionless)."""
        rounding = "float32" if self.problem.scene.precision == "float32" else "float64"  # mixed included
        return rounding_floor(self.problem.stiffness, self.displacement, rounding)


def certify_or_fall_back(run: Run, problem: Problem) -> Certified:
    """Certify a relaxed state; where that fails the method aims at smaller residuals, and then its fallback goes on.

    problem: of the scene, which the certificate is for. The run gets its final status, with the reason, and a default
    tolerance that rounding does not allow becomes the residual that it does allow.
    """
    run.times[2] = time.perf_counter()
    found, begin = _certified(run, problem), time.perf_counter()
    if not _good(run, found):
        found = _tightened(run, found)
        ended = run.status is Status.INTERRUPTED or run.spent or _good(run, found) or _rounded_off(run, found)
        if run.kind.fallback and not ended:
            found = _from_there(run, found, METHODS[run.kind.fallback])
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


def _certified(run: Run, problem: Problem) -> Certified:
    """The present state with its certificate."""
    state, displacement = run.state, run.state.displacement
    if np.shape(displacement) != (problem.num_points,):
        what = f"displacement of {type(state).__name__} has shape {np.shape(displacement)}"
        raise ValueError(f"{what}; allowed: ({problem.num_points},)")
    if not np.isfinite(displacement).all():  # diverged beyond all numbers
        state.start(np.zeros_like(displacement))
        displacement = state.displacement
    state.rest()
    certificate, pressure, contact = certify(problem, displacement)
    return Certified(problem, certificate, displacement, pressure, contact)


def _bounded(run: Run, found: Certified) -> bool:
    """Whether the energy's error is bounded well enough."""
    bound = found.certificate.energy_error_bound
    return math.isfinite(bound) if run.own_tolerance else bound <= MOST_ENERGY


def _good(run: Run, found: Certified) -> bool:
    return found.residual <= run.tolerance and _bounded(run, found)


def _rounded_off(run: Run, found: Certified) -> bool:
    """Whether rounding keeps the residual above the tolerance; no other method knows a way below that."""
    return run.tolerance < 2 * found.floor and found.residual < _NEAR_THE_FLOOR * found.floor


def _tightened(run: Run, found: Certified) -> Certified:
    """The result of the same method aiming at smaller residuals, unless that makes them larger."""
    while run.status is Status.CONVERGED and not _good(run, found) and run.state.tighten():
        residual, pressure = found.residual, run.state.contact_pressure
        run.status = run.relax(run.state)
        found = _certified(run, found.problem)
        if not _good(run, found) and not found.residual < residual:  # rounding may have changed the set: go back
            run.state.start_from_pressure(pressure)
            return _certified(run, found.problem)
    return found


def _from_there(run: Run, found: Certified, kind: MethodKind) -> Certified:
    """The result of a method that starts at the end of the last one, or anew; the better one, with its status."""
    problem, before, status = found.problem, run.state, run.status
    run.handed_over = True
    run.allow(min(kind.max_iterations, _MOST_WORK // problem.num_points))
    run.state = run.begin(problem, run.tolerance, kind)
    if found.residual < MEANINGLESS:
        run.state.start(found.displacement)
    else:  # then the displacement may be anything
        run.state.start_from_pressure(foundation_pressure(problem))
    run.status = run.relax(run.state)
    other = _tightened(run, _certified(run, problem))
    if _good(run, other) or other.residual < found.residual:
        return other
    run.state = before
    if run.status is not Status.INTERRUPTED and not run.spent:
        run.status = status
    return found


def _reason(run: Run, found: Certified) -> Reason | None:
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
            return Reason(Cause.INTERRUPTION, "", "it was interrupted", "")
        case Status.ITERATION_LIMIT:
            return Reason(Cause.ITERATIONS, "max_iterations", f"reached after {run.taken}", f"more{other}{looser}")
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
