"""A solve to a given rigid approach: the mean pressure that brings it is found by Newton's method.

The approach grows with the pressure, and its derivative is known exactly from the problem linearised on the contact.
Newton's method is applied to the logarithms, between which power profiles have nearly a straight line. It begins on
coarse grids, where it costs little. Between the pressures at which the contact changes the approach is linear in the
pressure, so two or three solves on the scene's own grid do.
"""

import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..endings import Cause, Reason, Status
from ..grid.observables import Observables, first_node, foundation_modulus
from ..grid.problem import full_contact_pressure, half_spectrum
from ..scene import Scene
from ..solution import MEANINGLESS, Choice, Solution
from .errors import QUANTITIES, estimated
from .grids import grids
from .linearised import contact_compliance

_COARSEST = 2**10  # points
_EXACT, _GUESS = 1e-10, 1e-3  # relative error of the approach at which to stop, on the scene's grid and on coarse ones
_SHARE = 0.01  # of the tolerance of the solves, where that is more
_GOOD, _LOOSE = 1e-8, 1e-3  # relative error at which an approach is met; the tolerance of the solves between the two
_FULL = 1e-9  # relative distance from the approach of full contact, within which that is the answer
_OVER_FULL = 1e-7  # by which the pressure is taken higher there, so that rounding leaves no node without contact
_MOST_SOLVES, _PATIENCE = 40, 4  # on a grid; and without progress: of the approach, or of what pressures are possible
_MOST_FAILED = 2  # of them that do not converge, which still tell whether the pressure is too low or too high
_FAR = 1.0  # where an error's logarithm is larger, coming nearer by as much is progress, too
_LONGEST_STEP = 30.0  # factor of the pressure
_STEEPEST = 3.0  # power of the approach with which a quantity grows, where nothing else tells

Tried = tuple[float, Observables]
"""A pressure, and what it has brought."""


@dataclass
class _Newton:
    """Newton's method for the pressure, kept between the pressures that are known to be too low and too high."""

    approach: float
    """That is wanted [length]."""
    low: float = 0.0
    """A pressure whose approach is too small [pressure]."""
    high: float = math.inf
    """A pressure whose approach is too large [pressure]."""

    @property
    def room(self) -> float:
        """Logarithm of the factor between the two pressures (dimensionless)."""
        return math.log(min(self.high, sys.float_info.max)) - math.log(max(self.low, sys.float_info.min))

    def next(self, pressure: float, found: float, compliance: float) -> float:
        """The next pressure, from one, its approach [length] and d(approach)/dp."""
        if found < self.approach:
            self.low = max(self.low, pressure)
        else:
            self.high = min(self.high, pressure)
        step = math.copysign(math.log(_LONGEST_STEP), self.approach - found)
        slope = pressure * compliance / found if found > 0 else math.nan
        if slope > 0:  # not so where rounding has eaten it, or at full contact
            step = math.copysign(min(abs(math.log(self.approach / found) / slope), abs(step)), step)
        better = pressure * math.exp(step)
        if self.low < better < self.high:
            return better
        return math.sqrt(max(self.low, self.high / _LONGEST_STEP**2) * self.high)


