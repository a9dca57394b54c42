"""The estimated errors of area, kappa, peak pressure and approach, and an accuracy asked of each of them."""

import math

import numpy as np
import pytest
from linecontact.solver import (
    QUANTITIES,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    solve,
)
from linecontact.solver.reference import collocation
from linecontact.solver.strategy.errors import estimated

QUICK_ROUGH = RoughIndenter(0.8, 3, 1 / 8, 1 / 8)


def measured(solution, quantity):
    """Value and estimated error."""
    return getattr(solution.observables, quantity.value), getattr(solution.observables, quantity.error)


def rough_scene(seed):
    """On 2^12 points with 64 to the shortest wave."""
    rng = np.random.default_rng([41, seed])
    thickness = math.inf if rng.random() < 0.3 else float(10 ** rng.uniform(-4, 0))
    indenter = RoughIndenter(float(rng.uniform(0.3, 0.9)), seed, 1 / 8, 1 / 8)
    return Scene(Layer(thickness, float(rng.uniform(-0.3, 0.5))), indenter, float(10 ** rng.uniform(-2.5, -0.5)))


@pytest.fixture(scope="module")
def ratios():
    """Error estimated over true error of 60 rough scenes at 2^12 points, by quantity; the truth is that of 2^16."""
    found = {name: [] for name in QUANTITIES}
    for seed in range(60):
        scene = rough_scene(seed)
        coarse, fine = (solve(scene.on_grid(n), tolerance=1e-8) for n in (2**12, 2**16))
        for name, quantity in QUANTITIES.items():
            value, claimed = measured(coarse, quantity)
            found[name].append(claimed / max(abs(value - measured(fine, quantity)[0]), 1e-9 * abs(value)))
    return {name: np.array(values) for name, values in found.items()}


@pytest.mark.parametrize("name", QUANTITIES)
def test_estimates_hold_and_are_not_much_too_large(ratios, name):
    """97 of 100 are meant to hold; the medians are 10 times the true error for the area, 48 and 56 for the others."""
    assert np.mean(ratios[name] >= 1) >= 0.93
    assert np.median(ratios[name]) < {"contact-area": 13, "kappa": 13}.get(name, 80)


def test_few_points_to_the_shortest_wave_are_told():
    """The same edges and changes are worth less there, and patches are too narrow, 0.1 spacings each at 16 points."""
    quantity = QUANTITIES["contact-area"]
    coarse, fine = (
        Scene(indenter=RoughIndenter(0.8, 0, 1 / 8, ratio), pressure=0.02, num_points=2**12)
        for ratio in (1 / 32, 1 / 8)
    )
    found = solve(coarse)
    estimates = [estimated(quantity, scene, 2**12, found.observables, found.levels) for scene in (coarse, fine)]
    common = [0.1 * found.observables.num_patches / 2**12 * (16 / w) ** 1.5 for w in (16, 64)]
    random = [math.sqrt(e**2 - c**2) for e, c in zip(estimates, common, strict=True)]
    assert random[0] == pytest.approx(2 * random[1])
    smooth = MeasuredIndenter(np.cos(2 * np.pi * np.arange(2**12) / 2**12))
    assert smooth.effective_wave(2**12) == 1  # not the shortest that the values could hold
    rough = MeasuredIndenter(RoughIndenter(0.8, 0, 1 / 8, 1 / 32).profile(2**12, 1.0))
    assert rough.effective_wave(2**12) == pytest.approx(256, rel=0.02)


@pytest.mark.parametrize("name", QUANTITIES)
@pytest.mark.parametrize("scene", [Scene(Layer(0.1), num_points=2**14), Scene(Layer(0.1), QUICK_ROUGH, 2e-2)])
def test_an_accuracy_is_that_of_what_was_asked(name, scene):
    scene, quantity = scene.on_grid(2**14), QUANTITIES[name]
    truth = measured(solve(scene.on_grid(2**17), tolerance=1e-8), quantity)[0]
    sizes = []
    for accuracy in (2e-2, 1e-3):
        solution = solve(scene, accuracy=accuracy, accuracy_of=name)
        value, error = measured(solution, quantity)
        assert solution.status is Status.CONVERGED
        assert (solution.accuracy, solution.accuracy_of) == (accuracy, name)
        assert abs(value / truth - 1) <= accuracy
        assert error <= accuracy * abs(value)
        sizes.append(solution.scene.num_points)
    assert sizes == sorted(sizes)
    assert solution.to_dict()["accuracy_of"] == name


def test_peak_pressure_at_a_sharp_tip_is_not_collocation_s():
    """h ~ |x|^1.5: the pressure has a cusp, which collocation's nodes miss, and grids approach slowly."""
    scene = Scene(indenter=PowerIndenter(1.5), num_points=2**14)
    assert solve(scene, accuracy=1e-2).method == "collocation"
    solution = solve(scene, accuracy=1e-2, accuracy_of="peak-pressure")
    assert solution.method == "active-set"
    finer = solve(scene.on_grid(2**20)).observables.peak_pressure
    value, error = measured(solution, QUANTITIES["peak-pressure"])
    assert abs(value - finer) < error


def test_smaller_models_stand_in_for_what_they_know_only():
    thick, thin = Scene(Layer(1.8, 0.3), QUICK_ROUGH, 1e-2, num_points=2**12), Scene(Layer(1e-6, 0.25))
    assert any(c.chosen == "half-space" for c in solve(thick, accuracy=1e-2).choices)
    assert not any(c.chosen == "half-space" for c in solve(thick, accuracy=1e-2, accuracy_of="approach").choices)
    assert solve(thin, accuracy=1e-2, accuracy_of="kappa").method == "winkler-foundation"
    assert solve(thin, accuracy=1e-2, accuracy_of="peak-pressure").method != "winkler-foundation"


@pytest.mark.parametrize("exponent", [2.0, 3.0])
def test_collocation_tells_the_accuracy_of_each(exponent):
    exact = collocation.solve_load(2e-3, exponent, 1.0, 0.05, 0.3, 800)
    for name in collocation.MEASURED:
        found, errors = collocation.solve_to_accuracy(2e-3, exponent, 1.0, 0.05, 0.3, 1e-5, name)
        assert abs(getattr(found, name) / getattr(exact, name) - 1) <= errors[name] <= 1e-5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"accuracy_of": "kappa"}, "accuracy_of is 'kappa'; allowed: together with an accuracy"),
        ({"accuracy": 1e-2, "accuracy_of": "width"}, "accuracy_of is 'width'; allowed: contact-area, kappa"),
    ],
)
def test_bad_input(options, message):
    with pytest.raises(ValueError, match=message):
        solve(Scene(num_points=64), **options)
