"""The command line: linecontact solve | study | plot | info."""

import json
import math
import os
import platform
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro
from linecontact.solver import (
    METHODS,
    Layer,
    PowerIndenter,
    Scene,
    Solution,
    default_tolerance,
    provenance,
    solve,
    transforms,
)
from rich.console import Console
from rich.table import Table

from . import console, hertz, iterations, store


@dataclass(frozen=True)
class Solve:
    """Solve one scene. Lengths and pressures in consistent units of your own; the published study's are 1."""

    profile: Literal["power"] = "power"
    """Indenter: h = (R/n) |x/R|^n."""
    exponent: float = 2.0
    """n > 1: 1.5 sharp, 2 Hertz, 4 blunt (dimensionless)."""
    radius: float = 1.0
    """R > 0 [length]."""
    pressure: float = 2e-3
    """Mean external pressure p > 0 [pressure]."""
    thickness: float = math.inf
    """Layer thickness d > 0 [length]; inf is the half-space."""
    poisson_ratio: float = 0.25
    """-1 < nu <= 0.5 (dimensionless)."""
    period: float = 1.0
    """Period L > 0 [length]."""
    num_points: int = 2**18
    """Grid points, even, at least 16."""
    contact_modulus: float = 1.0
    """E* = E/(1-nu^2) > 0 [pressure]."""
    method: Literal["mass-weighted-fire", "fire"] = METHODS[0]  # type: ignore[assignment]
    """Relaxation method."""
    tolerance: float | None = None
    """Stop at this rms free residual over p (dimensionless); default 1e-8, in float32 what rounding allows."""
    max_iterations: int | None = None
    """Iteration limit; reaching it gives exit status 3."""
    precision: Literal["float64", "float32"] = "float64"
    """Of the iteration; the certificate is always float64."""
    threads: int = 1
    """Threads of the transforms."""
    planning: Literal["estimate", "measure", "patient"] = "estimate"
    """FFTW's planning effort; what it finds is kept for later runs."""
    json: bool = False
    """One JSON object on standard output instead of a table."""
    save: Path | None = None
    """Write fields and results to this HDF5 file."""
    overwrite: bool = False
    """Let --save replace an existing file."""


@dataclass(frozen=True)
class Study:
    """Run a study: data, figures and a table in one folder."""

    study: Annotated[
        Annotated[hertz.Options, tyro.conf.subcommand("hertz")]
        | Annotated[iterations.Options, tyro.conf.subcommand("iterations")],
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
        store.check_target(options.save, options.overwrite)
    scene = Scene(
        layer=Layer(options.thickness, options.poisson_ratio, options.contact_modulus),
        indenter=PowerIndenter(options.exponent, options.radius),
        pressure=options.pressure,
        period=options.period,
        num_points=options.num_points,
        precision=options.precision,
    )
    with console.solve_progress(options.tolerance or default_tolerance(scene)) as report:
        solution = solve(
            scene,
            method=options.method,
            tolerance=options.tolerance,
            max_iterations=options.max_iterations,
            threads=options.threads,
            planning=options.planning,
            progress=report,
        )
    if options.json:
        print(json.dumps(solution.to_dict()), flush=True)
    else:
        Console().print(solution_table(solution))
    if options.save:
        store.save_solution(options.save, solution)
    status = console.exit_status(solution.status)
    if status:
        kept = f"; the partial result is in {options.save}" if options.save else ""
        console.errors.print(
            f"linecontact: not converged: {solution.status} after {solution.iterations} iterations, residual "
            f"{solution.certificate.free_residual:.2e}, tolerance {solution.tolerance:g}{kept}",
            markup=False,
        )
    return status


def solution_table(solution: Solution) -> Table:
    """What a solve found, with units."""
    record = solution.to_dict()
    table = Table(title=f"{solution.method}, {record['precision']}: {solution.status}", show_header=True)
    table.add_column("quantity")
    table.add_column("value", justify="right")
    table.add_column("unit")
    spacing = 1 / solution.scene.num_points
    rows = [
        ("contact area a_r (nodes counted)", f"{record['contact_area']:.8g}", f"- (one node: {spacing:.1e})"),
        ("rms gradient in contact g_c", record["rms_gradient_contact"], "-"),
        ("reduced pressure p* = p/(E* g_c)", record["reduced_pressure"], "-"),
        ("kappa = a_r/p*", record["kappa"], "-"),
        ("kappa over the half-space's", record["kappa_ratio"], "-"),
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


def run_plot(options: Plot) -> int:
    """`linecontact plot`."""
    from . import figures

    for file in figures.draw(options.file):
        print(file)
    return 0


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
    Console().print(table)
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
    study = command.study
    if isinstance(study, hertz.Options):
        return console.guard(lambda: hertz.command(study))
    return console.guard(lambda: iterations.command(study))


if __name__ == "__main__":
    sys.exit(main())
