"""What a solve may use and what it has taken: methods are begun and relaxed here, on every grid."""

from dataclasses import dataclass, field

from ..endings import Status
from ..grid.problem import Problem, foundation_pressure
from ..methods import Method, MethodKind, Progress, Setting, relax
from ..scene import Scene
from ..solution import MEANINGLESS

SMALLEST_WARP = 2**13
"""Points; on smaller coarse grids recording Warp's launches takes longer than a few passes of the twins."""

COARSE_TOLERANCE, COARSE_WRONG_NODES, COARSE_REDUCTION = 1e-6, 0.1, 0.01
"""On coarse grids: the residual to stop at, the nodes per patch that may still be wrong, and the part of the residual
at the start beyond which nothing is gained, because the next grid starts no better (dimensionless)."""

CAUTION = 0.95
"""Share of the tolerance that is the method's: the certificate's own rounding must not turn a solution away."""

_SECOND_START = 20_000  # iterations for a start from elsewhere


@dataclass(frozen=True)
class Means:
    """Threads, FFTW planning and kernels of a solve."""

    threads: int = 1
    """Threads of the transforms."""
    planning: str = "estimate"
    """FFTW's planning effort."""
    backend: str = "warp"
    """What runs the kernels: 'warp', or 'numpy' for the twins."""
    device: str = "cpu"
    """Where the method works: 'cpu' or 'cuda'."""
    progress: Progress | None = None
    """Called about ten times a second with (iteration, residual)."""


@dataclass
class Effort:
    """One solve's means, its limit of iterations, and what it has taken so far."""

    scene: Scene
    """What is solved; its grid is the finest."""
    kind: MethodKind
    """The method that was chosen."""
    means: Means
    """What to compute with."""
    max_iterations: int | None = None
    """Largest number of iterations on all grids and by all methods together; None: each method has its own limit."""
    iterations: int = 0
    """On all grids."""
    points_transformed: float = 0.0
    """Transform pairs on all grids times the points of each grid."""
    left: int = field(init=False)
    """Iterations before the present attempt ends."""

    def __post_init__(self) -> None:
        self.allow(self.kind.max_iterations)
        if any(fallback.method != self.kind.name for fallback in self.kind.fallbacks):
            self.left = min(self.left, self.kind.max_iterations)  # what is more is for the other method

    @property
    def may_go_on(self) -> bool:
        """Whether the limit allows another method to try."""
        return self.max_iterations is None or self.iterations < self.max_iterations

    def allow(self, iterations: int) -> None:
        """Give the next attempt so many iterations, or all that are left of a limit that was asked for."""
        self.left = iterations if self.max_iterations is None else self.max_iterations - self.iterations

    def begin(
        self,
        problem: Problem,
        tolerance: float,
        kind: MethodKind | None = None,
        precision: str | None = None,
        wrong_nodes_per_patch: float = 0.0,
        reduction: float = 0.0,
        contact_share: float = 0.0,
    ) -> Method:
        """A method on a grid; by default the one that was chosen, and the scene's precision on its own grid.

        Coarser grids cost little in float64, and what they pass on is better than float32's residual could tell.
        """
        size, means = problem.num_points, self.means
        precision = precision or (self.scene.precision if size == self.scene.num_points else "float64")
        backend, few = self.backend_on(size), wrong_nodes_per_patch
        how = means.threads, means.planning, backend, means.device
        return (kind or self.kind).begin(problem, Setting(tolerance, precision, few, reduction, contact_share, *how))

    def backend_on(self, num_points: int) -> str:
        """What runs the kernels on a grid: the twins on small ones, but for the scene's own."""
        return self.means.backend if num_points >= min(SMALLEST_WARP, self.scene.num_points) else "numpy"

    def add_start(self, state: Method) -> None:
        """Add the transforms by which a state was started."""
        self.points_transformed += state.transform_pairs * state.problem.num_points

    def relax(self, state: Method) -> Status:
        """Relax, and add what it took."""
        iterations, pairs = state.iteration, state.transform_pairs
        status = Status.ITERATION_LIMIT
        if self.left > 0:
            status = relax(state, iterations + self.left, self.means.progress)
        self.left -= state.iteration - iterations
        self.iterations += state.iteration - iterations
        self.points_transformed += (state.transform_pairs - pairs) * state.problem.num_points
        return status

    def settle(self, state: Method) -> tuple[Method, Status]:
        """Relax; a method that lost contact, on a thin and nearly incompressible layer, and did not settle starts anew.

        Measured with FIRE on 150 of these, nu = 0.4999 to 1/2, d = 1e-9 to 0.03: from u = 0 three did not settle, and
        these did from the pressure of a Winkler foundation as stiff as the layer's longest wave.
        """
        status = self.relax(state)
        lost = status is not Status.INTERRUPTED and not state.residual < MEANINGLESS
        if self.kind.starts_again and lost and self.may_go_on:
            self.allow(max(self.left, _SECOND_START))
            try:
                again = self.begin(state.problem, state.tolerance)
                start_on_foundation(again)
            except KeyboardInterrupt:
                return state, Status.INTERRUPTED
            except ValueError:  # a GPU has no memory for a second state
                return state, status
            return again, self.relax(again)
        return state, status


def start_on_foundation(state: Method) -> None:
    """Begin with the pressure of a Winkler foundation as stiff as the layer's longest wave."""
    state.start_from_pressure(foundation_pressure(state.problem, float(state.problem.stiffness[1])))
