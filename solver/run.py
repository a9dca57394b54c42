"""One solve: grids from coarse to fine, the method on each, the certificate, and the hand-over if that fails."""

import math
import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .. import kernels
from . import checks
from .active_set import ActiveSet
from .certificate import certify
from .fire import Fire, MassWeightedFire
from .mixed import MixedActiveSet, MixedFire, MixedMassWeightedFire
from .nested import Level, discretisation_error, grids, iteration_error, measure_level, prolong
from .observables import contact_edges, observe
from .problem import Problem, rounding_floor
from .relaxation import Method, Progress, Status, relax
from .scene import Scene
from .solution import Choice, Solution
from .stiffness import stiffness
from .transforms import Transforms, save_wisdom

Array64 = NDArray[np.float64]

_METHODS: dict[str, type[ActiveSet] | type[Fire]] = {
    "active-set": ActiveSet,
    "mass-weighted-fire": MassWeightedFire,
    "fire": Fire,
}
_MIXED: dict[type[ActiveSet] | type[Fire], type[ActiveSet] | type[Fire]] = {
    ActiveSet: MixedActiveSet,
    MassWeightedFire: MixedMassWeightedFire,
    Fire: MixedFire,
}

METHODS = tuple(_METHODS)
"""Names of the methods, fastest first; the first is the default."""

_BYTES_PER_POINT = 250  # at the peak; measured: 130 (plain FIRE, float32), 210 (active set), 310 (contact everywhere)

SMALLEST_WARP = 2**13
"""Points; on smaller coarse grids recording Warp's launches takes longer than a few passes of the twins."""

COARSE_TOLERANCE, COARSE_SLACK = 1e-5, 0.1
"""Residual, and nodes per patch that may be wrong, so that the next grid starts with the right set of nodes."""


CAUTION = 0.95
"""Of the tolerance is the method's: the certificate's own rounding must not turn a solution away."""

DEFAULT_MAX_ITERATIONS = {"active-set": 2_000, "mass-weighted-fire": 20_000, "fire": 200_000}


_FLOOR_POINTS = 1024  # of the solution that tells the size of u
BELOW_FLOOR = ("refuse", "mixed")
"""What to do with a tolerance that float32 cannot reach."""


def float32_floor(scene: Scene, problem: Problem | None = None) -> float:
    """The rms free residual over p that float32 leaves, see `rounding_floor` (dimensionless).

    The size of u hardly depends on the grid and is taken from a coarse one.
    """
    size = min(_FLOOR_POINTS, scene.num_points)
    coarse = ActiveSet(Problem.from_scene(scene, size), Transforms(size, "float64"), 1e-3, "numpy")
    if relax(coarse, 300) is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return rounding_floor((problem or Problem.from_scene(scene)).stiffness, coarse.displacement, "float32")


def default_tolerance(scene: Scene, problem: Problem | None = None) -> float:
    """1e-8; in float32 the larger of 1e-4 and four times what rounding leaves (dimensionless).

    Raises `ValueError` where rounding in float32 leaves no meaning in the residual.
    """
    if scene.precision != "float32":
        return 1e-8
    tolerance = max(1e-4, 4 * float32_floor(scene, problem))
    if tolerance > 0.2:
        raise ValueError(
            f"num_points is {scene.num_points}, where float32 leaves a residual of about {tolerance / 4:.1g}; allowed: "
            "fewer points, precision mixed or float64, a tolerance of your own, or --below-floor mixed"
        )
    return tolerance


