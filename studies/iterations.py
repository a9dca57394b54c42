"""How the iterations grow with N: plain and mass-weighted FIRE on the Hertz half-space.

linecontact study iterations [--quick] [--folder FOLDER]
"""

import time
from dataclasses import asdict, dataclass
from pathlib import Path

from linecontact.solver import Scene, closed_forms, solve
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
    folder: Path = Path("results/iterations")
    """Where iterations.h5 and the figure go."""
    overwrite: bool = False
    """Replace an existing file."""


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    configuration = Configuration((12, 13, 14), (12, 13, 14)) if options.quick else Configuration()
    options.folder.mkdir(parents=True, exist_ok=True)
    path = options.folder / "iterations.h5"
    store.check_target(path, options.overwrite)
    study = store.StudyFile(KIND, asdict(configuration))
    sizes = [("mass-weighted-fire", k) for k in configuration.mass_weighted] + [
        ("fire", k) for k in configuration.plain
    ]
    work = {key: 2.0 ** key[1] * (1 if key[0] != "fire" else 2.0 ** (key[1] / 2 - 4)) for key in sizes}
    begin, done = time.monotonic(), 0.0
    with console.bar() as progress:
        task = progress.add_task("iterations", total=sum(work.values()), state="")
        for method, k in sizes:
            left = console.remaining(done / sum(work.values()), time.monotonic() - begin)

            def report(iteration: int, residual: float, k: int = k, method: str = method, left: str = left) -> None:
                progress.update(task, state=f"{method}, 2^{k}: iteration {iteration}, residual {residual:.1e}; {left}")

            solution = solve(Scene(num_points=2**k), method=method, tolerance=configuration.tolerance, progress=report)
            study.runs.append(store.flatten(solution.to_dict()))
            done += work[method, k]
            progress.update(task, completed=done)
            store.save_study(path, study)
    study.complete = True
    store.save_study(path, study)
    from . import figures

    output = Console()
    output.print(summary(study))
    output.print(f"Data: {path}\nFigures: {', '.join(str(f) for f in figures.draw(path))}", soft_wrap=True)
    return console.EXIT_NOT_CONVERGED if (study.column("status") != "converged").any() else 0


def summary(study: store.StudyFile) -> Table:
    """One row per run, with the error it reached."""
    exact = closed_forms.periodic_half_space_area(2.0, 1.0, 2e-3)
    table = Table(box=box.SIMPLE, title="Iterations to a residual of 1e-8, Hertz on the half-space, from u = 0")
    for heading in (
        "method",
        "N",
        "iterations",
        "transform pairs",
        "residual",
        "a_r error\n[grid spacings]",
        "solve [s]",
    ):
        table.add_column(heading, justify="right")
    for run in study.runs:
        n = run["scene.num_points"]
        table.add_row(
            run["method"],
            str(n),
            str(run["iterations"]),
            str(run["transform_pairs"]),
            f"{run['certificate.free_residual']:.1e}",
            f"{(run['contact_area'] - exact) * n:+.2f}",
            f"{run['seconds.solve']:.2f}",
        )
    return table
