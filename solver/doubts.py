"""Where a solution should not be taken at its word: what it says of itself without being asked.

A converged solution is exact for its grid and for linear elasticity. Whether the grid resolves the contact, and whether
linear elasticity holds there, are other questions.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from .grid.observables import Observables
from .grid.patch_table import PatchTable
from .scene import Scene

LARGEST_ERROR = 0.02
"""Estimated relative error of a_r beyond which it is warned of (dimensionless)."""

LARGEST_SLOPE = 0.3
"""Rms slope in the contact: linear elasticity takes tan(t) for t and 1 for sqrt(1 + t^2), 3 and 4 % off there."""

LARGEST_STRAIN = 0.1
"""Largest pressure over the modulus that resists it, about the strain: what is left out is of the strain's square."""

NEARLY_FULL = 0.97
"""Contact area beyond which the gaps left have no reference to be compared with (dimensionless)."""

# Measured on 600 random scenes (power, rough and measured profiles, 2^8 to 2^15 points), against eight times as many
# points: more than this share of the nodes in such patches is found in 98 % of the areas off by more than 5 %, and in
# 2.7 % of those off by less than 1 %.
_UNRESOLVED_SHARE = 0.1
_FEWEST_NODES = 3  # of a patch whose ends can be found between nodes
_WAVE_POINTS = 4  # half a shortest wave on fewer points needs as many more nodes to a patch
_SHARE_OF_LOAD = 0.05  # on patches as narrow as two values of a scan


class Concern(StrEnum):
    """What a warning is about."""

    GRID = "grid"
    """So few nodes are in contact that the area is not resolved."""
    ERROR = "error"
    """The estimated error of the area is large."""
    STRAIN = "strain"
    """Pressures are beyond small strains."""
    SLOPE = "slope"
    """Slopes in the contact are beyond small ones."""
    FULL = "full contact"
    """The contact is nearly full."""
    SCAN = "scan"
    """What a scan does not resolve carries load."""


@dataclass(frozen=True)
class Doubt:
    """A warning that comes with a solution."""

    concern: Concern
    """What it is about."""
    text: str
    """What was found, and what would help."""


def doubts(scene: Scene, found: Observables, patches: PatchTable, claimed: Sequence[float]) -> Iterator[Doubt]:
    """What to doubt of a solution. claimed: errors of a_r estimated on coarser grids."""
    area = found.contact_area_subgrid
    if not area > 0:
        yield Doubt(Concern.GRID, "nothing is in contact; more num_points, or another start")
        return
    yield from _of_grid(scene, patches)
    relative = found.contact_area_error / area
    if relative > LARGEST_ERROR:
        grown = min(claimed, default=math.inf) < found.contact_area_error
        why = "; a coarser grid claimed less, and the area has changed by more than that since" if grown else ""
        yield Doubt(Concern.ERROR, f"the area may be off by {relative:.2g} of itself (estimated){why}")
    yield from _of_elasticity(scene, found, area)
    if area > NEARLY_FULL:
        text = f"{area:.4f} of the period is in contact; areas above {NEARLY_FULL} have not been checked against others"
        yield Doubt(Concern.FULL, text)


def _of_grid(scene: Scene, patches: PatchTable) -> Iterator[Doubt]:
    """Whether the patches are resolved by the grid, and by the values of a scan."""
    n = scene.num_points
    waves = scene.indenter.shortest_wave(n)
    half_wave = n / (2 * waves) if waves else math.inf  # grid points
    needed = _FEWEST_NODES + max(0.0, _WAVE_POINTS - half_wave)
    few = float(patches.nodes[patches.nodes < needed].sum() / patches.nodes.sum())
    if few > _UNRESOLVED_SHARE:
        text = f"{few:.0%} of the contact nodes are in patches of fewer than {math.ceil(needed)} nodes"
        yield Doubt(Concern.GRID, f"{text}: the grid does not resolve the area; more num_points")
    if scene.indenter.given_points and waves:
        narrow = patches.width < scene.period / waves
        share = float(patches.load[narrow].sum() / patches.load.sum())
        if share > _SHARE_OF_LOAD:
            text = f"{share:.0%} of the load is carried by patches as narrow as two values of the scan"
            yield Doubt(Concern.SCAN, f"{text}: roughness that it does not resolve would change the area")


def _of_elasticity(scene: Scene, found: Observables, area: float) -> Iterator[Doubt]:
    """Whether strains and slopes are small, as linear elasticity takes them to be."""
    layer = scene.layer
    modulus = layer.contact_modulus
    if layer.thickness < area * scene.period / max(1, found.num_patches) / 2:  # thin: confined below the contact
        modulus = max(modulus, layer.foundation_modulus(1.0) * layer.contact_modulus * layer.thickness)
    strain = found.peak_pressure / modulus
    if strain > LARGEST_STRAIN:
        text = f"the largest pressure is {strain:.2g} of the modulus that resists it, E* or that of the confined layer"
        yield Doubt(Concern.STRAIN, f"{text}: above {LARGEST_STRAIN:g} strains are not small, but taken to be")
    slope = found.rms_gradient_subgrid
    if slope > LARGEST_SLOPE:
        text = f"the rms slope in the contact is {slope:.2g}"
        yield Doubt(Concern.SLOPE, f"{text}: above {LARGEST_SLOPE:g} slopes are not small, but taken to be")
