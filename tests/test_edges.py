"""Sub-grid edges: the closed form against measured places, areas against collocation, and their estimated error."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from edge_formulas import edge_function, edge_offset
from linecontact import studies
from linecontact.solver import (
    CoatedHalfSpace,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    Scene,
    SlidingLayer,
    TabulatedLayer,
    solve,
)
from linecontact.solver.grid import edges
from linecontact.solver.grid.edge_curves import half_space_curve
from linecontact.solver.grid.edges import find_edges
from linecontact.solver.grid.layer_on_grid import layer_on_grid
from linecontact.solver.grid.patches import Patches
from linecontact.solver.grid.problem import Problem
from linecontact.solver.grid.prolong import prolong
from linecontact.solver.layers.bonded import edge_shift
from linecontact.solver.reference import closed_forms, collocation
from linecontact.solver.strategy.grids import grids
from linecontact.studies.edge_curve.scenes import by_scene, from_two
from linecontact.studies.files import study_files

FEW_SPACINGS = [
    Layer(0.5, 0.3),
    Layer(2.0, 0.5),
    SlidingLayer(3.0),
    CoatedHalfSpace(1.0, 50.0),
    CoatedHalfSpace(1.0, 0.02),
]
STORED = Path(studies.__file__).parent / "results" / "edge-curve.h5"


def curve_of(layer):
    """The edge on a layer whose thickness is given in grid spacings."""
    return layer_on_grid(layer.in_units(1 / 2**20, 1.0), 2**20, 1.0).edge_curve


def test_closed_form_constants():
    """s by the plain sum of its series, and S_j by expanding the factor on a circle: independent of the quadrature."""
    curve = half_space_curve()
    n = 2**15
    q = np.pi * (np.arange(n) + 0.5) / n
    half = [np.mean(np.log(q / 2 / np.sin(q / 2)) * np.cos(k * q)) for k in range(400)]  # l_k/2
    terms = np.array([half[0] / 2, *half[1:]])
    partial = np.cumsum(np.arange(400) * terms)
    assert 0.75 - (partial[-1] + partial[-2]) / 2 == pytest.approx(curve.shift, abs=1e-5)  # alternating, ~ 1/k
    z = 0.5 * np.exp(2j * np.pi * np.arange(256) / 256)
    factor = np.exp(sum(t * z**k for k, t in enumerate(terms)))
    families = np.fft.fft(factor * (1 - z) ** -1.5).real / 256 * 2.0 ** np.arange(256)
    np.testing.assert_allclose(curve.table[:20], families[:20] * math.sqrt(math.pi) / 2, rtol=1e-7)


def test_the_half_space_s_shift_against_30_digits():
    """By the same series with mpmath."""
    assert half_space_curve().shift == pytest.approx(0.809990714058132, abs=1e-10)


def test_table_joins_the_square_root():
    curve = half_space_curve()
    far = np.sqrt(np.arange(curve.table.size) + curve.shift)
    np.testing.assert_allclose(curve.table[40:], far[40:], rtol=2e-5)


def test_exact_edges_are_recovered():
    """Fields made of the edge families themselves: every place between the nodes comes back."""
    beta = np.linspace(0, 1, 11)
    for curve in (half_space_curve(), *map(curve_of, FEW_SPACINGS)):
        pressures = np.stack([edge_function(curve, beta, np.full(11, j)) for j in range(3)], axis=1)
        three, two, _ = edge_offset(curve, pressures)
        np.testing.assert_allclose(two, beta - curve.shift, atol=1e-11)
        np.testing.assert_allclose(three, beta - curve.shift, atol=1e-11)
        np.testing.assert_allclose(from_two(curve, pressures[:, 0] / pressures[:, 1]), two, atol=1e-11)


def test_beyond_the_last_contact_node_an_edge_has_no_pressure():
    """Patches of one and two nodes are asked for it by the edges of the patches beside them."""
    for curve in (half_space_curve(), curve_of(FEW_SPACINGS[0])):
        values = edge_function(curve, np.array([0.4]), np.array([5, 0, -1, -2]))
        assert (values[:2] > 0).all()
        assert not values[2:].any()


def test_stored_measurement_meets_the_closed_form():
    """High-resolution solutions: the curves are the layers' own, and the closed forms are they."""
    study = study_files.load_study(STORED)
    assert study.complete
    assert (study.column("status") == "converged").all()
    scenes = by_scene(study)
    assert {"bonded", "sliding", "coated"} == {scene[1] for scene in scenes}
    assert len(scenes) == 10
    for (exponent, _, spacings, nu, _), runs in scenes.items():
        offset = np.array([run["offset"] for run in runs])
        assert np.ptp(offset) > 0.9  # all places between two nodes
        two, three = (max(abs(run[f"offset.{k}_nodes"] - run["offset"]) for run in runs) for k in ("two", "three"))
        if float(spacings) > 100:
            assert two < 1.5e-3
            assert three < (7e-4 if exponent < 2 else 5e-5)
        else:  # contacts of 39 nodes and more, of 53 if compressible
            assert three < (0.03 if nu == 0.5 else 0.01)


