"""Stiffness K(q) of the layer, in a form that neither overflows nor cancels.

Convention: u(x) = sum_k u_k exp(i q_k x) with q_k = 2 pi k/L; the elastic pressure of mode k is K(q_k) u_k. `numpy.fft`
and FFTW's unnormalised transforms agree with it up to the factor 1/N on the way back. Only k = 0 ... N/2 are kept (half
spectrum); at k = N/2 the value is K(pi N/L). The mean mode has K = 0: the mean pressure is p by force balance, so area
and pressure do not depend on the layer's mean compression, which `observables` adds to the approach.

    K(q) = (E* q/2) f(q d),  f(y) = [(3-4nu) cosh 2y + 2y^2 - 4nu(3-2nu) + 5] / [(3-4nu) sinh 2y - 2y]

(Carbone and Mangialardi, J. Mech. Phys. Solids 56, 684 (2008); the published study's eq. 4.) As it stands, cosh
overflows at q d = 355 and the denominator cancels for small q d as nu -> 1/2. With x = 2y and both parts times exp(-x),

    numerator   = (3-4nu) (1 + e^-2x)/2 + (x^2/2 + 5 - 12nu + 8nu^2) e^-x
    denominator = (2-4nu) (1 - e^-2x)/2 + (sinh x - x) e^-x,

every term is positive; sinh x - x comes from its series where it would cancel.
"""

import numpy as np
from numpy.typing import NDArray

Array64 = NDArray[np.float64]

_SERIES_BELOW = 2.0
_SERIES_TERMS = 13  # (2^2)^13/27! < 1e-20 of the first term


def layer_factor(y: Array64, poisson_ratio: float) -> Array64:
    """f(y), the layer's stiffness over the half-space's, for y = q d > 0 of any size; shape of `y`, dimensionless."""
    x = 2 * np.asarray(y, dtype=np.float64)
    nu = poisson_ratio
    with np.errstate(under="ignore"):
        e = np.exp(-x)
        e2 = np.exp(-2 * x)
        # beyond x = 800 the product is 0 in float64; the clip keeps x^2 from overflowing
        numerator = (3 - 4 * nu) * (1 + e2) / 2 + (np.minimum(x, 800.0) ** 2 / 2 + (5 - 12 * nu + 8 * nu**2)) * e
        denominator = (2 - 4 * nu) * -np.expm1(-2 * x) / 2 + _sinh_minus_argument(x, e, e2)
    return np.asarray(numerator / denominator)


def _sinh_minus_argument(x: Array64, e: Array64, e2: Array64) -> Array64:
    """(sinh x - x) exp(-x)."""
    small = np.minimum(x, _SERIES_BELOW)
    series = np.ones_like(small)
    for m in range(_SERIES_TERMS, 0, -1):
        series = 1 + small * small / ((2 * m + 2) * (2 * m + 3)) * series
    return np.where(x < _SERIES_BELOW, small**3 / 6 * series * e, (1 - e2) / 2 - np.minimum(x, 800.0) * e)


def stiffness(num_points: int, thickness: float, poisson_ratio: float) -> Array64:
    """K(q_k) for k = 0 ... N/2, shape (N//2 + 1,), in units of E*/L; `thickness` in units of L, `inf` = half-space.

    K[0] = 0, see above.
    """
    q = 2 * np.pi * np.arange(num_points // 2 + 1, dtype=np.float64)
    k = q / 2
    if np.isfinite(thickness):
        k[1:] *= layer_factor(q[1:] * thickness, poisson_ratio)
    return k


def foundation_modulus(thickness: float, poisson_ratio: float) -> float:
    """Winkler modulus k_W = E* (1-nu)^2/((1-2nu) d), the limit K(0) for nu < 1/2, in units of E*/L.

    0 for the half-space, `inf` for nu = 1/2.
    """
    if poisson_ratio == 0.5:
        return np.inf
    return (1 - poisson_ratio) ** 2 / ((1 - 2 * poisson_ratio) * thickness)
