"""solve(scene, accuracy=...): the models it chooses, their bounds, and that random scenes get what they asked for."""

import dataclasses
import json
import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from linecontact.solver import Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene, Status, solve
from linecontact.solver.methods import DEFAULT
from linecontact.solver.methods.active_set.active_set import ActiveSet
from linecontact.solver.reference import collocation, gradient_equation

pytestmark = pytest.mark.once

ROUGH = RoughIndenter(0.8, 3, 1 / 8, 1 / 16)


def chosen(solution):
    return {choice.what: choice.chosen for choice in solution.choices}


def error(solution, exact):
    return abs(solution.observables.contact_area_subgrid / exact - 1)


def test_a_thick_layer_is_as_accurate_as_a_half_space():
    scene = Scene(Layer(1.8, 0.3), ROUGH, 1e-2, num_points=2**14)
    solution, full = solve(scene, accuracy=1e-3), solve(scene)
    assert solution.status is Status.CONVERGED
    assert solution.observables.approach == pytest.approx(full.observables.approach, rel=1e-3)
    assert error(solution, full.observables.contact_area_subgrid) < 1e-3
    # with a kind of layer so thick that no wave finds its base
    thick, half_space = (solve(Scene(Layer(d)), accuracy=1e-9).observables for d in (100.0, math.inf))
    assert thick.contact_area_subgrid == pytest.approx(half_space.contact_area_subgrid, rel=1e-9)


def test_one_asperity_needs_no_grid():
    solution = solve(Scene(Layer(0.01, 0.25)), accuracy=1e-8)
    assert chosen(solution) == {"model": "collocation", "grid": "4096 points"}
    assert solution.method == "collocation"
    assert solution.certificate is None
    assert solution.to_dict()["certificate"] == {}
    assert error(solution, 0.056514257547) < 1e-8
    assert solution.contact_pressure.mean() == pytest.approx(2e-3, rel=1e-3)
    assert (solution.displacement <= solution.scene.profile).all()
    grid = solve(Scene(Layer(0.01, 0.25), num_points=4096))
    np.testing.assert_allclose(solution.contact_pressure, grid.contact_pressure, atol=0.02 * 2e-3 / 0.05)
    for name in ("kappa_subgrid", "rms_gradient_subgrid", "approach", "peak_pressure"):
        assert getattr(solution.observables, name) == pytest.approx(getattr(grid.observables, name), rel=2e-3), name


@pytest.mark.parametrize("d", [0.01, 1e-7])
def test_units_do_not_matter_to_the_models(d):
    one = solve(Scene(Layer(d, 0.2), num_points=2**12), accuracy=1e-3)
    scene = Scene(Layer(8 * d, 0.2, 4.0), PowerIndenter(2.0, 8.0), 8e-3, period=8.0, num_points=2**12)
    other = solve(scene, accuracy=1e-3)
    assert other.method == one.method
    for name, unit in (("contact_area_subgrid", 1), ("approach", 8), ("peak_pressure", 4)):
        assert getattr(other.observables, name) == pytest.approx(unit * getattr(one.observables, name), rel=1e-9)
    np.testing.assert_allclose(other.displacement, 8 * one.displacement, atol=1e-9 * np.ptp(other.displacement))


@pytest.mark.parametrize("indenter", [PowerIndenter(), PowerIndenter(4.0)])
def test_a_thin_layer_is_a_winkler_foundation(indenter):
    scene = Scene(Layer(1e-6, 0.25), indenter, 2e-2, num_points=2**16)
    solution = solve(scene, accuracy=2e-2)
    assert (solution.method, solution.certificate) == ("winkler-foundation", None)
    o, full = solution.observables, solve(scene).observables
    assert error(solution, full.contact_area_subgrid) <= o.contact_area_error / full.contact_area < 2e-2
    for name, most in (("kappa_subgrid", 0.05), ("approach", 0.05), ("peak_pressure", 0.02)):
        assert getattr(o, name) == pytest.approx(getattr(full, name), rel=most)
    # so thin that no grid sees the contact: 3/2 of the mean pressure in it, a^2/2 deep
    o = solve(Scene(Layer(1e-20)), accuracy=1e-4).observables
    assert o.contact_area_subgrid < 2**-18
    assert o.peak_pressure == pytest.approx(1.5 * 2e-3 / o.contact_area_subgrid)
    assert o.approach == pytest.approx((o.contact_area_subgrid / 2) ** 2 / 2)


