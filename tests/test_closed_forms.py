"""Closed forms against mpmath and against each other."""

import mpmath
import numpy as np
import pytest
from linecontact.solver.layers.bonded import edge_shift
from linecontact.solver.reference import closed_forms as cf
from linecontact.solver.reference import collocation


@pytest.mark.parametrize("n", [1.1, 1.5, 2.0, 3.3, 4.0, 20.0])
def test_coefficients_against_mpmath(n):
    m = mpmath.mpf(n)
    kappa = mpmath.sqrt(16 / (mpmath.pi * (2 * m - 1))) * mpmath.gamma(m / 2 + 1) / mpmath.gamma(m / 2 + 0.5)
    alpha = (m + 1) * mpmath.sqrt(mpmath.pi) / 2 * mpmath.gamma((m + 1) / 2) / mpmath.gamma(m / 2 + 1)
    assert cf.kappa_half_space(n) == pytest.approx(float(kappa), rel=1e-13)
    assert cf.thin_layer_alpha(n) == pytest.approx(float(alpha), rel=1e-13)


def test_known_values():
    assert cf.kappa_half_space(2) == pytest.approx(8 / (np.sqrt(3) * np.pi), rel=1e-14)
    assert cf.thin_layer_alpha(2) == pytest.approx(3 * np.pi / 4, rel=1e-14)
    assert [cf.periodic_half_space_area(n, 1.0, 2e-3) for n in (1.5, 2, 4)] == pytest.approx(
        [0.03471835, 0.10071406, 0.47054576], abs=6e-9
    )


def test_periodic_load_against_mpmath():
    def exact(a, n):
        def f(theta):
            x = mpmath.asin(mpmath.sin(mpmath.pi * a) * mpmath.sin(theta)) / mpmath.pi
            return x ** (n - 1) * mpmath.tan(mpmath.pi * x) / mpmath.pi

        return float(mpmath.quad(f, [0, mpmath.pi / 4, mpmath.pi / 2]))

    for a, n in ((0.05, 2), (0.2, 1.5), (0.45, 4)):
        assert cf.periodic_line_load(a, lambda x, n=n: x ** (n - 1)) == pytest.approx(exact(a, n), rel=1e-9)


def test_westergaard_is_the_periodic_load_of_a_sinusoid():
    amplitude, area = 0.01, 0.3
    load = cf.periodic_line_load(area / 2, lambda x: 2 * np.pi * amplitude * np.sin(2 * np.pi * x))
    assert load == pytest.approx(np.pi * amplitude * np.sin(np.pi * area / 2) ** 2, rel=1e-12)


def test_far_apart_contacts_do_not_feel_the_period():
    # images change the load of a small contact by O(a^2): pi^2 a^2/4 for n = 2
    area = cf.periodic_half_space_area(2, 1.0, 1e-8)
    assert cf.kappa_from_area(2, area, 1.0, 1e-8) == pytest.approx(cf.kappa_half_space(2), rel=(np.pi * area) ** 2)


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.25, 0.4, 0.45, 0.4999, 0.5])
def test_edge_shift_against_mpmath(nu):
    def integrand(s):
        s, n = mpmath.mpf(s), mpmath.mpf(nu)
        above = (3 - 4 * n) * mpmath.cosh(2 * s) + 2 * s**2 - 4 * n * (3 - 2 * n) + 5
        factor = above / ((3 - 4 * n) * mpmath.sinh(2 * s) - 2 * s)
        limit = 4 * s**2 / 3 if nu == 0.5 else (1 - 2 * n) / (1 - n) ** 2
        return mpmath.log(2 / (s * factor) / limit) / s**2

    with mpmath.workdps(40):
        exact = -mpmath.quad(integrand, [1e-8, 1e-3, 1e-2, 0.1, 1, 10, 100, 1e4]) / mpmath.pi
        exact -= integrand(1e-8) * mpmath.mpf(1e-8) / mpmath.pi
        s, power = mpmath.mpf(1e4), 3 if nu == 0.5 else 1  # beyond, C = 2/s
        exact -= (integrand(s) * s**2 - power) / s / mpmath.pi
    # the integrand below `first` is taken as constant: 1e-3 of 1e-6 of its size
    assert edge_shift(nu) == pytest.approx(float(exact), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.4, 0.45])
def test_second_order_of_the_thin_layer(nu):
    # what is left after the edge shift falls faster than d~^2, so at d~ = 0.01 it is far below the first correction
    errors = []
    for t in (0.02, 0.01):
        _, exact = collocation.solve_reduced_thickness(2e-3, 2.0, 1.0, t, nu)
        second = cf.thin_layer_kappa_ratio(2.0, nu, t, edge_shift(nu))
        first = cf.thin_layer_kappa_ratio(2.0, nu, t)
        errors.append(abs(second / exact.kappa_ratio - 1))
        assert errors[-1] < 0.05 * abs(first / exact.kappa_ratio - 1)
    assert errors[1] < errors[0] / 4 + 1e-6


def test_incompressible_thin_layer():
    _, exact = collocation.solve_reduced_thickness(2e-3, 2.0, 1.0, 0.01, 0.5)
    assert cf.thin_layer_kappa_ratio(2.0, 0.5, 0.01, edge_shift(0.5)) == pytest.approx(exact.kappa_ratio, rel=5e-4)
    assert cf.thin_layer_kappa_ratio(2.0, 0.5, 0.01) == pytest.approx(60 * np.pi * 1e-6, rel=1e-12)
