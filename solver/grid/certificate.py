"""The certificate: how wrong a displacement can be, recomputed in float64 from u alone.

No method shares this code: it transforms with `numpy.fft`, not through `transforms` as they do, and decides by itself
which nodes are in contact. All numbers are dimensionless.

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

from ..arrays import Array64, Mask
from .problem import Problem


@dataclass(frozen=True)
class Certificate:
    """Errors of a displacement, all dimensionless."""

    free_residual: float
    """Rms net force on the free nodes over the mean pressure."""
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


def certify(problem: Problem, displacement: Array64) -> tuple[Certificate, Array64, Mask]:
    """Certificate of a displacement, shape (N,) [u], with the contact pressure, shape (N,) [p], and the contact.

    The contact pressure is max(r, 0) on touching nodes and 0 elsewhere.
    """
    h, n = problem.height, problem.num_points
    with np.errstate(over="ignore", invalid="ignore"):
        elastic = np.fft.irfft(problem.stiffness * np.fft.rfft(displacement), n)
        r = 1 - elastic
        touching = displacement >= h
        contact = touching & (r > 0)
        pressure = np.where(contact, r, 0.0)
        free_force = np.where(contact, 0.0, r)
        scale = float(h.std()) or 1.0
        gap = h - displacement
        energy, bound = float(displacement @ elastic) / 2, _energy_bound(problem, free_force, pressure)
        certificate = Certificate(
            free_residual=float(np.sqrt(np.sum(free_force**2) / max(1, n - contact.sum()))),
            tensile_violation=max(0.0, -float(r[touching].min(initial=0.0))),
            penetration=max(0.0, -float(gap.min())) / scale,
            complementarity=float(np.abs(free_force) @ np.abs(gap)) / (n * scale),
            force_balance=abs(float(pressure.mean()) - 1),
            energy_error_bound=bound / energy if energy > 0 else 0.0 if bound == 0 else math.inf,
        )
    return certificate, pressure, contact


def _energy_bound(problem: Problem, free_force: Array64, pressure: Array64) -> float:
    """s.K^+ s/2 with the free force balanced on the contact; `inf` without a contact."""
    if not pressure.any():
        return math.inf
    s = free_force - pressure * (free_force.sum() / pressure.sum())
    power = np.abs(np.fft.rfft(s)[1:]) ** 2
    weight = np.full(power.size, 2.0)
    if problem.num_points % 2 == 0:
        weight[-1] = 1.0  # the Nyquist mode stands once
    return float(np.sum(weight * power / problem.stiffness[1:])) / (2 * problem.num_points)
