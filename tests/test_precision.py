"""Precision as a choice: the floor of float32 is predicted, and mixed precision is as good as float64."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linecontact.solver import (
    CoatedHalfSpace,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    certify,
    solve,
)
from linecontact.solver.display import rounded_up
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods import relax
from linecontact.solver.methods.mass_weighted_fire import MassWeightedFire
from linecontact.solver.solve import float32_floor
from linecontact.solver.transforms.planned import plan_transforms


@given(st.floats(1e-300, 1e300))
def test_a_bound_of_two_digits_is_not_below_the_number(value):
    assert value <= float(rounded_up(value)) <= 1.12 * value


def hertz(thickness=math.inf, poisson_ratio=0.25, num_points=2**10, **changes):
    return Scene(Layer(thickness, poisson_ratio), num_points=num_points, **changes)


@pytest.mark.parametrize("scene", [hertz(0.1, 0.25, 2**12), hertz(1e-3, 0.5, 2**14), hertz(num_points=2**16)])
def test_the_floor_of_float32_is_predicted(scene):
    """FIRE stagnates within a factor of four of it; a tolerance below it is refused."""
    floor = float32_floor(Problem.from_scene(scene))
    single = replace(scene, precision="float32")
    low = solve(single, method="mass-weighted-fire", tolerance=1.01 * floor, max_iterations=1)
    transforms = plan_transforms(scene.num_points, "float32")
    state = MassWeightedFire(Problem.from_scene(single), transforms, 1e-3 * floor)
    relax(state, 1200)
    reached = certify(state.problem, state.displacement)[0].equilibrium_residual
    assert 0.25 * floor < reached < 4 * floor
    assert low.choices == ()
    with pytest.raises(ValueError, match=f"tolerance is .*allowed: at least {rounded_up(floor)}, "):
        solve(single, tolerance=0.1 * floor)


FIRES = ("fire", "mass-weighted-fire")
MIXED_SCENES = [
    hertz(num_points=2**12),
    hertz(1e-3, 0.5, 2**12),
    hertz(0.01, 0.49, 3070),
    Scene(Layer(0.05, 0.3), RoughIndenter(0.8, 0, 1 / 8, 1 / 16), 2e-2, num_points=2**12),
]


@pytest.mark.parametrize("method", FIRES)
@pytest.mark.parametrize("scene", MIXED_SCENES)
def test_mixed_equals_float64_to_its_certificate(method, scene):
    double, mixed = (solve(replace(scene, precision=p), method=method, tolerance=1e-10) for p in ("float64", "mixed"))
    assert double.status is mixed.status is Status.CONVERGED
    assert mixed.certificate.equilibrium_residual <= 1e-10
    np.testing.assert_array_equal(mixed.contact, double.contact)
    # the pressure's error is the residual's, times at most the preconditioned condition (about 10), at any node
    atol = 20 * math.sqrt(scene.num_points) * 1e-10 * scene.pressure
    np.testing.assert_allclose(mixed.contact_pressure, double.contact_pressure, rtol=0, atol=atol)


def test_the_active_set_works_in_float64_where_mixed_is_asked_for():
    double, mixed = (solve(replace(MIXED_SCENES[3], precision=p), method="active-set") for p in ("float64", "mixed"))
    np.testing.assert_array_equal(mixed.displacement, double.displacement)


def test_mixed_reaches_what_float32_cannot():
    scene = hertz(num_points=2**12, precision="mixed")
    floor = float32_floor(Problem.from_scene(scene))
    for method in FIRES:
        assert solve(scene, method=method, tolerance=1e-3 * floor).status is Status.CONVERGED
    hopeless = solve(scene, method="mass-weighted-fire", tolerance=2e-14)
    assert hopeless.status is Status.STAGNATED
    assert hopeless.certificate.equilibrium_residual < 1e-10


@pytest.mark.parametrize(
    ("exponent", "thickness", "pressure", "num_points", "most"),
    [
        (4, 0.001, 0.057, 2**14, 2e-4),
        (8, 0.001, 0.027, 2**14, 3e-4),
        (8, 0.01, 0.0079, 2**12, 3e-3),
        (3, 0.001, 0.0006, 2**14, 2e-4),
    ],
)
def test_rounding_to_float32_is_in_the_estimated_errors(exponent, thickness, pressure, num_points, most):
    scene = Scene(Layer(thickness, 0.3), PowerIndenter(exponent), pressure, num_points=num_points)
    single, double = (
        solve(replace(scene, precision=precision, num_points=points)).observables
        for precision, points in (("float32", num_points), ("float64", 4 * num_points))
    )
    assert abs(single.contact_area_subgrid - double.contact_area_subgrid) < single.contact_area_error
    assert abs(single.kappa_subgrid - double.kappa_subgrid) < single.kappa_error
    assert single.kappa_error < most * single.kappa_subgrid


def test_what_float32_does_not_settle_says_which_precision_may():
    scene = Scene(CoatedHalfSpace(1e-3, 1e-4), RoughIndenter(0.8, 0, 1 / 8, 1 / 64), 1e-3, num_points=2**13)
    failed = solve(replace(scene, precision="float32"))
    assert failed.status in (Status.STAGNATED, Status.ITERATION_LIMIT)
    assert ", or precision mixed or float64" in str(failed.reason)
    assert solve(scene).status is Status.CONVERGED


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_images_whose_squares_float32_does_not_hold():
    """Two nodes on a very thin incompressible layer (found by a soak)."""
    heights = np.full(3**10, 5.9875e-4)
    heights[[14434, 21842]] = 0
    indenter, layer = MeasuredIndenter(heights, convention="gap"), Layer(9.62222e-11, 0.5)
    scene = Scene(layer, indenter, 0.00037680477703036416, num_points=3**10, precision="mixed")
    assert solve(scene).status is Status.CONVERGED
