"""Warnings, where a solution should not be taken at its word.

A converged solution is exact for its grid and for linear elasticity. Whether the grid resolves the contact, and whether
linear elasticity holds there, are other questions.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from . import display
from .arrays import Array64
from .grid.observables import Observables
from .grid.patch_table import PatchTable
from .scene import Scene

LARGEST_ERROR = 0.1
"""Estimated error of the edges and of gaps between the nodes, over the area, beyond which it is warned of: of 82
random areas off by more than 5 % all were warned of, and of 250 within 1 % 4 % (against eight times as many points)."""

LARGEST_SLOPE = 0.3
"""Rms slope in the contact: linear elasticity takes tan(t) for t and 1 for sqrt(1 + t^2), 3 and 4 % off there."""

LARGEST_STRAIN = 0.1
"""Largest strain, estimated (dimensionless): linear elasticity leaves out terms of its square."""

NEARLY_FULL = 0.97
"""Contact area beyond which there is hardly anything but finer grids to compare with (dimensionless)."""

_FEWEST_NODES = 3  # of a patch that is resolved, on the average
_MOST_LEFT_OUT = 0.02  # of the mean square slope, in waves that the grid leaves out, and of the load, where a scan does

_FAR_APART = 1e-5, 1e3  # thickness over the period of a scan


class WarningKind(StrEnum):
    """Kinds of warnings."""

    GRID = "grid"
    """So few nodes are in contact that the area is not resolved."""
    WAVES = "waves"
    """The grid does not hold all waves of the profile."""
    ERROR = "error"
    """The edges of the contact lie between so few nodes that the area is not well known."""
    ESTIMATE = "estimate"
    """Peak pressure or approach is less than the error that is estimated for it, or the peak is not resolved."""
    UNITS = "units"
    """Two numbers are so far from each other that they may be in different units."""
    STRAIN = "strain"
    """Strains are beyond small ones."""
    SLOPE = "slope"
    """Slopes in the contact are beyond small ones."""
    FULL = "full contact"
    """The contact is nearly full."""
    SCAN = "scan"
    """Parts that a scan does not resolve carry load."""
    PROFILE = "profile"
    """The profile made of a scan may not be the surface."""


@dataclass(frozen=True)
class SolutionWarning:
    """A warning that comes with a solution."""

    kind: WarningKind
    """Its kind."""
    text: str
    """The doubt, and a remedy."""


def find_warnings(
    scene: Scene, found: Observables, patches: PatchTable, displacement: Array64
) -> Iterator[SolutionWarning]:
    """The warnings of a solution; displacement: u, shape (N,) [length]."""
    area = found.contact_area_subgrid
    if scene.pressure == 0:  # nothing is to be in contact
        return
    if not (area > 0 and patches.nodes.size):
        yield SolutionWarning(WarningKind.GRID, "nothing is in contact; more num_points, or another start")
        return
    yield from _of_units(scene)
    if doubts := scene.indenter.doubts:  # like the units early, because it may be the cause of the others
        yield SolutionWarning(WarningKind.PROFILE, doubts)
    yield from _of_grid(scene, found, patches)
    yield from _of_estimates(found, patches)
    yield from _of_elasticity(found, _strain(scene, found, patches, displacement))
    if area > NEARLY_FULL:
        text = f"{area:.4f} of the period is in contact; above {NEARLY_FULL}, areas and their estimated errors"
        text += " have been compared with finer grids only"
        if found.unseen_gap_area > 1 - area:
            text += "; gaps may be left between the nodes, and with them the contact stiffness is less"
        yield SolutionWarning(WarningKind.FULL, text)


def _of_units(scene: Scene) -> Iterator[SolutionWarning]:
    """Whether pressure and modulus, and the lengths of a scan and of its layer, are likely in one unit each."""
    thickness, period, unit = scene.layer.thickness, scene.period, scene.length_unit
    (low, high), found = _FAR_APART, list[str]()
    if scene.reduced_load > 1:
        found.append(f"the mean pressure is {scene.reduced_load:.2g} times the contact modulus E*")
    if unit != "length" and math.isfinite(thickness) and not low < thickness / period < high:
        found.append(f"the layer is {thickness:.3g} {unit} thick, and the period of the scan is {period:.3g} {unit}")
    if found:
        yield SolutionWarning(WarningKind.UNITS, f"{'; '.join(found)}: check that they are in one unit")


def _of_grid(scene: Scene, found: Observables, patches: PatchTable) -> Iterator[SolutionWarning]:
    """Whether the patches are resolved by the grid, and by the values of a scan."""
    area, waves = found.contact_area_subgrid, scene.indenter.shortest_wave(scene.num_points)
    uncertain = found.contact_area_edges_error + found.unseen_gap_area
    nodes = float(patches.nodes.mean())
    if nodes < _FEWEST_NODES and uncertain > LARGEST_ERROR * area:
        text = f"the patches have {nodes:.2g} nodes on the average, and fewer than {_FEWEST_NODES} hardly resolve them"
        yield SolutionWarning(WarningKind.GRID, f"{text}; there may be others between the nodes; more num_points")
    if scene.indenter.omitted(scene.num_points) > _MOST_LEFT_OUT:
        yield SolutionWarning(
            WarningKind.WAVES, "the grid is coarser than the profile and leaves out waves of it; more num_points"
        )
    if uncertain > LARGEST_ERROR * area:
        text = f"the area may be off by {display.rounded_up(uncertain / area)} of itself"
        yield SolutionWarning(WarningKind.ERROR, f"{text}: few nodes tell where its edges are; more num_points")
    if scene.indenter.given_points and waves:
        narrow = patches.width < scene.period / waves
        share = float(patches.load[narrow].sum() / patches.load.sum())
        if share > _MOST_LEFT_OUT:
            text = f"{share:.0%} of the load is carried by patches as narrow as two values of the scan"
            yield SolutionWarning(WarningKind.SCAN, f"{text}: roughness that it does not resolve would change the area")


def _of_estimates(found: Observables, patches: PatchTable) -> Iterator[SolutionWarning]:
    """Whether peak pressure and approach say more than their estimated errors; for kappa the area's warnings do."""
    estimated = {
        "peak pressure": (found.peak_pressure, found.peak_pressure_error),
        "approach": (found.approach, found.approach_error),
    }
    large = [name for name, (value, error) in estimated.items() if 0 < value < error < math.inf]
    texts = []
    if found.peak_pressure_sampling == math.inf:
        nodes = int(patches.nodes[np.argmax(patches.peak_pressure)])
        texts.append(f"the peak pressure is not resolved, with {nodes} node{'s' * (nodes > 1)} in its patch")
    if large:
        text = f"the error estimated of the {' and of the '.join(large)} is larger than the value"
        texts.append(f"{text}: it has not settled from one nested grid to the next")
    if texts:
        yield SolutionWarning(WarningKind.ESTIMATE, f"{'; '.join(texts)}; more num_points")