@pytest.mark.parametrize("n", [1.5, 2.0, 4.0])
@pytest.mark.parametrize("d", [math.inf, 0.1, 0.03, 20 / 2**12])
def test_area_within_a_hundredth_of_a_spacing_per_edge(n, d):
    for load in (2e-3, 1.83e-3):
        exact = collocation.solve_layer(Layer(d, 0.25), load, n, 1.0)
        found = solve(Scene(Layer(d, 0.25), PowerIndenter(n), load, num_points=2**12)).observables
        error = abs(found.contact_area_subgrid - exact.contact_area)
        assert error < 0.02 / 2**12  # two edges
        assert error < 3 * found.contact_area_error < 0.2 / 2**12  # the estimate holds in 97 of 100
        assert abs(found.kappa_subgrid - exact.kappa) < 2 * found.kappa_error
        assert found.kappa_error < 3e-3 * exact.kappa


@pytest.mark.parametrize(("n", "smallest"), [(2.0, 2.8), (4.0, 2.5)])
def test_areas_of_smooth_contacts_converge_with_the_third_power_of_the_spacing(n, smallest):
    """With the edges to the first order it is the second power; kappa's integral goes along with that."""
    errors = []
    for num_points in (2**10, 2**12):  # patches so wide that their pressures tell where they end
        found = []
        for load in np.geomspace(1.5e-3, 3e-3, 9):  # all places between two nodes
            exact = closed_forms.periodic_half_space_area(n, 1.0, load)
            scene = Scene(indenter=PowerIndenter(n), pressure=load, num_points=num_points)
            o = solve(scene, tolerance=1e-11).observables
            kappa = closed_forms.kappa_from_area(n, exact, 1.0, load)
            found.append((o.contact_area_subgrid / exact - 1, o.kappa_subgrid / kappa - 1))
        errors.append(np.sqrt(np.mean(np.square(found), axis=0)))
    orders = np.log2(errors[0] / errors[1]) / 2
    assert (orders > smallest).all(), orders
    assert (errors[1] < 2e-7).all()


def test_wide_patches_on_thin_layers_have_edges_to_the_first_order_only():
    """To the second order they would be those of a half-space, and worse. Those of the layer are known to the first."""
    layer = Layer(60 / 2**12, 0.3)
    for load, narrow in ((2e-6, True), (2e-3, False)):
        solution = solve(Scene(layer, pressure=load, num_points=2**12), tolerance=1e-10)
        patches = Patches.of(solution.contact_pressure > 0)
        pressure = solution.contact_pressure[patches.nodes]
        there, half_space = (
            find_edges(patches, pressure, layer_on_grid(of, patches.num_points, 1.0)) for of in (layer, Layer())
        )
        assert (there.width == half_space.width).all() == narrow
        exact = collocation.solve_layer(Layer(60 / 2**12, 0.3), load, 2.0, 1.0).contact_area * 2**12
        assert abs(there.width[0] - exact) < 1e-3
        assert abs(there.width[0] - exact) < there.total_error()


