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
from .problem import Problem, foundation_pressure, rounding_floor
from .relaxation import Method, Progress, Status, relax
from .scene import Scene
from .solution import MEANINGLESS, MOST_ENERGY, Choice, Solution
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
    problem = problem or Problem.from_scene(scene)
    displacement = coarse.displacement * (coarse.problem.length_unit / problem.length_unit)
    return rounding_floor(problem.stiffness, displacement, "float32")


def default_tolerance(scene: Scene, problem: Problem | None = None) -> float:
    """1e-8; in float32 the larger of 1e-4 and four times what rounding leaves (dimensionless).

    Where rounding turns out to leave more, `Solution.tolerance` says how much, up to `MEANINGLESS`, as long as
    `MOST_ENERGY` bounds the energy's error.

    Raises `ValueError` where rounding in float32 leaves no meaning in the residual.
    """
    if scene.precision != "float32":
        return 1e-8
    floor = float32_floor(scene, problem)
    if 4 * floor > MEANINGLESS:
        raise ValueError(_too_many_points(scene, floor))
    return max(1e-4, 4 * floor)


def _too_many_points(scene: Scene, floor: float) -> str:
    own = "a tolerance of your own, " if floor < MEANINGLESS else ""
    return (
        f"num_points is {scene.num_points}, where float32 leaves a residual of about {floor:.1g}; allowed: "
        f"fewer points, precision mixed or float64, {own}or --below-floor mixed"
    )


