"""The stiffness against 60-digit arithmetic and its limits."""

import warnings

import mpmath
import numpy as np
import pytest
from linecontact.solver import Layer
from linecontact.solver.grid.layer_on_grid import half_spectrum

POISSON_RATIOS = [-0.99, -0.5, 0.0, 0.25, 0.4, 0.45, 0.49, 0.4999, 0.5 - 1e-6, 0.5 - 1e-12, 0.5]


def stiffness(num_points, thickness, nu):
    return half_spectrum(Layer(thickness, nu), num_points, 1.0)


def exact_factor(y: float, nu: float) -> mpmath.mpf:
    """The textbook form at 60 digits beyond what cosh needs."""
    with mpmath.workdps(60):
        y, nu = mpmath.mpf(y), mpmath.mpf(nu)
        if y > 1e4:
            return mpmath.mpf(1)  # exp(-2e4) is far below 60 digits
        return ((3 - 4 * nu) * mpmath.cosh(2 * y) + 2 * y**2 - 4 * nu * (3 - 2 * nu) + 5) / (
            (3 - 4 * nu) * mpmath.sinh(2 * y) - 2 * y
        )


@pytest.mark.parametrize("nu", POISSON_RATIOS)
def test_layer_factor_against_mpmath(nu):
    y = np.concatenate([np.logspace(-12, 8, 121), [0.2, 0.2499, 0.25, 0.9999, 1.0, 1.0001, 354, 356, 399, 401]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        factor = 2 / y * Layer(1.0, nu).stiffness(y, 1.0)
    worst = max(abs(float(f / exact_factor(v, nu) - 1)) for f, v in zip(factor, y, strict=True))
    assert worst <= 1e-14


@pytest.mark.parametrize("nu", [-0.9, 0.0, 0.3, 0.49])
def test_long_waves_feel_the_winkler_foundation(nu):
    # K = k_W (1 + O((q d)^2/(1-2nu))): at q d = 2 pi 1e-6 the correction is below 1e-9
    k = stiffness(16, 1e-6, nu)[1]
    assert k == pytest.approx(Layer(1e-6, nu).foundation_modulus(1.0), rel=1e-8)


def test_incompressible_long_waves():
    d = 1e-5
    q = 2 * np.pi
    assert stiffness(16, d, 0.5)[1] == pytest.approx(3 / (4 * q**2 * d**3), rel=1e-8)  # correction O((q d)^2)
    assert Layer(d, 0.5).foundation_modulus(1.0) == np.inf
    assert Layer(np.inf, 0.25).foundation_modulus(1.0) == 0
