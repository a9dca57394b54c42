"""The active set: the method that needs fewest transforms, put together from its parts.

`active_set` is the method with pressures as unknown, `free_nodes` with displacements; `search` is common to both.
`surface` holds the pressure on one set of nodes and the response to it, by the `fields` on all nodes or near the
contact. `preconditioner` with `greens_function` makes the iterations few.

May import: method, linecontact.solver.arrays, linecontact.solver.transforms, linecontact.solver.grid,
linecontact.kernels.
"""

from .active_set import KIND, ActiveSet, begin

__all__ = ["KIND", "ActiveSet", "begin"]
