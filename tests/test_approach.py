"""Approach instead of pressure, mean gap and contact stiffness."""

import math
import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from linecontact import contact_stiffness
from linecontact import load as load_solution
from linecontact.solver import (
    CoatedHalfSpace,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    SlidingLayer,
    Status,
    solve,
)
from linecontact.solver.grid.problem import Problem
from linecontact.solver.reference import collocation
from linecontact.solver.solve import solve_to_tolerance
from linecontact.solver.strategy.linearised import flat_punch
from linecontact.studies.command_line import main

ROUGH = RoughIndenter(0.8, 0, cut_off_ratio=1 / 16)
LAYERS = [Layer(), Layer(0.1, 0.3), Layer(1e-3, 0.45), Layer(0.01, 0.5), SlidingLayer(0.03), CoatedHalfSpace(0.01, 0.1)]


def mean_height(scene):
    """Above the lowest point, which mostly lies between two nodes."""
    return float(scene.profile.mean()) + scene.indenter.depth_between_nodes(scene.profile)


def random_scene(seed):
    """Any indenter, layer and load; grids of up to 2^12 points."""
    rng = np.random.default_rng(seed)
    n, nu = int(2 ** rng.integers(7, 13)), float(rng.choice([-0.5, 0, 0.25, 0.45, 0.5]))
    thickness = float(10 ** rng.uniform(-4, 1))
    kinds = (
        lambda: Layer(math.inf, nu),
        lambda: Layer(thickness, nu),
        lambda: SlidingLayer(thickness),
        lambda: CoatedHalfSpace(thickness, float(10 ** rng.uniform(-2, 2)), nu),
    )
    layer = kinds[seed % 4]()
    power = PowerIndenter(float(rng.uniform(1.2, 6)), float(10 ** rng.uniform(-1, 1)))
    rough = RoughIndenter(float(rng.uniform(0.2, 1)), seed, cut_off_ratio=min(1.0, 64 / n))
    return Scene(layer, power if rng.random() < 0.5 or n < 1024 else rough, float(10 ** rng.uniform(-5, -0.5)), 1.0, n)


@pytest.mark.parametrize("seed", [*range(40), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(40, 200))])
def test_there_and_back(seed):
    """The approach of a pressure, and the pressure of that approach."""
    scene = random_scene(seed)
    there = solve(scene)
    approach = there.observables.approach
    if there.contact.all():
        return  # see below
    back = solve(replace(scene, pressure=math.nan, approach=approach))
    assert back.status is Status.CONVERGED
    assert back.observables.approach == pytest.approx(approach, rel=1e-9)
    assert back.observables.approach_error == abs(back.observables.approach - approach)
    assert back.certificate.approach_balance == abs(back.observables.approach / approach - 1)
    assert (back.scene.approach, back.choices[0].what) == (None, "pressure")
    # an error of the approach comes back as one of the pressure, times how steep the load is there
    steepness = max(1.0, there.contact_stiffness * approach / scene.pressure)
    assert back.scene.pressure == pytest.approx(scene.pressure, rel=1e-8 * steepness)
    gap = scene.profile - there.displacement
    assert there.observables.mean_gap == pytest.approx(float(gap.mean()), rel=1e-12)


def test_beyond_full_contact_the_foundation_yields():
    scene = Scene(Layer(0.1, 0.3), ROUGH, 10.0, num_points=2**10)
    there = solve(scene)
    assert there.contact.all()
    assert there.observables.mean_gap == pytest.approx(0, abs=1e-15)
    back = solve(replace(scene, pressure=math.nan, approach=there.observables.approach))
    assert back.scene.pressure == pytest.approx(10.0, rel=1e-8)
    assert back.contact_stiffness == pytest.approx(scene.layer.foundation_modulus(1.0), rel=1e-12)
    assert solve(replace(scene, layer=Layer())).contact_stiffness == math.inf


