"""The active set: the method that needs fewest transforms, put together from its parts.

`active_set` is the method with pressures as unknown, `free_nodes` with displacements; `search` is common to both.
`contact_set` holds one set of nodes with its iteration. `surface` is the displacement under the pressure, on all nodes
in `everywhere`, near the contact in `nearby`. `preconditioner` with `local_inverses` and `greens_function` makes the
iterations few.

May import: method, linecontact.solver.arrays, linecontact.solver.transforms, linecontact.solver.grid,
linecontact.kernels.
"""

import weakref

from ...grid.cached import MOST_POINTS
from ...grid.problem import Problem
from ..method import ExecutionConfig, MethodKind
from .active_set import ActiveSet
from .everywhere import Everywhere
from .free_nodes import FreeNodes, suits
from .greens_function import GreensFunction

__all__ = ["KIND", "ActiveSet", "begin"]


def begin(problem: Problem, config: ExecutionConfig) -> ActiveSet | FreeNodes:
    """The active set on a grid, in the form that suits the contact's share of it."""
    of_layer = problem.rigidity
    free = suits(problem, config)
    symbol = problem.stiffness if free else of_layer.compliance
    # plans and recorded kernels are a quarter of a small solve's time: they serve the next one with layer and grid, and
    # do not keep the layer's response alive
    key = free, config.precision, config.threads, config.planning, config.backend
    left: list[tuple[Everywhere, GreensFunction]] = of_layer.made.setdefault(key, [])
    try:
        field, green = left.pop()
    except IndexError:  # all are in use
        field, green = Everywhere(symbol, problem.num_points, config), GreensFunction(weakref.proxy(of_layer))
    field.begin(problem.height)
    green.begin()
    found: ActiveSet | FreeNodes = (FreeNodes if free else ActiveSet)(problem, config, green, field)
    if problem.num_points <= MOST_POINTS:
        weakref.finalize(found, left.append, (field, green)).atexit = False
    return found


def _bytes_per_point(contact_share: float) -> float:
    # measured on 2^23 and 2^24 points: 92 to 101 (2 % in contact), 116 (10 %), 152 (21 %), 163 (74 %), 188 (99.8 %)
    # and up to 12 % more on 2^23 points with what is kept of coarser grids
    return 120 + min(360 * contact_share, 60 + 100 * contact_share)


KIND = MethodKind(
    name="active-set",
    label="active set",
    begin=begin,
    max_iterations=2_000,
    precisions=("float64", "float32", "mixed"),
    nested=True,
    fallback="mass-weighted-fire",
    bytes_per_point=_bytes_per_point,
    share=0.6,
)