def _above_floor(scene: Scene, problem: Problem, tolerance: float | None, below_floor: str) -> tuple[float, Scene, str]:
    """A tolerance, the scene in a precision that reaches it, and the reason if that is not the scene's own.

    Raises `ValueError` if float32 cannot reach it and `below_floor` is 'refuse'.
    """
    try:
        if tolerance is None:
            return default_tolerance(scene, problem), scene, ""
        if scene.precision != "float32" or tolerance >= (floor := float32_floor(scene, problem)):
            return tolerance, scene, ""
        raise ValueError(
            f"tolerance is {tolerance!r}; allowed: at least {floor:.1g}, which is what rounding in float32 leaves of "
            "the residual, or precision mixed or float64, or --below-floor mixed"
        )
    except ValueError:
        if below_floor == "refuse":
            raise
        reason = f"float32 leaves a residual of about {float32_floor(scene, problem):.1g}"
        return tolerance or 1e-8, replace(scene, precision="mixed"), reason


class Run:
    """State of one solve; after `drive` and `certified` the last method's state, the certificate and the account."""

    def __init__(
        self,
        scene: Scene,
        method: str,
        tolerance: float | None,
        initial: Array64 | None = None,
        threads: int = 1,
        planning: str = "estimate",
        backend: str = "warp",
        max_iterations: int | None = None,
        below_floor: str = "refuse",
        progress: Progress | None = None,
        state: Method | None = None,
    ) -> None:
        check_scene(scene)
        checks.choice("backend", backend, kernels.BACKENDS)
        checks.choice("below_floor", below_floor, BELOW_FLOOR)
        self.method, self.backend = _METHODS[method], backend
        self.threads, self.planning, self.progress = threads, planning, progress
        self.problem = Problem.from_scene(scene)
        if state:  # contact is where u = h exactly
            self.problem = replace(self.problem, height=state.problem.height)
        _check_range(scene, self.problem)
        if tolerance is not None:
            tolerance = checks.real("tolerance", tolerance, "1e-14 < tolerance <= 0.5", 1e-14, 0.5)
        self.tolerance, self.scene, self.precision_changed = _above_floor(scene, self.problem, tolerance, below_floor)
        self.initial = None
        if initial is not None:
            displacement = _check_initial(initial, scene.num_points)
            # on the wall exactly, whatever the units' rounding
            on_wall = displacement >= scene.profile
            self.initial = np.where(on_wall, self.problem.height, displacement / self.problem.length_unit)
        self.state = state or self._method_on(self.problem, CAUTION * self.tolerance)
        if planning != "estimate":
            save_wisdom()
        self.limited = max_iterations is not None
        self.left = max_iterations or DEFAULT_MAX_ITERATIONS[method]
        self.iterations, self.transform_pairs = 0, 0.0
        self.levels: list[Level] = []
        self.handed_over, self.seconds_more = False, 0.0

    def _method_on(
        self, problem: Problem, tolerance: float, method: type[ActiveSet] | type[Fire] | None = None
    ) -> Method:
        # coarse grids cost little in float64, and what they pass on is better than float32's residual could tell
        finest = problem.num_points == self.scene.num_points
        precision = self.scene.working_precision if finest else "float64"
        transforms = Transforms(problem.num_points, precision, self.threads, self.planning)
        backend = self.backend if problem.num_points >= min(SMALLEST_WARP, self.scene.num_points) else "numpy"
        chosen = method or self.method
        if finest and self.scene.precision == "mixed":
            chosen = _MIXED[chosen]
        return chosen(problem, transforms, tolerance, backend)

    def relax(self, state: Method) -> Status:
        """Relax, and add what it took to the account."""
        iterations, pairs = state.iteration, state.transform_pairs
        status = relax(state, iterations + self.left, self.progress) if self.left > 0 else Status.ITERATION_LIMIT
        self._account(state, state.iteration - iterations, state.transform_pairs - pairs)
        return status

    def _account(self, state: Method, iterations: int, pairs: float) -> None:
        self.left -= iterations
        self.iterations += iterations
        self.transform_pairs += pairs * state.problem.num_points / self.scene.num_points

    def drive(self, nested: bool) -> Status:
        """All grids; the last state is on the finest one."""
        if self.initial is not None:
            self.state.start(self.initial)
            return self.relax(self.state)
        sizes = grids(self.scene.num_points) if nested else [self.scene.num_points]
        coarse = None
        for size in sizes:
            finest = size == sizes[-1]
            state = self.state
            if not finest:
                single = self.scene.precision == "float32"
                tolerance = max(COARSE_TOLERANCE, 0.0 if single else self.tolerance)
                state = self._method_on(Problem.from_scene(self.scene, size), tolerance)
                if isinstance(state, ActiveSet):
                    state.slack = COARSE_SLACK
            status = Status.CONVERGED
            if coarse:
                state.start_from_pressure(prolong(self.scene, *coarse, size))
            elif isinstance(state, MassWeightedFire):
                status = self._lead_in(state)
            if status is not Status.INTERRUPTED:
                status = self.relax(state)
            if not finest:
                pressure = state.contact_pressure
                coarse = pressure, *contact_edges(self.scene, pressure)
                if status is Status.INTERRUPTED:
                    if pressure.any():
                        self.state.start_from_pressure(prolong(self.scene, *coarse, sizes[-1]))
                    return status
                self.levels.append(measure_level(self.scene, *coarse[1:], state))
        return status

    def certified(self, status: Status) -> Status:
        """The certificate's verdict. An active set that misses it tries harder, then hands over to FIRE."""
        good, begin, tries = self._certify(), time.perf_counter(), 0
        while not good and status is Status.CONVERGED and isinstance(self.state, ActiveSet) and tries < 3:
            before, residual = self.state.contact_pressure, self.certificate.free_residual
            self.state.try_harder()
            status, tries = self.relax(self.state), tries + 1
            good = self._certify()
            if not good and self.certificate.free_residual > residual:  # sets decided on rounding
                self.state.start_from_pressure(before)
                self._certify()
                break
        gave_up = not good and status not in (Status.INTERRUPTED, Status.ITERATION_LIMIT)
        if (
            gave_up
            and not self._rounded_off()
            and isinstance(self.state, ActiveSet)
            and (self.left > 0 or not self.limited)
        ):
            status, good = self._hand_over()
        if tries or self.handed_over:
            self.seconds_more = time.perf_counter() - begin
        if status is Status.CONVERGED and not good:
            return Status.STAGNATED  # the method's own precision cannot see the difference
        if good and status in (Status.STAGNATED, Status.ITERATION_LIMIT):
            return Status.CONVERGED
        return status

    def _rounded_off(self) -> bool:
        """Whether rounding is what keeps the residual above the tolerance; FIRE knows no way below that either."""
        precision = "float32" if self.scene.precision == "float32" else "float64"
        floor = rounding_floor(self.problem.stiffness, self.state.displacement, precision)
        return self.tolerance < 2 * floor and self.certificate.free_residual < 1000 * floor

    def _hand_over(self) -> tuple[Status, bool]:
        """Mass-weighted FIRE from where the active set ended; the better of the two stays."""
        self.handed_over = True
        if not self.limited:
            self.left = DEFAULT_MAX_ITERATIONS["mass-weighted-fire"]
        start, before = self.state.displacement, self.certificate.free_residual
        self.state = self._method_on(self.problem, CAUTION * self.tolerance, MassWeightedFire)
        self.state.start(start)
        status = self.relax(self.state)
        good = self._certify()
        if not good and self.certificate.free_residual > before:
            self.state.start(start)
            self._certify()
        return status, good

    def solution(
        self, scene: Scene, method: str, status: Status, choices: tuple[Choice, ...], times: tuple[float, float]
    ) -> Solution:
        """What was found, certified. scene: the user's; status: of the method; times: begin, end of the set-up."""
        relaxed = time.perf_counter()
        status = self.certified(status)
        relaxed += self.seconds_more  # what the certificate asked for
        displacement = np.where(self.contact, scene.profile, self.state.displacement * self.problem.length_unit)
        pressure = self.pressure * scene.pressure
        observables = observe(scene, displacement, pressure, self.contact)
        observables = iteration_error(discretisation_error(observables, self.levels), self.certificate.free_residual)
        end = time.perf_counter()
        return Solution(
            scene=scene,
            method=method,
            tolerance=self.tolerance,
            status=status,
            displacement=displacement,
            contact_pressure=pressure,
            contact=self.contact,
            observables=observables,
            certificate=self.certificate,
            iterations=self.iterations,
            transform_pairs=self.transform_pairs,
            seconds=stages(*times, relaxed, end),
            threads=self.threads,
            planning=self.planning,
            backend=self.backend,
            handed_over=self.handed_over,
            levels=tuple(self.levels),
            choices=choices,
        )

    def _certify(self) -> bool:
        self.certificate, self.pressure, self.contact = certify(self.problem, self.state.displacement)
        c = self.certificate
        return c.free_residual <= self.tolerance and math.isfinite(c.energy_error_bound)

    def _lead_in(self, state: MassWeightedFire) -> Status:
        """Bring `state` near the solution of a thin, nearly incompressible layer by way of more compressible ones.

        Such a layer's softest and longest modes differ by (L/d)^3 in stiffness; from u = 0 mass-weighted FIRE bounces
        off the wall and may never settle. Measured for nu = 1/2, d = 1e-3 to 1e-5, n = 1.5 to 8: with this ladder, each
        rung solved to 1e-2, every solve converged.
        """
        k, layer = state.problem.stiffness[1:], self.scene.layer
        status = Status.CONVERGED
        if k[0] < 1e3 * k.min():
            return status
        for poisson_ratio in (0.4, 0.48, 0.498):
            if poisson_ratio < layer.poisson_ratio and status is not Status.INTERRUPTED:
                softer = stiffness(state.num_points, layer.thickness / self.scene.period, poisson_ratio)
                rung = type(state)(replace(state.problem, stiffness=softer), state.transforms, 1e-2, self.backend)
                rung.start(state.displacement)
                status = relax(rung, min(500, self.left), self.progress)
                self._account(rung, rung.iteration, rung.transform_pairs)
                if status is not Status.DIVERGED:
                    state.start(rung.displacement)
        return status


