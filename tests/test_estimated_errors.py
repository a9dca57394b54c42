"""The estimated errors of area, kappa, peak pressure and approach, and an accuracy asked of each of them."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from linecontact import curve
from linecontact.solver import (
    QUANTITIES,
    CoatedHalfSpace,
    Indenter,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    SlidingLayer,
    Status,
    solve,
)
from linecontact.solver.calibration import FITTED
from linecontact.solver.grid.contact import contact_edges
from linecontact.solver.grid.errors import estimated
from linecontact.solver.grid.patches import Patches
from linecontact.solver.grid.problem import Problem
from linecontact.solver.grid.unseen import unseen_gaps, unseen_patches
from linecontact.solver.reference import closed_forms, collocation
from linecontact.studies.command_line import main
from linecontact.studies.files.study_files import load_study

pytestmark = pytest.mark.once

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


def test_of_an_iteration_that_has_hardly_begun_no_error_is_known():
    scene = Scene(Layer(), RoughIndenter(cut_off_ratio=1 / 64), 0.01, num_points=2**12)
    solution = solve(scene, method="fire", nested=False, max_iterations=12)
    assert solution.status is Status.ITERATION_LIMIT
    assert {measured(solution, quantity)[1] for quantity in QUANTITIES.values()} == {math.inf}
    assert "inf" not in " ".join(warning.text for warning in solution.warnings)


@pytest.fixture(scope="module")
def ratios():
    """Error estimated over true error of 60 rough scenes at 2^12 points, by quantity; the truth is that of 2^16."""
    found = {name: [] for name in QUANTITIES}
    for seed in range(60):
        scene = rough_scene(seed)
        coarse, fine = (solve(scene.on_grid(n), tolerance=1e-8) for n in (2**12, 2**16))
        for name, quantity in QUANTITIES.items():
            value, estimate = measured(coarse, quantity)
            found[name].append(estimate / max(abs(value - measured(fine, quantity)[0]), 1e-9 * abs(value)))
    return {name: np.array(values) for name, values in found.items()}


@pytest.mark.parametrize("name", QUANTITIES)
def test_estimates_hold_and_are_not_much_too_large(ratios, name):
    """97 of 100 are meant to hold; of the approach 92 do here. The medians are 10 to 20 times the true error."""
    assert np.mean(ratios[name] >= 1) >= 0.91
    assert np.median(ratios[name]) < 30


@pytest.mark.parametrize("tolerance", [None, 1e-4])
@pytest.mark.parametrize(
    ("thickness", "exponent", "pressure", "num_points"),
    [(1.57775e-06, 1.2, 6.0889e13, 65536), (4.65758e-05, 1.1, 15045014808.5, 30876), (2.12938e-4, 1.5, 2064597, 37733)],
)
def test_pressures_that_hardly_tell_where_a_contact_ends(thickness, exponent, pressure, num_points, tolerance):
    """Below the residual, as on thin incompressible layers, where they rise like a parabola (found by a stress test:
    off by 13 times the estimated error, and by up to 34 grid spacings)."""
    scene = Scene(Layer(thickness, 0.5), PowerIndenter(exponent), pressure, num_points=num_points)
    found = solve(scene, tolerance=tolerance).observables
    exact = solve(scene, tolerance=1e-12).observables
    off = abs(found.contact_area_subgrid - exact.contact_area_subgrid)
    assert off < found.contact_area_error < 150 * off + 3 * exact.contact_area_error


@pytest.mark.parametrize(
    ("thickness", "exponent", "pressure", "num_points", "tolerance"),
    [
        (1e-3, 3, 0.3, 2**15, 1e-5),
        (1e-3, 5, 0.03, 2**15, 1e-3),
        (1e-3, 3, 0.03, 2**15, 1e-3),
        (0.01, 3, 0.3, 2**12, 1e-4),
    ],
)
def test_a_residual_that_is_left_near_the_ends(thickness, exponent, pressure, num_points, tolerance):
    """Below blunt profiles on thin layers: on fine grids a hundred times the rms (found by a stress test: off by up to
    4 times the estimated error)."""
    scene = Scene(Layer(thickness, 0.49), PowerIndenter(exponent), pressure, num_points=num_points)
    solution, exact = solve(scene, tolerance=tolerance), solve(scene, tolerance=1e-11).observables
    assert solution.certificate.largest_residual > 5 * solution.certificate.equilibrium_residual
    found = solution.observables
    off = abs(found.contact_area_subgrid - exact.contact_area_subgrid)
    assert off < found.contact_area_error < 10 * off
    assert abs(found.kappa_subgrid - exact.kappa_subgrid) < found.kappa_error


@pytest.mark.parametrize(
    ("exponent", "radius", "pressure", "num_points", "most"),
    [
        # the nodes see too little of a tip; that, and not the edges, is most of the error of a wide contact
        *((n, 1.0, *scene, 0.03) for n in (1.01, 1.2, 1.5) for scene in ((0.02, 4096), (0.09, 4099), (0.4, 16384))),
        *((n, 1.0, pressure, 256, 1.6) for n, pressure in ((1.2, 1e-6), (1.2, 1e-5), (1.5, 1e-6))),  # one or two nodes
        # sides too steep for the grid: ends off by 1.4 grid spacings together
        (25.8381, 0.40989, 1.36068e-6, 61, 3),
        (28.7836, 0.509115, 3.68724e-8, 81, 3),
        (64.0, 1.0, 1e-6, 256, 3),
        (9.88088, 1.0, 1.9642e-05, 61, 3),  # the gap has the profile's kink, which lets it tell no ends
    ],
)
def test_sharp_tips_and_steep_sides_without_a_coarser_grid(exponent, radius, pressure, num_points, most):
    """Found by soaks: off by 6 to 20 times the estimated error."""
    scene = Scene(Layer(), PowerIndenter(exponent, radius), pressure, num_points=num_points)
    o = solve(scene, nested=False, tolerance=1e-10).observables
    area = closed_forms.periodic_half_space_area(exponent, radius, pressure)
    assert abs(o.contact_area_subgrid - area) < o.contact_area_error < most / num_points


@pytest.mark.parametrize(
    ("num_points", "waves", "gap", "beside"),
    [(4800, 39, 0.033, 0.218), (1979, 39, 0.0555, 0.172), (1024, 17, 0.05, 0), (12833, 119, 0.0169, 0.013)],
)
def test_gaps_of_a_wave_that_hide_between_nodes(num_points, waves, gap, beside):
    """By H. M. Westergaard (1939); area errors of up to 860 times the estimated one were seen there."""
    area = 1 - gap * waves / num_points
    heights = 0.01 + 0.01 * np.cos(2 * np.pi * waves * (np.arange(num_points) - beside) / num_points)
    wave = MeasuredIndenter(heights, convention="gap")
    load = math.pi * 0.01 * waves * math.sin(math.pi * area / 2) ** 2
    solution = solve(Scene(indenter=wave, pressure=load, num_points=num_points))
    value, error = measured(solution, QUANTITIES["contact-area"])
    assert 1e-5 < abs(value - area) < error < 2 * waves / num_points
    exact = -waves * math.pi / (2 * math.log(math.sin(math.pi * area / 2)))
    assert solution.contact_stiffness > exact
    assert any("the contact stiffness is less" in warning.text for warning in solution.warnings)


@pytest.mark.parametrize("num_points", [2**12, 2**14])
@pytest.mark.parametrize("load", [0.9, 0.9999, 1.5])
def test_the_approach_of_a_wave_whose_lowest_point_lies_beside_a_node_of_all_grids(num_points, load):
    """Its derivative with respect to p is -2/pi ln sin(pi a_r/2), with p = pi D sin(pi a_r/2)^2."""
    heights = 0.01 - 0.01 * np.cos(2 * np.pi * (np.arange(num_points) - 0.3) / num_points)
    wave = MeasuredIndenter(heights, convention="gap")
    share = min(load, 1.0)
    true = 0.01 * share * (1 - math.log(share))
    value, error = measured(
        solve(Scene(indenter=wave, pressure=math.pi * 0.01 * load, num_points=num_points)), QUANTITIES["approach"]
    )
    assert 1e-11 < abs(value - true) < error < 1e-5 * true


@pytest.mark.parametrize("half_gap", [10, 30, 60, 120])
@pytest.mark.parametrize("beside", [0.0, 0.3, 0.5])
def test_a_gap_at_a_ridge_that_closes_between_the_nodes(half_gap, beside):
    """The ridge between two parabolas, on a sliding layer."""
    n, pressure = 2**12, {10: 5.6e-5, 30: 5.6e-4, 60: 1.78e-3, 120: 1e-2}[half_gap]
    ridge = Ridge(beside / n, half_gap / n)
    scene = Scene(SlidingLayer(0.01), ridge, pressure, num_points=n)
    (value, error), (fine, _) = (measured(solve(s), QUANTITIES["contact-area"]) for s in (scene, scene.on_grid(16 * n)))
    assert 0.03 / n < abs(value - fine) < error < 2 / n


@pytest.mark.parametrize(("gap", "beside"), [(0.2, 0.0), (0.2, 0.39), (0.7, -0.14), (1.35, 0.01)])
def test_a_gap_between_two_nodes_is_seen(gap, beside):
    """The pressure beside a narrow gap, as it is on a grid without a node in it, wherever between two nodes it lies."""
    pressure = 0.1 * (np.arange(16) - 6.5 - beside) ** 2 - 0.1 * gap**2 / 8
    within, across = np.arange(3, 19), np.append(np.arange(6), np.arange(22, 32))  # the end of the period
    for patches in (Patches.of_nodes(nodes, 32) for nodes in (within, across)):
        assert unseen_gaps(patches, pressure, kinks=True) == pytest.approx(gap)
    for shift in range(16):  # in full contact also across the end of the period
        assert unseen_gaps(Patches.of_nodes(np.arange(16), 16), np.roll(pressure, shift), True) == pytest.approx(gap)
    two = Patches.of_nodes(np.delete(np.arange(17), 7), 32)  # a gap with a node in it is seen already
    assert not unseen_gaps(two, pressure, kinks=True)


# where the period ends, and where the parts meet in which the nodes are looked at
@pytest.mark.parametrize(("n", "shift"), [(16, 0), (16, 5), (16, 15), *((2**15, 2**14 + step) for step in (-1, 0, 1))])
@pytest.mark.parametrize("half_space", [True, False])
def test_a_summit_between_two_nodes_is_seen(half_space, n, shift):
    """It stands out by D = k a^2 [1/4 + ln(2/a)/2], or by k a^2/2 of a foundation."""
    curvature, a = 0.02, 0.2
    stands_out = a**2 * (0.25 + math.log(2 / a) / 2 if half_space else 0.5)
    x = np.minimum(np.abs((np.arange(n) - 0.4 + n / 2) % n - n / 2), 20)
    gap = np.roll(curvature * (x**2 / 2 - stands_out), shift)
    assert gap.min() > 0
    nowhere, flat = Patches.of(np.zeros(n, dtype=bool)), np.zeros(n)
    assert unseen_patches(nowhere, gap, flat, half_space) == pytest.approx(2 * a, rel=1e-3)
    assert not unseen_patches(nowhere, gap + 1.001 * curvature * stands_out, flat, half_space)


def test_rounding_of_the_heights_makes_no_unseen_patches():
    """A profile computed again, of a solution that was stored, differs in its last digits."""
    solution = solve(Scene(indenter=RoughIndenter(0.8, 1, 1.0, 1 / 64), pressure=0.02, num_points=2**10))
    problem, rounded = Problem.from_scene(solution.scene), solution.displacement * (1 - 2**-53)
    known = contact_edges(problem, solution.contact_pressure, solution.displacement)
    assert known.ends.unseen == contact_edges(problem, solution.contact_pressure, rounded).ends.unseen


def test_patches_between_two_nodes_are_in_the_estimated_error():
    """Equal waves under small loads, of which some touch no node; a_r by Westergaard."""
    rng, held = np.random.default_rng(1), {True: [], False: []}
    for _ in range(150):
        waves, share = int(rng.integers(2, 12)), 10 ** rng.uniform(-4.5, -2.5)
        n, depth = round(waves * rng.uniform(6, 40)), 0.01 / waves
        x = (np.arange(n) - rng.uniform()) / n
        indenter = MeasuredIndenter(depth * (1 - np.cos(2 * np.pi * waves * x)), convention="gap")
        found = solve(Scene(Layer(), indenter, share * math.pi * depth * waves, num_points=n)).observables
        off = abs(found.contact_area_subgrid - 2 / math.pi * math.asin(math.sqrt(share)))
        held[found.num_patches < waves].append(off <= found.contact_area_error)
    assert min(map(len, held.values())) > 30
    assert np.mean(held[True]) > 0.85
    assert all(held[False])


def test_what_many_patches_have_in_common_is_estimated():
    """With a hundred patches at 32 points to the shortest wave their common error is most of it (found by a user: half
    of the estimates too small)."""
    beyond = []
    for seed in range(12):
        scene = Scene(indenter=RoughIndenter(0.8, seed, 1 / 8, 1 / 128), pressure=1e-2, num_points=2**15)
        coarse, fine = (solve(scene.on_grid(n)).observables for n in (2**15, 2**18))
        off = abs(coarse.contact_area_subgrid - fine.contact_area_subgrid)
        beyond.append(off / coarse.contact_area_error)
    assert sum(ratio > 1 for ratio in beyond) <= 2
    assert max(beyond) < 2


@pytest.mark.parametrize("indenter", [QUICK_ROUGH, PowerIndenter(4.0)])
def test_an_estimate_is_the_rule_of_its_parts(indenter):
    """sqrt((a c)^2 + [b V/M (s/m)^2]^2 + e^2), also where the last change is small by chance."""
    scene = Scene(Layer(), indenter, 2e-2, num_points=2**14)
    found = solve(scene)
    o, quantity = found.observables, QUANTITIES["peak-pressure"]
    last, before = (replace(o, peak_pressure=share * o.peak_pressure) for share in (1.0 + 1e-9, 1.1))
    nodes = o.contact_area_subgrid * scene.num_points / o.num_patches
    of_nodes = o.peak_pressure / o.num_patches * (indenter.steepness / nodes) ** 2
    for levels, change in (([last, before], 0.1), ([before, last], 0.1 / 16)):
        parts = 0.2 * change * o.peak_pressure, FITTED.of_nodes_in_peak * of_nodes, o.peak_pressure_sampling
        assert estimated(quantity, scene, scene.num_points, o, levels) == pytest.approx(math.hypot(*parts), rel=1e-6)
    assert estimated(quantity, scene, scene.num_points, o, []) == math.inf


KINKED = {
    "at the period's end": lambda x: x**2 / 2,
    "between two patches": lambda x: (np.abs(x) - 0.2) ** 2 / 2,
    "in the contact": lambda x: 0.02 * np.abs(x) + x**2 / 2,
    "of a cusp in the contact": lambda x: np.abs(x) ** 1.5 / 1.5,
}


@pytest.mark.parametrize("kink", KINKED)
@pytest.mark.parametrize("thickness", [math.inf, 0.02])
def test_heights_with_a_kink_are_as_smooth_as_between_kinks(kink, thickness):
    n = 2**11
    coarse, fine = (
        solve(
            Scene(
                Layer(thickness),
                MeasuredIndenter(KINKED[kink](np.arange(m) / m - 0.5), convention="gap"),
                2e-3,
                num_points=m,
            )
        )
        for m in (n, 16 * n)
    )
    assert coarse.scene.indenter.kinked
    value, error = measured(coarse, QUANTITIES["contact-area"])
    assert abs(value - measured(fine, QUANTITIES["contact-area"])[0]) < error < 0.01 * value
    for name in ("kappa", "peak-pressure"):  # at a kink they may have no limit
        assert math.isinf(measured(coarse, QUANTITIES[name])[1])
    assert not MeasuredIndenter(QUICK_ROUGH.profile(n, 1.0), convention="gap").kinked


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
    thin = Scene(Layer(1e-6, 0.25))
    assert solve(thin, accuracy=1e-2, accuracy_of="kappa").method == "winkler-foundation"
    assert solve(thin, accuracy=1e-2, accuracy_of="peak-pressure").method != "winkler-foundation"


@pytest.mark.parametrize("exponent", [2.0, 3.0])
def test_collocation_tells_the_accuracy_of_each(exponent):
    exact = collocation.solve_layer(Layer(0.05, 0.3), 2e-3, exponent, 1.0, 800)
    for name in collocation.MEASURED:
        found, errors = collocation.solve_to_accuracy(Layer(0.05, 0.3), 2e-3, exponent, 1.0, 1e-5, name)
        assert abs(getattr(found, name) / getattr(exact, name) - 1) <= errors[name] <= 1e-5


@pytest.mark.parametrize(
    ("layer", "load", "exponent", "radius", "accuracy"),
    [
        # peak pressures at sharp tips change by less than the rest of their error
        *((Layer(d, 0.3), 2e-3, n, 1.0, 1e-3) for d in (math.inf, 1.0, 0.03) for n in (1.3, 1.5, 2.5)),
        # near full contact areas on 150, 300 and 600 nodes change by 1.3e-3 and -4e-6, not by a quarter and a sixteenth
        (Layer(0.007, 0.25), 50.0, 1.07, 1e-6, 1e-5),
    ],
)
def test_collocation_knows_what_is_left_of_its_errors(layer, load, exponent, radius, accuracy):
    wanted = layer, load, exponent, radius
    fine = collocation.solve_layer(*wanted, 2304)
    found, errors = collocation.solve_to_accuracy(*wanted, accuracy)
    assert abs(found.contact_area / fine.contact_area - 1) <= errors["contact_area"]
    assert abs(found.peak_pressure / fine.peak_pressure - 1) <= errors["peak_pressure"]


@pytest.mark.parametrize("nodes", [1.3, 3.3, 5.3, 7.3, 12.3])
@pytest.mark.parametrize("exponent", [1.5, 2.0, 4.0])
def test_estimates_hold_for_lone_contacts_of_few_nodes(nodes, exponent):
    held, num_points = [], 2**11
    for width in np.linspace(nodes, nodes + 1.5, 6):
        asperity = collocation.solve_layer(Layer(math.inf, 0.3), 1e-4, exponent, 1.0)
        load = 1e-4 * (width / num_points / asperity.contact_area) ** exponent  # on a half-space p ~ a^n
        exact = closed_forms.periodic_half_space_area(exponent, 1.0, load)
        found = solve(Scene(indenter=PowerIndenter(exponent), pressure=load, num_points=num_points)).observables
        held.append(abs(found.contact_area_subgrid - exact) <= found.contact_area_error)
    assert np.mean(held) >= (0.6 if nodes < 3 else 0.8)


def test_a_peak_under_a_stiff_coating_thinner_than_a_spacing_is_not_known():
    """It is at the edge, higher than any node's pressure; the answer to an accuracy of it says that it falls short."""
    layer = CoatedHalfSpace(7.3e-5, base_modulus=1e-4)
    scene = Scene(layer, pressure=2e-7, num_points=2**12)
    assert solve(scene).observables.peak_pressure_error == math.inf
    assert solve(scene, accuracy=1e-2, accuracy_of="peak-pressure").status is Status.INACCURATE
    for thick in (CoatedHalfSpace(0.01, 1e-2), CoatedHalfSpace(7.3e-5, 1e2), Layer(7.3e-5), Layer()):
        assert solve(Scene(thick, pressure=2e-5, num_points=2**12)).observables.peak_pressure_error < math.inf


