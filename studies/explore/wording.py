"""What the page says of an answer, as HTML. All text that comes from elsewhere is escaped."""

import math
from html import escape

from linecontact.solver import Scene, Solution

from .answers import Answer
from .controls import HALF_SPACE
from .units import lengths


def said(answer: Answer, seconds: float) -> str:
    """The answer, its error and its milliseconds, or why there is none.

    seconds: wall time from the event to the page [s].
    """
    about = f"<div>{_scene(answer.scene)}</div>" if answer.scene else ""
    if answer.solution is None:
        return f'{about}<div style="color:#b00000"><b>{escape(answer.refused)}</b></div>{_times(answer, seconds)}'
    warnings = "".join(
        f'<div style="color:#8a5a00">Warning, {escape(w.kind)}: {escape(w.text)}.</div>'
        for w in answer.solution.warnings
    )
    return about + _found(answer.solution) + _times(answer, seconds) + warnings


def _scene(scene: Scene) -> str:
    """What was pressed against what, dimensionless and in the scan's unit."""
    thickness = scene.layer.thickness
    along, _ = lengths(scene)
    over = f"d/L = {thickness / scene.period:.3g}" if math.isfinite(thickness) else HALF_SPACE
    if math.isfinite(thickness) and along.symbol != "/L":
        over += f" (d = {thickness * along.factor:.4g}{along.symbol})"
    parts = [over, f"p/E* = {scene.reduced_load:.3g}"]
    given = scene.to_dict()
    named = {"poisson_ratio": "nu", "exponent": "n", "hurst": "H", "seed": "seed"}
    parts += [f"{sign} = {given[name]:g}" for name, sign in named.items() if name in given]
    if "profile_file" in given:
        parts.append(f"scan {given['profile_file']}")
    return "For " + escape(", ".join(parts)) + f"; {scene.num_points} points:"


def _found(solution: Solution) -> str:
    o = solution.observables
    area, error = o.contact_area_subgrid, o.contact_area_error
    along, _ = lengths(solution.scene)
    width = solution.contact_width * along.factor
    lines = [
        f"<b>contact area a_r = {area:.6g} &plusmn; {error:.1g}</b> (dimensionless, relative error {error / area:.1g}, "
        f"as claimed), {escape(str(solution.status))} on its grid",
        f"kappa = {o.kappa_subgrid:.5g} &plusmn; {o.kappa_error:.1g}, p* = {o.reduced_pressure:.4g}, "
        f"d/(a_r L) = {o.reduced_thickness:.4g}, peak pressure/E* = "
        f"{o.peak_pressure / solution.scene.layer.contact_modulus:.4g} (dimensionless)",
        f"{o.num_patches} contact {'patch' if o.num_patches == 1 else 'patches'}, "
        f"contact width{escape(along.symbol)} = {width:.5g}",
    ]
    return "".join(f"<div>{line}</div>" for line in lines)


def _times(answer: Answer, seconds: float) -> str:
    return f"<div>{answer.seconds * 1e3:.0f} ms to solve, {seconds * 1e3:.0f} ms from the event to the page</div>"