def _above_floor(scene: Scene, problem: Problem, tolerance: float | None, below_floor: str) -> tuple[float, Scene, str]:
    """A tolerance, the scene in a precision that reaches it, and the reason if that is not the scene's own.

    Raises `ValueError` if float32 cannot reach it and `below_floor` is 'refuse'.
    """
    try:
        if tolerance is None:
            return default_tolerance(scene, problem), scene, ""
        if scene.precision != "float32" or tolerance >= (floor := float32_floor(scene, problem)):
            return tolerance, scene, ""
        if floor > MEANINGLESS:
            raise ValueError(_too_many_points(scene, floor))
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
        if tolerance is not None:
            tolerance = checks.real("tolerance", tolerance, "1e-14 < tolerance <= 0.5", 1e-14, 0.5)
        self.asked = tolerance is not None
        self.tolerance, self.scene, changed = _above_floor(scene, self.problem, tolerance, below_floor)
        self.choices = [Choice("precision", "mixed", changed)] if changed else []
        self.initial = None
        if initial is not None:
            displacement = _check_initial(initial, scene.num_points)
            # on the wall exactly, whatever the units' rounding; and not beyond where any solution is
            on_wall, reach = displacement >= scene.profile, self.problem.reach
            reach *= self.problem.length_unit
            inside = np.clip(displacement, -reach, reach) / self.problem.length_unit
            self.initial = np.where(on_wall, self.problem.height, inside)
        self.state = state or self._method_on(self.problem, CAUTION * self.tolerance)
        if planning != "estimate":
            save_wisdom()
        self.limited = max_iterations is not None
        self.left = max_iterations or DEFAULT_MAX_ITERATIONS[method]
        self.iterations, self.transform_pairs = 0, 0.0
        self.levels: list[Level] = []
        self.handed_over, self.seconds_more = False, 0.0

    def _method_on(
        self,
        problem: Problem,
        tolerance: float,
        method: type[ActiveSet] | type[Fire] | None = None,
        precision: str | None = None,
    ) -> Method:
        # coarse grids cost little in float64, and what they pass on is better than float32's residual could tell
        finest = problem.num_points == self.scene.num_points
        precision = precision or (self.scene.precision if finest else "float64")
        working = "float64" if precision == "float64" else "float32"
        transforms = Transforms(problem.num_points, working, self.threads, self.planning)
        backend = self.backend if problem.num_points >= min(SMALLEST_WARP, self.scene.num_points) else "numpy"
        chosen = method or self.method
        return (_MIXED[chosen] if precision == "mixed" else chosen)(problem, transforms, tolerance, backend)

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
            self.state, status = self._settle(self.state)
            return status
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
            if coarse:
                state.start_from_pressure(prolong(self.scene, *coarse, size))
            state, status = self._settle(state)
            if finest:
                self.state = state
            else:
                pressure = state.contact_pressure
                coarse = pressure, *contact_edges(self.scene, pressure)
                if status is Status.INTERRUPTED:
                    if pressure.any():
                        self.state.start_from_pressure(prolong(self.scene, *coarse, sizes[-1]))
                    return status
                self.levels.append(measure_level(self.scene, *coarse[1:], state))
        return status

    def _settle(self, state: Method) -> tuple[Method, Status]:
        """Relax; FIRE that bounced off the wall, on a thin and nearly incompressible layer, does so from elsewhere.

        Measured on 150 of these, nu = 0.4999 to 1/2, d = 1e-9 to 0.03: from u = 0 three did not settle, and these did
        from the Winkler foundation's pressure.
        """
        status = self.relax(state)
        lost = status is not Status.INTERRUPTED and not state.residual < MEANINGLESS
        if isinstance(state, Fire) and lost and (self.left > 0 or not self.limited):
            if not self.limited:
                self.left = max(self.left, DEFAULT_MAX_ITERATIONS["mass-weighted-fire"])
            state = self._method_on(state.problem, state.tolerance)
            state.start_from_pressure(foundation_pressure(state.problem))
            status = self.relax(state)
        return state, status

    def certified(self, status: Status) -> Status:
        """The certificate's verdict. An active set that misses it tries harder, then in float64, then FIRE does.

        A default tolerance that rounding does not allow becomes the residual that it does allow.
        """
        first, begin = self._certify(), time.perf_counter()
        status, good = self._insist(status, first)
        for hand_over in (self._to_float64, self._to_fire):
            gave_up = not good and status not in (Status.INTERRUPTED, Status.ITERATION_LIMIT)
            if gave_up and not self._rounded_off() and (self.left > 0 or not self.limited) and (other := hand_over()):
                status, good = self._go_on(other)
        if not first:
            self.seconds_more = time.perf_counter() - begin
        if not good and status in (Status.STAGNATED, Status.CONVERGED):
            status = Status.STAGNATED  # the method's own precision cannot see the difference
            residual = self.certificate.free_residual
            if not self.asked and self._bounded and residual < min(100 * self._floor(), MEANINGLESS):
                self.tolerance, good = residual, True
        return Status.CONVERGED if good and status in (Status.STAGNATED, Status.ITERATION_LIMIT) else status

    def _insist(self, status: Status, good: bool) -> tuple[Status, bool]:
        """An active set that misses the certificate tries harder, up to three times."""
        for _ in range(3):
            if good or status is not Status.CONVERGED or not isinstance(self.state, ActiveSet):
                break
            before, residual = self.state.contact_pressure, self.certificate.free_residual
            self.state.try_harder()
            status = self.relax(self.state)
            good = self._certify()
            if not good and self.certificate.free_residual > residual:  # sets decided on rounding
                self.state.start_from_pressure(before)
                self._certify()
                break
        return status, good

    def _rounded_off(self) -> bool:
        """Whether rounding is what keeps the residual above the tolerance; no other method knows a way below that."""
        floor = self._floor()
        return self.tolerance < 2 * floor and self.certificate.free_residual < 1000 * floor

    def _floor(self) -> float:
        precision = "float32" if self.scene.precision == "float32" else "float64"
        return rounding_floor(self.problem.stiffness, self.state.displacement, precision)

    def _to_float64(self) -> Method | None:
        """The active set in float64 after that in mixed precision; or once more, if the search went in circles."""
        if not isinstance(self.state, ActiveSet) or self.scene.precision == "float32":
            return None
        if isinstance(self.state, MixedActiveSet):
            residual = self.certificate.free_residual
            self.choices.append(Choice("precision", "float64", f"mixed ends at a residual of {residual:.1g}"))
        return self._method_on(self.problem, CAUTION * self.tolerance, precision="float64")

    def _to_fire(self) -> Method | None:
        """Mass-weighted FIRE after the active set."""
        if not isinstance(self.state, ActiveSet):
            return None
        self.handed_over = True
        if not self.limited:
            self.left = DEFAULT_MAX_ITERATIONS["mass-weighted-fire"]
        return self._method_on(self.problem, CAUTION * self.tolerance, MassWeightedFire)

    def _go_on(self, state: Method) -> tuple[Status, bool]:
        """With another method from where this one ended; the better of the two stays."""
        before, residual = self.state, self.certificate.free_residual
        state.start(before.displacement)
        self.state = state
        status = self.relax(state)
        status, good = self._insist(status, self._certify())
        if not good and not self.certificate.free_residual < residual:
            self.state = before
            self._certify()
        return status, good

    def solution(self, scene: Scene, method: str, status: Status, times: tuple[float, float]) -> Solution:
        """What was found, certified. scene: the user's; status: of the method; times: begin, end of the set-up."""
        relaxed = time.perf_counter()
        status = self.certified(status)
        relaxed += self.seconds_more  # what the certificate asked for
        profile = scene.profile
        displacement = np.minimum(self.state.displacement * self.problem.length_unit, profile)  # units round
        displacement[self.contact] = profile[self.contact]
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
            choices=tuple(self.choices),
            rounded_off=status is Status.STAGNATED and self._rounded_off(),
        )

    def _certify(self) -> bool:
        displacement = self.state.displacement
        if not np.isfinite(displacement).all():  # diverged beyond all numbers
            self.state.start(np.zeros_like(displacement))
            displacement = self.state.displacement
        self.certificate, self.pressure, self.contact = certify(self.problem, displacement)
        return self.certificate.free_residual <= self.tolerance and self._bounded

    @property
    def _bounded(self) -> bool:
        bound = self.certificate.energy_error_bound
        return math.isfinite(bound) if self.asked else bound <= MOST_ENERGY


def stages(begin: float, ready: float, relaxed: float, end: float) -> dict[str, float]:
    """Seconds by stage."""
    return {"setup": ready - begin, "solve": relaxed - ready, "certificate": end - relaxed, "total": end - begin}


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
