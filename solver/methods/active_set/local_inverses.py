"""Approximate inverses of the response G on the contact, patch by patch.

G is a Toeplitz matrix, so all patches share one inverse Cholesky factor, whose leading m x m block serves a patch of m
nodes (`inverse_cholesky`).

For longer patches K restricted to the patch, by a short transform, is nearly the inverse: K_bb >= G_bb^-1, and K_bb
G_bb has the spectrum 1 except one outlier for each edge (3 to 11 on the half-space). Both are deflated with K_bb 1 and
K_bb x; 1 to 1.4 is left. Where K is short-ranged it is applied on a ring little longer than the patch: its part that
reaches around the ring makes single values down to 0.6 on the half-space, 0.3 on layers. G needs a ring that is twice
as long.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import cached_property

import numpy as np

from ...arrays import Array64, Indices, Mask
from ...grid.patches import Patches
from .greens_function import GreensFunction

LONGEST_DENSE = 256  # nodes; the factor of longer patches costs more than short transforms


Block = tuple[Array64, Indices, Mask]
"""Runs of similar size: the inverse Cholesky factor of a Toeplitz matrix on the longest of them, the compact indices of
their nodes and which of these there are, both shape (runs, width)."""


def blocks_of(runs: Patches, chosen: Mask, factor: Callable[[int], Array64]) -> Iterator[Block]:
    """The chosen runs of nodes, shape (runs,), by their size. factor: the inverse factor of at least an order."""
    widths = np.where(chosen, np.maximum(8, 2 ** np.ceil(np.log2(runs.size)).astype(np.int64)), 0)
    for width in np.unique(widths[chosen])[::-1]:  # the longest first, whose factor serves the others
        alike = np.flatnonzero(widths == width)
        width = int(runs.size[alike].max())
        mask = np.arange(width) < runs.size[alike, None]
        # outside of a run: the slot behind the last node
        index = np.where(mask, runs.offset[alike, None] + np.arange(width), runs.nodes.size)
        yield factor(width)[:width, :width], index, mask


def invert_blocks(blocks: Iterable[Block], residual: Array64) -> Array64:
    """The inverse times a residual on the nodes of the blocks, 0 on the others; both in compact order."""
    padded = np.append(residual, 0.0)
    z = np.zeros_like(padded)
    for factor, index, mask in blocks:
        z[index] = ((padded[index] @ factor.T) * mask) @ factor * mask
    return z[:-1]


class LongPatch:
    """Approximate inverse of G on a patch of m nodes, by short transforms."""

    def __init__(self, green: GreensFunction, size: int) -> None:
        self.size = size
        self._around, self._along = around, along = green.around(size), green.along(size)
        # 1 is even and x is odd on the patch, and both operators keep that: one transform for the two
        self._basis = _even_and_odd(along(along.rigidity, 1 + np.linspace(-1, 1, size)))
        self._image = _even_and_odd(around(around.compliance, self._basis.sum(axis=0)))
        self._inverse = np.linalg.inv(self._basis @ self._image.T)

    def solve(self, residual: Array64) -> Array64:
        """About G_bb^-1 residual, shape (m,); symmetric and positive definite."""
        along = self._along
        coarse = self._inverse @ (self._basis @ residual)
        z = along(along.rigidity, residual - coarse @ self._image)
        return np.asarray(z + (coarse - self._inverse @ (self._image @ z)) @ self._basis)

    @cached_property
    def flat_punch(self) -> Array64:
        """About G_bb^-1 1, shape (m,), by a few steps of conjugate gradients."""
        x, r = np.zeros(self.size), np.ones(self.size)
        d, before = np.zeros(self.size), 1.0
        for _ in range(4):
            z = self.solve(r)
            rz = float(r @ z)
            d = z + rz / before * d
            before = rz
            image = self._around(self._around.compliance, d)
            step = rz / float(d @ image)
            x += step * d
            r -= step * image
            if np.abs(r).max() < 0.03:
                break
        return x


def _even_and_odd(values: Array64) -> Array64:
    """The even and the odd part of values on a patch, shape (2, m)."""
    return np.stack([values + values[::-1], values - values[::-1]]) / 2


class PatchByPatch:
    """Every patch on its own."""

    def __init__(self, green: GreensFunction, patches: Patches) -> None:
        self._patches, short = patches, patches.size <= LONGEST_DENSE
        self._blocks = list(blocks_of(patches, short, green.factor))
        by_size = {size: LongPatch(green, size) for size in set(patches.size[~short].tolist())}
        self._long = {p: by_size[int(patches.size[p])] for p in np.flatnonzero(~short).tolist()}

    @property
    def punch(self) -> Array64:
        """The pressure of a flat punch on every patch, for a displacement of 1; in compact order."""
        punch = self(np.ones(self._patches.nodes.size))
        for p, long in self._long.items():
            if self._patches.count > 1:  # the only patch keeps its load anyway
                punch[self._part(p)] = long.flat_punch
        return punch

    def _part(self, patch: int) -> slice:
        start = self._patches.offset[patch]
        return slice(start, start + self._patches.size[patch])

    def __call__(self, residual: Array64) -> Array64:
        """About G_bb^-1 residual on every patch b, in compact order."""
        z = invert_blocks(self._blocks, residual)
        for p, long in self._long.items():
            z[self._part(p)] = long.solve(residual[self._part(p)])
        return z
