"""The text of an answer on the page."""

import math

from linecontact.solver import Scene, Solution
from linecontact.solver.display import rounded_up

from ..figures.units import shown_units
from ..scans.preparation import mirrored
from .answers import Answer
from .controls import HALF_SPACE


def said(answer: Answer, seconds: float) -> str:
    """The answer, its error and its milliseconds.

    seconds: wall time from the event to the page [s].
    """
    about = [_scene(answer.scene)] if answer.scene else []
    found = _found(answer.solution) if answer.solution else []
    return "\n".join([*about, *found, _times(answer, seconds)])


def doubted(answer: Answer) -> str:
    """Why there is no answer, or its warnings."""
    if answer.solution is None:
        return f"No answer. {answer.refused}"
    return "\n".join(f"Warning, {w.kind}: {w.text}." for w in answer.solution.warnings)


def _scene(scene: Scene) -> str:
    """Indenter and layer, in the scan's units or dimensionless."""
    given, thickness = scene.to_dict(), scene.layer.thickness
    along, _, pressures = shown_units(given)
    told = f"{thickness * along.factor:.5g}" if math.isfinite(thickness) else HALF_SPACE
    parts = [f"d{along.symbol} = {told}" * (told != HALF_SPACE) or told]
    parts.append(f"p{pressures.symbol} = {scene.pressure * pressures.factor:.5g}")
    if "base_modulus" in given:
        ratio = float(given["base_modulus"]) / scene.layer.contact_modulus
        parts.append(f"base E2*/E* = {ratio:.3g}, nu2 = {given['base_poisson_ratio']:g}")
    named = {"poisson_ratio": "nu", "exponent": "n", "hurst": "H", "seed": "seed"}
    parts += [f"{sign} = {given[name]:g}" for name, sign in named.items() if name in given]
    if "profile_file" in given:
        parts.append(f"scan {given['profile_file']}")
    return "For " + ", ".join(parts) + f"; {scene.num_points} points:"


def _found(solution: Solution) -> list[str]:
    o = solution.observables
    area, error = o.contact_area_subgrid, o.contact_area_error
    along, _, pressures = shown_units(solution.scene.to_dict())
    image = " (its mirror image's among them)" * mirrored(solution.scene.indenter.to_dict())
    width = solution.contact_width * along.factor
    peak = f"peak pressure{pressures.symbol} = {o.peak_pressure * pressures.factor:.4g}"
    # of one kind with a_r and kappa: `reduced_pressure` and `reduced_thickness` are of counted nodes
    reduced_pressure = area / o.kappa_subgrid if o.kappa_subgrid else math.inf
    reduced_thickness = solution.scene.layer.thickness / (area * solution.scene.period) if area else math.inf
    return [
        f"contact area a_r = {area:.6g} \N{PLUS-MINUS SIGN} {rounded_up(error)} (dimensionless, estimated relative "
        f"error {rounded_up(error / area)}), {solution.status} on its grid",
        f"kappa = {o.kappa_subgrid:.5g} \N{PLUS-MINUS SIGN} {rounded_up(o.kappa_error)}, p* = {reduced_pressure:.4g}, "
        f"d/(a_r L) = {reduced_thickness:.4g}, {peak}",
        f"{o.num_patches} contact {'patch' if o.num_patches == 1 else 'patches'}{image}, "
        f"contact width{along.symbol} = {width:.5g}",
    ]


def _times(answer: Answer, seconds: float) -> str:
    return f"{answer.seconds * 1e3:.0f} ms to solve, {seconds * 1e3:.0f} ms from the event to the page"
