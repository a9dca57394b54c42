"""The two nearest peers on the same scenes: who agrees on area and peak pressure, and then the times at equal gap.

linecontact study peers [--quick] [--folder FOLDER]

A peer is timed at its loosest tolerance that keeps the rms gap inside the contact, over that of the heights, below a
limit; linecontact runs at its default tolerance, where the gap is smaller. Rough surfaces have 64 grid points to their
shortest wave on every grid, as in the published study; at 2^18 points that is the published surface.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from linecontact.solver import Layer, PowerIndenter, RoughIndenter, Scene, Solution, Status, collocation, provenance
from linecontact.solver import solve as solve_ours
from linecontact.solver.relaxation import Progress
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.table import Table

from ..files import records
from ..files.study_files import StudyFile
from ..runner import ensemble, executors
from ..runner.tasks import Record
from ..terminal import console
from .solvers import PEERS, PeerResult, at_gap, available, gap_rms, solve

__all__ = ["PeerResult", "at_gap", "available", "gap_rms", "solve"]  # what another study may want, and the study's own

KIND = "peers"
OURS = "linecontact"
LOADS = {"Hertz": 2e-3, "rough": 1e-2}
NODES, NODES_SHARE, PEAK = 2, 1e-3, 1e-5
"""What agreement is: this many nodes in contact more or fewer, or this share of them; the peak's relative error."""
HOW = ("counted", "subgrid")
"""How contact areas are measured."""

_SECONDS, _REPEATS = 3.0, 20  # short solves are repeated, ours and theirs, and the fastest counts

Array64 = NDArray[np.float64]
Timed = TypeVar("Timed")


def fastest(first: Timed, again: Callable[[], Timed], seconds: Callable[[Timed], float]) -> Timed:
    """The fastest of a few runs, of which one has been made: short ones are repeated."""
    runs = [first]
    while len(runs) < _REPEATS and sum(map(seconds, runs)) < _SECONDS:
        runs.append(again())
    return min(runs, key=seconds)


@dataclass(frozen=True)
class Configuration:
    """sizes: log2 of the numbers of points; hertz, rough: thicknesses over the period; gap: `gap_rms` that the peers
    have to reach; peers: those that take part.
    """

    sizes: tuple[int, ...] = (12, 14, 16, 18)
    hertz: tuple[float, ...] = (math.inf, 0.1, 0.01)
    rough: tuple[float, ...] = (math.inf, 0.01, 1e-4)
    hursts: tuple[float, ...] = (0.8, 0.3)
    gap: float = 5e-9
    peers: tuple[str, ...] = field(default_factory=available)

    def study(self) -> ensemble.Study:
        """The tasks: for every scene the solvers in turn, so that a slower hour of the machine meets them all."""
        scenes = [(None, d) for d in self.hertz] + [(hurst, d) for hurst in self.hursts for d in self.rough]
        runs = [
            Task(solver, hurst, thickness, size, self.gap)
            for size in self.sizes
            for hurst, thickness in scenes
            for solver in (OURS, *self.peers)
        ]
        return ensemble.Study(KIND, asdict(self), runs)


@dataclass(frozen=True)
class Options(ensemble.Options):
    """The two nearest peers on the same scenes, areas and peaks before times at equal gap: data, figure, table."""

    workers: int = 1
    """More than one disturb each other's times."""
    quick: bool = False
    """Up to 2^14 points only."""


@dataclass(frozen=True)
class Task:
    """One solver on one scene, timed. hurst: None for Hertz; thickness over the period; gap: for the peers."""

    solver: str
    hurst: float | None
    thickness: float
    log2_num_points: int
    gap: float

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
            layer = scene.layer
            exact = collocation.solve_load(scene.pressure, 2.0, 1.0, layer.thickness, layer.poisson_ratio).contact_area
            areas = nodes / scene.num_points, record.get("contact_area_subgrid", math.nan)
            record |= {
                f"spacings_off.{how}": (area - exact) * scene.num_points for how, area in zip(HOW, areas, strict=True)
            }
        return record

    def _by_us(self, scene: Scene, report: Progress | None) -> tuple[Record, Array64]:
        def again() -> Solution:
            solution = solve_ours(scene, progress=report)
            if solution.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            return solution

        again()  # loads kernels, tables and plans, as a peer's first tolerance does
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


def command(options: Options) -> int:
    """Run the study as asked, or what is left of it; returns the exit status."""
    configuration = Configuration(sizes=(12, 14)) if options.quick else Configuration()
    executors.check(options.workers, options.memory, options.scheduler)  # a refusal is all there is to say
    for peer in PEERS:
        if peer not in configuration.peers:
            console.errors.print(f"{peer} is left out; to compare: pip install 'linecontact[peers]'")
    folder = Path("results/peers-quick" if options.quick else "results/peers")
    return ensemble.command([configuration.study()], options, folder, closing)


