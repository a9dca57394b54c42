"""The sliding layer and the coated half-space: K against 60-digit arithmetic, limits, collocation, bad input."""

import math
import warnings

import mpmath
import numpy as np
import pytest
from linecontact.solver import CoatedHalfSpace, Layer, PowerIndenter, RoughIndenter, Scene, SlidingLayer, Status, solve
from linecontact.solver.layers import bonded
from linecontact.solver.reference import collocation

Y = np.concatenate([np.logspace(-12, 8, 61), [0.2, 0.2499, 0.25, 0.9999, 1.0, 1.0001, 24.9, 25.1, 354, 401]])
POISSON_RATIOS = [-0.99, 0.0, 0.25, 0.49, 0.5 - 1e-9, 0.5]


def worst(found, exact):
    return max(abs(float(f / exact(y) - 1)) for f, y in zip(found, Y, strict=True))


def exact_sliding(y):
    with mpmath.workdps(60):
        x = 2 * mpmath.mpf(y)
        return mpmath.mpf(1) if y > 1e4 else (mpmath.sinh(x) + x) / (mpmath.cosh(x) - 1)


def exact_coated(y, nu_1, nu_2, m):
    """Nogi and Kato's form, at 60 digits beyond what cancels."""
    with mpmath.workdps(100):
        y, nu_1, nu_2, m = map(mpmath.mpf, (y, nu_1, nu_2, m))
        kappa = (m - 1) / (m + 3 - 4 * nu_1)
        lam = 1 - 4 * (1 - nu_1) / (1 + m * (3 - 4 * nu_2))
        theta = mpmath.exp(-2 * y)
        return (1 - (lam + kappa + 4 * kappa * y**2) * theta + lam * kappa * theta**2) / (
            1 + 4 * y * kappa * theta - lam * kappa * theta**2
        )


def test_sliding_factor_against_mpmath():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert worst(2 / Y * SlidingLayer(1.0).stiffness(Y, 1.0), exact_sliding) <= 1e-14


@pytest.mark.parametrize("nu_1", POISSON_RATIOS)
@pytest.mark.parametrize("nu_2", [-0.99, 0.3, 0.5])
def test_coated_factor_against_mpmath(nu_1, nu_2):
    for ratio in (1e-6, 1e-3, 0.7, 1.0, 30.0, 1e6):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            factor = 2 / Y * bonded.stiffness(Y, 1.0, nu_1, nu_2, ratio)
        assert worst(factor, lambda y, m=ratio: exact_coated(y, nu_1, nu_2, m)) <= 1e-14


def test_limits_of_the_coated_half_space():
    waves = 2 * np.pi * np.arange(1.0, 1000.0)
    equal = CoatedHalfSpace(0.01, 2.0, 0.3, 0.3, 2.0)
    np.testing.assert_allclose(equal.stiffness(waves, 1.0), waves / 2, rtol=1e-15)
    # the base of 1e6 times the modulus adds a share of about 1e-6/(q d) to the compliance
    rigid = CoatedHalfSpace(0.01, 1e6, 0.3)
    np.testing.assert_allclose(rigid.stiffness(waves, 1.0), Layer(0.01, 0.3).stiffness(waves, 1.0), rtol=1e-4)
    for base in (1e-3, 0.1, 10.0, 1e3):
        thick, thin = (CoatedHalfSpace(d, base, 0.2, 0.4).stiffness(waves[:1], 1.0)[0] for d in (10.0, 1e-9))
        assert thick == pytest.approx(np.pi, rel=1e-14)  # the layer's own half-space, E* q/2
        assert thin == pytest.approx(np.pi * base, rel=1e-5)  # that of the base


def test_limits_of_the_sliding_layer():
    assert SlidingLayer(1e-6).stiffness(np.array([2 * np.pi]), 1.0)[0] == pytest.approx(1e6, rel=1e-9)
    assert SlidingLayer(1e-6).foundation_modulus(1.0) == 1e6
    assert SlidingLayer(math.inf).stiffness(np.array([3.0]), 1.0)[0] == 1.5
    assert SlidingLayer(math.inf).stiffness(3.0, 1.0) == 1.5
    assert SlidingLayer(math.inf).foundation_modulus(1.0) == 0
    below = Layer(1.0, 0.3).stiffness(Y[Y < 10], 1.0) > SlidingLayer(1.0).stiffness(Y[Y < 10], 1.0)
    assert below.all()  # a base that holds the layer makes it stiffer


def _random_layers(kind, count):
    rng = np.random.default_rng(4)
    for _ in range(count):
        thickness = float(10 ** rng.uniform(-2.5, 0))  # 13 grid spacings and more
        if kind == "sliding":
            yield SlidingLayer(thickness)
        else:
            base, *ratios = float(10 ** rng.uniform(-2, 2)), *(float(nu) for nu in rng.uniform(0, 0.5, 2))
            yield CoatedHalfSpace(thickness, base, *ratios)


