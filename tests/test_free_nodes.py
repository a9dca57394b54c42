"""The search by displacements, where much of the period is in contact, beside that by pressures."""

import numpy as np
import pytest
from linecontact.solver import (
    CoatedHalfSpace,
    Layer,
    PowerIndenter,
    RoughIndenter,
    Scene,
    SlidingLayer,
    Status,
    solve,
)
from linecontact.solver.grid.patches import Patches
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods import ExecutionConfig, active_set, relax
from linecontact.solver.methods.active_set.active_set import ActiveSet
from linecontact.solver.methods.active_set.free_nodes import FreeNodes, gap_by_gap
from linecontact.solver.methods.active_set.greens_function import GreensFunction
from linecontact.solver.transforms.plain import irfft

TOLERANCE = 1e-9
ROUGH = RoughIndenter(0.8, 0, cut_off_ratio=1 / 16)
LAYERS = [Layer(), Layer(0.1, 0.3), Layer(1e-3, 0.25), SlidingLayer(0.03), CoatedHalfSpace(0.01, 10.0)]


def begin(problem, share, **setting):
    return active_set.begin(problem, ExecutionConfig(TOLERANCE, contact_share=share, **setting))


def both(scene, **setting):
    """The problem solved by pressures and by displacements, from the same start."""
    problem = Problem.from_scene(scene)
    found = [begin(problem, share, **setting) for share in (0.0, 0.5)]
    assert [type(one) for one in found] == [ActiveSet, FreeNodes]
    for one in found:
        one.start_from_pressure((problem.height < np.median(problem.height)).astype(float))
        assert relax(one, 2000) is Status.CONVERGED
    return found


@pytest.mark.parametrize("layer", LAYERS, ids=lambda layer: layer.name)
@pytest.mark.parametrize("pressure", [0.2, 0.7])
def test_both_forms_find_the_same_contact(layer, pressure):
    scene = Scene(layer, ROUGH, num_points=2**12)
    scene = Scene(layer, ROUGH, pressure * Problem.from_scene(scene).full_contact_pressure, num_points=2**12)
    by_pressure, by_displacement = both(scene)
    for one, other in zip(*((x.contact_pressure, x.displacement) for x in (by_pressure, by_displacement)), strict=True):
        np.testing.assert_allclose(one, other, atol=100 * TOLERANCE * np.abs(one).max())
    np.testing.assert_array_equal(by_pressure.contact_pressure > 0, by_displacement.contact_pressure > 0)


def test_it_begins_with_the_nodes_that_carry_the_pressure():
    """Also where others penetrate, because that pressure is only about right."""
    problem = Problem.from_scene(Scene(Layer(), ROUGH, 0.3, num_points=2**12))
    exact = begin(problem, 0.5)
    exact.start_from_pressure(np.zeros(2**12))
    assert relax(exact, 2000) is Status.CONVERGED
    rough = exact.contact_pressure * np.random.default_rng(0).uniform(0.9, 1.1, 2**12)
    state = begin(problem, 0.5)
    state.start_from_pressure(rough)
    np.testing.assert_array_equal(~state._free, rough > 0)
    assert relax(state, 2000) is Status.CONVERGED
    np.testing.assert_array_equal(state.contact_pressure > 0, exact.contact_pressure > 0)
    assert state.iteration < exact.iteration


def test_the_backends_agree():
    scene = Scene(Layer(0.1), ROUGH, 0.5, num_points=2**12)
    warp, numpy = (both(scene, backend=backend)[1] for backend in ("warp", "numpy"))
    assert warp.iteration == numpy.iteration
    np.testing.assert_allclose(warp.displacement, numpy.displacement, rtol=1e-12, atol=1e-15)


def test_the_preconditioner_inverts_a_short_gap_exactly():
    problem = Problem.from_scene(Scene(Layer(0.1, 0.3), num_points=2**10))
    free = np.zeros(2**10, dtype=bool)
    free[100:180] = True
    column, nodes = irfft(problem.stiffness, 2**10), np.arange(80)
    force = np.random.default_rng(0).standard_normal(80)
    green = GreensFunction(problem.layer)
    found = gap_by_gap(green, Patches.of(free))(force)
    np.testing.assert_allclose(found, np.linalg.solve(column[abs(nodes[:, None] - nodes)], force), rtol=1e-9)


def test_full_contact_and_nearly_full_contact():
    scene = Scene(Layer(0.1), ROUGH, num_points=2**12)
    full = Problem.from_scene(scene).full_contact_pressure
    for part in (1.01, 0.999):
        found = solve(Scene(Layer(0.1), ROUGH, part * full, num_points=2**12))
        assert found.status is Status.CONVERGED
        assert found.contact.all() == (part > 1)
        assert not found.handed_over


def test_what_cannot_go_on_is_taken_over_by_pressures(monkeypatch):
    scene = Scene(Layer(), ROUGH, 0.3, num_points=2**12)
    expected = solve(scene)
    assert expected.observables.contact_area > 0.3
    monkeypatch.setattr(FreeNodes, "_iterate", lambda self, force: False)
    found = solve(scene)
    assert found.status is Status.CONVERGED
    np.testing.assert_array_equal(found.contact, expected.contact)


@pytest.mark.parametrize("start", ["nothing", "no pressure", "displacement"])
def test_it_may_begin_anywhere(start):
    scene = Scene(Layer(0.1), ROUGH, 0.5, num_points=2**12)
    state = begin(Problem.from_scene(scene), 0.5)
    assert state.displacement.max() == 0
    if start == "no pressure":
        state.start_from_pressure(np.zeros(2**12))
    elif start == "displacement":
        state.start(np.full(2**12, -1.0))
    assert relax(state, 2000) is Status.CONVERGED
    np.testing.assert_array_equal(state.contact_pressure > 0, solve(scene).contact)


def test_near_rounding_it_tries_harder():
    scene = Scene(Layer(), PowerIndenter(2.0), num_points=2**13)
    scene = Scene(Layer(), PowerIndenter(2.0), 0.95 * Problem.from_scene(scene).full_contact_pressure, num_points=2**13)
    found = solve(scene, tolerance=1e-13)
    assert found.status is Status.CONVERGED
    assert not found.handed_over


def test_a_start_that_hardly_touches_keeps_a_contact():
    problem = Problem.from_scene(Scene(Layer(), ROUGH, 0.5, num_points=2**12))
    state, start = begin(problem, 0.5), np.full(2**12, -1e3)
    start[7] = problem.height[7]
    state.start(start)
    for _ in range(300):
        state.step()
        assert not state.stopped or state.contact_pressure.any()
        if state.stopped:
            break
    assert np.isfinite(state.displacement).all()
