"""What the page says of an answer, as plain text."""

import math

from linecontact.solver import Scene, Solution
from linecontact.solver.display import rounded_up

from ..scans.preparation import mirrored
from .answers import Answer
from .controls import HALF_SPACE
from .units import lengths


def said(answer: Answer, seconds: float) -> str:
    """The answer, its error and its milliseconds.

    seconds: wall time from the event to the page [s].
    """
    about = [_scene(answer.scene)] if answer.scene else []
    found = _found(answer.solution) if answer.solution else []
    return "\n".join([*about, *found, _times(answer, seconds)])


def doubted(answer: Answer) -> str:
    """Why there is no answer, or what to doubt of it."""
    if answer.solution is None:
        return f"No answer. {answer.refused}"
    return "\n".join(f"Warning, {w.kind}: {w.text}." for w in answer.solution.warnings)


def _scene(scene: Scene) -> str:
    """What was pressed against what, dimensionless and in the scan's unit."""
    thickness = scene.layer.thickness
    along, _ = lengths(scene)
    over = f"d/L = {thickness / scene.period:.3g}" if math.isfinite(thickness) else HALF_SPACE
    if math.isfinite(thickness) and along.symbol != "/L":
        over += f" (d = {thickness * along.factor:.4g}{along.symbol})"
    parts = [over, f"p/E* = {scene.reduced_load:.3g}"]
    given = scene.to_dict()
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
    along, _ = lengths(solution.scene)
    image = " (its mirror image's among them)" * mirrored(solution.scene.indenter.to_dict())
    width = solution.contact_width * along.factor
    # of one kind with a_r and kappa: `reduced_pressure` and `reduced_thickness` are of counted nodes
    reduced_pressure = area / o.kappa_subgrid if o.kappa_subgrid else math.inf
    reduced_thickness = solution.scene.layer.thickness / (area * solution.scene.period) if area else math.inf
    return [
        f"contact area a_r = {area:.6g} \N{PLUS-MINUS SIGN} {rounded_up(error)} (dimensionless, estimated relative "
        f"error {rounded_up(error / area)}), {solution.status} on its grid",
        f"kappa = {o.kappa_subgrid:.5g} \N{PLUS-MINUS SIGN} {rounded_up(o.kappa_error)}, p* = {reduced_pressure:.4g}, "
        f"d/(a_r L) = {reduced_thickness:.4g}, peak pressure/E* = "
        f"{o.peak_pressure / solution.scene.layer.contact_modulus:.4g} (dimensionless)",
        f"{o.num_patches} contact {'patch' if o.num_patches == 1 else 'patches'}{image}, "
        f"contact width{along.symbol} = {width:.5g}",
    ]


def _times(answer: Answer, seconds: float) -> str:
    return f"{answer.seconds * 1e3:.0f} ms to solve, {seconds * 1e3:.0f} ms from the event to the page"
