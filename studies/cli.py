"""The command line: linecontact solve | study | plot | info."""

import json
import math
import os
import platform
import sys
import warnings
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any, Literal, TextIO

import tyro
from linecontact.solver import (
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Solution,
    provenance,
    solve,
    transforms,
)
from rich.table import Table

from . import blunt, hertz, rough, sharp
from .edge_curve import study as edge_curve
from .extremes import soak
from .extremes import study as extremes
from .figures.names import FORMATS
from .files import profile_columns, scans, solution_files, writing
from .iterations import study as iterations
from .kernel_benchmark import study as kernels
from .paper import study as paper
from .peers import study as peers
from .runner import study as runner
from .terminal import console
from .tradeoff import study as tradeoff


@dataclass(frozen=True)
class Solve:
    """Solve one scene. Lengths and pressures in consistent units of your own; the published study's are 1."""

    profile: Literal["power", "rough", "file"] = "power"
    """Indenter: h = (R/n) |x/R|^n; self-affine random roughness; or a file."""
    exponent: float = 2.0
    """n > 1: 1.5 sharp, 2 Hertz, 4 blunt (dimensionless)."""
    radius: float = 1.0
    """R > 0 [length]."""
    hurst: float = 0.8
    """Rough: 0 < H <= 1 (dimensionless)."""
    seed: int = 0
    """Rough: one seed is one surface, on every grid that resolves it."""
    roll_off_ratio: float = 1 / 8
    """Rough: lambda_r/L (dimensionless)."""
    cut_off_ratio: float = 1 / 512
    """Rough: lambda_s/lambda_r (dimensionless)."""
    rms_gradient: float = 1.0
    """Rough: rms gradient over the period (dimensionless)."""
    profile_file: Path | None = None
    """File: .npy, .csv, .txt (one column of heights, or x and heights), .h5, or an instrument's format."""
    profile_dataset: str | None = None
    """File: the dataset of an .h5 file that holds several."""
    profile_convention: Literal["gap", "heights"] = "gap"
    """File: h as the indenter's distance, or heights as a scan has them, peaks up."""
    x_unit: profile_columns.Unit | None = None
    """File: unit of its positions; default the length unit."""
    z_unit: profile_columns.Unit | None = None
    """File: unit of its heights; default the length unit."""
    length_unit: profile_columns.Unit = "m"
    """File: what one [length] of the scene is, where x_unit or z_unit is given."""
    resample: bool = False
    """File: treat even a file with as many values as grid points like any other."""
    detrend: scans.Detrend = "auto"
    """File: tilt removal; auto: linear, or none for a file taken as it is."""
    window: scans.Window = "auto"
    """File: what makes it periodic; auto: mirror, or none for a file taken as it is."""
    pressure: float = 2e-3
    """Mean external pressure p > 0 [pressure]."""
    thickness: float = math.inf
    """Layer thickness d > 0 [length]; inf is the half-space."""
    poisson_ratio: float = 0.25
    """-1 < nu <= 0.5 (dimensionless)."""
    period: float | None = None
    """Period L > 0 [length]; default 1, or the length of a file with positions."""
    num_points: int | None = None
    """Grid points, at least 4; default 2^18, for a file the next power of two (at most 16 times its values)."""
    contact_modulus: float = 1.0
    """E* = E/(1-nu^2) > 0 [pressure]."""
    accuracy: float | None = None
    """Relative error wanted of a_r, 1e-9 to 0.1 (dimensionless). Chooses model, grid, method, precision and tolerance,
    which must not be given; num_points is then the most to use."""
    method: Literal["active-set", "mass-weighted-fire", "fire"] | None = None
    """Method; default: active-set, the fastest."""
    grids: Literal["auto", "nested", "single"] = "auto"
    """Start from the solution on coarser grids; auto: for the active set."""
    tolerance: float | None = None
    """Stop at this rms free residual over p (dimensionless); default 1e-8, in float32 what rounding allows."""
    max_iterations: int | None = None
    """Iteration limit; reaching it gives exit status 3."""
    precision: Literal["float64", "float32", "mixed"] = "float64"
    """Of the iteration; mixed: float32 inside, residuals in float64. The certificate is always float64."""
    below_floor: Literal["refuse", "mixed"] = "refuse"
    """What to do with a tolerance that float32 cannot reach: refuse it, or meet it in mixed precision."""
    threads: int = 1
    """Threads of the transforms."""
    planning: Literal["estimate", "measure", "patient"] = "estimate"
    """FFTW's planning effort; what it finds is kept for later runs."""
    json: bool = False
    """One JSON object on standard output instead of a table."""
    save: Path | None = None
    """Write fields and results to this HDF5 file."""
    plot: bool = False
    """Draw the figure beside the saved file."""
    overwrite: bool = False
    """Let --save replace an existing file."""


