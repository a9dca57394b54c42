"""What is measured on a solution: area, gradient, reduced pressure, coefficient, approach."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array64, chunks
from ..reference.closed_forms import kappa_half_space
from ..scene import SMALLEST
from ..value import Value
from .contact import Contact
from .edges import UNRESOLVED_BELOW, Edges
from .narrow import squared_slopes
from .patch_table import PatchTable, patch_table
from .patches import Patches
from .problem import Problem


@dataclass(frozen=True)
class Measured(Value):
    """What is measured on every grid; dimensionless unless a unit is given."""

    contact_area_subgrid: float
    """a_r between the sub-grid edges."""
    rms_gradient_subgrid: float
    """Rms of h' between the sub-grid edges."""
    kappa_subgrid: float
    """kappa between the sub-grid edges."""
    contact_area_edges_error: float
    """a_r's error, estimated from the ends of the patches alone."""
    kappa_edges_error: float
    """The same for kappa."""
    unseen_gap_area: float
    """Share of the period that gaps between two contact nodes, and patches between two open ones, may have; part of
    `contact_area_error`."""
    peak_pressure: float
    """Largest contact pressure [pressure]."""
    peak_pressure_sampling: float
    """By how much the largest pressure may differ from that of the nodes, see `peak_sampling` [pressure]."""
    approach: float
    """Rigid approach since first touch [length]: mean(u) + p/k_W, for a half-space mean(u), by convention. Under a
    rough surface the depth of its lowest point below its lowest node is added."""
    approach_sampling: float
    """By how much the approach may be off because the lowest point may lie between the nodes [length]."""
    num_patches: int
    """Runs of neighbouring contact nodes."""


@dataclass(frozen=True)
class Observables(Measured):
    """What is measured on a solution; dimensionless unless a unit is given.

    Areas and kappa come in two ways: by counting nodes, and with every contact edge located between two nodes
    ("sub-grid", see `contact`).
    """

    contact_area: float
    """a_r, nodes in contact over all nodes; a node more or less is 1/N."""
    rms_gradient_contact: float
    """g_c, rms of h' over the nodes in contact."""
    reduced_pressure: float
    """p* = p/(E* g_c); `inf` where the contact is flat, or a single node whose slope is 0."""
    kappa: float
    """a_r/p*."""
    kappa_ratio: float | None
    """kappa over kappa_inf(n) of the half-space; None for anything but power profiles."""
    reduced_thickness: float
    """d/(a_r L)."""
    mean_gap: float
    """Mean of h - u over all nodes [length]."""
    num_unresolved_patches: int
    """Patches whose ends neither pressures nor loads tell: their nodes are counted even in the sub-grid area."""
    num_patches_by_load: int
    """Narrow patches whose ends are found by their loads, see `narrow`."""
    contact_area_error: float
    """Estimated error of the sub-grid a_r, by the ends of the patches (1 if a solve ended without a contact) and the
    unfinished iteration."""
    kappa_error: float
    """Estimated error of `kappa_subgrid`; `inf` where the contact is flat."""
    peak_pressure_error: float = math.inf
    """Estimated error of the largest contact pressure [pressure]; `inf` where no coarser grid tells."""
    approach_error: float = math.inf
    """The same for the approach [length]."""


def observe(found: Contact, displacement: Array64) -> tuple[Observables, PatchTable]:
    """Observables and patches of a contact, its pressure in [pressure], with a displacement, shape (N,) [length]."""
    problem, pressure, patches, edges = found
    measured, contact = measure(found, displacement), pressure > 0
    scene, profile, exponent = problem.scene, problem.profile, problem.indenter.exponent
    area = float(contact.mean())
    gradient = math.sqrt(float(problem.indenter.squared_slope[contact].mean())) if area else 0.0
    reduced = scene.reduced_load / gradient if gradient else math.inf
    kappa = area / reduced
    observables = Observables(
        **measured,
        contact_area=area,
        rms_gradient_contact=gradient,
        reduced_pressure=reduced,
        kappa=kappa,
        kappa_ratio=kappa / kappa_half_space(exponent) if exponent else None,
        reduced_thickness=scene.layer.thickness / (area * scene.period) if area else math.inf,
        mean_gap=sum(float((profile[part] - displacement[part]).sum()) for part in chunks(profile.size)) / profile.size,
        num_unresolved_patches=int(edges.unresolved.sum()),
        num_patches_by_load=int(edges.by_load.sum()),
        contact_area_error=measured["contact_area_edges_error"],
        kappa_error=measured["kappa_edges_error"],
    )
    return observables, patch_table(patches, edges, pressure, scene.period)


def measure(found: Contact, displacement: Array64, unit: float = 1.0) -> dict[str, Any]:
    """The fields of `Measured` on any grid, by name. Arguments as for `observe`, with pressures in [`unit`]."""
    problem, pressure, patches, edges = found
    scene, indenter, num_points = problem.scene, problem.indenter, problem.num_points
    area, gradient, kappa, kappa_error = subgrid_measures(problem, patches, edges)
    modulus, lowest = scene.foundation_modulus, indenter.of.depth_between_nodes(problem.profile)
    # patches of one or two nodes do not tell how deep the lowest point is in contact before a node touches
    resolved = patches.count > 0 and int(patches.size.max()) >= UNRESOLVED_BELOW
    return {
        "contact_area_subgrid": area,
        "rms_gradient_subgrid": gradient,
        "kappa_subgrid": kappa,
        "contact_area_edges_error": edges.total_error() / num_points if patches.count else 1.0,
        "kappa_edges_error": kappa_error,
        "unseen_gap_area": edges.unseen / num_points,
        "peak_pressure": unit * float(pressure.max(initial=0.0)),
        "peak_pressure_sampling": unit * peak_sampling(indenter.exponent, pressure, patches, edges),
        "approach": float(displacement.mean()) + (scene.pressure / modulus if modulus else 0.0) + lowest,
        "approach_sampling": indenter.of.hidden_depth(problem.profile) + (0.0 if resolved else lowest),
        "num_patches": patches.count,
    }


