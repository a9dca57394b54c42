"""Methods: their interface and the loop that drives each (`method`); a file for each method.

Whoever adds a method writes one file here and adds one line to `METHODS`.

May import: arrays, checks, endings, transforms, grid, linecontact.kernels.
"""

from . import active_set, fire, mass_weighted_fire
from .method import ExecutionConfig, Method, MethodKind, Progress, relax

METHODS: dict[str, MethodKind] = {kind.name: kind for kind in (active_set.KIND, mass_weighted_fire.KIND, fire.KIND)}
"""The one list of methods, by name, fastest first."""

DEFAULT = next(iter(METHODS.values()))
"""The method where none is chosen: the fastest on every scene measured."""

__all__ = ["DEFAULT", "METHODS", "ExecutionConfig", "Method", "MethodKind", "Progress", "relax"]
