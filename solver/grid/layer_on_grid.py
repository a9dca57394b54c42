"""A layer on one grid: K of its waves, in real space G = 1/K without the mean mode, the displacement around one loaded
node, and how the pressure ends at the edge of a contact.
"""

import math
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array64
from ..layers import ElasticLayer
from ..layers.layer import own_stiffness
from ..transforms.plain import irfft
from .cached import MOST_POINTS, cached, read_only
from .edge_curves import EdgeCurve, half_space_curve, make_curve
from .split import Split, inverse, make_split

_ALIKE = 0.2
"""Logarithm of the shortest wave's stiffness over the half-space's, up to which a grid resolves a layer."""


def half_spectrum(layer: ElasticLayer, num_points: int, period: float) -> Array64:
    """K(q_k) of a layer for k = 0 ... N/2, shape (N//2 + 1,), in units of E*/L; 0 for the mean mode.

    Raises `ValueError` like `own_stiffness`.
    """
    stiffness = np.zeros(num_points // 2 + 1)
    wave_numbers = 2 * np.pi * np.arange(1, stiffness.size, dtype=np.float64)
    what = f"stiffness of layer {layer.name}"
    stiffness[1:] = own_stiffness(what, "q L", lambda q: layer.stiffness(q, period), wave_numbers, layer)
    return stiffness


def modulus_on_grid(layer: ElasticLayer, q: Array64, num_points: int, period: float) -> Array64:
    """2K(q)/(E* q), 1 on the half-space, for wave numbers q > 0 [1/grid spacing], of their shape (dimensionless).

    Waves longer or shorter than those of the grid count as its longest or its shortest one. Raises `ValueError` where
    the layer does not know the grid's waves.
    """
    longest = 2 * np.pi / num_points
    return _modulus(layer, np.clip(q, longest, longest * (num_points // 2)), num_points, period)


def _modulus(layer: ElasticLayer, q: Array64, num_points: int, period: float) -> Array64:
    """The same of any waves. Raises `ValueError` where the layer does not know them."""
    wave_numbers = q * num_points
    return np.asarray(2 * np.asarray(layer.stiffness(wave_numbers, period)) / wave_numbers)


class LayerOnGrid:
    """A layer on one grid; all but K is made when it is asked for. Raises `ValueError` like `half_spectrum`."""

    def __init__(self, layer: ElasticLayer, num_points: int, period: float) -> None:
        self._layer, self.num_points, self._period = layer, num_points, period
        self.stiffness = half_spectrum(layer, num_points, period)
        """K(q_k), shape (N//2 + 1,) [K], read-only; 0 for the mean mode."""
        self.unit = 2.0 ** math.floor(math.log2(self.stiffness.max()))
        """[K] over E*/L, a power of two, so that the largest K is from 1 to below 2 (dimensionless)."""
        self.stiffness /= self.unit
        self.stiffness.flags.writeable = False
        self.made: dict[Any, Any] = {}
        """Fields and Green's functions that methods have made, by configuration; they serve the next solve."""

    @property
    def reach(self) -> float:
        """What |u| stays below in every solution [u], see `problem`."""
        return 2 * self.num_points / float(self.stiffness[1:].min())

    def modulus(self, q: Array64) -> Array64:
        """See `modulus_on_grid`."""
        return modulus_on_grid(self._layer, q, self.num_points, self._period)

    @cached_property
    def thickness(self) -> float:
        """d [grid spacings]; `inf` for a half-space, 0 where the grid does not resolve the layer: its shortest wave
        does not find a half-space. Raises `ValueError` where the layer does not know that wave.
        """
        (shortest,) = self.modulus(np.array([np.pi]))
        return self._layer.thickness / self._period * self.num_points if abs(np.log(shortest)) < _ALIKE else 0.0

    @cached_property
    def edge_curve(self) -> EdgeCurve:
        """The pressure at the edge of a contact. Raises `ValueError` like `modulus_on_grid`."""
        if self.thickness == math.inf:
            return half_space_curve()
        layer, n, period = self._layer, self.num_points, self._period
        return make_curve(lambda q: np.log(self.modulus(q)), lambda q: np.log(_modulus(layer, q, n, period)))

    @cached_property
    def around_node(self) -> Array64:
        """Displacement around a node by a unit load on it, without its mean, shape (N//2 + 1,) (E* = 1).

        On large grids it has the error of a `split`: some 1e-5 of its largest value, at most 1e-3.
        """
        return read_only(self.num_points / self.unit * self.head(self.num_points // 2 + 1))

    @cached_property
    def compliance(self) -> Array64:
        """G(q_k) = 1/K(q_k), 0 for the mean mode; shape (N//2 + 1,) [1/K]."""
        return read_only(inverse(self.stiffness))

    @cached_property
    def split(self) -> Split | None:
        """Its two parts, see `make_split`."""
        return make_split(self.stiffness, self.num_points)

    @cached_property
    def whole(self) -> Array64:
        """G in real space, shape (N,) [1/K]."""
        return read_only(irfft(self.compliance, self.num_points))

    def head(self, count: int) -> Array64:
        """G on the nodes 0 to count - 1 [1/K]. Where it has two parts it is made of them, with their error, and on
        N//2 + 1 nodes at most.
        """
        return self.split.response(count) if self.split else self.whole[:count]

    @cached_property
    def second_sum(self) -> Array64:
        """T with T(k+1) - 2 T(k) + T(k-1) = G(k), shape (N,), with the error of the two parts where there are any."""
        if self.split:
            return read_only(self.split.second_sum())
        sums = irfft(self.compliance, self.num_points)
        np.cumsum(sums, out=sums)
        sums -= sums.mean()  # so that the second sum is periodic, too
        sums[1:] = np.cumsum(sums[:-1])
        sums[0] = 0
        return read_only(sums)

    def rest(self) -> None:
        """Give back long arrays of a large grid; they are made anew when they are needed."""
        for name in ("compliance", "whole", "second_sum") if self.num_points > MOST_POINTS else ():
            self.__dict__.pop(name, None)


@cached
def layer_on_grid(layer: ElasticLayer, num_points: int, period: float) -> LayerOnGrid:
    """A layer on a grid of `num_points` in the period L [length]. Raises `ValueError` like `half_spectrum`."""
    return LayerOnGrid(layer, num_points, period)
