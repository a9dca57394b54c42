"""The active set: all methods against one another, few transform pairs, cold and warm starts, many patches."""

import itertools
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linecontact.solver import (
    METHODS,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    certify,
    solve,
)
from linecontact.solver.grid import layer_on_grid as grid_response
from linecontact.solver.grid.cached import forget
from linecontact.solver.grid.problem import Problem, foundation_pressure
from linecontact.solver.methods import ExecutionConfig, active_set, relax
from linecontact.solver.methods.active_set import preconditioner as deflation
from linecontact.solver.transforms import plain, planned


def test_patches_that_share_an_unknown_take_longer(monkeypatch):
    """They were taken for a set that rounding does not let be solved: 2^21 of them went to FIRE, for hours."""
    monkeypatch.setattr(deflation, "_unknowns", lambda n: 16)
    teeth = MeasuredIndenter(2e-7 * (np.arange(4097) % 2), convention="gap")
    solution = solve(Scene(Layer(), teeth, 5e-15, num_points=4097))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.iterations < 200


def scenes():
    """Layers of all kinds; power profiles, random roughness and random walks."""
    layers = st.builds(
        Layer,
        st.one_of(st.just(math.inf), st.floats(-3, 0).map(lambda x: 10.0**x)),
        st.floats(-0.9, 0.47),
    )
    rough = st.builds(RoughIndenter, st.floats(0.1, 1), st.integers(0, 99), st.just(0.25), st.floats(0.02, 0.2))
    power = st.builds(PowerIndenter, st.floats(1.3, 5))
    walk = st.integers(0, 99).map(
        lambda seed: MeasuredIndenter(
            1e-2 * np.random.default_rng(seed).standard_normal(1024).cumsum(), convention="gap"
        )
    )
    return st.builds(
        Scene,
        layers,
        st.one_of(power, rough, walk),
        st.floats(-4, -0.5).map(lambda x: 10.0**x),
        num_points=st.just(1024),
    )


@settings(max_examples=30, deadline=None)
@given(scenes())
def test_all_methods_agree(scene):
    solutions = [solve(scene, method=m, nested=n) for m, n in itertools.product(list(METHODS)[:2], (True, False))]
    if isinstance(scene.indenter, PowerIndenter):
        solutions.append(solve(scene, method="fire"))
    problem = Problem.from_scene(scene)
    for solution in solutions:
        assert solution.status is Status.CONVERGED
        certificate, _, _ = certify(problem, solution.displacement / problem.length_unit)
        assert certificate.equilibrium_residual <= 1.01e-8
        assert certificate.energy_error_bound < 1e-9
        assert certificate.force_balance < 1e-6
        # nodes whose pressure is nothing may count or not
        apart = solution.contact != solutions[0].contact
        assert (solution.contact_pressure[apart] < 1e-4 * scene.pressure).all()
        force = solution.contact_pressure - solutions[0].contact_pressure
        assert np.abs(force).max() < 1e-4 * scene.pressure
        assert solution.observables.num_patches >= 1


@pytest.mark.parametrize(("d", "nu"), [(math.inf, 0.25), (0.01, 0.25), (1e-4, -0.9), (1e-2, 0.49), (1e-3, 0.5)])
@pytest.mark.parametrize("indenter", [PowerIndenter(), PowerIndenter(4.0), RoughIndenter(0.8, 3, 0.25, 1 / 32)])
def test_few_pairs_without_help(d, nu, indenter):
    """Nested, to 1e-8, not handed over, in a number of pairs that FIRE needs hundreds for."""
    solution = solve(Scene(Layer(d, nu), indenter, 1e-2, num_points=2**12))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.transform_pairs < 60


def test_pairs_do_not_grow():
    rough = RoughIndenter(0.8, 0, 1 / 8, 1 / 64)
    for indenter, load in ((PowerIndenter(), 2e-3), (rough, 1e-2)):
        pairs = [solve(Scene(indenter=indenter, pressure=load, num_points=n)).transform_pairs for n in (2**14, 2**18)]
        assert pairs[1] < 1.25 * pairs[0]


def test_float32_finds_the_same_area():
    double, single = (solve(Scene(Layer(0.05, 0.3), num_points=2**11, precision=f"float{k}")) for k in (64, 32))
    assert single.status is Status.CONVERGED
    assert single.observables.contact_area_subgrid == pytest.approx(double.observables.contact_area_subgrid, rel=1e-4)


@pytest.mark.parametrize("threads", [1, 2])
def test_nested_grids_round_fire(threads):
    scene = Scene(indenter=RoughIndenter(0.8, 1, 0.25, 1 / 32), pressure=1e-2, num_points=2**12)
    single, nested = (
        solve(scene, method="mass-weighted-fire", nested=choice, threads=threads) for choice in (False, True)
    )
    assert nested.status is single.status is Status.CONVERGED
    assert nested.levels
    assert not single.levels
    assert nested.transform_pairs < single.transform_pairs
    assert nested.observables.contact_area == single.observables.contact_area


@pytest.mark.parametrize(("length", "modulus"), [(1.0, 1.0), (3.7e-5, 2.1e11)])
def test_warm_start_from_a_displacement(length, modulus):
    layer = Layer(0.1 * length, 0.25, modulus)
    scene = Scene(layer, PowerIndenter(2.0, length), 2e-3 * modulus, length, 2**12)
    cold = solve(scene)
    warm = solve(scene, initial=cold.displacement)
    assert warm.iterations == 0
    assert warm.transform_pairs < 2
    assert not warm.levels
    np.testing.assert_array_equal(warm.contact, cold.contact)
    lifted = solve(scene, initial=cold.displacement - length)  # touches nowhere
    assert lifted.status is Status.CONVERGED


