"""The tasks: an iteration timed, kernels timed, a whole solve, and a random scene solved on both."""

import os
from dataclasses import dataclass
from typing import ClassVar

from linecontact.solver import Status, solve
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods import Progress
from linecontact.solver.provenance import provenance
from linecontact.solver.transforms.device import device_name

from ..files import records
from ..runner.tasks import ROWS, Record
from . import measuring
from .scenes import random_scene, timed_scene

METHOD = "mass-weighted-fire"
"""The method of the scenes on which CPU and GPU are to agree."""


def _machine() -> Record:
    return {"device": device_name("cuda")} | records.flatten({"provenance": provenance()})


@dataclass(frozen=True)
class Iteration:
    """An iteration of a method, on the CPU with one thread and with all, and on the GPU."""

    kind: ClassVar[str] = "gpu.Iteration"

    method: str
    """A method that works on both."""
    precision: str
    """'float64' or 'float32'."""
    log2_num_points: int
    """log2 of the number of grid points."""
    on_cpu: bool = True
    """Whether it is timed there, too."""

    def run(self, report: Progress | None) -> Record:
        """The record of the times."""
        problem = Problem.from_scene(timed_scene(self.log2_num_points, self.precision))
        times = {"gpu": ("cuda", 1)} | (
            {"cpu": ("cpu", 1), "cores": ("cpu", os.cpu_count() or 1)} if self.on_cpu else {}
        )
        found: Record = {"what": "iteration", "method": self.method, "precision": self.precision}
        for name, (device, threads) in times.items():
            seconds = measuring.seconds_per_iteration(problem, self.method, self.precision, device, threads)
            found[f"seconds.{name}"] = seconds
        return found | {"num_points": problem.num_points} | _machine()


@dataclass(frozen=True)
class Kernels:
    """The bandwidth of the kernels on the GPU."""

    kind: ClassVar[str] = "gpu.Kernels"

    precision: str
    """'float64' or 'float32'."""
    log2_num_points: int
    """log2 of the length of the arrays."""

    def run(self, report: Progress | None) -> Record:
        """A row for each kernel."""
        found = measuring.shares_of_the_copy_bandwidth(self.precision, 2**self.log2_num_points)
        copy = found.pop("copy")
        common = {"what": "kernel", "precision": self.precision, "num_points": 2**self.log2_num_points}
        common |= {"bytes_per_second": copy} | _machine()
        return {ROWS: [{"kernel": name, "share": share} | common for name, share in found.items()]}


@dataclass(frozen=True)
class Solve:
    """A whole solve with its certificate."""

    kind: ClassVar[str] = "gpu.Solve"

    method: str
    """That solves."""
    where: str
    """'cpu' or 'cuda'."""
    log2_num_points: int
    """log2 of the number of grid points."""

    def run(self, report: Progress | None) -> Record:
        """The solution's record, after a smaller one by which everything is compiled."""
        scene = timed_scene(self.log2_num_points)
        solve(timed_scene(min(14, self.log2_num_points)), method=self.method, device=self.where)
        solution = solve(scene, method=self.method, device=self.where, progress=report)
        found = {"what": "solve", "num_points": scene.num_points, "where": self.where}
        return records.run_record(solution) | found | _machine()


@dataclass(frozen=True)
class Agreement:
    """A random scene, solved on the CPU and on the GPU in float64."""

    kind: ClassVar[str] = "gpu.Agreement"

    seed: int
    """Of the scene."""

    def run(self, report: Progress | None) -> Record:
        """The nodes in contact on one alone, and both certificates."""
        scene = random_scene(self.seed)
        here, there = (solve(scene, method=METHOD, device=device) for device in ("cpu", "cuda"))
        assert here.certificate
        assert there.certificate
        return {
            "what": "agreement",
            "num_points": scene.num_points,
            "status.cpu": str(here.status),
            "status.gpu": str(there.status),
            "certified": int(here.status is there.status is Status.CONVERGED),
            "nodes": int(here.contact.sum()),
            "nodes_that_differ": int((here.contact != there.contact).sum()),
            "equilibrium_residual.cpu": here.certificate.equilibrium_residual,
            "equilibrium_residual.gpu": there.certificate.equilibrium_residual,
            "iterations.cpu": here.iterations,
            "iterations.gpu": there.iterations,
        } | _machine()