def peak_sampling(exponent: float | None, pressure: Array64, patches: Patches, edges: Edges) -> float:
    """By how much the largest pressure may differ from the largest one at a node, in the pressure's unit.

    Between the nodes of a patch a parabola passes the largest of them by an eighth of the second difference at most.
    One or two nodes tell their patch's load P only. With a the half-width that the load tells, the largest is 2P/(pi a)
    below a parabola (K. L. Johnson, Contact Mechanics (1985), section 4.2), n/(n - 1) P/(pi a) below a sharper tip, and
    on a layer that the grid does not resolve at most that of a thin incompressible one, 15/16 P/a. `inf` where nothing
    tells a.

    exponent: n of a power profile; pressure: shape (N,); patches, edges: its contact.
    """
    if not patches.count:
        return 0.0
    at = int(np.argmax(pressure))
    before, highest, after = (float(pressure[(at + step) % pressure.size]) for step in (-1, 0, 1))
    bent = max(2 * highest - before - after, 0.0) / 8 if min(before, after) > 0 else 0.0
    few = patches.size < UNRESOLVED_BELOW
    if not few.any():
        return bent
    inside = pressure[patches.nodes]
    largest = np.maximum.reduceat(inside, patches.offset)
    if (largest[few & edges.unresolved] == highest).any():
        return math.inf
    sharper = exponent / (exponent - 1) if exponent else 2.0
    share = np.where(edges.by_load, 2 / math.pi * max(2.0, sharper), 15 / 8)
    told = few & ~edges.unresolved
    width = np.maximum(edges.width, SMALLEST)
    expected = np.where(told, share * patches.sums(inside) / width, largest)
    lead = int(np.argmax(expected))
    doubt = expected[lead] * edges.end_errors[:, lead].sum() / width[lead] if told[lead] else 0.0
    return max(bent, abs(float(expected[lead]) - highest) + float(doubt))


def subgrid_measures(problem: Problem, patches: Patches, edges: Edges) -> tuple[float, float, float, float]:
    """a_r, g_c and kappa between the sub-grid edges, and kappa's error as far as edges and slopes tell it, without a
    coarser grid (dimensionless).
    """
    num_points, width = patches.num_points, float(edges.width.sum())
    if width == 0:
        return 0.0, 0.0, 0.0, math.inf
    scene, indenter, squared = problem.scene, problem.indenter, problem.indenter.squared_slope
    known = indenter.of.squared_slope_between(edges.left, edges.right, num_points, scene.period)
    if known is None:  # by the heights between ends that loads tell, or let estimate; elsewhere by the nodes
        known = np.full(patches.count, np.nan)
        told = edges.by_load | (patches.size < UNRESOLVED_BELOW) & ~edges.unresolved
        spacings = num_points / scene.period
        known[told] = squared_slopes(problem.profile, spacings, edges.left[told], edges.right[told])
    unknown = np.isnan(known)
    whole = np.where(unknown, patches.sums(squared[patches.nodes]), known)
    # the rest of the integral over the nodes' cells, to the next order (Euler and Maclaurin)
    first, last = patches.first, patches.last
    rise = squared[(last + 1) % num_points] - squared[last % num_points]
    rise -= squared[first % num_points] - squared[(first - 1) % num_points]
    whole += np.where(unknown & ~edges.unresolved, rise / 24, 0.0)
    # the strips between the last nodes' cells and the edges, by the parabola there
    strips = np.stack([first - 0.5 - edges.left, edges.right - last - 0.5])
    middles = np.stack([(first - 0.5 + edges.left) / 2, (last + 0.5 + edges.right) / 2])
    node = np.floor(middles).astype(np.int64)
    before, here, there, beyond = (squared[(node + step) % num_points] for step in (-1, 0, 1, 2))
    bend = (before - here - there + beyond) / 2

    def parabola(places: Array64) -> Array64:
        part = places - node
        return (1 - part) * here + part * there - bend * part * (1 - part) / 2

    at = parabola(middles) + bend * strips**2 / 24
    mean_square = float((whole + np.where(unknown, (strips * at).sum(axis=0), 0.0)).sum()) / width
    if not mean_square > 0:  # beside a step differences of high order leave less than nothing: as the nodes have it
        mean_square = float(squared[patches.nodes].mean())
    if not mean_square > 0:
        return width / num_points, 0.0, 0.0, math.inf
    gradient = math.sqrt(mean_square)
    per_area = gradient * scene.layer.contact_modulus / scene.pressure
    kappa = per_area * width / num_points
    # kappa goes like the root of the width times the integral of h'^2, which is off where h' is small at the ends, too
    weights = (1 + parabola(np.stack([edges.left, edges.right])) / mean_square) / 2
    by_edges = kappa / width * edges.total_error(np.maximum(weights, indenter.exponent or 0.5))
    by_slopes = 0.0  # of h'^2, twice that of its root
    if (doubt := indenter.squared_slope_doubt) is not None:
        by_slopes = float(np.abs(patches.sums(doubt[patches.nodes]))[unknown].sum()) / width / mean_square
    return width / num_points, gradient, kappa, math.hypot(by_edges, by_slopes * kappa)
