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
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from ..endings import Cause, Reason, Status
from ..grid.errors import FACTOR, MOST_ACCURACY, QUANTITIES, estimated
from ..grid.problem import Problem
from ..scene import Scene
from ..solution import Choice, Solution
from .grids import COARSEST, DEFAULT_TOLERANCE, grids
from .linearised import flat_punch

_MOST_SOLVES = 40  # on a grid
_LONGEST_STEP = 30.0  # factor of the pressure
_STEEPEST = 3.0  # power of the approach with which a quantity grows, where nothing else tells


def solve_to_approach(scene: Scene, solve: Callable[[Scene], Solution]) -> Solution:
    """Solve a scene whose approach is given; the pressure that was found is that of the solution's scene.

    solve: solves a scene that has a pressure. Raises `ValueError` for an approach that no pressure brings.
    """
    begin = time.perf_counter()
    approach, solved = scene.approach, list[Solution]()
    assert approach is not None
    full = approach >= check_approach(scene) * (1 - DEFAULT_TOLERANCE)
    pressure = _first_pressure(scene, approach, full)
    on_grid = cache(scene.on_grid)  # given heights are resampled once

    def under(pressure: float, size: int = scene.num_points) -> Solution:
        solved.append(solve(replace(on_grid(size), approach=None, pressure=pressure)))
        return solved[-1]

    sizes = grids(scene.num_points)
    if full:
        found, why = under(pressure), "the least pressure of full contact; any larger one gives the same approach"
        choices = (Choice("pressure", f"{pressure:.10g}", why), *found.choices)
        return _told(replace(found, choices=choices), approach)
    for size in sizes[:-1]:
        if size >= 2 * COARSEST:
            with suppress(ValueError):  # no such grid holds the indenter
                coarse = _tried(partial(under, size=size), approach, pressure, MOST_ACCURACY)[-1]
                if coarse.status is Status.INTERRUPTED:
                    raise KeyboardInterrupt  # nothing is known on the scene's grid
                pressure = coarse.scene.pressure
    tried = _tried(under, approach, pressure, DEFAULT_TOLERANCE)
    found, error = _best(tried, approach), math.inf
    try:
        error = _approach_error(found, under)
    except KeyboardInterrupt:
        found = replace(found, status=Status.INTERRUPTED)
    found, off_by = _with_error_of_pressure(found, tried, error)
    seconds = found.seconds | {"total": time.perf_counter() - begin}
    seconds["solve"] += seconds["total"] - found.seconds["total"]
    known = f"is about {off_by:.1g}" if math.isfinite(off_by) else "is not known"
    wanted = f"for the approach of {approach:g} [{scene.length_unit}]"
    why = f"{wanted}; the pressure's relative error {known}; solves on this grid: {len(tried)}"
    found = replace(
        found,
        iterations=sum(one.iterations for one in solved),
        transform_pairs=sum(one.transform_pairs * one.scene.num_points for one in solved) / scene.num_points,
        seconds=seconds,
        choices=(Choice("pressure", f"{found.scene.pressure:.10g}", why, off_by), *found.choices),
    )
    found = _told(found, approach)
    off = abs(found.observables.approach / approach - 1)
    if found.status is Status.CONVERGED and off > max(DEFAULT_TOLERANCE, found.tolerance):
        met = f"{approach:g}, and {found.observables.approach:.10g} was found"
        reason = Reason(Cause.METHOD, "approach", met, "another approach, or a smaller tolerance")
        return replace(found, status=Status.STAGNATED, reason=reason)
    return found


def _first_pressure(scene: Scene, approach: float, full: bool) -> float:
    """Where to begin: the least pressure of full contact, or that of a foundation as stiff as the longest wave."""
    problem = Problem.from_scene(scene)
    if full:  # more than that by a little, else rounding may leave nodes without contact
        return (1 + DEFAULT_TOLERANCE) * problem.full_contact_pressure
    modulus = float(problem.stiffness[1]) * problem.layer.unit * scene.layer.contact_modulus / scene.period
    return modulus * float(np.maximum(approach - scene.first_node - problem.profile, 0.0).mean())