@pytest.mark.parametrize("exponent", [2.0, 4.0])
@pytest.mark.parametrize("kind", ["sliding", "coated"])
def test_the_grid_agrees_with_collocation(kind, exponent):
    """Edges to 0.01 grid spacings; peak and approach to the order h^2 of the grid, with h = 1/(nodes in contact)."""
    for layer in _random_layers(kind, 10):
        load = 2e-3
        exact = collocation.solve_layer(layer, load, exponent, 1.0)
        o = solve(Scene(layer, PowerIndenter(exponent), load, num_points=2**12)).observables
        off = abs(o.contact_area_subgrid - exact.contact_area)
        assert off < 2 * 0.01 / 2**12, layer
        assert off < 2 * o.contact_area_error, layer
        bound = 200 / (exact.contact_area * 2**12) ** 2
        assert o.peak_pressure == pytest.approx(exact.peak_pressure, rel=bound)
        assert o.approach == pytest.approx(exact.approach, rel=bound)


@pytest.mark.parametrize("spacings", [0.3, 1.0, 3.0])
@pytest.mark.parametrize(
    "layer",
    [SlidingLayer(1.0), CoatedHalfSpace(1.0, 0.02), CoatedHalfSpace(1.0, 50.0), CoatedHalfSpace(1.0, 1.0, 0.5, -0.9)],
)
def test_edges_on_layers_as_thin_as_the_grid_have_honest_errors(layer, spacings):
    n = 2**8
    layer = layer.in_units(spacings / n, 1.0)
    found = solve(Scene(layer, num_points=n), nested=False).observables
    exact = collocation.solve_layer(layer, 2e-3, 2.0, 1.0)
    assert abs(found.contact_area_subgrid - exact.contact_area) < 2 * found.contact_area_error


@pytest.mark.parametrize("layer", [SlidingLayer(0.01), CoatedHalfSpace(0.01, 0.1, 0.5), CoatedHalfSpace(1e-5, 100.0)])
def test_rough_surfaces_on_other_layers(layer):
    scene = Scene(layer, RoughIndenter(0.8, 0, cut_off_ratio=1 / 32), 1e-2, num_points=2**14)
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    slow = solve(scene, method="mass-weighted-fire", nested=True, tolerance=1e-7)
    assert slow.observables.contact_area_subgrid == pytest.approx(solution.observables.contact_area_subgrid, rel=1e-4)
    cheap = solve(scene, accuracy=1e-2)
    off = abs(cheap.observables.contact_area_subgrid / solution.observables.contact_area_subgrid - 1)
    assert off < 1e-2
    scaled = solve(Scene(layer.in_units(8.0, 2.0), scene.indenter.in_units(8.0), 2e-2, 8.0, 2**14)).observables
    assert scaled.contact_area_subgrid == pytest.approx(solution.observables.contact_area_subgrid, rel=1e-9)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: SlidingLayer(0.0), "thickness is 0.0; allowed: a length > 0, or inf"),
        (lambda: SlidingLayer(0.1, -1), "contact_modulus is -1; allowed: a finite pressure > 0"),
        (lambda: CoatedHalfSpace(math.inf, 1.0), "thickness is inf; allowed: a finite length > 0"),
        (lambda: CoatedHalfSpace(0.1, 0.0), "base_modulus is 0.0; allowed: a finite pressure > 0"),
        (
            lambda: CoatedHalfSpace(0.1, 1e7),
            r"base_modulus is 10000000.0; allowed: from 1e-06 to 1e\+06 of the layer's",
        ),
        (lambda: CoatedHalfSpace(0.1, 1.0, 0.6), "poisson_ratio is 0.6; allowed: -1 < nu <= 0.5"),
        (lambda: CoatedHalfSpace(0.1, 1.0, 0.5, -1.0), "base_poisson_ratio is -1.0; allowed: -1 < nu <= 0.5"),
    ],
)
def test_bad_numbers_are_named(make, said):
    with pytest.raises(ValueError, match=said):
        make()


def test_a_thin_coating_of_the_same_material_is_no_reason_to_warn():
    assert not solve(Scene(CoatedHalfSpace(1e-4, 1.0), num_points=2**12)).warnings


@pytest.mark.parametrize(
    ("layer", "ratio"),
    [
        (lambda: Layer(0.1, None), "poisson_ratio"),
        (lambda: CoatedHalfSpace(0.1, 2.0, None), "poisson_ratio"),
        (lambda: CoatedHalfSpace(0.1, 2.0, base_poisson_ratio=None), "base_poisson_ratio"),
    ],
)
def test_only_sliding_layers_do_without_a_poisson_ratio(layer, ratio):
    with pytest.raises(ValueError, match=f"^{ratio} is None; allowed: -1 < nu <= 0.5"):
        layer()