_PROFILE_OPTIONS = {
    "power": ("exponent", "radius"),
    "rough": ("hurst", "seed", "roll_off_ratio", "cut_off_ratio", "rms_gradient"),
    "file": (
        "profile_file",
        "profile_dataset",
        "profile_convention",
        "x_unit",
        "z_unit",
        "length_unit",
        "resample",
        "detrend",
        "window",
    ),
}
"""Options that belong to one profile only."""


@dataclass(frozen=True)
class Study:
    """Run a study: data, figures and a table in one folder."""

    study: Annotated[
        Annotated[hertz.Options, tyro.conf.subcommand("hertz")]
        | Annotated[sharp.Options, tyro.conf.subcommand("sharp")]
        | Annotated[blunt.Options, tyro.conf.subcommand("blunt")]
        | Annotated[rough.Options, tyro.conf.subcommand("rough")]
        | Annotated[paper.Options, tyro.conf.subcommand("paper")]
        | Annotated[iterations.Options, tyro.conf.subcommand("iterations")]
        | Annotated[edge_curve.Options, tyro.conf.subcommand("edge-curve")]
        | Annotated[kernels.Options, tyro.conf.subcommand("kernels")]
        | Annotated[peers.Options, tyro.conf.subcommand("peers")]
        | Annotated[tradeoff.Options, tyro.conf.subcommand("tradeoff")]
        | Annotated[extremes.Options, tyro.conf.subcommand("extremes")]
        | Annotated[soak.Options, tyro.conf.subcommand("soak")],
        tyro.conf.arg(name=""),
    ]


@dataclass(frozen=True)
class Plot:
    """Draw the figures of a stored solution or study beside its file."""

    file: tyro.conf.Positional[Path]
    """An HDF5 file that linecontact wrote."""


@dataclass(frozen=True)
class Info:
    """Versions, threads, caches and devices."""


@dataclass(frozen=True)
class Arguments:
    """What is pressed against what, how large is the true contact, and how wrong can the answer be?"""

    command: Annotated[
        Annotated[Solve, tyro.conf.subcommand("solve")]
        | Annotated[Study, tyro.conf.subcommand("study")]
        | Annotated[Plot, tyro.conf.subcommand("plot")]
        | Annotated[Info, tyro.conf.subcommand("info")],
        tyro.conf.arg(name=""),
    ] = field()


