"""The contact patches of a solution as a table: where each one is, and what it carries.

A smaller model (an answer to an accuracy without a grid) knows the ends of its patches itself; what the nodes carry is
sampled.
"""

from dataclasses import dataclass

import numpy as np

from .. import display
from ..arrays import Array64
from ..value import Value
from .edges import Edges
from .patches import Patches


@dataclass(frozen=True)
class PatchTable(Value):
    """The M patches of a contact; ends lie between nodes where pressures or loads tell them. Its length is M."""

    left: Array64
    """Left ends, shape (M,), from 0 to the period [length]."""
    right: Array64
    """Right ends, shape (M,) [length]; beyond the period for a patch that goes on at its beginning."""
    width: Array64
    """Widths, shape (M,) [length]; on a grid their sum over the period is `contact_area_subgrid`."""
    nodes: Array64
    """Contact nodes, shape (M,), dimensionless."""
    load: Array64
    """Line loads, shape (M,) [pressure times length]; their sum over the period is the mean pressure."""
    peak_pressure: Array64
    """Largest pressures, shape (M,) [pressure]."""

    def __len__(self) -> int:
        return self.nodes.size

    def __repr__(self) -> str:
        count = len(self)
        widest = f", the widest {display.number(float(self.width.max()))} [length]" if count else ""
        return f"{type(self).__name__}: {count} contact patch{'es' * (count != 1)}{widest}"


def patch_table(patches: Patches, edges: Edges, pressure: Array64, period: float) -> PatchTable:
    """The table of patches with these edges, see `contact.contact_edges`, for the period L [length].

    pressure: contact pressure, shape (N,) [pressure], 0 off the contact.
    """
    if not patches.count:
        return PatchTable(*np.zeros((6, 0)))
    spacing, inside = period / pressure.size, pressure[patches.nodes]
    left = edges.left % pressure.size
    return PatchTable(
        left=left * spacing,
        right=(left + edges.width) * spacing,
        width=edges.width * spacing,
        nodes=patches.size.astype(np.float64),
        load=patches.sums(inside) * spacing,
        peak_pressure=np.maximum.reduceat(inside, patches.offset),
    )
