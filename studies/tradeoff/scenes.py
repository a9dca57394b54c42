"""Random scenes, solved to an accuracy: does the estimated error hold on scenes that nothing was fitted to?"""

import math
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from linecontact.solver import Layer, PowerIndenter, RoughIndenter, Scene, Solution, Status, solve
from linecontact.solver.grid.cached import forget
from linecontact.solver.methods import Progress
from linecontact.solver.reference import closed_forms, collocation
from linecontact.solver.strategy import small_models

from ..files import records
from ..runner.tasks import Record
from .measuring import refused

KINDS = ("power", "rough")

_LONGEST = 300.0  # half-widths over thicknesses: beyond, collocation takes too much memory
_NODES, _RESOLUTION = 400, 40.0
_FINER, _MOST = 16, 2**20  # times the solution's points; at most, but four times them in any case


def draw(kind: str, seed: int, log2_points: int) -> tuple[Scene, float]:
    """A scene with up to 2^log2_points points, and the accuracy to ask for."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    thickness = math.inf if rng.random() < 0.2 else float(10 ** rng.uniform(-6, 1))
    layer = Layer(thickness, 0.5 if rng.random() < 0.15 else float(rng.uniform(-0.5, 0.5)))
    if kind == "power":
        exponent = float(rng.choice([1.5, 2, 3, 4]) if rng.random() < 0.6 else rng.uniform(1.2, 6))
        load, accuracy = 10 ** rng.uniform(-5, math.log10(3e-2)), 10 ** rng.uniform(-6, math.log10(3e-2))
        return Scene(layer, PowerIndenter(exponent), float(load), num_points=2**log2_points), float(accuracy)
    indenter = RoughIndenter(float(rng.uniform(0.2, 0.95)), seed, 1 / 8, 1 / 16)
    load, accuracy = 10 ** rng.uniform(math.log10(3e-3), math.log10(0.3)), 10 ** rng.uniform(-4, math.log10(3e-2))
    return Scene(layer, indenter, float(load), num_points=2**log2_points), float(accuracy)


@dataclass(frozen=True)
class RandomScene:
    """A random scene, solved to an accuracy."""

    kind: ClassVar[str] = "linecontact.studies.tradeoff.scenes.RandomScene"

    scene_kind: str
    """One of `KINDS`."""
    seed: int
    """Of everything that is drawn."""
    log2_points: int
    """log2 of the points of the finest grid allowed."""

    def run(self, report: Progress | None) -> Record:
        """The errors asked for, estimated and true, and the time of the planner alone."""
        scene, accuracy = draw(self.scene_kind, self.seed, self.log2_points)
        begin = time.perf_counter()
        small_models.decide(scene, accuracy)
        decided = time.perf_counter() - begin
        own = {
            "kind": "scene",
            "family": self.scene_kind,
            "seed": self.seed,
            "accuracy": accuracy,
            "seconds.decide": decided,
        }
        own |= {f"scene.{name}": value for name, value in scene.to_dict().items()}
        forget()
        try:
            solution = solve(scene, accuracy=accuracy, progress=report)
        except ValueError as error:
            return own | refused(self.scene_kind, error)
        o = solution.observables
        truth, uncertain = true_area(scene, accuracy, solution.scene.num_points)
        record = {name: v for name, v in records.run_record(solution).items() if not name.startswith("choices.")}
        return (
            record
            | own
            | {
                "scene.num_points": solution.scene.num_points,
                "claimed": o.contact_area_error / o.contact_area_subgrid,
                "claimed.former": _former_estimate(solution),
                "error.area": abs(o.contact_area_subgrid / truth - 1),
                "error.reference": uncertain,
            }
        )


def _former_estimate(solution: Solution) -> float:
    """The error of a_r as version 0.1.0 would estimate it, relative: a third of the change from the last coarser grid,
    and the estimate from the edges. Without a coarser grid today's estimate.
    """
    o = solution.observables
    if not solution.levels:
        return o.contact_area_error / o.contact_area_subgrid
    change = abs(o.contact_area_subgrid - solution.levels[-1].contact_area_subgrid)
    return (change / 3 + o.contact_area_edges_error) / o.contact_area_subgrid


def true_area(scene: Scene, accuracy: float, num_points: int) -> tuple[float, float]:
    """a_r by collocation, or on a grid of 4 to 16 times as many points as the solution has; and its own error."""
    power, layer = scene.indenter.power_law, scene.layer
    if power and layer.bonded:
        shape = scene.pressure, *power
        if closed_forms.guessed_half_width(*shape, layer) < _LONGEST * layer.thickness:
            try:
                how = ((k * _NODES // 2, k * _RESOLUTION / 2) for k in (2, 1))
                fine, coarse = (collocation.solve_layer(layer, *shape, *one) for one in how)
                return fine.contact_area, abs(coarse.contact_area / fine.contact_area - 1)
            except ValueError:  # nearly full contact
                pass
    finer = scene.on_grid(max(4 * num_points, min(_FINER * num_points, _MOST)))
    solution = solve(finer, tolerance=max(1e-3 * accuracy, 1e-8))
    if solution.status is not Status.CONVERGED:
        raise RuntimeError(f"the reference is not certified: {solution.status}")
    o = solution.observables
    return o.contact_area_subgrid, o.contact_area_error / o.contact_area_subgrid
