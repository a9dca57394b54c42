"""The nearest peers: on the same scenes who agrees on area and peak pressure, and then the times at equal gap; of one
that solves areas the time of a point.

linecontact study peers [--quick] [--folder FOLDER]

A peer is timed at its loosest tolerance that keeps the rms gap inside the contact, over that of the heights, below a
limit; linecontact runs at its default tolerance, or at a smaller one if it takes that. Rough surfaces have 64 grid
points to their shortest wave on every grid, as in the published study; at 2^18 points that is the published surface.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, TypeVar

import numpy as np
from linecontact.solver import Layer, PowerIndenter, RoughIndenter, Scene, Solution, Status, provenance
from linecontact.solver import solve as solve_ours
from linecontact.solver.arrays import Array64
from linecontact.solver.grid.cached import forget
from linecontact.solver.methods import Progress
from linecontact.solver.reference import collocation

from ..files import records
from ..runner import executors, study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Record
from ..terminal import console
from . import areas
from .report import HOW, report
from .solvers import OURS, PEERS, at_gap, available, gap_rms, solve

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "peers"
_TIGHTEST = 1e-12  # tolerance of ours
LOADS = {"Hertz": 2e-3, "rough": 1e-2}

_SECONDS, _REPEATS = 3.0, 20  # short solves are repeated, ours and theirs, and the fastest counts

Timed = TypeVar("Timed")


def fastest(first: Timed, again: Callable[[], Timed], seconds: Callable[[Timed], float]) -> Timed:
    """The fastest of a few runs, of which one has been made: short ones are repeated."""
    runs = [first]
    while len(runs) < _REPEATS and sum(map(seconds, runs)) < _SECONDS:
        runs.append(again())
    return min(runs, key=seconds)


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the study."""

    sizes: tuple[int, ...] = (12, 14, 16, 18)
    """log2 of the numbers of points."""
    hertz: tuple[float, ...] = (math.inf, 0.1, 0.01)
    """Thicknesses over the period of the Hertz scenes (dimensionless)."""
    rough: tuple[float, ...] = (math.inf, 0.01, 1e-4)
    """Thicknesses over the period of the rough scenes (dimensionless)."""
    hursts: tuple[float, ...] = (0.8, 0.3)
    """Hurst exponents of the rough scenes (dimensionless)."""
    gap: float = 5e-9
    """The `gap_rms` that peers have to reach (dimensionless)."""
    peers: tuple[str, ...] = field(default_factory=available)
    """Names of the peers that take part."""

    def plan(self) -> Plan:
        """The tasks: for every scene the solvers in turn, so that a slower hour of the machine meets them all."""
        scenes = [(None, d) for d in self.hertz] + [(hurst, d) for hurst in self.hursts for d in self.rough]
        runs = [
            Task(solver, hurst, thickness, size, self.gap)
            for size in self.sizes
            for hurst, thickness in scenes
            for solver in (OURS, *self.peers)
        ]
        return Plan(NAME, asdict(self), runs)


@dataclass(frozen=True)
class Options(study.Options):
    """The two nearest peers on the same scenes, areas and peaks before times at equal gap: data, figure, table."""

    workers: int = 1
    """More than one disturb each other's times."""
    quick: bool = False
    """Up to 2^14 points only."""


@dataclass(frozen=True)
class Task:
    """One solver on one scene, timed."""

    kind: ClassVar[str] = "linecontact.studies.peers.Task"

    solver: str
    """Name of a peer, or `OURS`."""
    hurst: float | None
    """Hurst exponent of a rough surface; None for Hertz."""
    thickness: float
    """Of the layer over the period."""
    log2_num_points: int
    """log2 of the number of grid points."""
    gap: float
    """The `gap_rms` that a peer has to reach (dimensionless)."""

    @property
    def scene(self) -> Scene:
        """The scene; a rough surface has 64 grid points to its shortest wave."""
        n = 2**self.log2_num_points
        if self.hurst is None:
            return Scene(Layer(self.thickness), PowerIndenter(), LOADS["Hertz"], num_points=n)
        indenter = RoughIndenter(self.hurst, cut_off_ratio=512 / n)
        return Scene(Layer(self.thickness), indenter, LOADS["rough"], num_points=n)

    def run(self, report: Progress | None) -> Record:
        """The record with the gap reached, nodes in contact and, for Hertz, the area's errors."""
        scene = self.scene
        if self.solver == OURS:
            record, pressure = self._by_us(scene, report)
        else:
            record, pressure = self._by_peer(scene, report)
        nodes = int(np.count_nonzero(pressure > 0))
        record |= {
            "solver": self.solver,
            "name": "Hertz" if self.hurst is None else f"H={self.hurst:g}",
            "nodes": nodes,
            "gap_rms": gap_rms(scene, pressure),
            "gap_limit": self.gap,
        }
        if self.hurst is None:
            assert scene.layer.bonded is not None
            exact = collocation.solve_layer(scene.layer, scene.pressure, 2.0, 1.0).contact_area
            areas = nodes / scene.num_points, record.get("contact_area_subgrid", math.nan)
            record |= {
                f"spacings_off.{how}": (area - exact) * scene.num_points for how, area in zip(HOW, areas, strict=True)
            }
        return record

    def _by_us(self, scene: Scene, report: Progress | None) -> tuple[Record, Array64]:
        tolerance: float | None = None  # the default

        def again() -> Solution:
            forget()
            solution = solve_ours(scene, tolerance=tolerance, progress=report)
            if solution.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            return solution

        first = again()  # loads kernels, tables and plans, as a peer's first tolerance does
        while gap_rms(scene, first.contact_pressure) > self.gap and first.tolerance > _TIGHTEST:
            tolerance = first.tolerance / 2
            first = again()
        solution = fastest(again(), again, lambda s: s.seconds["solve"])
        return records.run_record(solution), solution.contact_pressure

    def _by_peer(self, scene: Scene, report: Progress | None) -> tuple[Record, Array64]:
        first, tolerance = at_gap(self.solver, scene, self.gap, report)
        result = fastest(first, lambda: solve(self.solver, scene, tolerance, report), lambda r: r.seconds)
        pressure = result.contact_pressure
        good = gap_rms(scene, pressure) <= self.gap
        seconds = {"setup": result.setup_seconds, "solve": result.seconds}
        record = {
            "status": str(Status.CONVERGED if good else Status.STAGNATED),
            "contact_area": np.count_nonzero(pressure > 0) / scene.num_points,
            "peak_pressure": float(pressure.max()),
            "iterations": result.iterations,
            "seconds": seconds | {"total": sum(seconds.values())},
            "tolerance": tolerance,
            "threads": 1,
            "scene": scene.to_dict(),
            "version": result.version,
            "provenance": provenance.provenance(),
        }
        return records.flatten(record), pressure


def plans(options: Options) -> Sequence[Plan]:
    """The tasks at full size, or those of the quick study."""
    found = [(Configuration(sizes=(12, 14)) if options.quick else Configuration()).plan()]
    if areas.available():
        found.append((areas.Configuration(sizes=(16,)) if options.quick else areas.Configuration()).plan())
    return found


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw)


def command(options: Options) -> int:
    """Run the study as asked, or the rest of it; returns the exit status."""
    executors.check(options.workers, options.memory, options.scheduler)  # a refusal is all there is to say
    for peer in PEERS:
        if peer not in available():
            console.errors.print(f"{peer} is left out; to compare: pip install {peer}")
    if not areas.available():
        console.errors.print(f"{areas.ASPHER} is left out; to compare: pip install aspher, which needs a compiler")
    return run_study(STUDY, options)