@pytest.mark.parametrize("nu", [-0.5, 0.25, 0.49, 0.5])
@pytest.mark.parametrize("spacings", [0.3, 1.0, 2.6, 6.0])
def test_layers_of_few_spacings_have_an_edge_of_their_own(nu, spacings):
    """To 0.005 spacings an edge, in contacts of 20 nodes; the half-space's curve is off by 0.2 to 0.35 there."""
    n = 2**12
    for load in (2e-3, 1.87e-3, 1.71e-3):
        exact = collocation.solve_layer(Layer(spacings / n, nu), load, 2.0, 1.0)
        found = solve(Scene(Layer(spacings / n, nu), pressure=load, num_points=n)).observables
        error = abs(found.contact_area_subgrid - exact.contact_area)
        assert error < 2 * (0.005 if nu < 0.49 else 0.03) / n
        assert error < 5 * found.contact_area_edges_error < 1 / n  # which holds in 97 of 100 of all scenes


def test_the_layer_s_edge_grows_into_the_half_space_s():
    for nu in (0.0, 0.3, 0.45):
        shifts = [curve_of(Layer(r, nu)).shift for r in (1e-3, 1.0, 8.0, 40.0)]
        assert shifts[0] == pytest.approx(1.0, abs=2e-3)  # a Winkler foundation ends where the wall does
        assert sorted(shifts, reverse=True) == shifts
        assert shifts[-1] == pytest.approx(half_space_curve().shift, abs=5e-3)


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.45])
@pytest.mark.parametrize("d", [0.1, 1.0, 5.0])
def test_the_edge_is_as_far_from_that_on_the_foundation_as_without_a_grid(d, nu):
    """Another way to s: K/K(0) is regular at q = 0, its far field begins where the factor says, c(nu) d outside."""
    n = 2**16
    q = np.pi * (np.arange(n) + 0.5) / n
    logarithm = np.log(Layer(d, nu).stiffness(q, 1.0) / Layer(d, nu).foundation_modulus(1.0))
    slope = -float(np.mean(logarithm / np.sin(q / 2) ** 2)) / 4  # sum of k l_k/2
    s = 1 - slope - edge_shift(nu) * d
    assert curve_of(Layer(d, nu)).shift == pytest.approx(s, abs=2e-5)


@pytest.mark.parametrize(
    ("ratio", "exponent"),  # stiff coatings touch a blunt indenter at two places
    [(0.01, 2.0), (0.1, 2.0), (3.0, 2.0), (3.0, 4.0), (100.0, 2.0), (100.0, 4.0), (1e4, 2.0)],
)
@pytest.mark.parametrize("spacings", [0.5, 3.0, 7.0])
def test_coatings_of_few_spacings_have_an_edge_of_their_own(spacings, ratio, exponent):
    """Soft and stiff ones, to 0.01 spacings; the half-space's curve is off by up to a spacing.

    The contact has as many nodes on either grid; on the coarse one collocation needs fewer of its own.
    """
    n = 2**10 if spacings < 3 else 2**12
    on_half_space = {2.0: math.pi / 4, 4.0: 3 * math.pi / 16}[exponent] * (40 / n) ** exponent
    load = on_half_space * min(ratio, 1.0)
    layer = CoatedHalfSpace(spacings / n, ratio, 0.3, 0.4)
    exact = collocation.solve_layer(layer, load, exponent, 1.0)
    found = solve(Scene(layer, PowerIndenter(exponent), load, num_points=n)).observables
    error = abs(found.contact_area_subgrid - exact.contact_area)
    assert error < 2 * 0.01 / n
    assert error < found.contact_area_edges_error < 0.2 / n


