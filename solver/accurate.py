"""A solve to a given accuracy of the contact area: the plan carried out, the smallest model first."""

import time
from dataclasses import replace

from ..kernels import BACKENDS
from . import checks, models
from .active_set import ActiveSet
from .certificate import certify
from .indenters import PowerIndenter
from .mixed import MixedActiveSet
from .models import Modelled
from .nested import grids, iteration_share
from .planner import FIELD_POINTS, Plan, climb, decide, on_grid, resolves
from .problem import Problem
from .relaxation import Progress, Status
from .run import CAUTION, COARSE_TOLERANCE, DEFAULT_MAX_ITERATIONS, METHODS, SMALLEST_WARP, Run, check_scene, stages
from .scene import Layer, Scene
from .solution import Choice, Solution
from .symmetric import EvenActiveSet, is_even
from .transforms import Transforms, check_settings

_MIXED_FROM = 2**18  # points from which mixed precision saves time on many patches


class Accurate:
    """One solve to `accuracy`, the relative error of a_r (dimensionless). Raises `ValueError`."""

    def __init__(
        self, scene: Scene, accuracy: float, threads: int, planning: str, backend: str, progress: Progress | None
    ) -> None:
        self.begin = time.perf_counter()
        self.accuracy = checks.real("accuracy", accuracy, "1e-9 <= accuracy <= 0.1", 0.99e-9, 0.1)
        check_scene(scene)
        checks.choice("backend", backend, BACKENDS)
        check_settings(threads, planning)
        self.scene = replace(scene, precision="float64")
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
        scene = on_grid(self.scene, min(FIELD_POINTS, self.scene.num_points))
        try:
            found = models.asperity(scene, layer, self.accuracy / 2)
        except ValueError as error:
            self.choices.append(Choice("collocation", "no", str(error)))
            return None
        reason = "a power profile is one asperity; error: the change by the last doubling of the nodes"
        self._chose("model", "collocation", reason, found.error)
        self._chose("grid", f"{scene.num_points} points", "for the fields only, which are sampled")
        return found

    def _winkler(self) -> Modelled | None:
        for size in filter(lambda size: resolves(self.scene, size), grids(self.scene.num_points)):
            found = models.winkler(on_grid(self.scene, size))
            if found.error <= self.accuracy:
                self._chose("model", "Winkler foundation", "the layer's edges are narrow", found.error)
                self._chose("grid", f"{size} points", "the coarsest that is good enough")
                return found
            if found.least > self.accuracy:
                break
        self._chose("Winkler foundation", "no", f"its a_r would be off by {found.error:.1g}")
        return None

    def _chose(self, what: str, chosen: str, reason: str, error: float = 0.0) -> None:
        self.choices.append(Choice(what, chosen, reason, error))

    def _modelled(self, model: str, found: Modelled) -> Solution:
        """A model's solution; a foundation's is certified with its own stiffness."""
        others = sum(choice.error for choice in self.choices if choice.what != "model")
        scene, certificate, ready = found.scene, None, time.perf_counter()
        if model == "winkler":
            problem = models.foundation(scene)
            certificate = certify(problem, found.displacement / problem.length_unit)[0]
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
        layered = replace(self.scene, layer=plan.layer)
        tolerance = min(max(0.2 * self.accuracy, 1e-10), COARSE_TOLERANCE)
        modelled = sum(choice.error for choice in self.choices)
        ready = time.perf_counter()
        climbed = climb(
            layered,
            self.accuracy - modelled - iteration_share(tolerance),
            lambda size: self._method(layered, size, tolerance),
            self.progress,
            DEFAULT_MAX_ITERATIONS[METHODS[0]],
            above,
        )
        size = climbed.state.problem.num_points
        precision = "mixed" if isinstance(climbed.state, MixedActiveSet) else "float64"
        solved = replace(on_grid(layered, size), precision=precision)
        settings = None, self.threads, self.planning, self.backend, None, "refuse", self.progress
        run = Run(solved, METHODS[0], tolerance, *settings, climbed.state)
        run.levels, run.transform_pairs, run.iterations = climbed.levels[:-1], climbed.pairs, climbed.iterations
        status = climbed.status if climbed.status is Status.INTERRUPTED else run.relax(climbed.state)
        why = "the coarsest that is good enough"
        if climbed.error > self.accuracy:
            why = "the finest allowed, and not fine enough"
        even = isinstance(climbed.state, EvenActiveSet)
        self._chose("model", "grid", "no smaller model will do")
        self._chose("grid", f"{size} points", why, climbed.error)
        self._chose("method", METHODS[0], "the fastest on every scene measured")
        self._chose("precision", precision, "mixed pays from 2^18 points on, with many patches")
        self._chose("symmetry", "even" if even else "none", f"h_i {'=' if even else '!='} h_(N-1-i) on this grid")
        self._chose("tolerance", f"{tolerance:g}", "small beside the accuracy", iteration_share(tolerance))
        solution = run.solution(on_grid(self.scene, size), METHODS[0], status, (), (self.begin, ready))
        return self._judged(solution, modelled)

    def _method(self, scene: Scene, size: int, tolerance: float) -> ActiveSet:
        check_scene(scene, size)
        problem = Problem.from_scene(scene, size)
        even = size >= SMALLEST_WARP and is_even(problem.height)
        mixed = size >= _MIXED_FROM and not even and not isinstance(scene.indenter, PowerIndenter)
        backend = self.backend if size >= SMALLEST_WARP else "numpy"
        kind = EvenActiveSet if even else MixedActiveSet if mixed else ActiveSet
        length, precision = size // 2 if even else size, "float32" if mixed else "float64"
        transforms = Transforms(length, precision, self.threads, self.planning)
        return kind(problem, transforms, CAUTION * tolerance, backend)

    def _judged(self, solution: Solution, modelled: float) -> Solution:
        """With the model's share in the errors, and whether they are what was asked for."""
        o = solution.observables
        area, kappa = o.contact_area_error + modelled * o.contact_area_subgrid, o.kappa_error
        o = replace(o, contact_area_error=area, kappa_error=kappa + 2 * modelled * o.kappa_subgrid)
        status = solution.status
        if status is Status.CONVERGED and not area <= self.accuracy * o.contact_area_subgrid:
            status = Status.INACCURATE
        return replace(solution, observables=o, status=status, accuracy=self.accuracy, choices=tuple(self.choices))
