"""A solve to a given accuracy of the contact area: the plan carried out, the smallest model first."""

import math
import time
from dataclasses import replace

import numpy as np

from ..kernels import BACKENDS
from . import checks, models
from .active_set import ActiveSet
from .certificate import certify
from .indenters import PowerIndenter
from .models import Modelled
from .nested import iteration_share
from .planner import Plan, climb, decide, on_grid, residual
from .problem import Problem
from .relaxation import Progress, Status
from .run import CAUTION, DEFAULT_MAX_ITERATIONS, METHODS, SMALLEST_WARP, Run, check_scene, stages
from .scene import Layer, Scene
from .solution import MOST_ACCURACY, Choice, Solution
from .symmetric import EvenActiveSet, is_even
from .transforms import Transforms, check_settings


class Accurate:
    """One solve to `accuracy`, the relative error of a_r (dimensionless). Raises `ValueError`."""

    def __init__(
        self, scene: Scene, accuracy: float, threads: int, planning: str, backend: str, progress: Progress | None
    ) -> None:
        self.begin = time.perf_counter()
        self.accuracy = checks.real(
            "accuracy", accuracy, "1e-9 <= accuracy <= 0.1", math.nextafter(1e-9, 0), MOST_ACCURACY
        )
        grid_free = isinstance(getattr(scene, "indenter", None), PowerIndenter)  # most likely
        check_scene(scene, 16 if grid_free else None)
        checks.choice("backend", backend, BACKENDS)
        check_settings(threads, planning)
        if scene.precision != "float64":
            raise ValueError(f"precision is {scene.precision!r}; allowed: float64, accuracy chooses the precision")
        self.scene = scene
        self.threads, self.planning, self.backend, self.progress = threads, planning, backend, progress
        self.choices: list[Choice] = []

    def solve(self) -> Solution:
        """The first model that is good enough; the grid always is, or says that it is not."""
        plan = decide(self.scene, self.accuracy)
        self.choices += plan.choices
        for model in plan.models:
            found = self._asperity(plan.layer) if model == "asperity" else self._winkler()
            if found:
                return self._modelled(model, found)
        return self._grid(plan)

    def _asperity(self, layer: Layer) -> Modelled | None:
        try:
            found = models.asperity(self.scene, layer, self.accuracy / 2)
        except ValueError as error:
            self._chose("collocation", "no", str(error))
            return None
        reason = "a power profile is one asperity; error: the change of a_r by the last doubling of the nodes"
        self._chose("model", "collocation", reason, found.error)
        self._chose("grid", f"{found.scene.num_points} points", "for the fields only, which are sampled")
        power = self.scene.indenter
        if isinstance(power, PowerIndenter) and power.exponent < 2:
            self._chose("peak pressure", "by collocation", "rough: at a tip sharper than a parabola 5 to 30 % too low")
        return found

    def _winkler(self) -> Modelled | None:
        found = models.winkler(self.scene)
        if found.error > self.accuracy:
            self._chose("Winkler foundation", "no", f"its a_r would be off by a share of {found.error:.1g}")
            return None
        self._chose("model", "Winkler foundation", "the layer's edges are narrow", found.error)
        self._chose("grid", f"{found.scene.num_points} points", "no transform is needed")
        return found

    def _chose(self, what: str, chosen: str, reason: str, error: float = 0.0) -> None:
        self.choices.append(Choice(what, chosen, reason, error))

    def _modelled(self, model: str, found: Modelled) -> Solution:
        """A model's solution; a foundation's on the grid is certified with its own stiffness."""
        others = sum(choice.error for choice in self.choices if choice.what != "model")
        scene, certificate, ready = found.scene, None, time.perf_counter()
        if found.problem:
            # on the wall exactly, whatever the units' rounding
            on_wall = np.where(found.contact, found.problem.height, found.displacement / found.problem.length_unit)
            certificate = certify(found.problem, on_wall)[0]
        end = time.perf_counter()
        solution = Solution(
            scene=scene,
            method="collocation" if model == "asperity" else "winkler-foundation",
            tolerance=self.accuracy / 2,
            status=Status.CONVERGED,
            displacement=found.displacement,
            contact_pressure=found.contact_pressure,
            contact=found.contact,
            observables=found.observables,
            certificate=certificate,
            iterations=0,
            transform_pairs=0.0,
            seconds=stages(self.begin, self.begin, ready, end),
            threads=self.threads,
            planning=self.planning,
            backend=self.backend,
        )
        return self._judged(solution, others)

    def _grid(self, plan: Plan) -> Solution:
        """The active set, from coarse to fine; on with a finer grid should the last one have promised too much."""
        above, before = 0, tuple(self.choices)
        while True:
            solution = self._climbed(plan, above)
            above = solution.scene.num_points
            if solution.status is not Status.INACCURATE or above == self.scene.num_points:
                return solution
            self.choices = list(before)

    def _climbed(self, plan: Plan, above: int) -> Solution:
        """Interrupted before the last grid it has nothing to return and raises `KeyboardInterrupt`."""
        layered = replace(self.scene, layer=plan.layer)
        tolerance = residual(self.accuracy)
        modelled = sum(choice.error for choice in self.choices)
        ready = time.perf_counter()
        budget = self.accuracy - modelled - iteration_share(tolerance)
        climbed = climb(
            layered,
            budget,
            lambda size: self._method(layered, size, tolerance),
            self.progress,
            DEFAULT_MAX_ITERATIONS[METHODS[0]],
            above,
        )
        size = climbed.state.problem.num_points
        scene = on_grid(self.scene, size)  # its layer, which the certificate is for
        run = Run(
            scene,
            METHODS[0],
            tolerance,
            threads=self.threads,
            planning=self.planning,
            backend=self.backend,
            progress=self.progress,
            state=climbed.state,
        )
        run.asked = False  # the accuracy was
        run.levels, run.transform_pairs, run.iterations = climbed.levels[:-1], climbed.pairs, climbed.iterations
        status = run.relax(climbed.state)
        good = climbed.error <= budget
        why = "the coarsest that is good enough" if good else "the finest allowed, and not fine enough"
        even = isinstance(climbed.state, EvenActiveSet)
        self._chose("model", "grid", "no smaller model will do")
        self._chose("grid", f"{size} points", why, climbed.error)
        self._chose("method", METHODS[0], "the fastest on every scene measured")
        self._chose("precision", "float64", "mixed saves next to nothing where transforms are few")
        self._chose("symmetry", "even" if even else "none", f"h_i {'=' if even else '!='} h_(N-1-i) on this grid")
        self._chose("tolerance", f"{tolerance:g}", "small beside the accuracy", iteration_share(tolerance))
        solution = run.solution(scene, METHODS[0], status, (self.begin, ready))
        return self._judged(solution, modelled, climbed.error)

    def _method(self, scene: Scene, size: int, tolerance: float) -> ActiveSet:
        check_scene(scene, size)
        problem = Problem.from_scene(scene, size)
        even = size >= SMALLEST_WARP and is_even(problem.height, problem.reach)
        backend = self.backend if size >= SMALLEST_WARP else "numpy"
        kind = EvenActiveSet if even else ActiveSet
        transforms = Transforms(size // 2 if even else size, "float64", self.threads, self.planning)
        return kind(problem, transforms, CAUTION * tolerance, backend)

    def _judged(self, solution: Solution, modelled: float, gridded: float = 0.0) -> Solution:
        """With the model's share and the climb's estimate in the errors, and whether they are what was asked for."""
        o = solution.observables
        area = max(o.contact_area_error, gridded * o.contact_area_subgrid) + modelled * o.contact_area_subgrid
        area = min(area, 1.0)  # without a coarser grid nothing is known
        kappa = max(o.kappa_error, 2 * gridded * o.kappa_subgrid) + 2 * modelled * o.kappa_subgrid
        o = replace(o, contact_area_error=area, kappa_error=kappa)
        status = solution.status
        if status is Status.CONVERGED and not area <= self.accuracy * o.contact_area_subgrid:
            status = Status.INACCURATE
        return replace(solution, observables=o, status=status, accuracy=self.accuracy, choices=tuple(self.choices))
