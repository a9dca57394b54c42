"""The certificate: how wrong a displacement can be, recomputed in float64 from u alone.

No method shares this code, which decides by itself which nodes are in contact. It shares the transforms with
them, which are tested against NumPy's. All numbers are dimensionless.

The bound. Let r = p - K u, F the free nodes, C the nodes in contact (u = h, r > 0). For every admissible v <= h, with
e = v - u and e <= 0 on C, the energy Pi = V - p L mean(u) obeys

    Pi(v) - Pi(u) = e.K e/2 - r.e = e.K e/2 - s.e + (r - s).(-e) >= e.K e/2 - s.e >= -s.K^+ s/2

for any s with s = r on F and s <= r on C, since there r - s >= 0 and -e >= 0. K^+ is the inverse without the mean mode,
so s must have zero sum: s = r_F on F and s = -r_C (sum r_F)/(sum r_C) on C, which is below r_C because sum r_F + sum
r_C = N p > 0. Hence, for an admissible u, 0 <= Pi(u) - min Pi <= s.K^+ s/2, contact set included: nodes that ought to
be in contact and are not, or the other way round, are covered. With the sum of r_F at 0 it is the r_F.G r_F/2 of a
two-metric argument (K_FF^-1 <= G_FF).
"""

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import Array64, Mask, chunks
from ..transforms.plain import pair
from ..value import Value
from .problem import Problem
from .split import inverse

MEANINGLESS = 0.2
"""Residual over the mean pressure; where there is more left, there is no solution (dimensionless)."""


@dataclass(frozen=True)
class Certificate(Value):
    """Errors of a displacement, all dimensionless."""

    equilibrium_residual: float
    """Rms net force on the free nodes over the mean pressure."""
    largest_residual: float
    """Largest net force on a free node over the mean pressure, often near the ends of a few patches."""
    tensile_violation: float
    """Largest tensile force between the wall and a node that touches it, over the mean pressure."""
    penetration: float
    """Deepest u - h over the rms of h about its mean."""
    complementarity: float
    """Sum of |pressure| times gap over the free nodes, over the load and the rms of h."""
    force_balance: float
    """|mean contact pressure/p - 1|."""
    energy_error_bound: float
    """Upper bound of the energy above the exact minimum on this grid, over the elastic energy; 0 where heights are so
    small that both underflow."""
    approach_balance: float | None = None
    """|approach/(the one asked for) - 1|; None where the pressure is given, and not the approach."""


def certify(problem: Problem, displacement: Array64) -> tuple[Certificate, Array64, Mask]:
    """Certificate of a displacement, shape (N,) [u], with the contact pressure, shape (N,) [p], and the contact.

    The contact pressure is max(r, 0) on touching nodes and 0 elsewhere.
    """
    h, n = problem.height, problem.num_points
    pressure, contact = np.zeros(n), np.zeros(n, dtype=bool)
    transforms = pair(n)
    with np.errstate(over="ignore", invalid="ignore"):
        transforms.multiply(displacement, problem.stiffness)
        elastic = transforms.real
        mean = float(h.mean())
        free = squares = energy = variance = apart = load = 0.0
        tensile = penetration = largest = 0.0
        for part in chunks(n):
            heights, u, ku = h[part], displacement[part], elastic[part]
            energy += float(u @ ku) / 2
            force, gap, away = np.subtract(1, ku, out=ku), heights - u, heights - mean
            touching = np.flatnonzero(gap <= 0)
            there = force[touching]
            held = np.where(there > 0, there, 0.0)
            force[touching] = there - held
            pressure[part][touching], contact[part][touching] = held, there > 0
            tensile = max(tensile, -float(there.min(initial=0.0)))
            penetration = max(penetration, -float(gap.min()))
            variance += float(away @ away) / n
            net = np.abs(force)
            largest = float(np.maximum(largest, net.max()))
            apart += float(net @ np.abs(gap, out=gap))
            squares += float(force @ force)
            free, load = free + float(force.sum()), load + float(held.sum())
        scale = math.sqrt(variance) or 1.0
        bound = math.inf
        if load > 0:  # s: the free force balanced on the contact
            for part in chunks(n):
                elastic[part] -= pressure[part] * (free / load)
            bound = transforms.power(inverse(problem.stiffness)) / 2
        certificate = Certificate(
            equilibrium_residual=math.sqrt(squares / max(1, n - int(contact.sum()))),
            largest_residual=largest,
            tensile_violation=tensile,
            penetration=penetration / scale,
            complementarity=apart / (n * scale),
            force_balance=abs(load / n - 1),
            energy_error_bound=bound / energy if energy > 0 else 0.0 if bound == 0 else math.inf,
        )
    return certificate, pressure, contact
