"""Closed forms and limits, in units L = E* = 1 unless said otherwise; none of them uses a grid.

Sources: half-space power profiles, I. N. Sneddon, Int. J. Eng. Sci. 3, 47 (1965) in its line-contact form; periodic
half-space, K. L. Johnson, Contact Mechanics (1985), chap. 13, after H. M. Westergaard (1939); thin layers, Johnson,
sec. 5.8, and V. L. Popov et al. for the foundation model.
"""

import math
from collections.abc import Callable

import numpy as np

from ..arrays import Array64, gauss_legendre
from ..layers import ElasticLayer
from ..layers.bonded import foundation_compliance
from ..transforms.plain import irfft, rfft


def kappa_half_space(exponent: float) -> float:
    """Area-pressure coefficient kappa_inf(n) of a lone power profile on the half-space (dimensionless).

    sqrt(16/(pi (2n-1))) Gamma(n/2+1)/Gamma(n/2+1/2); 8/(sqrt 3 pi) for n = 2.
    """
    n = exponent
    return math.sqrt(16 / (math.pi * (2 * n - 1))) * _gamma_ratio(n / 2 + 1, n / 2 + 0.5)


def kappa_from_area(exponent: float, area: float, radius: float, reduced_load: float) -> float:
    """kappa = a_r/p* of one centred contact of relative width `area`, without a grid (dimensionless).

    radius: R/L; reduced_load: p/E*. Uses the exact rms slope over |x| < a, g_c = (a/R)^(n-1)/sqrt(2n-1).
    """
    slope = _power(area / 2 / radius, exponent - 1) / math.sqrt(2 * exponent - 1)
    return float(area * slope / reduced_load)


def periodic_line_load(half_width: float, slope: Callable[[Array64], Array64]) -> float:
    """Line load F/(E* L) that presses an even profile to the half-width a/L < 1/2 on the periodic half-space.

    F = E* int_0^a h'(x) sin(pi x/L)/sqrt(sin^2(pi a/L) - sin^2(pi x/L)) dx (Westergaard's problem), made
    smooth by sin(pi x/L) = sin(pi a/L) sin(theta). `slope` maps x/L, shape (M,), to h', shape (M,).
    """
    nodes, weights = gauss_legendre()
    theta = (nodes + 1) * np.pi / 4
    x = np.arcsin(math.sin(math.pi * half_width) * np.sin(theta)) / np.pi
    return float(np.sum(weights * np.pi / 4 * slope(x) * np.tan(np.pi * x)) / np.pi)


def periodic_half_space_area(exponent: float, radius: float, reduced_load: float) -> float:
    """Relative contact area a_r of a power profile on the periodic half-space.

    radius: R/L; reduced_load: p/E*. The profile has a kink at x = L/2, so the load has no finite limit for a -> L/2;
    where a is within 1e-12 of it, 1 is returned.
    """

    def load(a: float) -> float:
        return periodic_line_load(a, lambda x: (x / radius) ** (exponent - 1))

    low, high = 0.0, 0.5
    if load(0.5 * (1 - 1e-12)) < reduced_load:
        return 1.0
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if load(middle) < reduced_load else (low, middle)
    return low + high


def foundation_half_width(reduced_load: float, exponent: float, radius: float, modulus: float) -> float:
    """Half-width a/L of a power profile on a Winkler foundation: p L = 2 k_W R^(1-n) a^(n+1)/(n+1).

    radius: R/L; reduced_load: p/E*; modulus: k_W [E*/L], 0 or `inf` make the half-width `inf` or 0.
    """
    if not 0 < modulus < math.inf:
        return 0.0 if modulus else math.inf
    n = exponent
    return _power(radius, (n - 1) / (n + 1)) * _power(reduced_load * (n + 1) / (2 * modulus), 1 / (n + 1))