def run_solve(options: Solve) -> int:
    """`linecontact solve`."""
    if options.save:
        check_targets(options)
    elif options.plot:
        raise ValueError("plot is True; allowed: together with --save, the figure is drawn from the file")
    if options.accuracy is not None and options.grids != "auto":
        raise ValueError(f"grids is {options.grids}; allowed: auto, with accuracy, which chooses the grid")
    scene = make_scene(options)
    aim = options.tolerance or (1e-5 if options.accuracy else 1e-4 if options.precision == "float32" else 1e-8)
    try:
        with console.solve_progress(aim) as report:
            solution = solve(
                scene,
                accuracy=options.accuracy,
                method=options.method,
                nested=None if options.grids == "auto" else options.grids == "nested",
                tolerance=options.tolerance,
                max_iterations=options.max_iterations,
                threads=options.threads,
                planning=options.planning,
                below_floor=options.below_floor,
                progress=report,
            )
    except KeyboardInterrupt:
        if options.accuracy is None:
            raise
        console.errors.print("linecontact: interrupted; to an accuracy there is no partial result, nothing is saved")
        return console.EXIT_INTERRUPTED
    try:
        if options.json:
            print(json.dumps(solution.to_dict()), flush=True)
        else:
            console.Output().print(solution_table(solution))
            if solution.choices:
                console.Output().print(choices_table(solution))
            steps = solution.scene.to_dict().get("profile_steps")
            if steps:
                console.Output().print(f"Profile: {steps}.")
    finally:  # also when the reader of the output has gone away
        if options.save:
            solution_files.save_solution(options.save, solution)
    if options.save and options.plot:
        run_plot(Plot(options.save), sys.stderr if options.json else sys.stdout)
    status = console.exit_status(solution.status)
    if status:
        kept = f"; the partial result is in {options.save}" if options.save else ""
        console.errors.print(f"linecontact: {solution.status}: {solution.reason}{kept}")
    return status


def check_targets(options: Solve) -> None:
    """Raise `ValueError` if the file or its figures would replace what they must not."""
    assert options.save
    writing.check_target(options.save, options.overwrite)
    if options.profile_file and options.save.exists() and options.profile_file.samefile(options.save):
        raise ValueError(f"save is {options.save}; allowed: another file than the profile's")
    for suffix in FORMATS if options.plot else ():
        if options.save.suffix == suffix:
            raise ValueError(f"save is {options.save}; allowed: with --plot not a figure's name")
        writing.check_target(options.save.with_suffix(suffix), options.overwrite)


def make_scene(options: Solve) -> Scene:
    """The scene that the options describe."""
    for profile, its_own in _PROFILE_OPTIONS.items():
        for name in its_own if profile != options.profile else ():
            if (value := getattr(options, name)) != getattr(Solve, name):
                raise ValueError(f"{name} is {value}; allowed: only with --profile {profile}, not {options.profile}")
    n = 2**18 if options.num_points is None else options.num_points
    period = 1.0 if options.period is None else options.period
    indenter: PowerIndenter | RoughIndenter | MeasuredIndenter = PowerIndenter(options.exponent, options.radius)
    if options.profile == "rough":
        ratios = options.roll_off_ratio, options.cut_off_ratio
        indenter = RoughIndenter(options.hurst, options.seed, *ratios, options.rms_gradient)
    elif options.profile == "file":
        if options.profile_file is None:
            raise ValueError("profile_file is missing; allowed: the path of a file, with --profile file")
        names = [field.name for field in fields(scans.Options)]
        renamed = {"path": "profile_file", "convention": "profile_convention", "dataset": "profile_dataset"}
        indenter, period, n = scans.read(
            scans.Options(**{name: getattr(options, renamed.get(name, name)) for name in names})
        )
    return Scene(
        layer=Layer(options.thickness, options.poisson_ratio, options.contact_modulus),
        indenter=indenter,
        pressure=options.pressure,
        period=period,
        num_points=n,
        precision=options.precision,
    )