def test_what_a_table_does_not_tell_of_the_edge_is_estimated():
    """It ends with the grid's shortest wave, far from a half-space."""
    n, layer = 2**10, SlidingLayer(0.3 / 2**10)
    exact = collocation.solve_layer(layer, 2e-3, 2.0, 1.0)
    q = np.geomspace(2 * np.pi, np.pi * n, 400)
    table = TabulatedLayer(tuple(q), tuple(layer.stiffness(q, 1.0)), contact_modulus=1.0)
    found = solve(Scene(table, num_points=n)).observables
    curve = layer_on_grid(table, n, 1.0).edge_curve
    at_end = math.log(2 * layer.stiffness(q[-1:], 1.0)[0] / q[-1])
    assert at_end / math.pi**2 < curve.error < 4 * at_end / math.pi**2
    assert abs(found.contact_area_subgrid - exact.contact_area) < found.contact_area_error
    assert found.contact_area_error > curve.error / n


@pytest.mark.parametrize("base", [0.01, 0.1, 10.0])
def test_so_is_what_a_table_without_its_contact_modulus_does_not_tell(base):
    """2K/q of the last row stands in for E*: that says nothing of how K goes on."""
    n, layer, load = 2**11, CoatedHalfSpace(1e-4, base), 2e-3 * min(base, 1.0)
    exact = solve(Scene(layer, pressure=load, num_points=2**16)).observables.contact_area_subgrid
    q = np.geomspace(1e-4, np.pi * n, 300)
    table = TabulatedLayer(tuple(q), tuple(layer.stiffness(q, 1.0)))
    found = solve(Scene(table, pressure=load, num_points=n)).observables
    assert abs(found.contact_area_subgrid - exact) < found.contact_area_error


@pytest.mark.parametrize("spacings", [0.3, 1.0, 3.0])
def test_waves_so_short_that_a_formula_overflows_do_not_matter(spacings):
    """The sliding layer as textbooks have it."""

    @dataclass(frozen=True)
    class Naive(SlidingLayer):
        def stiffness(self, wave_numbers, period):
            y = wave_numbers * self.thickness / period
            return wave_numbers / 2 * (np.sinh(2 * y) + 2 * y) / (np.cosh(2 * y) - 1)

    naive, exact = (curve_of(kind(spacings)) for kind in (Naive, SlidingLayer))
    assert naive.delta == pytest.approx(exact.delta, abs=1e-9)
    assert naive.error < 1e-9


def test_nonsense_beyond_the_grid_is_not_known():
    """No negative area, whatever a layer says of waves that the grid has not."""

    @dataclass(frozen=True)
    class Wild(Layer):
        thickness: float = 1e-4

        def stiffness(self, wave_numbers, period):
            found = super().stiffness(wave_numbers, period)
            return np.where(wave_numbers > 7000, 1e250 * found, found)

    wild, tame = (solve(Scene(layer, num_points=2**11)).observables for layer in (Wild(), Layer(1e-4)))
    assert abs(wild.contact_area_subgrid - tame.contact_area_subgrid) < wild.contact_area_error


@pytest.mark.parametrize("points", [64, 128, 300, 512, 1000, 2**11])
@pytest.mark.parametrize(("d", "nu"), [(math.inf, 0.3), (0.05, 0.45), (0.004, 0.25), (0.02, 0.5)])
def test_the_error_estimate_holds_the_truth(points, d, nu):
    exact = collocation.solve_layer(Layer(d, nu), 1.7e-3, 2.0, 1.0)
    found = solve(Scene(Layer(d, nu), pressure=1.7e-3, num_points=points)).observables
    assert abs(found.contact_area_subgrid - exact.contact_area) < 1.5 * found.contact_area_error
    assert abs(found.contact_area_subgrid - exact.contact_area) < 2 / points


