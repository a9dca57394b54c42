"""The certificate's verdict on what a method found, and what is tried where it is bad."""

import math
import time
from dataclasses import dataclass

import numpy as np

from .. import display
from ..arrays import Array64, Mask
from ..endings import INTERRUPTED, Cause, Reason, Status
from ..grid.certificate import Certificate, certify
from ..grid.problem import Problem, rounding_floor
from ..methods import METHODS, Fallback, Method
from ..solution import MEANINGLESS, MOST_ENERGY, Choice
from .effort import CAUTION, Effort, start_on_foundation

_MOST_TRIES = 3  # of a method that can aim at a smaller residual
_AT_THE_FLOOR = 2  # times what rounding leaves: a tolerance below is out of reach,
_NEAR_THE_FLOOR = 1000  # if the residual is below so many times that
_LEFT = 4  # times what rounding leaves: a smaller residual is not made smaller by the same method
_MOST_POINTS = 2**18  # on which another method goes on after a search that has reached its limit,
_MOST_WORK = 20_000 * 2**16  # and its iterations times the points
_NOT_FAR = 100  # times what rounding leaves: a default tolerance gives way to a residual below


@dataclass(frozen=True)
class Certified:
    """What was found in the end, with its certificate; `report.make_solution` uses its arrays up."""

    status: Status
    """How the solve ended."""
    reason: Reason | None
    """Why it did not converge; None if it did."""
    tolerance: float
    """That the certificate meets: the one asked for, or the residual that rounding leaves (dimensionless)."""
    certificate: Certificate
    """How wrong the displacement is."""
    displacement: Array64
    """u, shape (N,) [u]."""
    pressure: Array64
    """Contact pressure by the certificate, shape (N,) [p]."""
    contact: Mask
    """Nodes that the wall carries, shape (N,)."""
    choices: tuple[Choice, ...]
    """What was chosen on the way, and why."""
    handed_over: bool
    """Whether another method than the chosen one went on."""
    seconds: float
    """Time spent after the first certificate on further iterations [s]."""


def certify_or_fall_back(
    effort: Effort, problem: Problem, state: Method, status: Status, tolerance: float, own_tolerance: bool
) -> Certified:
    """Certify a relaxed state; where that fails the method tries harder, and then its fallbacks try.

    problem: of the scene, which the certificate is for; status: how the relaxation ended; own_tolerance: whether the
    tolerance was asked for. A default one that rounding does not allow becomes the residual that it does allow.
    """
    return _Certification(effort, problem, state, tolerance, own_tolerance).run(status)


