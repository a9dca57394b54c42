"""What is measured on a solution: area, gradient, reduced pressure, coefficient, approach."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .closed_forms import kappa_half_space
from .edges import Edges, find_edges
from .indenters import PowerIndenter
from .patches import Patches
from .scene import Scene
from .stiffness import foundation_modulus

Array64 = NDArray[np.float64]


@dataclass(frozen=True)
class Observables:
    """Dimensionless unless a unit is given.

    contact_area: a_r, nodes in contact over all nodes. A node more or less is 1/N.
    contact_area_subgrid: a_r between the sub-grid edges (`edges`). contact_area_error: estimate of its error: the
        edges' own (1 if a solve ended without a contact), what the unfinished iteration leaves, and with nested grids
        the discretisation's.
    contact_area_discretisation_error: a third of the change from the last coarser grid; None without nested grids.
    num_patches: runs of neighbouring contact nodes; num_counted_patches: those of fewer than three nodes, for which the
        sub-grid area counts nodes.
    rms_gradient_contact: g_c, rms of h' over the contact.
    reduced_pressure: p* = p/(E* g_c); inf where the contact is flat, or one node, whose slope is 0.
    kappa: a_r/p*; kappa_ratio: kappa over kappa_inf(n) of the half-space, None but for power profiles.
    rms_gradient_subgrid, kappa_subgrid, kappa_error, kappa_discretisation_error: likewise between the sub-grid edges;
        the error is inf where the contact is flat.
    reduced_thickness: d/(a_r L).
    approach: rigid approach since first touch [length]: mean(u) + p/k_W; for a half-space mean(u), by convention.
    peak_pressure: largest contact pressure [pressure].
    """

    contact_area: float
    rms_gradient_contact: float
    reduced_pressure: float
    kappa: float
    kappa_ratio: float | None
    reduced_thickness: float
    approach: float
    peak_pressure: float
    num_patches: int
    num_counted_patches: int
    contact_area_subgrid: float
    contact_area_error: float
    rms_gradient_subgrid: float
    kappa_subgrid: float
    kappa_error: float
    contact_area_discretisation_error: float | None = None
    kappa_discretisation_error: float | None = None


def observe(scene: Scene, displacement: Array64, contact_pressure: Array64, contact: NDArray[np.bool_]) -> Observables:
    """Observables of a displacement [length] and contact pressure [pressure], both shape (N,)."""
    squared_slope = scene.indenter.slope(scene.num_points, scene.period) ** 2
    area = float(contact.mean())
    gradient = math.sqrt(float(squared_slope[contact].mean())) if area else 0.0
    reduced = scene.pressure / scene.layer.contact_modulus / gradient if gradient else math.inf
    kappa = area / reduced
    layer, indenter = scene.layer, scene.indenter
    patches, edges = contact_edges(scene, np.where(contact, contact_pressure, 0.0))
    area_subgrid, gradient_subgrid, kappa_subgrid, sensitivity = subgrid_measures(scene, patches, edges, squared_slope)
    area_error = math.sqrt(float(edges.error @ edges.error)) / scene.num_points if area else 1.0
    modulus = foundation_modulus(layer.thickness, layer.poisson_ratio) * layer.contact_modulus  # 0 for a half-space
    return Observables(
        contact_area=area,
        rms_gradient_contact=gradient,
        reduced_pressure=reduced,
        kappa=kappa,
        kappa_ratio=kappa / kappa_half_space(indenter.exponent) if isinstance(indenter, PowerIndenter) else None,
        reduced_thickness=layer.thickness / (area * scene.period) if area else math.inf,
        approach=float(displacement.mean()) + (scene.pressure / modulus if modulus else 0.0),
        peak_pressure=float(contact_pressure.max(initial=0.0)),
        num_patches=patches.count,
        num_counted_patches=int(edges.counted.sum()),
        contact_area_subgrid=area_subgrid,
        contact_area_error=area_error,
        rms_gradient_subgrid=gradient_subgrid,
        kappa_subgrid=kappa_subgrid,
        kappa_error=sensitivity * area_error if area_error else 0.0,
    )


def contact_edges(scene: Scene, pressure: Array64) -> tuple[Patches, Edges]:
    """Patches and their sub-grid edges, from the contact pressure [any unit], 0 off the contact, shape (N,), any N."""
    patches = Patches.of(pressure > 0)
    thickness = scene.layer.thickness / scene.period * pressure.size
    return patches, find_edges(patches, pressure[patches.nodes], thickness, scene.layer.poisson_ratio)


def subgrid_measures(
    scene: Scene, patches: Patches, edges: Edges, squared_slope: Array64
) -> tuple[float, float, float, float]:
    """a_r, g_c and kappa between the sub-grid edges, and |d kappa/d a_r| where the edges move (dimensionless).

    squared_slope: h'^2 on the grid of `patches` and `edges`, shape (N,).
    """
    num_points, width = squared_slope.size, float(edges.width.sum())
    if width == 0:
        return 0.0, 0.0, 0.0, math.inf
    whole = float(squared_slope[patches.nodes].sum())
    # the strips between the last nodes' cells and the edges, at the slope in their middle
    strips = np.concatenate([patches.first - 0.5 - edges.left, edges.right - patches.last - 0.5])
    middles = np.concatenate([(patches.first - 0.5 + edges.left) / 2, (patches.last + 0.5 + edges.right) / 2])
    node = np.floor(middles).astype(np.int64)
    part = middles - node
    at = (1 - part) * squared_slope[node % num_points] + part * squared_slope[(node + 1) % num_points]
    mean_square = (whole + float(strips @ at)) / width
    if not mean_square > 0:
        return width / num_points, 0.0, 0.0, math.inf
    gradient = math.sqrt(mean_square)
    per_area = gradient * scene.layer.contact_modulus / scene.pressure
    # d(a g) = g da + da (s_e^2 - g^2)/(2 g), s_e the slope at the edge
    sensitivity = per_area * (1 + abs(float(at.mean()) / mean_square - 1) / 2)
    return width / num_points, gradient, per_area * width / num_points, sensitivity
