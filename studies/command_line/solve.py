"""`linecontact solve`: one scene, as a table or as JSON, and its file and figure."""

import inspect
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from linecontact.solver import METHODS, QUANTITIES, MeasuredIndenter, Scene, Solution, Status, solve
from linecontact.solver.scene import PRECISIONS
from linecontact.solver.transforms.device import DEVICES, PLANNING
from linecontact.solver.units import named

from ..files import solution_files, writing
from ..files.marks import names
from ..scenes import making, scan_table
from ..scenes.making import Given, make_scene
from ..terminal import console
from ..terminal.options import one_of
from .solution_tables import choices_table, solution_table

_DEFAULTS = {name: parameter.default for name, parameter in inspect.signature(solve).parameters.items()}
"""Of the parameters of `solve`."""


@dataclass(frozen=True)
class Options(making.Options):
    """Solve one scene. Lengths and pressures in consistent units of your own; the published study's are 1.

    The problem: a linear elastic layer on its base, and a rigid indenter, the same along a second axis (plane
    strain), periodic along the first; no friction, no adhesion; small strains and slopes. A scan is one line of a
    surface, which is taken to be the same along the second axis. E* = E/(1 - nu^2).
    """

    approach: float | None = None
    """Rigid approach since first touch [length], instead of the pressure, which is then found; up to 0 nothing
    touches."""
    num_points: int | None = None
    """Grid points, at least 4, like 262144 or 2^18; default 2^18, for a file four or more to a value."""
    accuracy: float | None = _DEFAULTS["accuracy"]
    """Relative error wanted, 1e-9 to 0.1 (dimensionless). Chooses model, grid, method, precision and tolerance, which
    must not be given; num_points is then the most to use."""
    accuracy_of: str = one_of(QUANTITIES, _DEFAULTS["accuracy_of"])
    """Quantity whose accuracy is asked for; area and kappa between sub-grid edges."""
    method: str | None = one_of(METHODS, _DEFAULTS["method"])
    """Method; default: active-set, the fastest."""
    grids: Literal["auto", "nested", "single"] = "auto"
    """Start from the solution on coarser grids; auto: for the active set."""
    tolerance: float | None = _DEFAULTS["tolerance"]
    """Stop at this rms equilibrium residual over p, 1e-14 to 0.5 (dimensionless); default 1e-8, in float32 as
    small as rounding allows."""
    max_iterations: int | None = _DEFAULTS["max_iterations"]
    """Iteration limit; reaching it gives exit status 3."""
    precision: str = one_of(PRECISIONS, Scene.precision)
    """Of the iteration; mixed: FIRE's transforms in float32, residuals in float64. The certificate is always
    float64."""
    threads: int = _DEFAULTS["threads"]
    """Threads of the transforms. Where other programs keep the cores busy, two take many times as long as one."""
    planning: str = one_of(PLANNING, _DEFAULTS["planning"])
    """FFTW's planning effort; its plans are kept for later runs."""
    device: str = one_of(DEVICES, _DEFAULTS["device"])
    """Where the method works; cuda: on a GPU, with --method mass-weighted-fire or fire. The certificate stays on the
    CPU."""
    json: bool = False
    """One JSON object on standard output instead of a table."""
    save: Path | None = None
    """Write fields and results to this HDF5 file, .h5 or .hdf5."""
    plot: bool = False
    """Draw the figure beside the saved file."""
    patches: Path | None = None
    """Write the contact patches to this CSV file: left and right end, width, nodes, load, largest pressure."""
    overwrite: bool = False
    """Let --save replace an existing file, and --plot and --patches one that linecontact has not made."""
    strict: bool = False
    """Give exit status 3 if there is a warning."""


def command(options: Options, given: Given) -> int:
    """Solve the scene that the options describe, and show the results; returns the exit status."""
    check_targets(options, given)
    if options.plot and not options.save:
        raise ValueError("--plot is given without --save; allowed: both, as the figure is drawn from the file")
    if options.accuracy is not None and options.grids != "auto":
        raise ValueError(f"grids is {options.grids}; allowed: auto, with accuracy, which chooses the grid")
    scene = make_scene(options, given)
    if options.profile == MeasuredIndenter.name and not options.json:
        console.Output().print(scan_table.table(scene))
    aim = options.tolerance or (1e-5 if options.accuracy else 1e-4 if options.precision == "float32" else 1e-8)
    try:
        with console.solve_progress(aim) as report:
            solution = solve(
                scene,
                accuracy=options.accuracy,
                accuracy_of=options.accuracy_of,
                method=options.method,
                nested=None if options.grids == "auto" else options.grids == "nested",
                tolerance=options.tolerance,
                max_iterations=options.max_iterations,
                threads=options.threads,
                planning=options.planning,
                device=options.device,
                progress=report,
            )
    except KeyboardInterrupt:
        console.errors.print("linecontact: interrupted before there was a result; nothing is saved")
        return console.EXIT_INTERRUPTED
    try:
        show(solution, options.json)
    finally:  # also when the reader of the output has gone away
        if options.save:
            solution_files.save_solution(options.save, solution)
        if options.patches:
            solution_files.save_patches(options.patches, solution)
    tell_files(options)
    status = console.exit_status(solution.status)
    if not status and options.strict and solution.warnings:
        named = ", ".join(warning.kind for warning in solution.warnings)
        console.errors.print(f"linecontact: strict, and there are warnings: {named}")
        return console.EXIT_NOT_CONVERGED
    if status:
        kept = f"; the partial result is in {options.save}" if options.save else ""
        why = "" if solution.status is Status.INTERRUPTED else f": {solution.reason}"
        console.errors.print(f"linecontact: {solution.status}{why}{kept}")
    return status


def show(solution: Solution, as_json: bool) -> None:
    """Print the results on standard output."""
    if as_json:
        print(json.dumps(solution.to_dict()), flush=True)
        return
    console.Output().print(solution_table(solution))
    for warning in solution.warnings:
        console.Output().print(f"Warning, {warning.kind}: {warning.text}.", style="bold yellow")
    if solution.choices:
        console.Output().print(choices_table(solution))
    steps = solution.scene.to_dict().get("profile_steps")
    if steps:
        console.Output().print(f"Profile: {steps}.")


def tell_files(options: Options) -> None:
    """Draw the figure if it is asked for, and say which files were written; not where the result itself is read."""
    written = {"Data": [options.save], "Patches": [options.patches]}
    if options.save and options.plot:
        from ..runner import drawing  # Matplotlib takes its time

        written["Figures"] = [*drawing.draw(options.save, options.overwrite, own=True)]
    output = console.errors if options.json else console.Output()
    for what, paths in written.items():
        if any(paths):
            output.print(f"{what}: {', '.join(map(str, paths))}", soft_wrap=True, highlight=False)


def check_targets(options: Options, given: Given) -> None:
    """Raise `ValueError` if the files or the figures would replace a file that they must not, or one another."""
    read = [(name, path) for group in given.values() for name, path in group.items() if isinstance(path, Path)]
    written = []
    if options.save:
        solution_files.check_file(options.save, options.overwrite)
        written.append(("save", options.save))
        written += [("plot", figure) for figure in names(options.save, [""] * options.plot)]
    if options.patches:
        writing.check_csv("patches", options.patches)
        written.append(("patches", options.patches))
    writing.check_targets(read, written, options.overwrite, solution_files.patches_head(named({})))
