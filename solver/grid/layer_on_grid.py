"""A layer on the scale of a grid: its thickness in grid spacings, and its stiffness over the half-space's."""

from collections.abc import Callable

import numpy as np

from ..arrays import Array64
from ..layers import ElasticLayer
from .cached import cached

Modulus = Callable[[Array64], Array64]
"""2K(q)/q over E* for waves q [1/grid spacing]: 1 on the half-space."""

_ALIKE = 0.2
"""Logarithm of the shortest wave's stiffness over the half-space's, up to which a grid resolves a layer."""


@cached
def thickness_on_grid(layer: ElasticLayer, num_points: int, period: float) -> float:
    """d [grid spacings], on a grid of `num_points` in the period L [length]; `inf` for a half-space.

    0 where the grid does not resolve the layer: its shortest wave does not find a half-space. Raises `ValueError`
    where the layer does not know that wave.
    """
    (shortest,) = modulus_on_grid(layer, np.array([np.pi]), num_points, period)
    return layer.thickness / period * num_points if abs(np.log(shortest)) < _ALIKE else 0.0


def modulus_on_grid(layer: ElasticLayer, q: Array64, num_points: int, period: float) -> Array64:
    """2K(q)/(E* q), 1 on the half-space, for wave numbers q > 0 [1/grid spacing], of their shape (dimensionless).

    Waves longer or shorter than those of the grid count as its longest or its shortest one. Raises `ValueError` where
    the layer does not know the grid's waves.
    """
    longest = 2 * np.pi / num_points
    return modulus_anywhere(layer, np.clip(q, longest, longest * (num_points // 2)), num_points, period)


def modulus_anywhere(layer: ElasticLayer, q: Array64, num_points: int, period: float) -> Array64:
    """2K(q)/(E* q) of any waves q > 0 [1/grid spacing], of their shape (dimensionless).

    Raises `ValueError` where the layer does not know them.
    """
    wave_numbers = q * num_points
    return np.asarray(2 * np.asarray(layer.stiffness(wave_numbers, period)) / wave_numbers)
