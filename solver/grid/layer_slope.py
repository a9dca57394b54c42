"""What a layer adds to the slope beside a load, over the distance.

A load P adds, besides what it does on the half-space, P/pi int (2 - q/K(q)) sin(q D) dq over q > 0 at the distance D,
in units of E*. Beyond ten thicknesses this is as if the layer were the half-space that its longest waves find (none on
a rigid base). On a base much softer than the layer, which only waves of many thicknesses find, it is so beyond thirty,
and more of the neighbouring patches matter; where waves that long have not found the base either, loads tell nothing.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import Array64

Modulus = Callable[[Array64], Array64]
"""2K(q)/q over E* for waves q [1/grid spacing]: 1 on the half-space."""

NEIGHBOURS = 4
"""Patches on each side of one that are looked at one by one, but on a base much softer than the layer."""

_SHORTEST = 12.0  # times the thickness: the shortest wave with which the layer's part is integrated
_USUAL = 10.0, 128, 256, NEIGHBOURS
"""Thicknesses beyond which the longest waves tell the rest, waves and places of the layer's part, and neighbours."""
_ON_SOFT = 30.0, 192, 256, 16
"""The same where waves of more than two thicknesses still change, as on a base much softer than the layer."""
_SOFT = 0.5  # change of their compliance, over the half-space's, from which that is so
_ALIKE, _SETTLED = 0.1, 0.2
"""By how much the compliance of waves of thirty thicknesses may differ from that of the longest waves: of the
half-space's, or of the longest waves' own."""

_gauss = functools.cache(np.polynomial.legendre.leggauss)


@dataclass(frozen=True, eq=False)
class LayerSlope:
    """w' by a unit load on a layer less that on the half-space, over the distance."""

    distance: Array64
    """From 0 to many thicknesses [grid spacings]; of size 0 for a half-space."""
    table: Array64
    """w' [1/E*/grid spacing]."""
    derivative: Array64
    """Of that [1/E*/grid spacing^2]."""
    far: float = 0.0
    """Share of the half-space's slope that is missing at distances of many thicknesses (dimensionless)."""
    neighbours: int = NEIGHBOURS
    """On each side, that are looked at one by one."""

    @classmethod
    def of(cls, modulus: Modulus, thickness: float, num_points: int) -> "LayerSlope":
        """Of the layer with this modulus. thickness: [grid spacings], on a grid of `num_points`."""
        if not thickness < num_points:
            return cls(np.zeros(0), np.zeros(0), np.zeros(0))
        limit, there = _compliance(modulus, thickness, num_points, 2.0)
        reach, waves, places, neighbours = _USUAL if abs(there - limit) < _SOFT else _ON_SOFT
        nodes, weights = _gauss(waves)
        most, root = min(_SHORTEST / thickness, np.pi), (nodes + 1) / 2
        q = most * root**2
        part = most * root * weights * (2 - 2 / modulus(q)) / np.pi
        distance = reach * thickness * np.linspace(0.0, 1.0, places) ** 2
        phase = distance[:, None] * q
        return cls(distance, np.sin(phase) @ part, np.cos(phase) @ (part * q), 1 - limit, neighbours)

    @property
    def is_soft(self) -> bool:
        """Whether the base is much softer than the layer."""
        return self.neighbours > NEIGHBOURS

    @property
    def reach(self) -> float:
        """Where the table ends [grid spacings]."""
        return float(self.distance[-1])

    def slope(self, distance: Array64) -> tuple[Array64, Array64]:
        """w' [1/E*/grid spacing] and its derivative at distances to either side [grid spacings], of their shape."""
        if not self.distance.size:
            return np.zeros_like(distance), np.zeros_like(distance)
        away = np.abs(distance)
        beyond = away > self.reach
        far = 2 / np.pi * self.far / np.maximum(away, self.reach)
        slope, bent = (np.interp(away, self.distance, known) for known in (self.table, self.derivative))
        slope, bent = np.where(beyond, far, slope), np.where(beyond, -far / np.maximum(away, self.reach), bent)
        return slope * np.sign(distance), bent


def loads_tell(modulus: Modulus, thickness: float, num_points: int) -> bool:
    """Whether the response far from a load is known: waves of the longest reach find what the longest waves find.

    thickness: the layer's own, also where the grid does not resolve it [grid spacings].
    """
    limit, there = _compliance(modulus, thickness, num_points, _ON_SOFT[0])
    return abs(there - limit) <= max(_ALIKE, _SETTLED * limit)


def _compliance(modulus: Modulus, thickness: float, num_points: int, reach: float) -> tuple[float, float]:
    """Compliance of the grid's longest wave, and of one that tells of the response so many thicknesses away, over the
    half-space's (dimensionless).
    """
    longest = 2 * np.pi / num_points
    found = 1 / modulus(np.array([longest, max(longest, 1 / (reach * thickness))]))
    return float(found[0]), float(found[1])