def test_nested_grids_tell_the_discretisation_error():
    for load in np.geomspace(1e-3, 4e-3, 7):
        exact = collocation.solve_layer(Layer(0.05, 0.3), load, 2.0, 1.0)
        solution = solve(Scene(Layer(0.05, 0.3), pressure=load, num_points=2**13))
        o = solution.observables
        assert [level.num_points for level in solution.levels] == [512, 2048]
        assert 0 < o.contact_area_edges_error <= o.contact_area_error < 0.1 / 2**13
        error = abs(o.contact_area_subgrid - exact.contact_area)
        assert error < 2 * o.contact_area_error
        assert abs(o.kappa_subgrid - exact.kappa) < 2 * o.kappa_error
        coarse = abs(solution.levels[-1].contact_area_subgrid - exact.contact_area)
        # what is left after the last refinement is at most what the estimate makes of the change
        assert error < max(coarse / 3, 1e-7)
    single = solve(Scene(num_points=2**10), nested=False)
    assert not single.levels
    assert single.observables.contact_area_error >= single.observables.contact_area_edges_error
    assert single.observables.peak_pressure_error == single.observables.approach_error == math.inf


def test_small_patches_are_counted_and_flagged():
    heights = np.ones(256)
    heights[[20, 90, 91, 200, 201, 202, 203]] = 0
    o = solve(
        Scene(indenter=MeasuredIndenter(1e-3 * heights, convention="gap"), pressure=1e-5, num_points=256)
    ).observables
    assert o.num_patches == 3
    assert o.num_unresolved_patches == 2
    patches = Patches.of(heights == 0)
    ends = edges.find_edges(patches, np.ones(patches.nodes.size), layer_on_grid(Layer(), patches.num_points, 1.0))
    np.testing.assert_array_equal(ends.unresolved, [True, True, False])
    np.testing.assert_allclose(ends.width[:2], [1, 2])


def test_patches_wrap_round():
    contact = np.zeros(10, dtype=bool)
    contact[[0, 1, 4, 8, 9]] = True
    patches = Patches.of(contact)
    assert list(zip(patches.first, patches.last, strict=True)) == [(4, 4), (8, 11)]
    np.testing.assert_array_equal(patches.nodes, [4, 8, 9, 0, 1])
    np.testing.assert_array_equal(patches.sums(np.arange(5.0)), [0, 10])
    assert Patches.of(np.ones(4, dtype=bool)).full
    assert Patches.of(np.zeros(4, dtype=bool)).count == 0
    for start, stop in ((0, 3), (7, 10), (2, 5)):
        one = np.zeros(10, dtype=bool)
        one[start:stop] = True
        np.testing.assert_array_equal(Patches.of(one).nodes, np.arange(start, stop))


def finer(pressure, num_points):
    patches = Patches.of(pressure > 0)
    ends = edges.find_edges(patches, pressure[patches.nodes], layer_on_grid(Layer(), patches.num_points, 1.0))
    coarse, finer = (Problem.from_scene(Scene(num_points=n)) for n in (pressure.size, num_points))
    return prolong(coarse, pressure, patches, ends, finer)


def test_grids_and_prolongation():
    assert grids(2**18) == [2**10, 2**12, 2**14, 2**16, 2**18]
    assert grids(1000) == [1000]
    assert all(size % 2 == 0 for n in (4098, 9998, 2**17 + 2) for size in grids(n))
    fine = solve(Scene(num_points=2**12), tolerance=1e-10)
    coarse = solve(Scene(num_points=2**10), tolerance=1e-10)
    guess = finer(coarse.contact_pressure, 2**12)
    np.testing.assert_array_equal(guess > 0, fine.contact)
    peak = fine.contact_pressure.max()
    # the edge families leave the smooth part's dx^2; plain interpolation is off by 5 % of the peak at the edge
    assert np.abs(guess - fine.contact_pressure).max() < 2e-3 * peak
    # any ratio, patches across the period's end and a full contact
    for n in (100, 514, 3000):
        assert finer(np.roll(coarse.contact_pressure, 512), n).mean() == pytest.approx(2e-3, rel=0.02)
    np.testing.assert_allclose(finer(np.full(16, 3.0), 40), 3.0)