def solution_table(solution: Solution) -> Table:
    """What a solve found, with units."""
    record = solution.to_dict()
    handed = ", handed over to mass-weighted-fire" if solution.handed_over else ""
    table = Table(title=f"{solution.method}{handed}, {record['precision']}: {solution.status}", show_header=True)
    table.add_column("quantity")
    table.add_column("value", justify="right")
    table.add_column("unit")
    spacing = 1 / solution.scene.num_points
    rows = [
        ("contact area a_r (sub-grid edges)", f"{record['contact_area_subgrid']:.10g}", "-"),
        ("  its error, estimated", record["contact_area_error"], "-" if solution.levels else "- (edges only)"),
        *(
            [("contact area a_r (nodes counted)", f"{record['contact_area']:.8g}", f"- (one node: {spacing:.1e})")]
            if solution.certificate
            else []
        ),
        ("contact patches", record["num_patches"], f"- ({record['num_counted_patches']} of 1 or 2 nodes)"),
        ("rms gradient in contact g_c", record["rms_gradient_contact"], "-"),
        ("reduced pressure p* = p/(E* g_c)", record["reduced_pressure"], "-"),
        ("kappa = a_r/p*", record["kappa"], "-"),
        ("kappa (sub-grid edges)", record["kappa_subgrid"], "-"),
        ("  its error, estimated", record["kappa_error"], "-"),
        *([("kappa over the half-space's", record["kappa_ratio"], "-")] if "kappa_ratio" in record else []),
        ("reduced thickness d/(a_r L)", record["reduced_thickness"], "-"),
        ("approach", record["approach"], "length"),
        ("peak pressure", record["peak_pressure"], "pressure"),
        ("iterations", record["iterations"], "-"),
        ("transform pairs", record["transform_pairs"], "-"),
        *((f"time: {stage}", f"{seconds:.3f}", "s") for stage, seconds in record["seconds"].items()),
        *((f"certificate: {name.replace('_', ' ')}", value, "-") for name, value in record["certificate"].items()),
    ]
    for name, value, unit in rows:
        table.add_row(name, f"{value:.7g}" if isinstance(value, float) else str(value), unit)
    return table


def choices_table(solution: Solution) -> Table:
    """What was chosen for the user."""
    table = Table(
        title="chosen" + (f" for an accuracy of {solution.accuracy:g}" if solution.accuracy else ""),
        caption="error: estimate of the relative error of a_r that it brings (dimensionless)",
    )
    for heading in ("what", "chosen", "error", "because"):
        table.add_column(heading)
    for choice in solution.choices:
        table.add_row(choice.what, choice.chosen, f"{choice.error:.1g}" if choice.error else "", choice.reason)
    return table


def run_plot(options: Plot, output: TextIO | None = None) -> int:
    """`linecontact plot`."""
    from .runner import drawing

    with warnings.catch_warnings(action="ignore"):  # of what matplotlib finds odd in a file
        drawn = drawing.draw(options.file)
    for file in drawn:
        print(console.printable(str(file)), file=output)
    return 0


def run_study(options: runner.Options) -> int:
    """`linecontact study`."""
    modules: tuple[Any, ...] = (hertz, sharp, blunt, rough, paper, iterations, edge_curve)
    modules += (kernels, peers, tradeoff, extremes, soak)
    return int(next(module for module in modules if type(options) is module.Options).command(options))


def run_info(_: Info) -> int:
    """`linecontact info`."""
    import pyfftw
    import warp as wp
    from linecontact import kernels

    kernels.load()
    table = Table(title="linecontact", show_header=False)
    rows = {
        **provenance.provenance(),
        "FFTW": pyfftw.fftw_version,
        "threads": f"FFTW 1 by default (--threads), Warp 1; {len(os.sched_getaffinity(0))} cores usable"
        if hasattr(os, "sched_getaffinity")
        else str(os.cpu_count()),
        "Warp kernel cache": str(wp.config.kernel_cache_dir),
        "FFTW wisdom": f"{transforms.wisdom_file()} ({'present' if transforms.wisdom_file().exists() else 'none yet'})",
        "devices": ", ".join(str(device) for device in wp.get_devices()) + " (only cpu is used)",
        "interpreter": f"{sys.executable}, {platform.machine()}",
    }
    for name, value in rows.items():
        table.add_row(name, value)
    console.Output().print(table)
    return 0


def main(arguments: list[str] | None = None) -> int:
    """Entry point of `linecontact`; returns the exit status."""
    command = console.parse(Arguments, arguments, "linecontact", Arguments.__doc__ or "").command
    if isinstance(command, Solve):
        return console.guard(lambda: run_solve(command))
    if isinstance(command, Plot):
        return console.guard(lambda: run_plot(command))
    if isinstance(command, Info):
        return console.guard(lambda: run_info(command))
    return console.guard(lambda: run_study(command.study), console.KEPT)


if __name__ == "__main__":
    sys.exit(main())
