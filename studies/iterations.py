"""How the iterations grow with N: plain and mass-weighted FIRE on the Hertz half-space.

linecontact study iterations [--quick] [--folder FOLDER]
"""

from dataclasses import dataclass
from pathlib import Path

from linecontact.solver import Scene, Status, closed_forms, solve
from rich import box
from rich.console import Console
from rich.table import Table

from . import console, store

KIND = "iterations"


@dataclass(frozen=True)
class Configuration:
    """log2 of the numbers of points, by method."""

    mass_weighted: tuple[int, ...] = (12, 13, 14, 15, 16, 17, 18, 19, 20)
    plain: tuple[int, ...] = (12, 13, 14, 15, 16, 17, 18)
    tolerance: float = 1e-8


@dataclass(frozen=True)
class Options:
    """Iterations to a residual of 1e-8 over N for both methods, Hertz on the half-space: data, figure, table."""

    quick: bool = False
    """Up to 2^14 points only."""
    folder: Path | None = None
    """Where iterations.h5 and the figure go; default results/iterations, or results/iterations-quick."""
    overwrite: bool = False
    """Start anew even if there is a file."""


def command(options: Options) -> int:
    """Run the study as asked, or what is left of it; returns the exit status."""
    configuration = Configuration((12, 13, 14), (12, 13, 14)) if options.quick else Configuration()
    folder = options.folder or Path("results/iterations-quick" if options.quick else "results/iterations")
    store.make_folder(folder)
    path = folder / "iterations.h5"
    store.check_target(path, overwrite=True)
    wanted = {"mass-weighted-fire": list(configuration.mass_weighted), "fire": list(configuration.plain)}
    study = store.StudyFile(KIND, {"log2_num_points": wanted, "tolerance": configuration.tolerance})
    if path.exists() and not options.overwrite:
        stored = store.load_study(path)
        if (stored.kind, stored.configuration) != (KIND, study.configuration):
            raise store.StoreError(f"file {path} holds another study; allowed: --overwrite, or a new --folder")
        study = stored
    cost = {("mass-weighted-fire", k): 2.0**k for k in configuration.mass_weighted}
    cost |= {("fire", k): 2.0 ** (1.5 * k - 4) for k in configuration.plain}
    done = {(run["method"], int(run["scene.num_points"]).bit_length() - 1) for run in study.runs}
    left = {key: value for key, value in cost.items() if key not in done}
    share = 0.0
    with console.Bar("iterations") as progress:
        for (method, k), value in left.items():

            def report(iteration: int, residual: float, at: float = share, name: str = f"{method}, 2^{k}") -> None:
                progress.show(at, f"{name}: iteration {iteration}, residual {residual:.1e}")

            solution = solve(Scene(num_points=2**k), method=method, tolerance=configuration.tolerance, progress=report)
            if solution.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            study.runs.append(store.flatten(solution.to_dict()))
            share += value / sum(left.values())
            study.complete = len(study.runs) == len(cost)
            store.save_study(path, study)
    from . import figures

    output = Console()
    output.print(summary(study))
    output.print(f"Data: {path}\nFigures: {', '.join(str(f) for f in figures.draw(path))}", soft_wrap=True)
    return console.EXIT_NOT_CONVERGED if (study.column("status") != "converged").any() else 0


def summary(study: store.StudyFile) -> Table:
    """One row per run, with the error it reached."""
    exact = closed_forms.periodic_half_space_area(2.0, 1.0, 2e-3)
    table = Table(
        box=box.SIMPLE, pad_edge=False, title="Iterations to a residual of 1e-8, Hertz on the half-space, from u = 0"
    )
    for heading in ("method", "N", "iterations", "pairs", "residual", "a_r err\n(dx)", "solve\n(s)"):
        table.add_column(heading, justify="right", no_wrap=True)
    for run in study.runs:
        n = run["scene.num_points"]
        table.add_row(
            run["method"],
            str(n),
            str(run["iterations"]),
            str(run["transform_pairs"]),
            f"{run['certificate.free_residual']:.1e}",
            f"{(run['contact_area'] - exact) * n:+.2f}",
            f"{run['seconds.solve']:.2g}",
        )
    return table
