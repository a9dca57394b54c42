"""One solve, as it is passed along: its configuration, its iterations, and its grids from coarse to fine.

Which method works on a grid, and when a grid is fine enough, is said elsewhere. A finer grid begins from the coarse
one's contact pressure (`grid.prolong`).
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from .. import checks
from ..endings import Reason, Status
from ..grid.contact import Contact, contact_edges
from ..grid.errors import FACTOR
from ..grid.observables import measure
from ..grid.problem import Problem
from ..grid.prolong import prolong
from ..methods import DEFAULT, ExecutionConfig, Method, MethodKind, relax
from ..scene import Scene
from ..solution import Choice, Level

SMALLEST_WARP = 2**13
"""Points; on smaller coarse grids recording Warp's launches takes longer than a few passes of the reference kernels."""

COARSEST = 512
"""Points of the coarsest grid, at least."""

DEFAULT_TOLERANCE, COARSE_TOLERANCE = 1e-8, 1e-4
"""Equilibrium residual over p to stop at in float64 and mixed precision; on coarse grids or in float32, at least."""


@dataclass
class Run:
    """One solve."""

    scene: Scene
    """To be solved; its grid is the finest."""
    kind: MethodKind
    """The method that was chosen."""
    config: ExecutionConfig
    """Precision, threads, planning, kernels and device."""
    limit: int | None = None
    """Of iterations on all grids and by all methods together; None: each method has its own."""
    left: int = 0
    """Iterations before the present attempt ends."""
    taken: int = 0
    """Iterations on all grids."""
    points_transformed: float = 0.0
    """Transform pairs on all grids times the points of each grid."""
    tolerance: float = 0.0
    """Of the certificate, on the equilibrium residual over p (dimensionless)."""
    own_tolerance: bool = False
    """Whether that was asked for. Any other gives way to the residual of rounding."""
    levels: list[Level] = field(default_factory=list)
    """Of the grids, from coarse to fine."""
    choices: list[Choice] = field(default_factory=list)
    """Made for the user, with reasons."""
    handed_over: bool = False
    """Whether another method than the chosen one went on."""
    state: Method = field(init=False)
    """The method on the present grid."""
    status: Status = Status.ITERATION_LIMIT
    """How the present attempt ended; in the end, how the solve did."""
    reason: Reason | None = None
    """Why it did not converge; None if it did."""
    contact: Contact | None = None
    """On the last grid that was measured, where a finer one begins."""
    times: list[float] = field(default_factory=lambda: [time.perf_counter()] * 3)
    """When the solve began, when it was set up, and when it was iterated to the end [s]."""

    def __post_init__(self) -> None:
        self.allow(self.kind.max_iterations, last=self.kind.fallback is None)

    @property
    def spent(self) -> bool:
        """Whether the limit allows nothing more."""
        return self.limit is not None and self.taken >= self.limit

    def allow(self, iterations: int, last: bool = True) -> None:
        """Give the next attempt so many iterations; the last one gets all that is left of a limit that was given."""
        left = iterations if self.limit is None else self.limit - self.taken
        self.left = left if last else min(left, iterations)

    @property
    def contact_share(self) -> float:
        """Share of the nodes that are in contact, 0 where that is not known (dimensionless)."""
        return self.contact.patches.nodes.size / self.contact.pressure.size if self.contact else 0.0

    def begin(self, problem: Problem, tolerance: float, kind: MethodKind | None = None) -> Method:
        """A method on a grid; by default the one that was chosen.

        Coarser grids than the scene's cost little in float64, and float32's residual would not tell their errors.
        """
        size = problem.num_points
        precision = self.scene.precision if size == self.scene.num_points else "float64"
        share, backend = self.contact_share, self.backend_on(size)
        config = replace(self.config, tolerance=tolerance, precision=precision, contact_share=share, backend=backend)
        return (kind or self.kind).begin(problem, config)

    def backend_on(self, num_points: int) -> str:
        """Of the kernels on a grid: 'numpy' on small ones except the scene's own."""
        return self.config.backend if num_points >= min(SMALLEST_WARP, self.scene.num_points) else "numpy"

    def relax(self, state: Method) -> Status:
        """Relax, and count the iterations and transforms."""
        iterations, pairs = state.iteration, state.transform_pairs
        status = relax(state, iterations + self.left, self.config.progress)
        self.left -= state.iteration - iterations
        self.taken += state.iteration - iterations
        self.points_transformed += (state.transform_pairs - pairs) * state.problem.num_points
        return status

    def start_from_contact(self, finer: Method) -> None:
        """Begin on a finer grid from the contact of the last one that was measured, if there is one."""
        if self.contact and self.contact.pressure.any():
            finer.start_from_pressure(prolong(*self.contact, finer.problem))

    def over_grids(self, sizes: Sequence[int], begin: Callable[[int], Method], measure_last: bool) -> Iterator[None]:
        """From coarse to fine; each grid as it is reached.

        sizes: numbers of points. begin: the method on a grid of so many. measure_last: whether the level of the finest
        grid is wanted, too, as any may be the last. An interruption before the first grid is reached is passed on; a
        later one ends the loop, and leaves the last grid that was reached, as interrupted.
        """
        for size in sizes:
            try:
                if self.contact:
                    self.state.rest()
                state = begin(size)
                self.start_from_contact(state)
                status, contact = self.relax(state), self.contact
                if measure_last or size < sizes[-1]:
                    # of an area, errors follow from the last two grids
                    level, contact = _measured(state, by_loads=measure_last or size in sizes[-2:])
                    if status in (Status.CONVERGED, Status.STAGNATED):  # another says nothing of errors
                        self.levels.append(level)
                self.state, self.status, self.contact = state, status, contact
            except KeyboardInterrupt:  # while a grid is prepared or measured
                if not self.contact:
                    raise
                self.status = Status.INTERRUPTED
            yield
            if self.status is Status.INTERRUPTED:
                return


def grids(num_points: int) -> list[int]:
    """Grid sizes from coarse to fine, each about four times the one before; the coarser ones are even."""
    sizes = [num_points]
    while sizes[0] // FACTOR >= COARSEST:
        sizes.insert(0, coarser(sizes[0]))
    return sizes


def coarser(num_points: int) -> int:
    """The next coarser grid."""
    return 2 * round(num_points / FACTOR / 2)


def check_memory(
    num_points: int, kind: MethodKind = DEFAULT, contact_share: float = 0.0, available: int | None = None
) -> None:
    """Raise `ValueError` for a grid that the free memory cannot hold.

    kind: the method; contact_share: of the nodes, where a coarser grid tells it (dimensionless). available: memory
    that was free before the solve began [bytes]; by default the memory that is free now.
    """
    available = checks.available_memory() if available is None else available
    needed = kind.bytes_per_point(contact_share) * num_points
    if available is not None and needed > available:
        raise ValueError(
            f"num_points is {num_points}, needing about {needed / 2**30:.1f} GiB; allowed: what fits into the "
            f"{available / 2**30:.1f} GiB that are free"
        )


def _measured(state: Method, by_loads: bool) -> tuple[Level, Contact]:
    """Level and contact of a grid; by_loads: whether loads may tell the ends of patches, for the errors."""
    pressure, problem, pairs = state.contact_pressure, state.problem, round(state.transform_pairs, 3)
    displacement = problem.to_length(state.displacement.copy(), pressure > 0)
    contact = contact_edges(problem, pressure, displacement if by_loads else None)
    measured = measure(contact, displacement, problem.scene.pressure)
    level = Level(**measured, num_points=problem.num_points, iterations=state.iteration, transform_pairs=pairs)
    problem.indenter.rest()
    return level, contact