@pytest.mark.parametrize("layer", [Layer(), Layer(0.1, 0.5), CoatedHalfSpace(0.1, 2.0)])
def test_no_pressure_brings_a_half_space_beyond_full_contact(layer):
    mean = mean_height(Scene(layer, ROUGH, num_points=2**10))
    with pytest.raises(ValueError, match=r"approach is .*; allowed: up to .*, the mean height on this grid"):
        solve(Scene(layer, ROUGH, num_points=2**10, approach=1.01 * mean))
    full = solve(Scene(layer, ROUGH, num_points=2**10, approach=mean))
    assert full.status is Status.CONVERGED
    assert full.contact.all()
    assert full.observables.approach == pytest.approx(mean, rel=1e-12)
    less = solve(Scene(layer, ROUGH, num_points=2**10, pressure=0.999 * full.scene.pressure))
    assert not less.contact.all()
    near = solve(Scene(layer, ROUGH, num_points=2**10, approach=0.999 * mean))
    assert near.status is Status.CONVERGED
    assert near.observables.contact_area > 0.9


@pytest.mark.parametrize("method", ["active-set", "mass-weighted-fire"])
def test_every_method_finds_the_pressure(method):
    scene = Scene(Layer(50.0, contact_modulus=7.0), PowerIndenter(2.0, 1e3), period=1e3, num_points=2**10, approach=1.0)
    found = solve(scene, method=method, nested=True, tolerance=1e-8)
    assert found.observables.approach == pytest.approx(1.0, rel=1e-8)
    other_units = solve(Scene(Layer(0.05), num_points=2**10, approach=1e-3))
    assert found.scene.pressure == pytest.approx(7 * other_units.scene.pressure, rel=1e-7)
    assert found.iterations > 0
    assert found.transform_pairs > 0


def test_where_rounding_is_coarse_few_solves_do():
    scene = Scene(Layer(0.1), num_points=2**11, precision="float32", approach=1e-3)
    found = solve(scene)
    assert found.status is Status.CONVERGED
    assert found.observables.approach == pytest.approx(1e-3, rel=1e-3)
    assert int(found.choices[0].reason.rsplit(" ", 1)[1]) <= 8


def test_ctrl_c_while_the_pressure_is_found_on_a_coarse_grid(monkeypatch):
    module = sys.modules["linecontact.solver.solve"]

    def interrupted(run, *rest):
        return replace(solve_to_tolerance(run, *rest), status=Status.INTERRUPTED)

    monkeypatch.setattr(module, "solve_to_tolerance", interrupted)
    with pytest.raises(KeyboardInterrupt):
        solve(Scene(Layer(0.1), num_points=2**14, approach=1e-3))
    assert solve(Scene(Layer(0.1), num_points=2**10, approach=1e-3)).status is Status.INTERRUPTED


def test_the_approach_of_a_scene_is_shown_and_kept_on_other_grids():
    scene = Scene(num_points=2**10, approach=1e-3)
    for shown in (repr(scene), scene._repr_html_()):
        assert "approach" in shown
        assert "nan" not in shown
    assert scene.to_dict()["approach"] == 1e-3
    assert "pressure" not in scene.to_dict()
    assert scene.on_grid(2**9).approach == 1e-3
    assert scene == replace(scene)
    with pytest.raises(ValueError, match=r"accuracy is 0.001; allowed: none for a scene with an approach"):
        solve(scene, accuracy=1e-3)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"pressure": 0.01, "approach": 0.01}, "approach is 0.01, and pressure 0.01; allowed: one of the two"),
        ({"approach": math.inf}, "approach is inf; allowed: a finite length; up to 0 nothing touches"),
        ({"approach": -1e-70}, r"\|approach\|/period is 1e-70; allowed: from 1e-60 to 1e"),
        ({"pressure": "x", "approach": 1e-3}, "approach is 0.001, and pressure 'x'; allowed: one of the two"),
    ],
)
def test_bad_loads_are_named(given, said):
    with pytest.raises(ValueError, match=said):
        Scene(num_points=2**8, **given)


