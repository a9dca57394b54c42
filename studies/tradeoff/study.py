"""The price of speed in accuracy: every choice of a solve, its seconds and its errors, and the Pareto fronts.

linecontact study tradeoff [--quick] [--folder FOLDER]

Methods, precisions, tolerances, grids, threads, nested or not; beside them solving to an accuracy, collocation
and the peers that are installed. Smooth scenes are compared with collocation, rough ones with a certified
solution on a finer grid than any. Others on the machine disturb all times: trust ratios.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from linecontact.solver import METHODS
from linecontact.solver.methods import active_set, fire, mass_weighted_fire
from rich.console import RenderableType

from ..files.study_files import StudyFile
from ..peers import solvers as peers
from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Task
from . import front
from . import report as tables
from .choices import Accuracy, Choice, Collocation, Peer, Precisions
from .ensembles import ENSEMBLES, Ensemble
from .families import COARSEST_ROUGH, FAMILIES, is_rough
from .scenes import KINDS, RandomScene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "tradeoff"
TOLERANCES = (1e-3, 1e-5, 1e-8, 1e-10)

_ONE_GRID = (1e-5, 1e-8)  # tolerances without nested grids
_TIGHTEST_TO = 18  # log2 of the points up to which float64 reaches 1e-10
_TWO_THREADS_FROM = 16
_PLAIN_TO = 14  # log2 of the points to which plain FIRE is tried at length
_HALF_SPACE = "Hertz, half-space"


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the study."""

    sizes: tuple[int, ...] = (8, 10, 12, 14, 16, 18, 20)
    """log2 of the numbers of points."""
    paper: int = 18
    """log2 of the points of the published choice, and the most that FIRE is given."""
    reference: int = 22
    """log2 of the points of the solution that rough surfaces are compared with."""
    accuracies: tuple[float, ...] = tuple(-k / 2 for k in range(3, 19))
    """Powers of ten of the accuracies asked for."""
    rough_to: float = -4.0
    """The least of these powers that is asked for on rough surfaces."""
    nodes: tuple[int, ...] = (8, 12, 16, 24, 32, 48, 64, 96, 128, 160)
    """Numbers of collocation nodes."""
    scenes: int = 150
    """Random scenes of each of `scenes.KINDS`."""
    scene_points: tuple[int, ...] = (18, 16)
    """log2 of the most points of a random scene, for each of `scenes.KINDS`."""
    ensembles: tuple[float, int, float] = (1 / 512, 20, 0.002)
    """Of the means over random surfaces: lambda_s/lambda_r, log2 of the most points, standard error over the mean."""
    peers: tuple[str, ...] = field(default_factory=peers.available)
    """Names of the peers that take part."""

    def plan(self) -> Plan:
        """The tasks."""
        runs = [task for family in FAMILIES for task in self._family(family)]
        for family in (_HALF_SPACE, "rough, half-space")[: 1 + (self.paper - 2 >= COARSEST_ROUGH)]:
            runs.append(Precisions(family, fire.KIND.name, self.paper, None))
            runs.append(Precisions(family, mass_weighted_fire.KIND.name, self.paper, TOLERANCES[-1]))
        kinds = tuple(zip(KINDS, self.scene_points, strict=True))
        runs += [RandomScene(kind, seed, most) for seed in range(self.scenes) for kind, most in kinds]
        runs += [Ensemble(name, *self.ensembles) for name in ENSEMBLES]
        return Plan(NAME, asdict(self), runs, figures=(*front.FIGURES, front.ENSEMBLES_FIGURE))

    def _family(self, family: str) -> Iterator[Task]:
        rough = is_rough(family)
        reference = self.reference if rough else 0
        sizes = [size for size in self.sizes if not rough or size >= COARSEST_ROUGH]
        for size in sizes:
            for choice in dict.fromkeys(self._choices(family, size)):
                yield Choice(family, *choice, reference)
        for power in self.accuracies:
            if sizes and (not rough or power >= self.rough_to):
                yield Accuracy(family, float(f"{10**power:.3g}"), sizes[-1], reference)
        if not rough:
            yield from (Collocation(family, nodes) for nodes in self.nodes)
        for peer in self.peers:
            yield from (Peer(family, peer, size, 1e-8, reference) for size in sizes if 12 <= size <= self.paper)

    def _choices(self, family: str, size: int) -> Iterator[tuple[str, str, float | None, int, int, bool]]:
        """Methods, precisions, tolerances, sizes, threads and nested grids that are worth the time of trying."""
        for method in _methods(grow=False)[: None if size <= self.paper else 1]:
            for precision in _precisions(method):
                tolerances = [t for t in TOLERANCES if t > TOLERANCES[-1] or size <= _TIGHTEST_TO]
                for tolerance in (*tolerances, *((None,) if precision == "float32" else ())):
                    yield method, precision, tolerance, size, 1, True
                    if tolerance in _ONE_GRID[: 2 if size < _TIGHTEST_TO else 1] or tolerance is None:
                        yield method, precision, tolerance, size, 1, False
        if size >= _TWO_THREADS_FROM:
            for method in _methods(grow=False)[: None if size <= self.paper else 1]:
                yield method, "float64", 1e-5, size, 2, True
        for method in _methods(grow=True) if size <= self.paper else ():
            precisions = _precisions(method)
            for precision in precisions if size <= _PLAIN_TO else ("float64",):
                for tolerance in (None,) if precision == "float32" else (1e-3, 1e-5)[size > _PLAIN_TO :]:
                    yield from ((method, precision, tolerance, size, 1, nested) for nested in (True, False))
            if size > _PLAIN_TO and "float32" in precisions:
                yield method, "float32", None, size, 1, False
        if size == self.paper:
            yield fire.KIND.name, "float64", 1e-5, size, 1, False
            if family == _HALF_SPACE:
                yield fire.KIND.name, "float64", 1e-8, size, 1, False


def _precisions(method: str) -> list[str]:
    """Precisions of a method; the active set works in float64 where mixed is asked for."""
    return [p for p in METHODS[method].precisions if p != "mixed" or method != active_set.KIND.name]


def _methods(grow: bool) -> list[str]:
    """Names of the methods whose iterations grow with the number of points, or do not."""
    return [name for name, kind in METHODS.items() if kind.grows is grow]


QUICK = Configuration(
    sizes=(8, 12),
    paper=12,
    reference=16,
    accuracies=tuple(range(-2, -10, -1)),
    scenes=10,
    scene_points=(14, 14),
    ensembles=(1 / 16, 14, 0.03),
)


@dataclass(frozen=True)
class Options(study.Options):
    """Errors of area, kappa and pressure over seconds for every choice there is: data, figures, tables."""

    workers: int = 1
    """More than one disturb each other's times."""
    quick: bool = False
    """Up to 2^12 points, and 20 random scenes instead of 300."""


def plans(options: Options) -> Sequence[Plan]:
    """The tasks at full size, or those of the quick study."""
    return [(QUICK if options.quick else Configuration()).plan()]


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """The tables and their summary."""
    return [part for file in files.values() if file.runs for part in tables.parts(file)]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw, may_not_converge=True)


def command(options: Options) -> int:
    """Run the study as asked, or the rest of it; returns the exit status."""
    return run_study(STUDY, options)