def solve_to_approach(scene: Scene, solve: Callable[[Scene], Solution]) -> Solution:
    """Solve a scene whose approach is given; the pressure that was found is that of the solution's scene.

    solve: solves a scene that has a pressure. Raises `ValueError` for an approach that no pressure brings.
    """
    begin = time.perf_counter()
    approach, iterations, points = scene.approach, 0, 0.0
    assert approach is not None

    def counted(scene: Scene) -> Solution:
        nonlocal iterations, points
        solution = solve(scene)
        iterations, points = iterations + solution.iterations, points + solution.transform_pairs * scene.num_points
        return solution

    check_approach(scene)
    if approach >= _full_approach(scene) * (1 - _FULL):
        return _full_contact(scene, solve, approach)
    guess = _foundation_guess(scene, approach)
    for size in grids(scene.num_points)[:-1]:
        if size >= _COARSEST:
            guess = _coarse_guess(scene, size, counted, guess)
    tried: list[Tried] = []
    found, solves = _found(scene, counted, guess, _EXACT, tried)
    try:
        error = _approach_error(found, counted)
    except KeyboardInterrupt:
        error, found = found.observables.approach_error, replace(found, status=Status.INTERRUPTED)
    found, off_by = _with_error_of_pressure(found, tried, error)
    pressure, seconds = found.scene.pressure, found.seconds | {"total": time.perf_counter() - begin}
    seconds["solve"] += seconds["total"] - found.seconds["total"]
    known = f"is about {off_by:.1g}" if math.isfinite(off_by) else "is not known"
    wanted = f"for the approach of {approach:g} [{scene.length_unit}]"
    why = f"{wanted}; the pressure's relative error {known}; solves on this grid: {solves}"
    found = replace(
        found,
        iterations=iterations,
        transform_pairs=points / scene.num_points,
        seconds=seconds,
        choices=(Choice("pressure", f"{pressure:.10g}", why, off_by), *found.choices),
    )
    found = _told(found, approach)
    off = abs(found.observables.approach / approach - 1)
    if found.status is Status.CONVERGED and off > max(_GOOD, min(found.tolerance, _LOOSE)):
        met = f"{approach:g}, and {found.observables.approach:.10g} was found"
        reason = Reason(Cause.METHOD, "approach", met, "another approach, or a smaller tolerance")
        return replace(found, status=Status.STAGNATED, reason=reason)
    return found


def _found(
    scene: Scene, solve: Callable[[Scene], Solution], pressure: float, exact: float, tried: list[Tried]
) -> tuple[Solution, int]:
    """The solution whose approach is right but for a share `exact`, or as near as Newton's method comes to that, and
    the number of solves.

    pressure: to begin with; tried: gets all that converged.
    """
    approach = scene.approach
    assert approach is not None
    newton, least, failed = _Newton(approach), math.inf, 0
    progress, room = 0, math.inf
    best: Solution | None = None
    last: Solution | None = None
    for solves in range(1, _MOST_SOLVES + 1):
        solution = solve(replace(scene, approach=None, pressure=pressure))
        found = solution.observables.approach
        off = abs(math.log(max(found, sys.float_info.min)) - math.log(approach))
        residual = solution.certificate.free_residual if solution.certificate else math.inf
        if solution.status is Status.INTERRUPTED or not residual < MEANINGLESS:
            return solution, solves
        if solution.status is Status.CONVERGED:
            tried.append((solution.scene.pressure, solution.observables))
            if _much_less(off, least):
                progress = solves
            if off < least:
                best, least = solution, off
        else:
            failed, last = failed + 1, solution
        if _much_less(newton.room, room):
            progress, room = solves, newton.room
        if least <= max(exact, _SHARE * solution.tolerance) or failed > _MOST_FAILED:
            break
        if solves >= progress + _PATIENCE:
            break
        touching = solution.contact.any()
        compliance = contact_compliance(solution.scene, solution.contact) if touching else math.nan
        pressure = newton.next(pressure, found, compliance)
    found_by = best if least <= _GOOD or last is None else last  # what failed says why
    assert found_by is not None
    return found_by, solves


def _much_less(logarithm: float, before: float) -> bool:
    """Whether a logarithm is half of what it was, or less by `_FAR` where it is large."""
    return logarithm < max(before / 2, before - _FAR)


def _coarse_guess(scene: Scene, num_points: int, solve: Callable[[Scene], Solution], guess: float) -> float:
    """The pressure on a coarse grid; the guess itself where the indenter is not to be had there."""
    try:
        coarse = scene.on_grid(num_points)
    except ValueError:
        return guess
    found = _found(coarse, solve, guess, _GUESS, [])[0]
    if found.status is Status.INTERRUPTED:
        raise KeyboardInterrupt  # nothing is known on the scene's grid
    return found.scene.pressure