def test_thousands_of_patches_share_unknowns():
    heights = 1e-4 * np.random.default_rng(0).standard_normal(2**14)
    solution = solve(
        Scene(indenter=MeasuredIndenter(heights, convention="gap"), pressure=0.5, num_points=2**14), nested=False
    )
    assert solution.status is Status.CONVERGED
    assert solution.observables.num_patches > 1000
    assert not solution.handed_over


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_a_method_that_rests_can_go_on(precision):
    problem = Problem.from_scene(Scene(indenter=RoughIndenter(0.8, 0, cut_off_ratio=1 / 32), num_points=2**12))
    found = []
    for rests in (False, True):
        state = active_set.begin(problem, ExecutionConfig(1e-4, precision))
        assert relax(state, 200) is Status.CONVERGED
        if rests:
            state.rest()
        found.append(state.displacement)
        state.tighten()
        if rests:
            state.rest()
        assert relax(state, 400) is Status.CONVERGED
        found.append(state.displacement)
    for before, after in zip(found[:2], found[2:], strict=True):
        np.testing.assert_array_equal(before, after)


@pytest.mark.parametrize("layer", [Layer(), Layer(0.01, 0.3)])
def test_what_saves_memory_on_large_grids_changes_nothing(layer, monkeypatch):
    scene = Scene(layer, RoughIndenter(0.8, 1), 0.01, num_points=2**16)
    usual = solve(scene)
    forget()
    monkeypatch.setattr(grid_response, "MOST_POINTS", 2**12)
    monkeypatch.setattr(plain, "IN_PLACE", 2**12)
    monkeypatch.setattr(plain, "_TOO_LONG", 2**12)
    saving = solve(scene)
    forget()
    np.testing.assert_array_equal(saving.contact, usual.contact)
    np.testing.assert_allclose(
        saving.contact_pressure, usual.contact_pressure, atol=1e-8 * usual.contact_pressure.max()
    )


def test_json_is_strict():
    scene = Scene(pressure=1e-12, num_points=2**12)  # one node on every grid, with a slope of 0
    record = json.loads(json.dumps(solve(scene).to_dict(), allow_nan=False))
    assert (record["kappa"], record["reduced_pressure"]) == (0.0, "inf")


@pytest.mark.parametrize(("method", "tolerance"), [("mass-weighted-fire", 1e-2), ("active-set", 1e-3)])
def test_a_loose_tolerance_widens_the_error(method, tolerance):
    for points in (2**12, 2**14):
        o = solve(Scene(num_points=points), method=method, tolerance=tolerance).observables
        assert abs(o.contact_area_subgrid - 0.100714056833) < o.contact_area_error
    single = solve(Scene(num_points=2**14, precision="float32")).observables
    assert abs(single.contact_area_subgrid - 0.100714056833) < single.contact_area_error


@pytest.mark.slow
@pytest.mark.parametrize("hurst", [0.8, 0.3])
@pytest.mark.parametrize(("d", "limit"), [(math.inf, 50), (1e-2, 50), (1e-4, 30)])
def test_real_size_rough(hurst, d, limit):
    solution = solve(Scene(Layer(d, 0.25), RoughIndenter(hurst, 0), 1e-2, num_points=2**18))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.transform_pairs < limit
    assert abs(solution.observables.contact_area_subgrid / solution.observables.contact_area - 1) < 0.05


@pytest.mark.slow
def test_thousands_of_patches_whose_sets_would_keep_changing():
    """Eight points to the shortest wave: seven thousand patches disturb each other."""
    n = 2**22
    solution = solve(Scene(indenter=RoughIndenter(0.8, 0, 1 / 8, 64 / n), pressure=1e-2, num_points=n))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.observables.num_patches > 5000


def test_a_flat_profile_starts_in_full_contact():
    wave = MeasuredIndenter(1 - np.cos(2 * np.pi * np.arange(16) / 16), convention="gap")
    flat = replace(Problem.from_scene(Scene(indenter=wave, num_points=16)), height=np.zeros(16))
    np.testing.assert_allclose(foundation_pressure(flat), 1)


@pytest.mark.parametrize("indenter", [PowerIndenter(), RoughIndenter(0.8, 0, 1 / 8, 1 / 32)])
@pytest.mark.parametrize(
    ("precision", "options"),
    [("float64", {}), ("float64", {"threads": 3}), ("mixed", {"method": "mass-weighted-fire"})],
)
def test_transforms_in_four_steps_change_nothing(indenter, precision, options, monkeypatch):
    """Where they take the place of all others, in mixed precision, too."""
    scene = Scene(Layer(0.05), indenter, pressure=0.01, num_points=2**13, precision=precision)
    usual = solve(scene, **options)
    forget()
    monkeypatch.setattr(planned, "FASTER", 2**10)
    found = solve(scene, **options)
    forget()
    assert found.status == usual.status == "converged"
    np.testing.assert_array_equal(found.contact, usual.contact)
    np.testing.assert_allclose(found.displacement, usual.displacement, rtol=0, atol=1e-7 * np.ptp(usual.displacement))
