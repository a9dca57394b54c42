"""Stiff coatings, and the sets that are solved by elimination."""

import numpy as np
import pytest
from linecontact.solver import (
    CoatedHalfSpace,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    solve,
)
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods.active_set.greens_function import GreensFunction


@pytest.mark.parametrize(
    ("thickness", "base", "pressure"), [(3e-3, 1e-3, 1e-4), (3e-3, 1e-5, 1e-2), (1e-3, 1e-4, 1e-3)]
)
@pytest.mark.parametrize("num_points", [2**9, 2**11, 2**13])
def test_noise_under_a_stiff_coating(num_points, thickness, base, pressure):
    """Every node's pressure is felt by all others, and sets on the way are too ill-conditioned to be iterated on."""
    heights = 1e-3 * np.random.default_rng(num_points).standard_normal(num_points)
    scene = Scene(
        CoatedHalfSpace(thickness, base), MeasuredIndenter(heights, convention="gap"), pressure, num_points=num_points
    )
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    assert solution.certificate.equilibrium_residual < 3e-8  # of which rounding leaves 1e-8
    assert solution.certificate.energy_error_bound < 1e-9


@pytest.mark.parametrize(("thickness", "base", "pressure", "hurst"), [(1e-3, 5e-5, 1e-5, 0.5), (2e-3, 1e-5, 1e-3, 0.8)])
def test_a_rough_surface_under_a_stiff_coating(thickness, base, pressure, hurst):
    """The coarser grid's few hundred nodes grow into thousands unless few are added at a time; the certificate is met
    at once, although the longest waves are a million times as compliant as the shortest.
    """
    scene = Scene(CoatedHalfSpace(thickness, base), RoughIndenter(hurst, 1), pressure, num_points=2**15)
    solution = solve(scene)
    assert (solution.status, solution.handed_over) == (Status.CONVERGED, False)
    assert solution.certificate.equilibrium_residual <= 1e-8
    assert solution.certificate.energy_error_bound < 1e-12


def test_where_elimination_fails_conjugate_gradients_go_on(monkeypatch):
    scene = Scene(Layer(0.01), PowerIndenter(), 1e-2, num_points=2**11)
    expected = solve(scene)
    monkeypatch.setattr(GreensFunction, "solve", lambda *_, **__: None)
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    np.testing.assert_array_equal(solution.contact, expected.contact)


def test_a_singular_set_has_no_pressure():
    problem = Problem.from_scene(Scene(num_points=2**10))
    green = GreensFunction(problem.layer)
    assert green.solve(np.array([3, 3]), np.zeros(2)) is None
