"""The universal edge curve, measured: where a contact ends, from the ratio of its last two nodal pressures.

linecontact study edge-curve [--folder FOLDER]

Loads are chosen so that the edge, known from the collocation oracle, takes every place between two nodes. The curve in
`linecontact.solver.edges` is a closed form; this is the check, on high-resolution solutions, and its error.
"""

import math
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from linecontact.solver import Layer, PowerIndenter, Scene, Status, collocation, edges, solve
from rich import box
from rich.console import Console
from rich.table import Table

from . import console, store

KIND = "edge-curve"


@dataclass(frozen=True)
class Configuration:
    """scenes: (exponent, thickness over the period, Poisson's ratio); places: of the edge between nodes, per scene."""

    num_points: int = 2**15
    scenes: tuple[tuple[float, float, float], ...] = (
        (2.0, math.inf, 0.25),
        (1.5, math.inf, 0.25),
        (4.0, math.inf, 0.25),
        (2.0, 0.05, 0.0),
        (2.0, 0.02, 0.45),
    )
    places: int = 12
    tolerance: float = 1e-9


@dataclass(frozen=True)
class Options:
    """Measure the universal edge curve on high-resolution solutions: data, figure, table."""

    folder: Path | None = None
    """Where edge-curve.h5 and the figure go; default results/edge-curve."""
    overwrite: bool = False
    """Start anew even if there is a file."""


def run_task(configuration: Configuration, scene: tuple[float, float, float], place: int) -> dict[str, object]:
    """One load: the flat record with the ratio, the edge's true offset and what the closed form makes of the ratio."""
    exponent, thickness, poisson_ratio = scene
    n = configuration.num_points
    guess = collocation.solve_load(2e-3, exponent, 1.0, thickness, poisson_ratio)
    # a grid spacing more of half-width, in steps; near enough, what matters is that the places differ
    stretch = 1 + place / configuration.places / (guess.half_width * n)
    load = 2e-3 * stretch ** (exponent if math.isinf(thickness) else exponent + 1)
    exact = collocation.solve_load(load, exponent, 1.0, thickness, poisson_ratio)
    solution = solve(
        Scene(Layer(thickness, poisson_ratio), PowerIndenter(exponent), load, num_points=n),
        tolerance=configuration.tolerance,
    )
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    nodes = np.flatnonzero(solution.contact)[:3]
    last = solution.contact_pressure[nodes]
    three, two = edges.edge_offset(last[None, :])
    return store.run_record(solution) | {
        "place": place,
        "ratio": float(last[0] / last[1]),
        "offset": float(n / 2 - exact.half_width * n - nodes[0]),
        "offset.two_nodes": float(two[0]),
        "offset.three_nodes": float(three[0]),
    }


def command(options: Options) -> int:
    """Run what is left of the study; returns the exit status."""
    configuration = Configuration()
    folder = options.folder or Path("results/edge-curve")
    store.make_folder(folder)
    path = folder / "edge-curve.h5"
    store.check_target(path, overwrite=True)
    wanted = asdict(configuration) | {"scenes": [[*map(str, scene)] for scene in configuration.scenes]}
    study = store.open_study(KIND, wanted, path, options.overwrite)
    tasks = [(scene, place) for scene in configuration.scenes for place in range(configuration.places)]
    with console.Bar("edge curve") as progress:
        for done, (scene, place) in enumerate(tasks[len(study.runs) :], len(study.runs)):
            progress.show(done / len(tasks), f"n = {scene[0]:g}, d = {scene[1]:g}, place {place}")
            study.runs.append(run_task(configuration, scene, place))
            study.complete = done + 1 == len(tasks)
            store.save_study(path, study)
    from . import figures

    output = Console()
    output.print(summary(study))
    output.print(f"Data: {path}\nFigures: {', '.join(str(f) for f in figures.draw(path))}", soft_wrap=True)
    return console.EXIT_NOT_CONVERGED if (study.column("status") != "converged").any() else 0


def summary(study: store.StudyFile) -> Table:
    """Largest deviations from the closed form, per scene."""
    table = Table(
        box=box.SIMPLE,
        pad_edge=False,
        title=f"Edge offsets against the oracle, {study.configuration['num_points']} points",
        caption="Largest |error| of the edge's place by the closed form, from the last two and the last three nodal "
        "pressures, in grid spacings. All dimensionless.",
        caption_justify="left",
    )
    for heading in ("n", "d/L", "nu", "places", "two nodes", "three nodes"):
        table.add_column(heading, justify="right", no_wrap=True)
    names = ("scene.exponent", "scene.thickness", "scene.poisson_ratio")
    for scene in dict.fromkeys(tuple(run[name] for name in names) for run in study.runs):
        runs = [run for run in study.runs if tuple(run[name] for name in names) == scene]
        worst = [max(abs(run[f"offset.{k}_nodes"] - run["offset"]) for run in runs) for k in ("two", "three")]
        table.add_row(*(f"{float(value):g}" for value in scene), str(len(runs)), *(f"{w:.1e}" for w in worst))
    return table