def test_the_command_line(tmp_path, capsys):
    words = ["--profile", "rough", "--cut-off-ratio", "0.125", "--num-points", "2^13", "--accuracy-of", "kappa"]
    assert main.main(["solve", *words, "--pressure", "0.02", "--accuracy", "0.01"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "chosen for an accuracy of 0.01 of kappa" in said
    assert said.count("its numerical error, estimated") == 4
    values = ["--values", "0.01,0.02", "--folder", str(tmp_path), "--workers", "1"]
    assert main.main(["curve", *words, *values]) == 2
    assert main.main(["curve", *words, *values, "--accuracy", "0.01"]) == 0
    runs = load_study(tmp_path / "curve.h5").runs
    assert all(run["kappa_error"] <= 0.01 * run["kappa_subgrid"] for run in runs)
    assert {run["accuracy_of"] for run in runs} == {"kappa"}
    capsys.readouterr()
    values[3], words[5] = str(tmp_path / "coarse"), "2^10"
    assert main.main(["curve", *words[:-2], *values, "--accuracy", "1e-6"]) == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "2 values are less accurate than asked (1e-06 of the contact area); allowed: more num_points." in said
    columns = curve(Scene(Layer(0.1), num_points=2**12), "pressure", [1e-3], accuracy=1e-3, accuracy_of="approach")
    assert columns["approach_error"][0] <= 1e-3 * columns["approach"][0]


def test_a_peak_between_nodes_that_all_grids_share_is_told():
    """In full contact the largest node is the same on nested grids, and its pressure does not change with them."""
    scene = Scene(indenter=RoughIndenter(0.8, 2, cut_off_ratio=0.0625), pressure=3.0, num_points=2**12)
    coarse, fine = (solve(scene.on_grid(n)).observables for n in (2**12, 2**18))
    assert abs(coarse.peak_pressure - fine.peak_pressure) < coarse.peak_pressure_error < 1e-3 * fine.peak_pressure
    bought = solve(scene.on_grid(2**18), accuracy=1e-5, accuracy_of="peak-pressure").observables
    assert abs(bought.peak_pressure - fine.peak_pressure) < 1e-5 * fine.peak_pressure


@dataclass(frozen=True)
class Wedge(Indenter):
    """h = s |x - c|, periodic: the tip stands a share of a spacing of the finest grid beside a node."""

    beside: float = 0.0

    name: ClassVar[str] = "wedge"

    def profile(self, num_points, period):
        h = 0.1 * np.abs(np.arange(num_points) / num_points - 0.5 + self.beside / 2**14)
        return h - h.min()

    def shortest_wave(self, num_points):
        return 0


@dataclass(frozen=True)
class Ridge(Wedge):
    """Two parabolas of R = L side by side, whose lowest points are `half` of their distance from the ridge."""

    half: float = 0.0

    name: ClassVar[str] = "ridge"

    def profile(self, num_points, period):
        h = (np.abs(np.arange(num_points) / num_points - 0.5 + self.beside) - self.half) ** 2 / 2
        return h - h.min()


@pytest.mark.parametrize("num_points", [2**12, 2**14])
@pytest.mark.parametrize("pressure", [0.002, 0.01, 0.04])
@pytest.mark.parametrize("beside", [0.0, 0.3, 1.5])
def test_kappa_where_slopes_are_differences_across_a_kink(beside, pressure, num_points):
    """Half-space: p/E* = (s/pi) arsinh(tan(pi a/L)), the integral of `closed_forms` for h' = s; kappa = a_r s E*/p."""
    found = solve(Scene(Layer(), Wedge(beside), pressure, num_points=num_points)).observables
    area = 2 * math.atan(math.sinh(10 * math.pi * pressure)) / math.pi
    assert found.contact_area_subgrid == pytest.approx(area, rel=1e-3)
    error = abs(found.kappa_subgrid - area * 0.1 / pressure)
    assert error < found.kappa_error < 0.1 * found.kappa_subgrid


@pytest.mark.parametrize("beside", [0.3, 0.5, 1.5])
@pytest.mark.parametrize("thickness", [0.05, math.inf])
def test_a_tip_between_the_nodes_is_in_the_approach_s_error(beside, thickness):
    """Nested grids share the lowest node, so that no change tells of it; nor does a given approach."""
    scene = Scene(Layer(thickness), Wedge(beside), 0.002, num_points=2**12)
    truth = solve(replace(scene, indenter=Wedge(0.0), num_points=2**16)).observables
    found = solve(scene).observables
    assert abs(found.approach - truth.approach) < found.approach_error < 0.02 * found.approach
    bought = solve(scene.on_grid(2**16), accuracy=1e-3, accuracy_of="approach").observables
    assert abs(bought.approach - truth.approach) < 1e-3 * truth.approach
    pressed = solve(Scene(scene.layer, scene.indenter, approach=truth.approach, num_points=2**12))
    assert abs(pressed.scene.pressure / 0.002 - 1) < pressed.choices[0].error < 0.1


@pytest.mark.parametrize("num_points", [2**10, 2**14])
def test_kappa_of_smooth_own_indenters_is_well_known(num_points):
    class Parabola(Wedge):
        def profile(self, num_points, period):
            return (np.arange(num_points) / num_points - 0.5) ** 2 / 2

    own, known = (
        solve(Scene(Layer(), indenter, 0.002, num_points=num_points)).observables
        for indenter in (Parabola(), PowerIndenter())
    )
    assert abs(own.kappa_subgrid - known.kappa_subgrid) < own.kappa_error < 4 * known.kappa_error


@pytest.mark.parametrize("exponent", [1.02, 1.1, 1.2, 1.35])
def test_peak_pressure_at_sharp_tips(exponent):
    """Half-space: a contact of half-width b spreads what it adds to the load F as dF/(L sqrt(sin^2 b - sin^2 x)/cos b)
    does, b and x in units of L/pi (Westergaard), so that p(0) = int_0^a dF(b)/sin(pi b/L)/L.
    """

    def load(half_width):
        return closed_forms.periodic_line_load(half_width, lambda x: x ** (exponent - 1))

    half_width = closed_forms.periodic_half_space_area(exponent, 1.0, 0.003) / 2
    nodes, weights = np.polynomial.legendre.leggauss(60)
    s, power = (nodes + 1) / 2, 2 / (exponent - 1)  # b = a s^power makes the integrand smooth at the tip
    peak = 0.0
    for at, weight in zip(s, weights / 2, strict=True):
        b = half_width * at**power
        if b > 1e-200:
            rate = (load(1.0001 * b) - load(0.9999 * b)) / (2e-4 * b)
            peak += weight * rate / math.sin(math.pi * b) * b * power / at
    for num_points in (2**12, 2**14, 2**16):
        found = solve(Scene(Layer(), PowerIndenter(exponent), 0.003, num_points=num_points)).observables
        assert abs(found.peak_pressure - peak) < found.peak_pressure_error < 5 * abs(found.peak_pressure - peak)


def test_what_has_no_limit_is_not_known():
    """The peak below a kink, and kappa of a step: the pressure's edges stand where the profile jumps, and its slope
    there grows with the grid."""

    class Step(Wedge):
        def profile(self, num_points, period):
            return np.where(np.abs(np.arange(num_points) / num_points - 0.5) < 0.1, 0.0, 0.3)

    kink, step = (solve(Scene(Layer(), of(), 0.01, num_points=2**14)).observables for of in (Wedge, Step))
    assert kink.peak_pressure_error == math.inf
    assert step.kappa_error > 0.4 * step.kappa_subgrid


def test_a_contact_that_may_split_below_a_tip_between_the_nodes_is_not_known():
    """On 2^10 points and more there are three patches."""
    scene = Scene(CoatedHalfSpace(3.38e-4, 1.48e-4, 0.268, 0.226), PowerIndenter(1.2), 3.669e-5, num_points=2**8)
    found, finer = (solve(one).observables for one in (scene, scene.on_grid(2**14)))
    assert (found.num_patches, finer.num_patches) == (1, 3)
    assert found.contact_area_error == found.kappa_error == found.peak_pressure_error == math.inf
    assert finer.contact_area_error < 3e-4
    full = Scene(CoatedHalfSpace(2 / 2**13, 0.1), PowerIndenter(1.8), 300.0, num_points=2**13)
    assert max(measured(solve(full), quantity)[1] for quantity in QUANTITIES.values()) < math.inf


SPLIT = (
    (4.9504, 4.36e-4, 1.4782, 6.816e-6, 2**12),
    (26.535855705967705, 1.5710749211167414e-4, 1.1414128410761342, 4.47666663732183e-5, 2**13),
)
FIVE_SPACINGS = RoughIndenter(0.97962, 1971399427, 0.188701, 0.278915, 419.746)
NEARLY_FULL = RoughIndenter(0.3, 702364, cut_off_ratio=1 / 4)
SMALL_BESIDE_LARGE = Scene(
    Layer(0.11797911947220245, 0.499),
    RoughIndenter(0.5216199445743808, 546384164, 0.1484276472465341, 0.9624699003674242, 13.161174665479246),
    1.7656690730713824,
    num_points=3254,
)


@pytest.mark.parametrize(
    ("scene", "finer", "patches", "least", "most"),
    [
        # slopes of larger patches beside a small one are those of Hertz contacts only about, and cancel each other
        (SMALL_BESIDE_LARGE, 16, None, 0, math.inf),
        # five spacings thick; the ends stay beside the last nodes
        (Scene(Layer(0.016228, 0.499), FIVE_SPACINGS, 128.091, num_points=286), 16, None, 0, math.inf),
        # near full contact the gap between two nodes may be all that is off
        (Scene(Layer(0.1), NEARLY_FULL, 0.9194363195903827, num_points=512), 8, (2, 3), 0.29, 2),
        # a tip between the nodes leaves the ends of all three patches open
        *(
            (Scene(CoatedHalfSpace(d / n, base), PowerIndenter(exponent), load, num_points=n), 16, (3, 3), 0, 3)
            for d, base, exponent, load, n in SPLIT
        ),
    ],
)
def test_areas_beside_a_finer_grid(scene, finer, patches, least, most):
    """Found by soaks: off by 1.6 to 25 times the estimated error. Limits in grid spacings."""
    n = scene.num_points
    coarse, fine = (solve(one).observables for one in (scene, scene.on_grid(finer * n)))
    found = coarse.num_patches, fine.num_patches
    assert found == patches or (patches is None and found[0] == found[1])
    off = abs(coarse.contact_area_subgrid - fine.contact_area_subgrid)
    allowed = 1 if patches else 2
    assert least / n <= off < allowed * coarse.contact_area_error < most / n


def test_a_narrow_gap_between_wide_patches_ends_where_a_finer_grid_has_it():
    """Of ten layer thicknesses each (found by a user: off by 1.3 grid spacings, 1.5 times the estimated error)."""
    scene = Scene(Layer(0.05), RoughIndenter(0.3, 10, cut_off_ratio=1 / 8), 1.2, num_points=2**11)
    coarse, fine = (solve(one).observables for one in (scene, scene.on_grid(2**14)))
    assert coarse.num_patches == fine.num_patches == 2
    assert abs(coarse.contact_area_subgrid - fine.contact_area_subgrid) < 0.05 / 2**11


@pytest.mark.parametrize("given", [False, True])
def test_peaks_of_one_and_two_nodes(given):
    """Under rough surfaces, as they are known between the nodes and as heights; fine grids have twenty nodes there."""
    few, held = 0, []
    for seed in range(30):
        rough, n = RoughIndenter(0.8, seed, 1 / 8, 1 / 16), 2**11
        layer = (Layer(), SlidingLayer(0.05), Layer(0.1))[seed % 3]
        scene = Scene(layer, rough, 10 ** (-6.5 + seed / 20), num_points=n)
        known = replace(scene, indenter=MeasuredIndenter(rough.profile(n, 1.0), convention="gap")) if given else scene
        solution, fine = solve(known), solve(scene.on_grid(64 * n)).observables
        if solution.patches.nodes.max() <= 2:
            few += 1
            value, error = measured(solution, QUANTITIES["peak-pressure"])
            held.append(abs(value - fine.peak_pressure) <= error < 70 * value)
    assert few > 10
    assert np.mean(held) >= 0.97


def test_a_peak_that_nothing_tells_is_not_resolved():
    """Noise from node to node: nodes tell nothing of what lies between them."""
    noise = MeasuredIndenter(1e-3 * np.random.default_rng(0).random(2**12), convention="gap")
    solution = solve(Scene(indenter=noise, pressure=1e-7, num_points=2**12))
    assert solution.observables.peak_pressure_error == math.inf
    assert any("the peak pressure is not resolved, with 1 node in its" in warning.text for warning in solution.warnings)


@pytest.mark.parametrize(
    ("layer", "exponent", "pressure", "name", "true"),
    [
        (SlidingLayer(0.119914), 2, 2.75e-5, "approach", 6.74252460e-05),
        (SlidingLayer(0.00487228), 4, 8.09e-4, "peak-pressure", 0.0050709990),
        (Layer(0.00495509, 0.100701), 3, 1.101e-4, "approach", 1.113439945e-05),
    ],
)
def test_a_change_that_is_small_by_chance_is_not_believed(layer, exponent, pressure, name, true):
    """True values by collocation; each change between the only two grids is 20 to 140 times smaller than the error."""
    scene = Scene(layer, PowerIndenter(exponent), pressure, num_points=2**11)
    value, error = measured(solve(scene), QUANTITIES[name])
    assert abs(value - true) < error < 5e-3 * true


@pytest.mark.parametrize("num_points", [4, 5, 8, 16])
@pytest.mark.parametrize("exponent", [1.1, 2.0, 3.0])
@pytest.mark.parametrize("over_full", [1.0001, 1.5])
def test_a_full_contact_of_few_nodes_is_not_known(num_points, exponent, over_full):
    """Such a grid calls full what finer ones do not."""
    one = Scene(indenter=PowerIndenter(exponent), pressure=1.0, num_points=num_points)
    scene = replace(one, pressure=over_full * Problem.from_scene(one).full_contact_pressure)
    found, fine = solve(scene).observables, solve(scene.on_grid(2**12)).observables
    assert found.contact_area == 1
    assert abs(found.contact_area_subgrid - fine.contact_area_subgrid) <= found.contact_area_error
    assert abs(found.kappa_subgrid - fine.kappa_subgrid) <= found.kappa_error


@pytest.mark.parametrize("exponent", [1.2, 2.0, 4.0, 20.0])
@pytest.mark.parametrize("num_points", [2**10, 2**14])
def test_kappa_in_full_contact(exponent, num_points):
    """a_r = 1 and the slope's root mean square over the period, (1/2)^(n-1)/sqrt(2n-1) for R = L, over p/E*."""
    scene = Scene(Layer(), PowerIndenter(exponent), 9.0, num_points=num_points)
    found = solve(scene).observables
    kappa = 0.5 ** (exponent - 1) / math.sqrt(2 * exponent - 1) / 9.0
    assert found.contact_area_subgrid == 1
    assert found.kappa_subgrid == pytest.approx(kappa, rel=1e-12)
    assert found.kappa_error < 1e-6 * kappa  # of the iteration