@pytest.mark.parametrize("load", [{"approach": -0.01}, {"approach": 0.0}, {"pressure": 0.0}])
@pytest.mark.parametrize("indenter", [PowerIndenter(), ROUGH])
def test_where_nothing_touches(load, indenter, tmp_path):
    """An answer: no area, no pressure, a flat surface as far from the indenter as the approach says."""
    scene = Scene(Layer(0.1), indenter, num_points=2**10, **load)
    found = solve(scene)
    assert (found.status, found.scene.pressure, found.contact_stiffness) == (Status.CONVERGED, 0, 0)
    assert not found.contact.any()
    assert not found.contact_pressure.any()
    measured = found.observables
    assert measured.contact_area_subgrid == measured.contact_area_error == measured.num_patches == 0
    assert measured.approach == load.get("approach", 0.0)
    assert measured.mean_gap == pytest.approx(mean_height(scene) - measured.approach)
    assert math.isnan(measured.kappa_subgrid)
    assert found.warnings == ()
    found.save(tmp_path / "apart.h5")
    assert found.plot(tmp_path / "apart.png").axes
    stored = load_solution(tmp_path / "apart.h5")
    assert (stored.results["approach"], stored.results["scene.pressure"]) == (measured.approach, 0.0)


def test_just_touching():
    """The load goes to 0 with the approach, and the answer goes over into that without contact."""
    near = solve(Scene(Layer(0.1), num_points=2**10, approach=1e-9))
    assert near.observables.num_patches == 1
    assert near.scene.pressure < 1e-9


def test_the_command_takes_an_approach(capsys):
    assert main.main(["solve", "--approach", "0.001", "--num-points", "2^10"]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"pressure +\W +0\.000\d+ \[pressure\]", shown)
    assert "for the approach of" in shown.replace("\n", " ")
    assert main.main(["solve", "--approach", "1", "--num-points", "2^10"]) == 2
    assert capsys.readouterr().err.startswith("linecontact: approach is 1; allowed: up to 0.041666")


@pytest.mark.parametrize(
    ("layer", "indenter", "load"),
    [
        *((layer, indenter, 0.01) for layer in LAYERS for indenter in (PowerIndenter(), PowerIndenter(1.5), ROUGH)),
        # nodes may pull there
        *((CoatedHalfSpace(0.01, 3e-3), RoughIndenter(0.8, seed, 0.25, 1 / 32), 1e-3) for seed in (0, 2, 3)),
    ],
)
def test_compliance_is_the_derivative_on_the_grid(layer, indenter, load):
    """Against central differences of the approach, over a step that leaves the contact as it is."""
    step = 1e-6
    scene = Scene(layer, indenter, load, num_points=2**11)
    middle = solve(scene, tolerance=1e-12)
    low, high = (solve(replace(scene, pressure=load * (1 + k * step)), tolerance=1e-12) for k in (-1, 1))
    assert (low.contact == high.contact).all()
    rise = high.observables.approach - low.observables.approach
    # the approach of 12 digits, over a difference that leaves 2e-6 of it
    bound = 1e-6 + 2e-15 * middle.observables.approach / rise
    compliance, *_ = flat_punch(Problem.from_scene(scene), middle.contact)
    assert compliance == pytest.approx(rise / (2 * step * load), rel=bound)


@pytest.mark.parametrize("layer", [Layer(), Layer(0.1), Layer(1e-3, 0.3), Layer(1e-3, 0.5)])
def test_contact_stiffness_of_collocation(layer):
    """The sampled pressures do not tell where the contact ends, but the model knows."""
    found = solve(Scene(layer), accuracy=1e-4)
    assert found.method == "collocation"
    if math.isinf(layer.thickness):
        exact = -math.pi / 2 / math.log(math.sin(math.pi * found.observables.contact_area_subgrid / 2))
        assert found.contact_stiffness == pytest.approx(exact, rel=1e-6)
        whole = found.observables.approach + found.observables.mean_gap
        assert whole == pytest.approx(1 / 24, rel=2e-7)  # of the profile, by the trapezium rule
    else:
        fine = solve(Scene(layer, num_points=2**16))
        assert found.contact_stiffness == pytest.approx(fine.contact_stiffness, rel=2e-4)


