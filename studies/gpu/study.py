"""The GPU beside the CPU: times of iterations, bandwidths of kernels, whole solves, and the same answers.

linecontact study gpu [--quick] [--folder FOLDER]

It needs a GPU, and its times are those of the machine that it runs on.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from linecontact.solver.methods import DEFAULT, METHODS
from linecontact.solver.transforms.device import check_device

from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan, Study
from ..runner.tasks import Task
from .report import report
from .tasks import METHOD, Agreement, Iteration, Kernels, Solve

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "gpu"


@dataclass(frozen=True)
class Configuration:
    """The configuration that identifies the study."""

    iterations: tuple[int, ...] = (14, 16, 18, 20, 22, 24)
    """log2 of the numbers of points of iterations on both."""
    large: tuple[int, ...] = (26, 28, 29)
    """The same on the GPU alone, in float64."""
    kernels: int = 26
    """log2 of the length of the kernels' arrays."""
    large_solves: tuple[int, ...] = (28,)
    """log2 of the numbers of points of whole solves by FIRE on the GPU alone."""
    solves: tuple[int, ...] = (14, 16, 18, 20, 22, 24, 26)
    """log2 of the numbers of points of whole solves, by the default method on the CPU and by FIRE on the GPU."""
    on_cpu: tuple[int, ...] = (14, 16, 18, 20)
    """The same by FIRE on the CPU."""
    scenes: int = 100
    """Random scenes on which both are to agree."""

    def plan(self) -> Plan:
        """The tasks."""
        able = [name for name, kind in METHODS.items() if "cuda" in kind.devices]
        runs: list[Task] = [Kernels(precision, self.kernels) for precision in ("float64", "float32")]
        runs += [Iteration(m, p, k) for m in able for p in ("float64", "float32") for k in self.iterations]
        sizes = {(DEFAULT.name, "cpu"): self.solves, (METHOD, "cuda"): self.solves, (METHOD, "cpu"): self.on_cpu}
        runs += [Solve(method, where, k) for (method, where), ks in sizes.items() for k in ks]
        runs += [Agreement(seed) for seed in range(self.scenes)]
        runs += [Solve(METHOD, "cuda", k) for k in self.large_solves]
        runs += [Iteration(m, "float64", k, on_cpu=False) for k in self.large for m in able]
        return Plan(NAME, asdict(self), runs)


QUICK = Configuration((14, 16), (), 20, (), (14, 16), (14,), 5)


@dataclass(frozen=True)
class Options(study.Options):
    """FIRE on a GPU beside the CPU: times, bandwidths, and whether both find the same; needs a GPU."""

    workers: int = 1
    """More than one disturb each other's times."""
    quick: bool = False
    """Few points only."""


def plans(options: Options) -> Sequence[Plan]:
    """The tasks at full size, or those of the quick study."""
    return [(QUICK if options.quick else Configuration()).plan()]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of a stored file, by the endings of their names."""
    from . import figures

    return figures.draw(path)


STUDY = Study(name=NAME, options=Options, plans=plans, report=report, draw=draw)


def command(options: Options) -> int:
    """Run the study as asked, or the rest of it; returns the exit status. Raises `ValueError` without a GPU."""
    check_device("cuda")
    return run_study(STUDY, options)