def _approach_error(found: Solution, solve: Callable[[Scene], Solution]) -> float:
    """Estimated error of the approach at the pressure that was found; where there is one grid alone by a coarser one.

    Raises `KeyboardInterrupt` where that is interrupted.
    """
    error, scene = found.observables.approach_error, found.scene
    if math.isinf(error) and found.status is Status.CONVERGED:
        try:
            coarse = solve(scene.on_grid(scene.num_points // 4))
        except ValueError:  # no such grid holds the scene
            return error
        if coarse.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        if coarse.status is Status.CONVERGED:
            return estimated(QUANTITIES["approach"], scene, scene.num_points, found.observables, [coarse.observables])
    return error


def _with_error_of_pressure(found: Solution, tried: Sequence[Tried], error: float) -> tuple[Solution, float]:
    """The solution with errors that include those of its pressure, and the relative error of that, estimated.

    error: of the approach at this pressure [length]. So another pressure may belong to the approach asked for; what
    that would change is known from another one that was tried.
    """
    own, pressure = found.observables, found.scene.pressure
    if not error or not own.approach > 0:
        return found, 0.0

    def distance(other: Tried) -> float:
        return abs(math.log(abs(other[1].approach - own.approach) / error))

    others = [one for one in tried if one[1].approach != own.approach and 0 < error < math.inf]
    if not others:
        share = _STEEPEST * error / own.approach
        values = {quantity: abs(getattr(own, quantity.value)) for quantity in QUANTITIES.values()}
        changes = {quantity: share * value if value else 0.0 for quantity, value in values.items()}
    else:
        at, other = min(others, key=distance)
        rate = error / abs(other.approach - own.approach)
        share = rate * abs(at / pressure - 1)
        changes = {q: rate * abs(getattr(other, q.value) - getattr(own, q.value)) for q in QUANTITIES.values()}
    errors: dict[str, Any] = {q.error: getattr(own, q.error) + change for q, change in changes.items()}
    return replace(found, observables=replace(own, **errors)), share


def _full_approach(scene: Scene) -> float:
    """The largest approach that a pressure brings [length]; `inf` where the layer has a foundation that yields."""
    if foundation_modulus(scene) not in (0.0, math.inf):
        return math.inf
    return float(scene.profile.mean()) + first_node(scene)


def _full_contact(scene: Scene, solve: Callable[[Scene], Solution], approach: float) -> Solution:
    """The solution under the least pressure of full contact; any larger one brings the same approach."""
    pressure = (1 + _OVER_FULL) * full_contact_pressure(scene)
    found = solve(replace(scene, approach=None, pressure=pressure))
    why = "the least pressure of full contact; any larger one gives the same approach"
    choices = (Choice("pressure", f"{pressure:.10g}", why), *found.choices)
    return _told(replace(found, choices=choices), approach)


def _told(found: Solution, approach: float) -> Solution:
    """The solution, which says how far its approach is off the one asked for."""
    balance = abs(found.observables.approach / approach - 1)
    observables = replace(found.observables, approach_error=abs(found.observables.approach - approach))
    certificate = found.certificate and replace(found.certificate, approach_balance=balance)
    return replace(found, observables=observables, certificate=certificate)


def check_approach(scene: Scene) -> None:
    """Raise `ValueError` for a scene whose approach no pressure brings."""
    full, approach = _full_approach(scene), scene.approach
    if approach is not None and approach > full * (1 + _FULL):
        allowed = f"up to {full:.12g}, the mean height on this grid above the lowest point: there the contact is full"
        raise ValueError(f"approach is {approach:.12g}; allowed: {allowed}")


def _foundation_guess(scene: Scene, approach: float) -> float:
    """The pressure of a Winkler foundation as stiff as the layer's longest wave."""
    modulus = float(half_spectrum(scene.layer, 2, scene.period)[1]) * scene.layer.contact_modulus / scene.period
    return modulus * float(np.maximum(approach - first_node(scene) - scene.profile, 0.0).mean())
