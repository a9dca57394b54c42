"""Collocation: against the periodic closed form, against itself with more nodes, against a physical identity."""

import numpy as np
import pytest
from linecontact.solver import CoatedHalfSpace, Layer
from linecontact.solver.reference import closed_forms, collocation, gradient_equation


@pytest.mark.parametrize("load", [1e-6, 2e-3, 5e-2])
@pytest.mark.parametrize("n", [2.0, 4.0])
def test_half_space_closed_form(n, load):
    exact = closed_forms.periodic_half_space_area(n, 1.0, load)
    assert collocation.solve_layer(Layer(np.inf, 0.3), load, n, 1.0).contact_area == pytest.approx(exact, rel=1e-11)


def test_reference_values():
    cases = [(np.inf, 0.100714056833), (0.1, 0.094482408562), (0.01, 0.056514257547)]
    for d, area in cases:
        assert collocation.solve_layer(Layer(d, 0.25), 2e-3, 2.0, 1.0).contact_area == pytest.approx(area, abs=1e-12)


@pytest.mark.parametrize("nu", [-0.5, 0.45, 0.5])
@pytest.mark.parametrize("d", [1.0, 1e-2, 1e-3])
def test_more_nodes_change_nothing(nu, d):
    coarse = collocation.solve_layer(Layer(d, nu), 2e-3, 2.0, 1.0)
    fine = collocation.solve_layer(Layer(d, nu), 2e-3, 2.0, 1.0, num_nodes=4 * coarse.t.size)
    assert coarse.contact_area == pytest.approx(fine.contact_area, rel=1e-9)
    assert coarse.peak_pressure == pytest.approx(fine.peak_pressure, rel=1e-8)
    assert coarse.approach == pytest.approx(fine.approach, rel=1e-8)


@pytest.mark.parametrize(("d", "nu"), [(0.1, 0.25), (0.01, 0.25), (0.05, 0.5)])
def test_shorter_period_of_thin_layers_changes_nothing(d, nu, monkeypatch):
    """A layer thinner than L/60 is solved with a shorter period; forcing the full one must give the same."""
    short = collocation.solve_layer(Layer(d, nu), 2e-3, 2.0, 1.0)
    monkeypatch.setattr(gradient_equation, "_DECAY", 1e9)
    full = collocation.solve_layer(Layer(d, nu), 2e-3, 2.0, 1.0)
    assert short.contact_area == pytest.approx(full.contact_area, rel=1e-11)
    assert short.approach == pytest.approx(full.approach, rel=1e-10)


def test_load_is_the_derivative_of_energy():
    """dF/da > 0 and dF = (dF/d(approach)) d(approach): the stiffness of a flat punch of the same width, d = inf.

    For the periodic half-space d(approach)/dF = -(2/pi) ln sin(pi a/L)/(E* L) (mean frame), exact.
    """
    low, high = (collocation.solve_layer(Layer(np.inf, 0.0), p, 2.0, 1.0) for p in (1.999e-3, 2.001e-3))
    compliance = (high.approach - low.approach) / (high.load - low.load)
    a = (low.half_width + high.half_width) / 2
    # central difference: error O(dp^2/p^2) = 2.5e-7 relative
    assert compliance == pytest.approx(-2 / np.pi * np.log(np.sin(np.pi * a)), rel=1e-6)


def test_a_contact_that_splits_is_refused_and_thin_layers_are_not():
    with pytest.raises(
        ValueError, match=r"load is 0.002; allowed: one under which the contact does not split.*tension"
    ):
        collocation.solve_layer(CoatedHalfSpace(0.0555, 7.1e-6, -0.9, 0.0), 2e-3, 1.5, 1.0)
    for layer in (Layer(1e-3, 0.25), Layer(1e-2, 0.49), Layer(1e-2, 0.5), CoatedHalfSpace(0.1, 10.0)):
        assert collocation.solve_layer(layer, 2e-3, 2.0, 1.0).pressure.min() >= 0
