"""The report of the comparison with the peers: who agrees on area and peak pressure, and then the times."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from ..runner.tasks import Record
from ..terminal import console
from . import areas
from .solvers import OURS

NODES, NODES_SHARE, PEAK = 2, 1e-3, 1e-5
"""Agreement: this many nodes in contact more or fewer, or this share of them; the peak's relative error."""
HOW = ("counted", "subgrid")
"""How contact areas are measured."""


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The table, and sentences on all that it has no room for."""
    parts: list[RenderableType] = []
    for kind, file in files.items():
        if file.runs:
            parts += [points(file)] if kind == areas.KIND else [summary(file), *remarks(file)]
    return parts


def points(study: StudyFile) -> Table:
    """The time of a point on a line and on an area, one row for each number of points."""
    peer = next((run["version"] for run in study.runs if run["solver"] != OURS), areas.ASPHER)
    table = console.table(
        title=f"The time of a point: lines by {OURS}, areas by {peer}",
        caption="Microseconds a point on one thread, everything included (set-up, nested grids, the check of the "
        f"answer). Rough half-space, H = 0.8, 8 points to the shortest wave, p = {areas.PRESSURE:g} E*, tolerance "
        "1e-8 of each one's own measure. Lines and areas are different problems, and only this cost is compared. "
        f"ratio: {areas.ASPHER}'s faster one over ours; contact: shares of the points, of the line and of the area "
        "(dimensionless).",
    )
    for heading in ("points", f"{OURS}\n(us)", "double\n(us)", "float, then\ndouble (us)", "ratio", "contact"):
        table.add_column(heading, justify="right", no_wrap=True)
    for n, good in times_of_a_point(study).items():
        runs = {run["solver"]: run for run in study.runs if run["points"] == n}
        theirs = [good[name] for name in areas.PRECISIONS if name in good]
        ratio = f"{min(theirs) / good[OURS]:.2g}" if theirs and OURS in good else "-"
        shares = [runs[name]["contact_area"] for name in (OURS, "double") if name in runs]
        cells = [f"{good[name]:.2f}" if name in good else "-" for name in (OURS, *areas.PRECISIONS)]
        table.add_row(f"2^{round(math.log2(n))}", *cells, ratio, ", ".join(f"{share:.3f}" for share in shares))
    return table


def times_of_a_point(study: StudyFile) -> dict[int, dict[str, float]]:
    """Microseconds a point of those that converged, by the number of points and the solver."""
    found: dict[int, dict[str, float]] = {n: {} for n in sorted({run["points"] for run in study.runs})}
    for run in study.runs:
        if run["status"] == "converged":
            found[run["points"]][run["solver"]] = run["microseconds_per_point"]
    return found


@dataclass(frozen=True)
class Comparison:
    """The solvers' records on one scene."""

    ours: Record
    """The record of linecontact."""
    peers: dict[str, Record]
    """The records of the peers by their names."""

    @property
    def solvers(self) -> tuple[str, ...]:
        """Names of those that have solved it."""
        return OURS, *self.peers

    def off(self, peer: str) -> tuple[int, float]:
        """By how many nodes in contact, and by which share of the peak pressure, a peer differs."""
        run = self.peers[peer]
        return run["nodes"] - self.ours["nodes"], run["peak_pressure"] / self.ours["peak_pressure"] - 1

    def agrees(self, peer: str) -> bool:
        """Whether both gaps are within the limit, and a peer's area and peak pressure are ours."""
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
        return self._over("seconds.solve")

    @property
    def ratio_in_all(self) -> float:
        """The same with set-up on both sides and the certificate on ours; nan without a peer that agrees."""
        return self._over("seconds.total")

    def _over(self, time: str) -> float:
        return float(self.peers[self.fastest][time] / self.ours[time]) if self.fastest else math.nan


def comparisons(study: StudyFile) -> list[Comparison]:
    """A comparison for each scene that linecontact has solved, in the study's order."""
    scenes: dict[tuple[Any, ...], dict[str, Record]] = {}
    for run in study.runs:
        key = run["name"], run["scene.thickness"], run["scene.num_points"]
        scenes.setdefault(key, {})[run["solver"]] = run
    return [Comparison(found.pop(OURS), found) for found in scenes.values() if OURS in found]


def summary(study: StudyFile) -> Table:
    """One row per scene on the largest grid: agreement, then times."""
    largest = max(run["scene.num_points"] for run in study.runs)
    names = study.configuration["peers"]
    table = console.table(
        padding=(0, 1, 0, 0),
        title=f"linecontact beside {' and '.join(names) or 'no peer: none was installed'}, {largest} points",
        caption=f"nodes, peak: largest difference of a peer's nodes in contact and (relative) peak pressure from ours; "
        f"beyond the larger of {NODES} nodes and {NODES_SHARE:g} of ours, or beyond {PEAK:g}, they differ, and no "
        "ratio is given. Seconds of solving on one thread; ratio: the faster peer's over ours; all: the same with "
        "everything included, set-up on both sides and the certificate on ours. CM: ContactMechanics. d/L = inf: "
        "half-space. All but the times dimensionless.",
    )
    short = {"ContactMechanics": "CM"}
    seconds = (f"{short.get(name, name)}\n(s)" for name in ("ours", *names))
    for heading in ("scene", "d/L", "pat-\nches", "nodes", "peak", *seconds, "ratio", "all"):
        table.add_column(heading, justify="right", no_wrap=True)
    for c in comparisons(study):
        if c.ours["scene.num_points"] == largest:
            table.add_row(*_cells(c, names))
    return table


def _cells(c: Comparison, names: Sequence[str]) -> list[str]:
    """The cells of a row of the table."""
    off = [c.off(peer) for peer in c.peers]
    return [
        c.ours["name"],
        f"{c.ours['scene.thickness']:g}",
        f"{c.ours['num_patches']:.0f}",
        f"{max((nodes for nodes, _ in off), key=abs):+d}" if off else "-",
        f"{max((peak for _, peak in off), key=abs):+.0e}" if off else "-",
        f"{c.ours['seconds.solve']:.2g}",
        *(f"{c.peers[name]['seconds.solve']:.2g}" if name in c.peers else "-" for name in names),
        *(_ratio(c, ratio) for ratio in (c.ratio, c.ratio_in_all)),
    ]


def _ratio(c: Comparison, ratio: float) -> str:
    return (f"{ratio:.3g}" if c.peers else "-") if all(map(c.agrees, c.peers)) else "differ"


def remarks(study: StudyFile) -> list[str]:
    """Sentences on the gaps and on Hertz's errors on the largest grid, and on every disagreement."""
    n = max(run["scene.num_points"] for run in study.runs)
    found, limit = comparisons(study), study.configuration["gap"]
    ours, *theirs = (
        max((run["gap_rms"] for run in study.runs if run["solver"] == solver), default=0.0)
        for solver in (OURS, *study.configuration["peers"])
    )
    lines = [
        f"Rms gap inside the contact over the rms height: at most {ours:.0e} (ours) and {max(theirs, default=0.0):.0e} "
        f"(peers, each at its loosest tolerance that keeps it within {limit:g}; dimensionless)."
    ]
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