def stages(begin: float, ready: float, relaxed: float, end: float) -> dict[str, float]:
    """Seconds by stage."""
    return {"setup": ready - begin, "solve": relaxed - ready, "certificate": end - relaxed, "total": end - begin}


def _check_range(scene: Scene, problem: Problem) -> None:
    """Reject layers so thin that their stiffness overflows the precision."""
    stiffest, limit = float(problem.stiffness.max()), 1e-8 * float(np.finfo(scene.working_precision).max)
    if not stiffest < limit:
        raise ValueError(
            f"thickness is {scene.layer.thickness!r} at period {scene.period!r}; allowed: thicker, the stiffness "
            f"reaches {stiffest:.1e} E*/L and {scene.precision} ends at {limit:.1e}"
        )


def _check_initial(initial: Array64, num_points: int) -> Array64:
    allowed = f"allowed: an array of {num_points} finite real numbers"
    try:
        array = np.asarray(initial)
        real = array.astype(np.float64) if array.dtype.kind in "fiu" else None
    except (TypeError, ValueError):
        real = None
    if real is None or real.shape != (num_points,):
        raise ValueError(f"initial has shape {np.shape(initial)}; {allowed}")
    if not np.isfinite(real).all():
        raise ValueError(f"initial holds a value that is not finite; {allowed}")
    return real


def check_scene(scene: Scene, num_points: int | None = None) -> None:
    """Reject what is no scene, and grids that the free memory cannot hold: 20 to 25 arrays of N values at the peak."""
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is {scene!r}; allowed: a Scene")
    num_points = num_points or scene.num_points
    available, needed = checks.available_memory(), _BYTES_PER_POINT * num_points
    if available is not None and needed > available:
        raise ValueError(
            f"num_points is {num_points}, needing about {needed / 2**30:.1f} GiB; allowed: what fits into the "
            f"{available / 2**30:.1f} GiB that are free"
        )
