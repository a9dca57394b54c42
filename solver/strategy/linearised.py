"""The contact stiffness, by the problem linearised on the contact that was found.

While no node joins or leaves the contact, the gap there stays 0: d sigma/dp is the pressure under a flat punch of the
contact's shape that carries the mean pressure 1, and du/dp the surface's displacement under it, 0 on the contact. The
contact stiffness is one over d(approach)/dp, the mean of du/dp and the layer's mean compression 1/k_W.

On the grid that is exact. In the continuum the contact ends between two nodes (`grid.edges`), and the punch's pressure
goes like k/sqrt(r) with the distance r from an end. Moving an end outwards by x takes 2 pi k^2 x/(E* L) off
d(approach)/dp (for one patch on a half-space, -(2 L/(pi E*)) ln sin(pi a/L) with k^2 = L cot(pi a/L)/(2 pi), it is the
derivative). A punch on nodes ends at a known place outside of its last node, and that node's pressure tells k: both are
the edge's curve (`grid.edge_curves`). With that the error falls from first to second order.

A patch whose load tells its width 2a is compared with a flat punch: widening one from the half-width c to a under the
load P takes 2 P^2/(pi E* L) ln(a/c) off d(approach)/dp, and c is that of the punch which is as compliant as the patch's
nodes (`grid.few_nodes`). A gap of the width 2b that tells its own ends opens over an area that goes like b^2: so it is
compared with the gap that opens as far as its nodes.
"""

import math
from dataclasses import replace

import numpy as np

from .. import checks
from ..arrays import Array64, Mask, on_one_thread
from ..endings import Status
from ..grid.contact import contact_edges
from ..grid.edges import UNRESOLVED_BELOW, Edges
from ..grid.few_nodes import MOST_NODES, equivalent_gaps, equivalent_half_widths
from ..grid.patches import Patches
from ..grid.problem import Problem
from ..methods import ExecutionConfig, active_set, relax
from ..solution import Solution

_TOLERANCE = 1e-5  # on the punch's pressure or free force; the stiffness has eight digits: of second order


@on_one_thread()
def contact_stiffness(solution: Solution) -> float:
    """dp/d(approach) of a solution [pressure/length]; 0 where nothing touches.

    For a half-space, whose approach is the mean of u by convention, it is infinite at full contact, as it is for an
    incompressible layer. It takes a quarter to a half of the time of the solve. Raises `ValueError`.
    """
    if not isinstance(solution, Solution):
        raise checks.refusal("solution", solution, "a Solution")
    contact = solution.contact
    if not contact.any():
        return 0.0
    problem = Problem.from_scene(solution.scene)
    compliance, punch, surface = flat_punch(problem, contact)
    if not contact.all():
        compliance -= _beyond_nodes(solution, problem, punch, surface)
    return 1 / compliance if compliance else math.inf


def flat_punch(problem: Problem, contact: Mask) -> tuple[float, Array64, Array64]:
    """d(approach)/dp on the grid [length/pressure], NaN where rounding leaves none of it, and, shape (N,), d sigma/dp
    (dimensionless) and du/dp [length/pressure]. contact: unchanged, shape (N,), of one node at least.
    """
    modulus = problem.scene.foundation_modulus
    compression = 1 / modulus if modulus else 0.0
    if contact.all():  # the surface stays where it is, and the layer below is compressed
        return compression, np.ones(contact.size), np.zeros(contact.size)
    punch = replace(problem, height=np.where(contact, 0.0, problem.layer.reach))
    config = ExecutionConfig(_TOLERANCE, fixed_set=True, contact_share=float(contact.mean()))
    method = active_set.begin(punch, config)
    method.start_from_pressure(contact.astype(np.float64))
    if relax(method, active_set.KIND.max_iterations) is Status.INTERRUPTED:
        raise KeyboardInterrupt
    surface, unit = method.displacement, problem.length_unit / problem.scene.pressure
    # the mean of u, with an error of the second order in the free force, which does its share of the work
    mean = float(surface.sum() + surface @ punch.net_force(surface)) / surface.size
    compliance = mean * unit + compression if method.residual < 10 * _TOLERANCE else math.nan
    return compliance, method.contact_pressure, surface * unit


def _beyond_nodes(solution: Solution, problem: Problem, punch: Array64, surface: Array64) -> float:
    """What d(approach)/dp is less because the contact ends beyond the ends of a punch on its nodes [length/pressure].

    punch: d sigma/dp; surface: du/dp [length/pressure]; both of shape (N,). Where loads tell the ends of a patch that
    is narrower than the gaps beside it, and than the layer is thick, it is compared with the flat punch that is as
    compliant without a grid as its nodes are with it, and a gap that tells its own ends with the one that opens as far
    as its nodes. Not known, and 0, for other patches of one or two nodes.
    """
    scene, pressure = solution.scene, np.where(solution.contact, solution.contact_pressure, 0.0)
    _, _, patches, edges = contact_edges(problem, pressure, solution.displacement)
    if not solution.certificate:  # a smaller model knows where its patches end, its sampled pressures do not
        n, table = pressure.size, solution.patches
        beyond_first = (table.left / scene.period * n - patches.first + n / 2) % n - n / 2
        begins = patches.first + beyond_first
        edges = replace(edges, left=begins, right=begins + table.width / scene.period * n)
    curve = problem.layer.edge_curve
    gaps, many = patches.gap, patches.size >= UNRESOLVED_BELOW  # nodes of the gaps
    # where the layer, or a gap, is narrower than a patch, a lone punch on a half-space says nothing of that
    alone = (patches.size < gaps.min(axis=0)) | ~many
    thick = patches.size < problem.layer.thickness
    by_load = edges.by_load & alone & thick & (edges.width > 0)
    told = np.stack([np.roll(edges.by_gap, 1), edges.by_gap])
    last_nodes = np.stack([patches.first, patches.last]) % pressure.size
    beyond = np.stack([patches.first - edges.left, edges.right - patches.last])
    squared = (punch[last_nodes] / curve.strength) ** 2  # k^2 over the grid spacing
    known = many & (gaps >= UNRESOLVED_BELOW) & ~by_load & ~told
    total = float(np.where(known, squared * (beyond - (curve.shift - 0.5)), 0.0).sum())
    of_nodes = equivalent_half_widths()[patches.size[by_load] - 1]
    wider = np.log(edges.width[by_load] / (2 * of_nodes))
    total += float(np.sum((patches.sums(punch[patches.nodes])[by_load] / math.pi) ** 2 * wider))
    spacing = scene.period / pressure.size
    edges_part = 2 * math.pi / scene.layer.contact_modulus * total * spacing**2 / scene.period
    return edges_part - _by_gaps(patches, edges, surface)


def _by_gaps(patches: Patches, edges: Edges, surface: Array64) -> float:
    """What d(approach)/dp is more because gaps are wider than those that open as far as their nodes [length/pressure].

    surface: as in `_beyond_nodes`.
    """
    (before,) = np.nonzero(edges.by_gap)
    n, behind = patches.num_points, (before + 1) % patches.count
    size = patches.gap[1, before]
    width = edges.left[behind] + np.where(behind == 0, n, 0) - edges.right[before]
    wider = (width / (2 * equivalent_gaps()[size - 1])) ** 2 - 1
    steps = np.arange(MOST_NODES)
    nodes = (patches.last[before, None] + 1 + steps) % n
    opened = np.where(steps < size[:, None], surface[nodes], 0.0).sum(axis=1)
    return float(opened @ wider) / n