def _tried(under: Callable[[float], Solution], approach: float, pressure: float, exact: float) -> list[Solution]:
    """The solutions by Newton's method, until one is right except for a hundredth of `exact`, or does not converge.

    under: the solution under a pressure; pressure: to begin with. The next one is kept between those that are known to
    be too low and too high.
    """
    low, high, tried = 0.0, math.inf, list[Solution]()
    while len(tried) < _MOST_SOLVES:
        solution = under(pressure)
        tried.append(solution)
        off = _off(solution, approach)
        if solution.status is not Status.CONVERGED or abs(off) <= max(exact, solution.tolerance) / 100:
            break
        if off < 0:
            low = max(low, pressure)
        else:
            high = min(high, pressure)
        step, found = math.log(_LONGEST_STEP), solution.observables.approach
        touching = found > 0 and solution.contact.any()
        compliance = flat_punch(Problem.from_scene(solution.scene), solution.contact)[0] if touching else 0.0
        if compliance > 0:  # not so where rounding has eaten it, or at full contact
            step = min(abs(off) * found / (pressure * compliance), step)
        pressure *= math.exp(-math.copysign(step, off))
        if not low < pressure < high:
            pressure = math.sqrt(max(low, high / _LONGEST_STEP**2) * high)
    return tried


def _off(solution: Solution, approach: float) -> float:
    """Logarithm of a solution's approach over the one wanted."""
    return math.log(max(solution.observables.approach, sys.float_info.min)) - math.log(approach)


def _best(tried: Sequence[Solution], approach: float) -> Solution:
    """The solution with the best approach; one that did not converge if none is good, because it has a reason."""
    best = min(tried, key=lambda one: abs(_off(one, approach)) if one.status is Status.CONVERGED else math.inf)
    return best if abs(_off(best, approach)) <= DEFAULT_TOLERANCE or tried[-1].status is Status.CONVERGED else tried[-1]


def _approach_error(found: Solution, under: Callable[[float, int], Solution]) -> float:
    """Estimated error of the approach at the pressure that was found; where there is one grid alone by a coarser one.

    under: the solution under a pressure on a grid of so many points. Raises `KeyboardInterrupt` if it is interrupted.
    """
    error, scene = found.observables.approach_error, found.scene
    if math.isinf(error) and found.status is Status.CONVERGED:
        with suppress(ValueError):  # no such grid holds the scene
            coarse = under(scene.pressure, scene.num_points // FACTOR)
            if coarse.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            if coarse.status is Status.CONVERGED:
                known = [coarse.observables]
                return estimated(QUANTITIES["approach"], scene, scene.num_points, found.observables, known)
    return error


def _with_error_of_pressure(found: Solution, tried: Sequence[Solution], error: float) -> tuple[Solution, float]:
    """The solution with errors that include those of its pressure, and the relative error of that, estimated.

    error: of the approach at this pressure [length]. So another pressure may belong to the approach asked for; another
    one that was tried tells the changes.
    """
    own, pressure = found.observables, found.scene.pressure
    if not error or not own.approach > 0:
        return found, 0.0
    values = {q: abs(getattr(own, q.value)) for q in QUANTITIES.values()}
    others = [one for one in tried if one.status is Status.CONVERGED and one.observables.approach != own.approach]
    if others and error < math.inf:
        other = min(others, key=lambda one: abs(math.log(abs(one.observables.approach - own.approach) / error)))
        rate = error / abs(other.observables.approach - own.approach)
        share = rate * abs(other.scene.pressure / pressure - 1)
        changes = {q: rate * abs(getattr(other.observables, q.value) - getattr(own, q.value)) for q in values}
    else:
        share = _STEEPEST * error / own.approach
        changes = {q: share * value if value else 0.0 for q, value in values.items()}
    errors: dict[str, Any] = {q.error: getattr(own, q.error) + change for q, change in changes.items()}
    return replace(found, observables=replace(own, **errors)), share


def _told(found: Solution, approach: float) -> Solution:
    """The solution, which says how far its approach is off the one asked for."""
    balance = abs(found.observables.approach / approach - 1)
    observables = replace(found.observables, approach_error=abs(found.observables.approach - approach))
    certificate = found.certificate and replace(found.certificate, approach_balance=balance)
    return replace(found, observables=observables, certificate=certificate)


def check_approach(scene: Scene) -> float:
    """Check the approach that is given; returns the largest that a pressure brings [length], `inf` where the layer has
    a foundation that yields.

    Raises `ValueError` for a scene whose approach no pressure brings.
    """
    if scene.foundation_modulus not in (0.0, math.inf):
        return math.inf
    full = float(scene.profile.mean()) + scene.first_node
    if scene.approach is not None and scene.approach > full * (1 + DEFAULT_TOLERANCE):
        allowed = f"up to {full:.12g}, the mean height on this grid above the lowest point: there the contact is full"
        raise ValueError(f"approach is {scene.approach:.12g}; allowed: {allowed}")
    return full