def closing(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The table, and what it has no room for."""
    parts: list[RenderableType] = []
    for file in files.values():
        if file.runs:
            parts += [summary(file), *remarks(file)]
    return parts


@dataclass(frozen=True)
class Comparison:
    """The solvers' records on one scene; peers: by name."""

    ours: Record
    peers: dict[str, Record]

    @property
    def solvers(self) -> tuple[str, ...]:
        """Names of those that have solved it."""
        return OURS, *self.peers

    def off(self, peer: str) -> tuple[int, float]:
        """By how many nodes in contact, and by which share of the peak pressure, a peer differs."""
        run = self.peers[peer]
        return run["nodes"] - self.ours["nodes"], run["peak_pressure"] / self.ours["peak_pressure"] - 1

    def agrees(self, peer: str) -> bool:
        """Gaps within the limit, and the same area and peak."""
        nodes, peak = self.off(peer)
        equal = all(run["gap_rms"] <= run["gap_limit"] for run in (self.ours, self.peers[peer]))
        return equal and abs(nodes) <= max(NODES, NODES_SHARE * self.ours["nodes"]) and abs(peak) <= PEAK

    @property
    def fastest(self) -> str | None:
        """The fastest peer of those that agree."""
        return min(filter(self.agrees, self.peers), key=lambda peer: self.peers[peer]["seconds.solve"], default=None)

    @property
    def ratio(self) -> float:
        """The fastest agreeing peer's time of solving over ours; nan without one."""
        return self.peers[self.fastest]["seconds.solve"] / self.ours["seconds.solve"] if self.fastest else math.nan


def comparisons(study: StudyFile) -> list[Comparison]:
    """One for each scene that linecontact has solved, in the study's order."""
    scenes: dict[tuple[Any, ...], dict[str, Record]] = {}
    for run in study.runs:
        key = run["name"], run["scene.thickness"], run["scene.num_points"]
        scenes.setdefault(key, {})[run["solver"]] = run
    return [Comparison(found.pop(OURS), found) for found in scenes.values() if OURS in found]


def summary(study: StudyFile) -> Table:
    """One row per scene on the largest grid: agreement, then times."""
    largest = max(run["scene.num_points"] for run in study.runs)
    names, limit = study.configuration["peers"], study.configuration["gap"]
    table = console.table(
        padding=(0, 1, 0, 0),
        title=f"linecontact beside {' and '.join(names) or 'no peer: none was installed'}, {largest} points",
        caption=f"nodes, peak: largest difference of a peer's nodes in contact and (relative) peak pressure from ours; "
        f"beyond the larger of {NODES} nodes and {NODES_SHARE:g} of ours, or beyond {PEAK:g}, they differ, and no "
        "ratio is given. gap: rms gap inside the contact over the rms height; peers: the larger of theirs, at each "
        f"one's loosest tolerance that keeps it within {limit:g}. Seconds of solving on one thread, without set-up; "
        "ratio: the faster peer's over ours. CM: ContactMechanics. d/L = inf: half-space. All but the times "
        "dimensionless.",
    )
    short = {"ContactMechanics": "CM"}
    seconds = (f"{short.get(name, name)}\n(s)" for name in ("ours", *names))
    for heading in ("scene", "d/L", "pat-\nches", "nodes", "peak", "gap\nours", "gap\npeers", *seconds, "ratio"):
        table.add_column(heading, justify="right", no_wrap=True)
    for c in comparisons(study):
        if c.ours["scene.num_points"] == largest:
            table.add_row(*_cells(c, names))
    return table


def _cells(c: Comparison, names: Sequence[str]) -> list[str]:
    """A row of the table."""
    off = [c.off(peer) for peer in c.peers]
    return [
        c.ours["name"],
        f"{c.ours['scene.thickness']:g}",
        f"{c.ours['num_patches']:.0f}",
        f"{max((nodes for nodes, _ in off), key=abs):+d}" if off else "-",
        f"{max((peak for _, peak in off), key=abs):+.0e}" if off else "-",
        f"{c.ours['gap_rms']:.0e}",
        f"{max(run['gap_rms'] for run in c.peers.values()):.0e}" if off else "-",
        f"{c.ours['seconds.solve']:.2g}",
        *(f"{c.peers[name]['seconds.solve']:.2g}" if name in c.peers else "-" for name in names),
        (f"{c.ratio:.3g}" if off else "-") if all(map(c.agrees, c.peers)) else "differ",
    ]


def remarks(study: StudyFile) -> list[str]:
    """On the largest grid the ratios with set-up and Hertz's errors; and every disagreement on any grid."""
    n = max(run["scene.num_points"] for run in study.runs)
    found = comparisons(study)
    shares = [
        c.peers[c.fastest]["seconds.total"] / c.ours["seconds.total"] / c.ratio
        for c in found
        if c.fastest and c.ours["scene.num_points"] == n
    ]
    lines = []
    if shares:
        lines.append(
            f"With set-up on both sides and the certificate on ours, ratios are {min(shares):.2f} to {max(shares):.2f} "
            "times these."
        )
    for solver, text in {run["solver"]: run["version"] for run in study.runs}.items():
        runs = [
            run for run in study.runs if (run["solver"], run["scene.num_points"], run["name"]) == (solver, n, "Hertz")
        ]
        counted, subgrid = (max((abs(r[f"spacings_off.{how}"]) for r in runs), default=math.nan) for how in HOW)
        more = f", {subgrid:.0e} between sub-grid edges" if solver == OURS else ""
        lines.append(f"{solver} {text}: Hertz's a_r is off by up to {counted:.2f} grid spacings counted{more}.")
    for c in found:
        for peer in c.peers:
            if not c.agrees(peer):
                nodes, peak = c.off(peer)
                lines.append(
                    f"{peer} disagrees on {c.ours['name']}, d/L = {c.ours['scene.thickness']:g}, "
                    f"{c.ours['scene.num_points']} points: {nodes:+d} nodes of {c.ours['nodes']}, peak {peak:+.0e}, "
                    f"gap {c.peers[peer]['gap_rms']:.0e} (ours {c.ours['gap_rms']:.0e})."
                )
    return lines
