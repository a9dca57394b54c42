"""Ends of narrow patches from their loads: closed forms, layers, and rough surfaces with few points."""

import math
from dataclasses import replace

import numpy as np
import pytest
from linecontact.solver import (
    CoatedHalfSpace,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    SlidingLayer,
    TabulatedLayer,
    solve,
)
from linecontact.solver.grid.contact import contact_edges
from linecontact.solver.grid.few_nodes import MARGIN, node_compliance, node_stiffness
from linecontact.solver.grid.layer_on_grid import layer_on_grid
from linecontact.solver.grid.narrow import Surface, from_loads, gap_ends, punch_compliance, squared_slopes
from linecontact.solver.grid.patches import Patches
from linecontact.solver.grid.problem import Problem
from linecontact.solver.reference import closed_forms, collocation

FEW_POINTS = RoughIndenter(hurst=0.3, roll_off_ratio=1 / 8, cut_off_ratio=1 / 64)
"""Shortest wave L/512."""


def fields(rng, n):
    """A wavy surface, a smooth displacement and a pressure, of N points a spacing apart."""
    x = np.arange(n)
    smooth = sum(rng.normal() * np.cos(2 * np.pi * k * (x / n + rng.random())) / k**2 for k in range(1, 9))
    profile = 0.02 * (x - n // 2) ** 2 + 1e-3 * smooth
    return Surface(profile, 1e-2 * smooth, 1e-2 * rng.random(n) * (np.abs(x - n // 2) < 40), 1.0, 1.0)


def fitted(field, own, caused, first, size, margin):
    """The field around one run of nodes, see `narrow`, as a polynomial of the place."""
    nodes = np.arange(first - margin, first + size + margin)
    inside = np.arange(first, first + size)
    values = field[nodes] + caused[np.abs(nodes[:, None] - inside)] @ own[inside]
    return np.polynomial.Polynomial.fit(nodes, values, max(2, min(6, nodes.size - 2)))


def means(g, middle, half_width):
    """M_0, M_1 and M_2 of a function, by Chebyshev's points."""
    t = np.cos(np.pi * (np.arange(8) + 0.5) / 8)
    return [float(np.mean(g(middle + half_width * t) * t**k)) for k in range(3)]


@pytest.mark.parametrize("size", [1, 2, 3, 7, 16, 32])
@pytest.mark.parametrize("gap", [2, 5, 40])
def test_ends_by_loads_solve_their_equations(size, gap):
    n, first, margin = 128, np.array([64 - size // 2]), min(gap // 2, MARGIN)
    surface = fields(np.random.default_rng(size + gap), n)
    around = fitted(surface.displacement, surface.pressure, node_compliance(), first[0], size, margin)
    load = np.array([math.pi / 4 * 0.04 * (size / 2) ** 2])
    begin = np.array([64.0]), np.array([size / 2])
    found = from_loads(surface, first, np.array([size]), np.array([gap]), load, begin, layer_on_grid(Layer(), n, 1.0))
    middle, half_width = float(found.middle[0]), float(found.half_width[0])

    def height(at):
        nodes = np.floor(at[:, None]).astype(int) + np.arange(-2, 4)
        return np.array(
            [np.poly1d(np.polyfit(k - p, surface.profile[k], 5))(0) for k, p in zip(nodes, at, strict=True)]
        )

    def slope(at):
        return (height(at + 1e-4) - height(at - 1e-4)) / 2e-4 - around.deriv()(at)

    assert found.solved[0]
    m_0, m_1, m_2 = means(slope, middle, half_width)
    assert m_0 == pytest.approx(0, abs=1e-5 * abs(m_1))
    assert math.pi / 2 * half_width * m_1 == pytest.approx(load[0], rel=1e-5)
    assert found.centre[0] == pytest.approx(middle + half_width * m_2 / m_1, abs=1e-5)
    deeper = means(lambda at: around(at) - height(at), middle, half_width)[0]
    assert found.deeper[0] == pytest.approx(deeper, rel=1e-6)
    assert punch_compliance(found.half_width)[0] == pytest.approx(2 / math.pi * math.log(2 / half_width))
    ends = np.array([middle - half_width]), np.array([middle + half_width])
    between = np.linspace(*np.concatenate(ends), 2001)
    squares = np.gradient(height(between), between) ** 2
    assert squared_slopes(surface.profile, 1.0, *ends)[0] == pytest.approx(np.trapezoid(squares, between), rel=1e-4)


@pytest.mark.parametrize("size", [1, 3, 9])
def test_ends_of_gaps_solve_their_equations(size):
    n, first, middle = 128, np.array([64]), 63.7 + size / 2
    x = np.arange(n)
    opening = 0.1 * np.random.default_rng(size).random(n) * ((x >= 64) & (x < 64 + size))
    profile, pressure = 0.3 + 1e-3 * x, (x - middle) ** 2 - size**2 / 8 + 0.01 * (x - middle) ** 3
    surface = Surface(profile, profile - opening, pressure, 1.0, 1.0)
    closed = fitted(pressure, -opening, node_stiffness(), 64, size, MARGIN)
    found = gap_ends(surface, first, np.array([size]), np.array([20]), np.array([63.5]), np.array([63.5 + size]))
    assert found.solved[0]
    m_0, m_1, _ = means(closed, float(found.middle[0]), float(found.half_width[0]))
    assert (m_0, m_1) == pytest.approx((0, 0), abs=1e-5 * size**2)


@pytest.mark.parametrize("load", [0.0, -1e-5, -1e-3])
def test_a_patch_without_a_load_has_no_ends(load):
    x, none = np.arange(64) - 32, np.zeros(64)
    begin, one = (np.array([32.2]), np.array([0.5])), np.array([1])
    surface, layer = Surface(0.01 * x**2, none, none, 1.0, 1.0), layer_on_grid(Layer(), 64, 1.0)
    assert not from_loads(surface, 32 * one, one, 6 * one, np.array([load]), begin, layer).solved[0]


@pytest.mark.parametrize("spacings", [1e-12, 1e-3, 0.3, 0.7])
def test_a_coating_like_its_base_of_any_thickness(spacings):
    layer = CoatedHalfSpace(spacings / 256, 1.0, 0.25, 0.25)
    found, exact = (
        solve(Scene(each, PowerIndenter(2.0), 1e-6, num_points=256)).observables for each in (layer, Layer())
    )
    assert found.contact_area_subgrid == pytest.approx(exact.contact_area_subgrid, rel=1e-3)


@pytest.mark.parametrize("num_points", [32, 48, 64, 100])
def test_a_parabola_of_few_nodes(num_points):
    """The load is the scene's, so only what the neighbouring periods do is not exact."""
    exact = closed_forms.periodic_half_space_area(2.0, 1.0, 5e-4)
    found = solve(Scene(indenter=PowerIndenter(2.0), pressure=5e-4, num_points=num_points)).observables
    assert found.num_patches_by_load == 1
    assert found.num_unresolved_patches == 0
    assert found.contact_area_subgrid == pytest.approx(exact, rel=2e-3)
    kappa = closed_forms.kappa_from_area(2.0, exact, 1.0, 5e-4)
    assert found.kappa_subgrid == pytest.approx(kappa, rel=5e-3)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.25, 0.45, 0.5])
@pytest.mark.parametrize("thickness", [0.3, 0.08, 0.03])
def test_a_layer_bends_the_slope(thickness, poisson_ratio):
    """A patch of some ten nodes on layers of different thickness, against collocation."""
    pressure = 0.004 * thickness**2
    exact = collocation.solve_layer(Layer(thickness, poisson_ratio), pressure, 2.0, 1.0).contact_area
    num_points = 2 * round(0.5 * 10 / exact)
    scene = Scene(Layer(thickness, poisson_ratio), PowerIndenter(2.0), pressure, num_points=num_points)
    found = solve(scene).observables
    assert found.num_patches_by_load == 1
    assert found.contact_area_subgrid * num_points == pytest.approx(
        exact * num_points, abs=0.016 if thickness > 0.1 else 0.004
    )


@pytest.mark.parametrize("ratio", [0.01, 0.1, 10.0])
def test_a_base_bends_the_slope(ratio):
    """Softer and stiffer than its coating; with a wrong sign of its part they are off by 0.06 and 0.2 on the softer."""
    layer = CoatedHalfSpace(0.036, ratio, 0.3, 0.25)
    exact = collocation.solve_layer(layer, 2e-6, 2.0, 1.0).contact_area
    found = solve(Scene(layer, PowerIndenter(2.0), 2e-6, num_points=2**12)).observables
    assert found.num_patches_by_load == 1
    assert abs(found.contact_area_subgrid - exact) * 2**12 < 1e-3


@pytest.mark.parametrize("num_points", [257, 4096])
@pytest.mark.parametrize("width", [0.3, 0.8, 1.4, 2.3, 3.1, 4.2])
def test_a_lone_patch_of_few_nodes_anywhere_between_them(num_points, width):
    """Westergaard's: a_r, its middle, and kappa = a_r g_c E*/p with g_c^2 = (2 pi D)^2 (1/2 - sin(2 pi a)/(4 pi a))."""
    depth, area = 0.01, width / num_points
    pressure = math.pi * depth * math.sin(math.pi * area / 2) ** 2
    kappa = area / pressure * 2 * math.pi * depth * math.sqrt(0.5 - math.sin(2 * math.pi * area) / (4 * math.pi * area))
    for beside in np.linspace(-0.5, 0.45, 7):
        x = (np.arange(num_points) - num_points // 2 - beside) / num_points
        heights = MeasuredIndenter(depth * (1 - np.cos(2 * np.pi * x)), convention="gap")
        solution = solve(Scene(indenter=heights, pressure=pressure, num_points=num_points))
        found, patches = solution.observables, solution.patches
        assert patches.left.size == 1
        assert found.contact_area_subgrid == pytest.approx(area, rel=2e-5)
        assert found.kappa_subgrid == pytest.approx(kappa, rel=2e-5)
        middle = (patches.left[0] + patches.right[0]) / 2 * num_points - num_points // 2
        assert middle == pytest.approx(beside, abs=1e-4)


@pytest.mark.parametrize("beside", [-0.45, 0.3])
@pytest.mark.parametrize("width", [1.4, 2.2, 5.2])
@pytest.mark.parametrize(
    "layer",
    [Layer(50 / 1024), Layer(60 / 1024, 0.5), SlidingLayer(40 / 1024), CoatedHalfSpace(40 / 1024, 0.1, 0.25, 0.3)],
)
def test_a_lone_patch_on_a_layer_lies_below_the_tip(layer, width, beside):
    """By symmetry, wherever the tip is: also where the period ends."""
    n, depth = 1024, 0.01
    load = math.pi * depth * math.sin(math.pi * width / n / 2) ** 2
    for tip in (n // 2 + beside, beside):
        heights = MeasuredIndenter(depth * (1 - np.cos(2 * np.pi * (np.arange(n) - tip) / n)), convention="gap")
        patches = solve(Scene(layer, heights, load, num_points=n)).patches
        middle = (patches.left[0] + patches.right[0]) / 2 * n
        assert patches.left.size == 1
        assert (middle - tip + n / 2) % n - n / 2 == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize(
    ("layer", "points", "most", "factor"),
    [(Layer(), 8, 0.004, 4), (Layer(), 16, 0.003, 4), (Layer(0.02, 0.4), 8, 0.006, 3)],
)
def test_areas_of_rough_surfaces_with_few_points_to_a_wave(layer, points, most, factor):
    """Relative errors by load, and by pressure and counting, against the grid of 2^15 points."""
    errors, num_points = [], 512 * points
    for seed in range(6):
        scene = Scene(layer, replace(FEW_POINTS, seed=seed), 0.01, num_points=2**15)
        coarse, true = solve(scene.on_grid(num_points)), solve(scene).observables.contact_area_subgrid
        counted = contact_edges(Problem.from_scene(coarse.scene), coarse.contact_pressure).ends
        errors.append((coarse.observables.contact_area_subgrid / true - 1, counted.width.sum() / num_points / true - 1))
    by_load, by_counting = np.sqrt(np.mean(np.square(errors), axis=0))
    assert by_load < most
    assert by_load < by_counting / factor


def test_the_load_says_nothing_where_the_profile_is_not_known_between_the_nodes():
    """Noise: the pressures go on telling, or nodes are counted; the error says how little is known."""
    noise = np.random.default_rng(1).uniform(0, 1e-3, 2**10)
    found = solve(
        Scene(indenter=MeasuredIndenter(noise, convention="gap"), pressure=1e-4, num_points=2**10)
    ).observables
    assert found.contact_area_error > 0.05 * found.contact_area_subgrid


def test_the_patches_of_a_solution_add_up():
    solution = solve(Scene(indenter=FEW_POINTS, pressure=0.01, num_points=2**12))
    _, _, patches, edges = contact_edges(
        Problem.from_scene(solution.scene), solution.contact_pressure, solution.displacement
    )
    assert edges.by_load.sum() == solution.observables.num_patches_by_load > 0.8 * patches.count
    assert edges.width.sum() / 2**12 == pytest.approx(solution.observables.contact_area_subgrid)
    assert (edges.left[1:] >= edges.right[:-1]).all()


def test_slopes_are_squared_between_the_ends():
    solution = solve(Scene(indenter=FEW_POINTS, pressure=0.01, num_points=2**12))
    problem = Problem.from_scene(solution.scene)
    edges = contact_edges(problem, solution.contact_pressure, solution.displacement).ends
    found = squared_slopes(problem.profile, 2**12, edges.left, edges.right)
    finer, slopes, exact = 64, solution.scene.indenter.slope(2**18, 1.0), np.zeros_like(found)
    for one, (left, right) in enumerate(zip(edges.left, edges.right, strict=True)):
        inside = np.arange(math.ceil(left * finer), math.floor(right * finer) + 1) % 2**18
        exact[one] = float((slopes[inside] ** 2).sum()) / finer
    np.testing.assert_allclose(found[edges.by_load], exact[edges.by_load], rtol=0.15, atol=2e-3)
    measured = solution.observables.rms_gradient_subgrid  # by the nodes alone off by 3e-3
    assert measured == pytest.approx(math.sqrt(exact.sum() / edges.width.sum()), rel=1e-3)


def test_a_table_that_ends_where_the_grid_does():
    """No wave is asked for that the grid has not, on odd grids either."""
    for num_points in (10, 11):
        q = np.geomspace(1e-3, 2 * math.pi * (num_points // 2), 200)
        layer = TabulatedLayer(tuple(q), tuple(1 + 0.2 * q))
        found = solve(Scene(layer, PowerIndenter(2.0), 1e-4, num_points=num_points))
        assert found.observables.contact_area_subgrid > 0


def test_a_coating_like_its_base_is_a_half_space():
    """The same pressures and displacements give the same ends."""
    scene = Scene(indenter=FEW_POINTS, pressure=0.01, num_points=2**12)
    solution = solve(scene)
    coated = Scene(CoatedHalfSpace(0.02, base_modulus=1.0, base_poisson_ratio=0.25), FEW_POINTS, 0.01)
    widths = [
        contact_edges(Problem.from_scene(s), solution.contact_pressure, solution.displacement).ends.width.sum()
        for s in (scene, coated.on_grid(2**12))
    ]
    assert widths[0] == pytest.approx(widths[1], rel=1e-3)


def bumps(layer, pressure, num_points):
    """Twenty bumps of different height in the period."""
    x = np.arange(num_points) / num_points - 0.5
    heights = -1e-3 * np.cos(40 * np.pi * x) - 2e-3 * np.cos(2 * np.pi * x)
    return Scene(layer, MeasuredIndenter(heights, convention="gap"), pressure, num_points=num_points)


@pytest.mark.parametrize("base", [1e3, 0.5, 0.1, 0.01, 0.003])
def test_ends_by_loads_on_bases_of_any_stiffness(base):
    """A response that goes over into that of the base after many thicknesses; the fine grid needs no loads."""
    layer, pressure = CoatedHalfSpace(0.05, base, 0.25, 0.3), 2e-3 * math.sqrt(min(base, 1.0))
    found = solve(bumps(layer, pressure, 2**11)).observables
    exact = solve(bumps(layer, pressure, 2**17)).observables
    assert found.num_patches_by_load > 0
    assert exact.num_patches_by_load == 0
    error = abs(found.contact_area_subgrid - exact.contact_area_subgrid)
    assert error < found.contact_area_error < 0.02 * exact.contact_area_subgrid


def test_an_accuracy_on_a_base_much_softer_than_the_layer():
    """Collocation of all patches together gives 0.0352448."""
    found = solve(bumps(CoatedHalfSpace(0.05, 0.01, 0.25, 0.3), 2e-4, 2**17), accuracy=1e-3)
    assert found.observables.contact_area_subgrid == pytest.approx(0.0352448, rel=1e-3)


@pytest.mark.parametrize("spacings", [0.1, 0.3, 0.6, 1.0, 3.0])
@pytest.mark.parametrize("base", [0.2, 0.5, 5.0])
def test_loads_tell_on_layers_that_the_grid_does_not_resolve(spacings, base):
    """On two patches of one or two nodes; counting is off by one to two spacings."""
    layer = CoatedHalfSpace(spacings / 512, base, 0.25, 0.3)
    scene = Scene(layer, RoughIndenter(0.8, 1, 1 / 8, 1 / 16), 1e-3 * min(1.0, base), num_points=512)
    found, exact = (solve(one).observables for one in (scene, scene.on_grid(2**14)))
    assert abs(found.contact_area_subgrid - exact.contact_area_subgrid) < 0.3 / 512


@pytest.mark.parametrize("points", [2, 3, 4])
def test_a_mirror_image_has_the_same_area(points):
    n = 32 * points
    for seed in range(12):
        heights = RoughIndenter(0.8, seed, 0.25, 1 / 8).profile(n, 1.0)
        one, other = (
            solve(Scene(indenter=MeasuredIndenter(h, convention="gap"), pressure=0.005, num_points=n))
            for h in (heights, heights[::-1])
        )
        assert one.observables.contact_area_subgrid == pytest.approx(other.observables.contact_area_subgrid, rel=1e-9)
        assert one.observables.contact_area_error == pytest.approx(other.observables.contact_area_error, rel=1e-6)


def test_a_narrow_patch_beside_one_that_is_longer_than_half_of_the_period():
    """A bump in the gap of a wide contact: what the wide patch does to itself reaches around the period."""

    def bump(num_points):
        x = np.arange(num_points) / num_points
        heights = 0.01 * (1 + np.cos(2 * np.pi * x)) - 0.02 * np.exp(-((np.minimum(x, 1 - x) / 0.006) ** 2))
        indenter = MeasuredIndenter(heights - heights.min(), convention="gap")
        return solve(Scene(Layer(0.1), indenter, pressure=0.06, num_points=num_points))

    found, finer = bump(1024), bump(4096)
    assert Patches.of(found.contact).size.max() > 512
    assert found.observables.num_patches_by_load == 1
    difference = abs(found.observables.contact_area_subgrid - finer.observables.contact_area_subgrid)
    assert difference < 0.04 / 1024


@pytest.mark.parametrize("pressure", [4.8e-15, 1e-12, 1e-9])
@pytest.mark.parametrize("num_points", [256, 1021])
def test_widths_far_below_a_spacing(pressure, num_points):
    """Down to 1e-5 spacings, against Hertz (found by a soak: off by half of the width)."""
    found = solve(Scene(Layer(114.0, -0.5), PowerIndenter(), pressure, num_points=num_points)).observables
    assert found.contact_area_subgrid == pytest.approx(2 * math.sqrt(4 * pressure / math.pi), rel=1e-5)


def test_an_error_beside_flat_heights_is_a_number():
    """Their differences are all 0, and an iteration that has not ended leaves a small patch there."""
    heights = np.full(2048, 0.1)
    heights[400:900] = 0
    scene = Scene(indenter=MeasuredIndenter(heights, convention="gap"), pressure=1e-3, num_points=2048)
    assert solve(scene, max_iterations=3).observables.contact_area_error > 0


@pytest.mark.parametrize(("num_points", "pressure"), [(7, 1e-3), (13, 1e-3), (16, 5e-3), (32, 5e-4), (44, 0.05)])
def test_a_few_nodes_beside_a_narrow_gap_around_the_period(num_points, pressure):
    """The gap's own images move the ends (found by a soak: off by up to 70 times the estimated error, which holds in 97
    of 100 scenes)."""
    coarse, fine = (solve(Scene(pressure=pressure, num_points=n)).observables for n in (num_points, 64 * num_points))
    assert coarse.num_patches_by_load == 1
    assert abs(coarse.contact_area_subgrid - fine.contact_area_subgrid) < 2 * coarse.contact_area_error