@pytest.mark.parametrize(("spacings", "most"), [(0.01, 0.05), (0.1, 0.05), (0.5, 0.2), (1.0, 0.25), (2.0, 0.05)])
@pytest.mark.parametrize("width", [1, 5])
def test_contact_stiffness_of_few_nodes_on_thin_layers(spacings, most, width):
    """Under a parabola, beside a grid of 64 times as many points."""
    layer, indenter = Layer(spacings / 512), PowerIndenter(2.0)
    fine = solve(Scene(layer, indenter, approach=(width / 1024) ** 2 / 2, num_points=2**15))
    assert fine.observables.contact_area_subgrid * 512 == pytest.approx(width, rel=0.5)
    coarse = solve(Scene(layer, indenter, fine.scene.pressure, num_points=512))
    assert coarse.contact_stiffness == pytest.approx(fine.contact_stiffness, rel=most)


NODES = (0.4, 0.9, 1.7, 2.6, 5.2, 11.3)
BESIDE = np.linspace(-0.5, 0.45, 7)  # the tip, anywhere between the nodes
WIDE = {(n, share): 1e-7 + 2 / (n * min(share, 1 - share)) ** 2 for n in (2**8, 2**14) for share in (0.1, 0.317, 0.8)}


@pytest.mark.parametrize(
    ("num_points", "share", "places", "most"),
    [
        *((2**8, width / 2**8, BESIDE, 1e-4) for width in NODES),
        *((2**12, width / 2**12, BESIDE, 1e-5) for width in NODES),
        *((*scene, (0.0,), bound) for scene, bound in WIDE.items()),  # second order
    ],
)
def test_contact_stiffness_under_a_sine_wave(num_points, share, places, most):
    """Westergaard: sin^2(pi a/L) = p L/(pi E* D) and d(approach)/dp = -(2 L/(pi E*)) ln sin(pi a/L)."""
    load = math.pi * 0.01 * math.sin(math.pi * share / 2) ** 2
    exact = -2 / math.pi * math.log(math.sin(math.pi * share / 2))
    for beside in places:
        x = (np.arange(num_points) - num_points // 2 - beside) / num_points
        indenter = MeasuredIndenter(0.01 * (1 - np.cos(2 * np.pi * x)), convention="gap")
        solution = solve(Scene(Layer(), indenter, load, num_points=num_points))
        assert 1 / solution.contact_stiffness == pytest.approx(exact, rel=most)
        assert contact_stiffness(solution) == solution.contact_stiffness


@pytest.mark.parametrize(
    ("layer", "spacing", "load", "most"),
    [
        *((layer, 1.0, 2e-3, 2e-5) for layer in (Layer(0.1, 0.3), Layer(0.02, 0.5), SlidingLayer(0.03))),
        (CoatedHalfSpace(0.05, 10.0), 1.0, 2e-3, 2e-5),
        # of few spacings: without the contact's ends between nodes it would be off by 0.3 to 3 %
        *((layer, 2**-12, 2e-4, 2e-3) for layer in (Layer(0.5, 0.3), Layer(3.0, 0.3), Layer(2.0, 0.5))),
        *((layer, 2**-12, 2e-4, 2e-3) for layer in (SlidingLayer(2.0), CoatedHalfSpace(1.0, 50.0))),
    ],
)
def test_contact_stiffness_on_layers(layer, spacing, load, most):
    """Against differences of collocation's approach."""
    layer = layer.in_units(spacing, 1.0)
    low, high = (collocation.solve_layer(layer, load * (1 + step), 2.0, 1.0) for step in (-1e-4, 1e-4))
    solution = solve(Scene(layer, pressure=load, num_points=2**12))
    exact = (high.load - low.load) / (high.approach - low.approach)
    assert solution.contact_stiffness == pytest.approx(exact, rel=most)


@pytest.mark.parametrize(("method", "precision"), [("mass-weighted-fire", "float64"), ("active-set", "float32")])
def test_full_contact_by_its_approach_with_other_methods_and_precisions(method, precision):
    scene = Scene(Layer(), ROUGH, num_points=2**10, precision=precision)
    found = solve(replace(scene, pressure=math.nan, approach=mean_height(scene)), method=method)
    assert found.status is Status.CONVERGED
    assert found.observables.contact_area > 0.99
    assert "least pressure of full contact" in found.choices[0].reason


STEP = MeasuredIndenter(np.repeat([0.02, 0.006, 0.0, 0.03], 2**10), convention="gap")


@pytest.mark.parametrize(
    ("layer", "indenter", "num_points", "share"),
    [
        # near full contact on grids of a few nodes, and beyond it on a layer that is hardly compressible
        (Layer(), PowerIndenter(), 8, 0.9999),
        (Layer(0.01, 0.5), PowerIndenter(), 4, 0.999),
        (CoatedHalfSpace(0.05, 1e-4), PowerIndenter(), 4, 0.9),
        (Layer(0.02, 0.49999999), PowerIndenter(), 64, 3.0),
        # the flat bottom of a step has ripples on coarse grids, and on an incompressible layer one node there sinks in
        # far more: the search ended at a fifth of the approach
        *((Layer(7e-5, 0.5), STEP, 2**12, share) for share in (2e-4, 0.07)),
    ],
)
def test_approaches_that_are_hard_to_find(layer, indenter, num_points, share):
    """Found by users and by a stress test."""
    scene = Scene(layer, indenter, 1.0, num_points=num_points)
    approach = share * float(scene.profile.mean())
    found = solve(replace(scene, pressure=math.nan, approach=approach))
    assert found.status is Status.CONVERGED
    assert found.observables.approach == pytest.approx(approach, rel=1e-8)


def test_a_solve_that_does_not_converge_ends_the_search():
    limited = solve(Scene(Layer(0.1), num_points=2**10, approach=1e-3), max_iterations=2)
    assert limited.status is Status.ITERATION_LIMIT
    assert str(limited.reason).startswith("max_iterations is reached after 2; allowed: more")


def test_with_one_node_left_without_contact_whose_ends_are_not_known_the_stiffness_is_the_grids():
    pressure = 1.1
    scene = Scene(Layer(), pressure=pressure, num_points=2**10)
    here, there = solve(scene), solve(replace(scene, pressure=pressure * (1 + 1e-6)))
    assert (~here.contact).sum() == 1
    rise = there.observables.approach - here.observables.approach
    assert here.contact_stiffness == pytest.approx(1e-6 * pressure / rise, rel=1e-4)


@pytest.mark.parametrize("layer", [Layer(), Layer(0.01, 0.3)])
@pytest.mark.parametrize("pressure", [0.03, 0.6])
def test_errors_at_an_approach_include_that_of_the_pressure(layer, pressure):
    """On a grid with a sixteenth of the points, against the solution whose approach is asked for."""
    beyond = []
    for seed in range(10):
        exact = Scene(layer, RoughIndenter(0.8, seed, 1 / 4, 1 / 16), pressure, num_points=2**14)
        fine = solve(exact).observables
        found = solve(Scene(layer, exact.indenter, approach=fine.approach, num_points=2**10)).observables
        for name in ("contact_area", "kappa", "peak_pressure"):
            value = name if name == "peak_pressure" else f"{name}_subgrid"
            beyond.append(abs(getattr(found, value) - getattr(fine, value)) / getattr(found, f"{name}_error"))
    assert sum(ratio > 1 for ratio in beyond) <= 1  # one surface touches between two nodes, which no estimate knows
    assert 0.02 < max(beyond) < 1.2  # nor are they meaningless


def test_the_approach_of_full_contact_is_that_of_the_surface_between_the_nodes():
    errors = []
    for seed in range(40):
        indenter = RoughIndenter(0.8, seed, 1 / 4, 1 / 16)  # 32 points to the shortest wave
        found = solve(Scene(Layer(), indenter, pressure=3.0, num_points=2**11)).observables
        fine = indenter.profile(2**17, 1.0)
        errors.append(abs(found.approach - fine.mean() + fine.min()))  # the parabola between its nodes: 1e-9
        assert errors[-1] <= found.approach_error + 2e-9
    assert max(errors) < 2e-8
