"""ASPHER, which solves areas on the half-space: the time of a point, beside that of a line here.

Nothing else can be compared. An area has other surfaces, longer chains of patches and transforms of two axes; what is
equal is the number of points, the kind of surface (Hurst exponent 0.8, eight longest waves along the period, eight
points to the shortest one), the mean pressure, the tolerance (1e-8, of each one's own measure) and one thread. Both
numbers include everything: set-up, nested grids, the check of the answer.
"""

import functools
import importlib.util
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from typing import Any, ClassVar

import numpy as np
from linecontact.solver import RoughIndenter, Scene, Status, provenance, solve
from linecontact.solver.grid.cached import forget
from linecontact.solver.methods import Progress
from numpy.typing import NDArray

from ..files import records
from ..runner.study import Plan
from ..runner.tasks import Record
from .solvers import OURS

KIND = "areas"
ASPHER = "ASPHER"
"""Name of the peer in the records."""

PRECISIONS = ("double", "float_then_double")
"""ASPHER's names of the precisions that it is run in."""

PRESSURE = 1e-2
_HURST, _LONGEST, _SHORTEST = 0.8, 8, 8  # waves along the period, and points to the shortest one
_TOLERANCE, _COARSEST = 1e-8, 64
_SECONDS, _REPEATS = 3.0, 7  # short solves are repeated, and the fastest counts


def available() -> bool:
    """Whether ASPHER is installed."""
    return importlib.util.find_spec("aspher") is not None


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies this part of the study."""

    sizes: tuple[int, ...] = (18, 20, 22)
    """log2 of the numbers of points; even, because ASPHER's grids are squares."""
    solvers: tuple[str, ...] = field(default_factory=lambda: (OURS, *PRECISIONS))
    """This program and ASPHER's precisions."""

    def plan(self) -> Plan:
        """The tasks: for every size the solvers in turn."""
        return Plan(KIND, asdict(self), [Task(s, size) for size in self.sizes for s in self.solvers], figures=())


@dataclass(frozen=True)
class Task:
    """One solver on one number of points, timed."""

    kind: ClassVar[str] = "linecontact.studies.peers.areas.Task"

    solver: str
    """`OURS`, or the precision of ASPHER."""
    log2_num_points: int
    """log2 of the number of points of the line or of the area."""

    def run(self, report: Progress | None) -> Record:
        """The record with the microseconds a point."""
        n = 2**self.log2_num_points
        once = functools.partial(_line, n, report) if self.solver == OURS else _area(n, self.solver)
        once()  # loads kernels, tables and plans
        runs = [once()]
        while len(runs) < _REPEATS and sum(run["seconds.total"] for run in runs) < _SECONDS:
            runs.append(once())
        record = min(runs, key=lambda run: run["seconds.total"])
        about = {"solver": self.solver, "points": n, "microseconds_per_point": record["seconds.total"] / n * 1e6}
        return record | about | records.flatten({"provenance": provenance.provenance()})


def _line(num_points: int, report: Progress | None) -> Record:
    """A rough line, as rough as the areas."""
    indenter = RoughIndenter(_HURST, 0, 1 / _LONGEST, _LONGEST * _SHORTEST / num_points)
    forget()
    begin = time.perf_counter()
    solution = solve(Scene(indenter=indenter, pressure=PRESSURE, num_points=num_points), progress=report)
    seconds = time.perf_counter() - begin
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    status, about = str(solution.status), f"{OURS} {version(OURS)}"
    return {
        "status": status,
        "contact_area": solution.observables.contact_area,
        "seconds.total": seconds,
        "version": about,
    }


def _area(num_points: int, precision: str) -> Callable[[], Record]:
    import aspher

    side = math.isqrt(num_points)
    heights = _rough_area(side)
    gap = (heights.max() - heights).ravel()

    def once() -> Record:
        begin = time.perf_counter()
        result: Any = aspher.solve_nested(
            grid_size=side,
            gap=gap,
            p_nominal=PRESSURE,
            coarsest=_COARSEST,
            backend="periodic",
            tol=_TOLERANCE,
            precision=precision,
        )
        seconds = time.perf_counter() - begin
        good = str(result.status).rsplit(".", 1)[-1].lower() == "converged"
        status = str(Status.CONVERGED if good else Status.STAGNATED)
        about = f"{ASPHER} {version('aspher')}"
        area = float(result.contact_area)
        return {"status": status, "contact_area": area, "seconds.total": seconds, "version": about}

    return once


def _rough_area(side: int) -> NDArray[np.float64]:
    """Heights of a rough area with the rms slope 1, shape (side, side)."""
    x, y = np.meshgrid(np.fft.fftfreq(side, 1 / side), np.fft.rfftfreq(side, 1 / side), indexing="ij")
    waves = np.hypot(x, y)
    spectrum = (1 + (waves / _LONGEST) ** 2) ** (-(1 + _HURST) / 2) * ((waves > 0) & (waves <= side / _SHORTEST))
    modes = spectrum * np.exp(2j * np.pi * np.random.default_rng(0).random(waves.shape))
    slopes = [np.fft.irfft2(2j * np.pi * axis * modes, s=(side, side)) for axis in (x, y)]
    return np.asarray(np.fft.irfft2(modes, s=(side, side)) / math.sqrt(sum(np.mean(slope**2) for slope in slopes)))