def _strain(scene: Scene, found: Observables, patches: PatchTable, displacement: Array64) -> float:
    """The largest strain, estimated (dimensionless).

    Below patches narrower than the layer is thick, and on an elastic base, it is about the pressure over E*. Below wide
    ones on a rigid base it is the layer's compression over its thickness, or the shear at the base, d/G times the
    pressure's gradient, by which a nearly incompressible layer is squeezed out sideways.
    """
    layer = scene.layer
    on_rigid_base = layer.foundation_modulus(scene.period) > 0
    wide = (patches.width > 2 * layer.thickness) & on_rigid_base
    largest = float(patches.peak_pressure[~wide].max(initial=0.0)) / layer.contact_modulus
    if wide.any():
        largest = max(largest, float(np.abs(found.approach - displacement).max()) / layer.thickness)
    if wide.any() and layer.bonded:
        shear_modulus = layer.contact_modulus * (1 - layer.bonded[1]) / 2
        gradient = float((2 * patches.peak_pressure[wide] / patches.width[wide]).max())
        largest = max(largest, gradient * layer.thickness / shear_modulus)
    return largest


def _of_elasticity(found: Observables, strain: float) -> Iterator[SolutionWarning]:
    """Whether strains and slopes are small, as linear elasticity takes them to be."""
    slope, taken = found.rms_gradient_subgrid, "are not small, but taken to be"
    if strain > LARGEST_STRAIN:
        text = f"strains reach about {strain:.2g}: above {LARGEST_STRAIN:g} they {taken}"
        yield SolutionWarning(WarningKind.STRAIN, text)
    if slope > LARGEST_SLOPE:
        text = f"the rms slope in the contact is {slope:.2g}: above {LARGEST_SLOPE:g} slopes {taken}"
        yield SolutionWarning(WarningKind.SLOPE, text)