def test_what_no_foundation_can_carry():
    """An incompressible layer has none, at 1e-6 its edges count, and a rough surface may not touch as a whole."""
    for nu, indenter, accuracy in ((0.5, PowerIndenter(), 2e-2), (0.25, PowerIndenter(), 1e-6), (0.25, ROUGH, 1e-2)):
        scene = Scene(Layer(1e-6, nu), indenter, 2e-2, num_points=2**16)
        solution = solve(scene, accuracy=accuracy)
        assert (solution.method, chosen(solution)["model"]) == ("active-set", "grid")
        if accuracy > 1e-6:  # which no grid of so many points reaches
            assert solution.status is Status.CONVERGED
            assert error(solution, solve(scene).observables.contact_area_subgrid) < accuracy


@pytest.mark.parametrize("seed", range(6))
def test_the_foundation_is_off_by_no_more_than_estimated(seed):
    """Nor by much less: its edges are a third to a half of the estimate."""
    rng = np.random.default_rng(seed)
    layer = Layer(10 ** rng.uniform(-5, -4), rng.uniform(-0.3, 0.25))
    scene = Scene(layer, PowerIndenter(rng.uniform(1.5, 4)), 10 ** rng.uniform(-1.5, -1), num_points=2**17)
    solution, exact = solve(scene, accuracy=0.1), solve(scene).observables
    assert solution.method == "winkler-foundation"
    estimate = solution.observables.contact_area_error / exact.contact_area_subgrid
    off = error(solution, exact.contact_area_subgrid)
    assert 0.1 * estimate < off <= estimate + exact.contact_area_error / exact.contact_area_subgrid


def test_the_grid_is_the_coarsest_that_will_do():
    scene = Scene(Layer(0.1), ROUGH, 2e-2, num_points=2**16)
    found = [solve(scene, accuracy=accuracy) for accuracy in (2e-2, 2e-3, 1e-5, 1e-8)]
    sizes = [solution.scene.num_points for solution in found]
    assert sizes == sorted(sizes)
    assert sizes[0] < sizes[-1] == 2**16
    assert found[-1].status is Status.INACCURATE
    o = found[-1].observables
    assert o.contact_area_error > 1e-8 * o.contact_area_subgrid
    assert "finest allowed" in {choice.what: choice.reason for choice in found[-1].choices}["grid"]
    # a grid that does not hold the surface is never good enough, whatever it finds
    fine = Scene(Layer(0.1), RoughIndenter(0.8, 3, 1 / 8, 1 / 512), 2e-2, num_points=2**16)
    assert solve(fine, accuracy=0.1).scene.num_points > 2 * fine.indenter.shortest_wave(2**16)


def test_no_measured_roughness_is_left_out():
    """Self-affine down to two grid spacings, or a short wave on a long one: coarse grids see something else."""
    n = 2**14
    x = np.arange(n) / n
    waves = 0.01 * (1 - np.cos(2 * np.pi * x)) + 2e-4 * np.cos(6000 * np.pi * x)
    profiles = [RoughIndenter(hurst, 1, 1 / 8, 1 / 512).profile(n, 1.0) for hurst in (0.3, 0.8)]
    for heights in (*profiles, waves, 1e-3 * np.cos(6000 * np.pi * x)):
        for layer, pressure in ((Layer(0.1, 0.3), 5e-3), (Layer(1e-3, 0.3), 0.1), (Layer(1e-6, 0.3), 0.5)):
            scene = Scene(layer, MeasuredIndenter(heights, convention="gap"), pressure, num_points=n)
            exact = solve(scene).observables.contact_area_subgrid
            for accuracy in (0.1, 1e-2):
                solution = solve(scene, accuracy=accuracy)
                assert solution.status is Status.INACCURATE or error(solution, exact) <= accuracy


