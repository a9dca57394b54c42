"""The active set: the method that needs fewest transforms, put together from its parts.

`active_set` is the method with pressures as unknown, `free_nodes` with displacements; `limits` has what both share.
`contact_set` and `free_set` are what belongs to one set of nodes, `elimination` solves small ones. `response` is what
the surface does under its pressure, on all nodes in `everywhere`, near the contact in `nearby` by the operator of
`packed`. `preconditioner` with `local_inverses` and `greens_function` makes the iterations few.

May import: method, linecontact.solver.arrays, linecontact.solver.transforms, linecontact.solver.grid,
linecontact.kernels.
"""

from ...grid.problem import Problem
from ..method import ExecutionConfig, MethodKind
from .active_set import ActiveSet
from .everywhere import Everywhere
from .free_nodes import FreeNodes, suits
from .greens_function import GreensFunction, Tables
from .response import Response

__all__ = ["KIND", "ActiveSet", "begin"]


def begin(problem: Problem, setting: ExecutionConfig) -> ActiveSet | FreeNodes:
    """The active set on a grid, in the form that suits the contact's share of it."""
    made = problem.rigidity.made
    of_layer = problem.rigidity.response
    tables: Tables = made.setdefault("active set", Tables(of_layer))
    green = GreensFunction(tables)
    if suits(problem, setting):
        return FreeNodes(problem, setting, green, Everywhere(problem.stiffness, problem.height, setting))
    response = Response(problem, of_layer.split, Everywhere(of_layer.compliance, problem.height, setting))
    return ActiveSet(problem, setting.tolerance, green, response, setting.fixed_set)


def _bytes_per_point(contact_share: float) -> float:
    # measured on 2^23 and 2^24 points: 88 to 90 (2 % in contact), 116 (10 %), 152 (21 %), 163 (74 %), 188 (99.8 %)
    # and up to 12 % more on 2^23 points with what is kept of coarser grids
    return 110 + min(360 * contact_share, 60 + 100 * contact_share)


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