class _Certification:
    """The state of one certification: the best method so far and its certificate."""

    def __init__(self, effort: Effort, problem: Problem, state: Method, tolerance: float, own_tolerance: bool) -> None:
        self.effort, self.problem, self.state = effort, problem, state
        self.tolerance, self.own_tolerance = tolerance, own_tolerance
        self.choices: list[Choice] = []
        self.handed_over = False

    def run(self, status: Status) -> Certified:
        """All that is tried, one after the other."""
        good = self.certify()
        begin, first = time.perf_counter(), good
        status, good = self.insist(status, good)
        for fallback in self.effort.kind.fallbacks:
            if good or status is Status.INTERRUPTED or self.rounded_off() or not self.effort.may_go_on:
                break
            in_vain = status is Status.ITERATION_LIMIT and not self.may_help(fallback)
            if self.effort.scene.precision not in fallback.not_in and not in_vain:
                status, good = self.hand_over(fallback, status)
        seconds = 0.0 if first else time.perf_counter() - begin
        if not good and status in (Status.STAGNATED, Status.CONVERGED):
            status = Status.STAGNATED  # the method's own precision cannot see the difference
            residual = self.certificate.free_residual
            if not self.own_tolerance and self.bounded() and residual < min(_NOT_FAR * self.floor(), MEANINGLESS):
                self.tolerance, good = residual, True
        if good and status in (Status.STAGNATED, Status.ITERATION_LIMIT):
            status = Status.CONVERGED
        return Certified(
            status=status,
            reason=self.reason(status),
            tolerance=self.tolerance,
            certificate=self.certificate,
            displacement=self.displacement,
            pressure=self.pressure,
            contact=self.contact,
            choices=tuple(self.choices),
            handed_over=self.handed_over,
            seconds=seconds,
        )

    def certify(self) -> bool:
        """Make the certificate of the present state; whether it is good enough."""
        self.displacement = self.state.displacement
        shape = np.shape(self.displacement)
        if shape != (self.problem.num_points,):
            what = f"displacement of {type(self.state).__name__} has shape {shape}"
            raise ValueError(f"{what}; allowed: ({self.problem.num_points},)")
        if not np.isfinite(self.displacement).all():  # diverged beyond all numbers
            self.state.start(np.zeros_like(self.displacement))
            self.displacement = self.state.displacement
        self.state.rest()
        self.certificate, self.pressure, self.contact = certify(self.problem, self.displacement)
        return self.certificate.free_residual <= self.tolerance and self.bounded()

    def bounded(self) -> bool:
        """Whether the energy's error is bounded well enough."""
        bound = self.certificate.energy_error_bound
        return math.isfinite(bound) if self.own_tolerance else bound <= MOST_ENERGY

    def floor(self) -> float:
        """What rounding leaves of the free residual in the scene's precision, over p (dimensionless)."""
        precision = "float32" if self.effort.scene.precision == "float32" else "float64"
        return rounding_floor(self.problem.stiffness, self.displacement, precision)

    def rounded_off(self, near: float = _NEAR_THE_FLOOR) -> bool:
        """Whether rounding is what keeps the residual above the tolerance; no other method knows a way below that.

        near: times what rounding leaves, up to which it may be the reason.
        """
        floor = self.floor()
        return self.tolerance < _AT_THE_FLOOR * floor and self.certificate.free_residual < near * floor

    def insist(self, status: Status, good: bool) -> tuple[Status, bool]:
        """A method that misses the certificate tries harder, if it can, up to three times."""
        for _ in range(_MOST_TRIES):
            residual = self.certificate.free_residual
            if good or status is not Status.CONVERGED:
                break
            in_vain = not self.own_tolerance and self.rounded_off(_LEFT)  # the residual becomes the tolerance
            if in_vain or not self.state.try_harder():
                break
            before = self.state.contact_pressure
            status = self.effort.relax(self.state)
            good = self.certify()
            if not good and self.certificate.free_residual > residual:  # the set has changed by rounding: go back
                self.state.start_from_pressure(before)
                self.certify()
                break
        return status, good

    def may_help(self, fallback: Fallback) -> bool:
        """Whether a fallback may help where the chosen method has reached its limit of iterations.

        The same method again does not, nor does another one on so many nodes that it takes hours, unless that was asked
        for by a larger limit.
        """
        bearable = self.effort.max_iterations is not None or self.problem.num_points <= _MOST_POINTS
        return fallback.method != self.effort.kind.name and bearable

    def hand_over(self, fallback: Fallback, status: Status) -> tuple[Status, bool]:
        """A fallback goes on from where this method ended, with that status; the better of the two stays."""
        effort, before, residual = self.effort, self.state, self.certificate.free_residual
        kind, precision = METHODS[fallback.method], fallback.precision
        other = kind.name != effort.kind.name
        if other:
            self.handed_over, most = True, kind.max_iterations
            if status is Status.ITERATION_LIMIT:  # a hard scene
                most = min(most, _MOST_WORK // self.problem.num_points)
            effort.allow(most)
        elif before.mixed and precision:
            self.choices.append(Choice("precision", precision, f"mixed ends at a residual of {residual:.1g}"))
        self.state = effort.begin(self.problem, CAUTION * self.tolerance, kind, precision)
        if other and not residual < MEANINGLESS:  # then the displacement may be anything
            start_on_foundation(self.state)
        else:
            self.state.start(self.displacement)
        status = effort.relax(self.state)
        status, good = self.insist(status, self.certify())
        if not good and not self.certificate.free_residual < residual:
            self.state = before
            self.certify()
        return status, good

    def reason(self, status: Status) -> Reason | None:
        """Why the solve ended short of its goal, and what is allowed instead."""
        residual, tolerance, scene = self.certificate.free_residual, self.tolerance, self.effort.scene
        other = ", or precision mixed or float64" if scene.precision == "float32" else ""
        looser = f", or tolerance above {display.rounded_up(residual)} (it is {tolerance:g})"
        if not tolerance < residual < MEANINGLESS:
            looser = ""
        match status:
            case Status.CONVERGED:
                return None
            case Status.INTERRUPTED:
                return INTERRUPTED
            case Status.ITERATION_LIMIT:
                reached = f"reached after {self.effort.iterations}"
                return Reason(Cause.ITERATIONS, "max_iterations", reached, f"more{looser}")
            case _ if residual <= tolerance:
                off = f"the energy may be off by {self.certificate.energy_error_bound:.2g} of itself"
                return Reason(Cause.ENERGY, "tolerance", f"{tolerance:.2g}, at which {off}", f"a smaller one{other}")
            case Status.STAGNATED if self.rounded_off():
                leaves = f"rounding in {scene.precision} leaves"
                if residual < MEANINGLESS:
                    allowed = f"above {display.rounded_up(residual)}, which {leaves}{other}"
                    return Reason(Cause.ROUNDING, "tolerance", f"{tolerance:g}", allowed)
                where = f"{scene.num_points}, where {leaves} a residual of {residual:.2g}"
                return Reason(Cause.ROUNDING, "num_points", where, f"fewer{other}")
        what = f"{self.effort.kind.name} in precision {scene.precision}, which does not settle here"
        return Reason(Cause.METHOD, "method", what, f"another{other}{looser}")