@pytest.mark.parametrize("num_points", [16, 18, 1000, 2000, 2046])
def test_small_grids_know_how_little_they_know(num_points):
    fine = 2**15
    for load in (0.02, 0.3):
        rough = RoughIndenter(0.3, 4, 1 / 4, 8 / num_points * (1 + 1e-3))  # two points to the shortest wave
        scene = Scene(Layer(math.inf), rough, load, num_points=num_points)
        exact = solve(Scene(scene.layer, rough, load, num_points=fine)).observables.contact_area_subgrid
        solution = solve(scene, accuracy=5e-2)
        assert solution.status is Status.INACCURATE or error(solution, exact) <= 5e-2
        json.dumps(solution.to_dict(), allow_nan=False)


def test_fields_of_a_tiny_asperity_carry_the_load():
    scene = Scene(Layer(math.inf), PowerIndenter(), 1e-9, num_points=2**18)
    solution = solve(scene, accuracy=1e-3)
    assert solution.contact.sum() >= 16
    assert solution.contact_pressure.mean() == pytest.approx(1e-9, rel=1e-12)
    o = solution.observables
    assert o.contact_area == o.contact_area_subgrid
    assert o.kappa == o.kappa_subgrid
    assert o.kappa_ratio == pytest.approx(1.0, abs=1e-5)
    assert o.reduced_pressure * o.kappa == pytest.approx(o.contact_area)


@pytest.mark.parametrize("options", [{"accuracy": 1e-2}, {"tolerance": 1e-8}])
def test_an_interrupted_iteration_returns_what_there_is(options, monkeypatch):
    """To an accuracy as to a tolerance; and what was interrupted before any iteration passes it on."""
    step, steps = ActiveSet.step, []

    def interrupt(*_):
        raise KeyboardInterrupt

    def interrupted_step(self):
        steps.append(1)
        return interrupt() if len(steps) > 2 else step(self)

    monkeypatch.setattr(ActiveSet, "step", interrupted_step)
    solution = solve(Scene(Layer(0.1), ROUGH, 1e-2, num_points=2**12), **options)
    assert solution.status is Status.INTERRUPTED
    assert str(solution.reason) == "it was interrupted"
    assert solution.contact.any()
    assert solution.displacement.shape == (solution.scene.num_points,)
    monkeypatch.setattr(gradient_equation.System, "__init__", interrupt)
    with pytest.raises(KeyboardInterrupt):
        solve(Scene(Layer(0.1), PowerIndenter(), 1e-2, num_points=2**12), accuracy=1e-2)


def test_an_interruption_on_a_grid_that_does_not_resolve_the_surface_is_passed_on(monkeypatch):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("linecontact.solver.methods.method.time.monotonic", iter(range(100)).__next__)
    with pytest.raises(KeyboardInterrupt):
        solve(Scene(indenter=RoughIndenter(), num_points=2**16), accuracy=1e-2, progress=stop)


def test_an_answer_that_is_less_accurate_than_estimated_goes_on_from_its_grid(monkeypatch):
    """Estimated errors that turn out too large only after certification: no grid is begun twice."""
    sizes, real = [], DEFAULT.begin
    kind = dataclasses.replace(DEFAULT, begin=lambda p, s: sizes.append(p.num_points) or real(p, s))
    monkeypatch.setattr(sys.modules["linecontact.solver.solve"], "DEFAULT", kind)
    monkeypatch.setattr("linecontact.solver.strategy.to_accuracy.estimated", lambda *_: 0.0)
    solution = solve(Scene(Layer(0.1), ROUGH, 2e-2, num_points=2**14), accuracy=2e-3)
    assert sizes == sorted(set(sizes))
    assert sizes[-1] == solution.scene.num_points
    assert len(sizes) > 1


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"accuracy": 1.0}, "accuracy is 1.0"),
        ({"accuracy": 9.99e-10}, "accuracy is 9.99e-10; allowed: 1e-9 <="),
        ({"accuracy": math.nan}, "accuracy is nan"),
        ({"accuracy": "fine"}, "accuracy is 'fine'"),
        ({"accuracy": 1e-3, "method": "fire"}, "method is 'fire'; allowed: without accuracy"),
        ({"accuracy": 1e-3, "tolerance": 1e-3}, "tolerance is 0.001"),
        ({"accuracy": 1e-3, "nested": False}, "nested is False"),
        ({"accuracy": 1e-3, "backend": "cuda"}, "backend is 'cuda'"),
        ({"accuracy": 1e-3, "threads": 0}, "threads is 0"),
        ({"accuracy": 1e-3, "accuracy_of": "width"}, "accuracy_of is 'width'; allowed: contact-area, kappa"),
        ({"accuracy_of": "kappa"}, "accuracy_of is 'kappa'; allowed: together with an accuracy"),
    ],
)
def test_bad_input_is_named(arguments, named):
    with pytest.raises(ValueError, match=named):
        solve(Scene(num_points=2**10), **arguments)
    with pytest.raises(ValueError, match="scene is of type int"):
        solve(3, accuracy=1e-3)
    with pytest.raises(ValueError, match="precision is 'mixed'; allowed: float64"):
        solve(Scene(precision="mixed"), accuracy=1e-3)


