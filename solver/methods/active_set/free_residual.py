"""The free residual that the certificate is going to find, before there is a displacement to certify."""

import math

import numpy as np

from ...arrays import Array64
from ...grid.patches import Patches
from ...grid.problem import Problem

_FOUND = 0.9
"""Of the number that is made here: the certificate found 0.65 to 0.87 of it on rough surfaces of 2^14 to 2^22 points,
H = 0.3 and 0.8, with 2 to 77 % in contact, and less where that is far below the tolerance. On thin layers with nu near
1/2 it finds up to twice as much."""


def free_residual(problem: Problem, patches: Patches, residual: Array64) -> float:
    """About the rms net force on the free nodes over p (dimensionless), if contact nodes are put on the wall.

    residual: level - (h + w) on the contact nodes, in compact order [u]. So much are they moved; the others stay where
    the pressure has them. What K d of that displacement d is on free nodes comes from its short waves, for which K^2 =
    a + b q^2. Now a acts on the nodes themselves, and b q^2 on differences: the sum of (K d)^2 is b times that of
    (d_(i+1) - d_i)^2, with q in 1/(grid spacing).
    """
    steepest = problem.stiffness[-1] ** 2 - problem.stiffness[1] ** 2
    if steepest <= 0:
        return 0.0
    first, last = patches.offset, patches.offset + patches.size - 1
    within = np.diff(residual)
    within[last[:-1]] = 0  # from one patch to the next
    squares = float(within @ within) + float(np.sum(residual[first] ** 2) + np.sum(residual[last] ** 2))
    free = max(1, problem.num_points - residual.size)
    return _FOUND * math.sqrt(steepest * squares / free) / math.pi