def guessed_half_width(load: float, exponent: float, radius: float, layer: ElasticLayer, period: float = 1.0) -> float:
    """Half-width [L]: the half-space's or that of a thin bonded layer, compressible or not (the less stiff), if less.

    On a thin layer with nu = 1/2 a^(n+3) = 2 (n+1)(n+3) d^3 R^(n-1) p L. period: L in the layer's unit of length.
    """
    n = exponent
    foundation = foundation_half_width(load, n, radius, layer.foundation_modulus(period))
    incompressible = _power(2 * (n + 1) * (n + 3) * load, 1 / (n + 3))
    incompressible *= _power(layer.thickness / period, 3 / (n + 3)) * _power(radius, (n - 1) / (n + 3))
    return min(lone_half_width(load, n, radius), max(foundation, incompressible))


def lone_half_width(load: float, exponent: float, radius: float, kappa_ratio: float = 1.0) -> float:
    """Half-width of a lone asperity of the given kappa_d/kappa_inf; 1, the half-space, bounds every layer's."""
    n = exponent
    area = kappa_ratio * kappa_half_space(n) * load * math.sqrt(2 * n - 1) / 2
    return float(area ** (1 / n) * math.exp((n - 1) / n * math.log(radius)))


def thin_layer_alpha(exponent: float) -> float:
    """alpha(n) of kappa_d/kappa_inf = alpha (1-2nu)/(1-nu)^2 d/(a_r L), exact for d -> 0 (dimensionless).

    (n+1) (sqrt(pi)/2) Gamma((n+1)/2)/Gamma(n/2+1): 3 pi/4 for n = 2, 2.1850 for n = 1.5, 2.9453 for n = 4.
    """
    n = exponent
    return (n + 1) * math.sqrt(math.pi) / 2 / _gamma_ratio(n / 2 + 1, (n + 1) / 2)


def thin_layer_kappa_ratio(
    exponent: float, poisson_ratio: float, reduced_thickness: float, edge_shift: float = 0.0
) -> float:
    """kappa_d/kappa_inf of a thin layer at d~ = d/(a_r L) (dimensionless).

    First order for `edge_shift` = 0. With `edge_shift` = c(nu) the half-width a in the thin-layer load becomes a + c d,
    the next order: the load grows by (1 + 2 c d~)^(n+1), or (1 + 2 c d~)^(n+3) for nu = 1/2, at the same area.

    nu < 1/2: alpha(n) (1-2nu)/(1-nu)^2 d~. nu = 1/2: 32 (n+1)(n+3)/(sqrt(2n-1) kappa_inf) d~^3.
    """
    n = exponent
    stretched = 1 + 2 * edge_shift * reduced_thickness
    if poisson_ratio == 0.5:
        limit = 32 * (n + 1) * (n + 3) / math.sqrt(2 * n - 1) / kappa_half_space(n) * reduced_thickness**3
        return float(limit / stretched ** (n + 3))
    limit = thin_layer_alpha(n) * foundation_compliance(poisson_ratio) * reduced_thickness
    return float(limit / stretched ** (n + 1))


def persson_area(reduced_load: float, rms_pressure: float) -> float:
    """Relative contact area by B. N. J. Persson's theory for a random surface (J. Chem. Phys. 115, 3840 (2001)).

    erf(p/(sqrt(2) s)). reduced_load: p/E*; rms_pressure: s/E*, see `full_contact_rms_pressure`. For small loads on the
    half-space a_r = sqrt(8/pi) p/(E* g), g the rms gradient of the whole surface.
    """
    return math.erf(reduced_load / math.sqrt(2) / rms_pressure)


def full_contact_rms_pressure(stiffness: Array64, height: Array64) -> float:
    """Rms of the pressure's variation in full contact [E*].

    stiffness: K(q_k), shape (N//2 + 1,) [E*/L], its mean mode without effect; height: h, shape (N,) [L].
    """
    modes = rfft(height - height.mean())
    return math.sqrt(float(np.mean(irfft(stiffness * modes, height.size) ** 2)))


def _gamma_ratio(a: float, b: float) -> float:
    return math.exp(math.lgamma(a) - math.lgamma(b))


def _power(base: float, exponent: float) -> float:
    """base^exponent for base > 0, cut off before it overflows."""
    return math.exp(min(exponent * math.log(base), 300.0))