def random_scene(rng, rough):
    """A scene, the accuracy asked, and its exact area; half of the rough ones ask much of the finest grid."""
    nu = float(rng.choice([0.5, rng.uniform(-0.5, 0.49)], p=[0.15, 0.85]))
    d = math.inf if rng.random() < 0.15 else 10 ** rng.uniform(-4, 1)
    if rough:
        cut_off = rng.choice([1 / 4, 1 / 32])
        indenter = RoughIndenter(rng.uniform(0.2, 0.95), int(rng.integers(10**6)), 1 / 8, cut_off)
        scene = Scene(Layer(d, nu), indenter, 10 ** rng.uniform(-2, -0.5), num_points=2**14)
        fine = Scene(scene.layer, indenter, scene.pressure, num_points=2**16)
        return scene, 10 ** rng.uniform(-3.5, -1.5), solve(fine).observables.contact_area_subgrid
    exponent = float(rng.choice([1.5, 2, 3, 4, rng.uniform(1.2, 6)]))
    scene = Scene(Layer(d, nu), PowerIndenter(exponent), 10 ** rng.uniform(-5, -1.5), num_points=2**16)
    try:
        exact = collocation.solve_to_accuracy(Layer(d, nu), scene.pressure, exponent, 1.0, 1e-6)[0].contact_area
    except ValueError:  # a thin layer
        exact = solve(replace(scene, num_points=2**19)).observables.contact_area_subgrid
    return scene, 10 ** rng.uniform(-5, -1.5), exact


@pytest.mark.parametrize("count", [40, pytest.param(100, marks=pytest.mark.slow)])
def test_random_scenes_get_the_accuracy_they_asked_for(count):
    """Scenes that nothing was calibrated on: at least 95 of 100."""
    rng, misses = np.random.default_rng(20261121), []
    for i in range(count):
        scene, accuracy, exact = random_scene(rng, rough=i % 2 == 1)
        solution = solve(scene, accuracy=accuracy)
        assert solution.status in (Status.CONVERGED, Status.INACCURATE)
        if error(solution, exact) > accuracy:
            misses.append((scene, accuracy, error(solution, exact), solution.status))
    assert len(misses) <= count / 20, misses


@pytest.mark.parametrize(
    "scene",
    [
        Scene(Layer(1.86e-5, 0.25), PowerIndenter(1.2), pressure=1e-3, num_points=2**14),
        Scene(Layer(1e-6, 0.25), PowerIndenter(), pressure=1e-3, period=2.0, num_points=2**18),
    ],
)
def test_patches_of_smaller_models_are_those_of_the_area(scene):
    found = solve(scene, accuracy=0.05)
    assert found.method != DEFAULT.name
    assert found.patches.width.sum() == pytest.approx(found.observables.contact_area_subgrid * scene.period, rel=1e-9)
    assert found.patches.load.sum() == pytest.approx(scene.pressure * scene.period, rel=1e-9)
    np.testing.assert_allclose(found.patches.right - found.patches.left, found.patches.width, rtol=1e-9)
    assert found.patches.peak_pressure == found.observables.peak_pressure
