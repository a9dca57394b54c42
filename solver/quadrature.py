"""Gauss-Legendre quadrature, whose nodes are kept because they cost an eigenvalue problem."""

from functools import cache

import numpy as np

from .arrays import Array64


@cache
def gauss_legendre(count: int) -> tuple[Array64, Array64]:
    """Nodes and weights on (-1, 1), shape (count,) each."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights
