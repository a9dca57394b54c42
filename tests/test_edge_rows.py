"""Edges of patches that follow each other: H. M. Westergaard's row, from wide gaps to gaps of one grid spacing."""

import math
from functools import partial

import edge_formulas
import numpy as np
import pytest
from linecontact.solver import Layer, MeasuredIndenter, PowerIndenter, Scene, solve
from linecontact.solver.grid.edge_curves import half_space_curve
from linecontact.solver.grid.edges import find_edges, pressed_ends
from linecontact.solver.grid.layer_on_grid import layer_on_grid
from linecontact.solver.grid.patches import Patches


def on_half_space(patches, pressure):
    return find_edges(patches, pressure, layer_on_grid(Layer(), patches.num_points, 1.0))


def row(width, gap, repeats=1):
    """The contact under waves of the length width + gap [grid spacings], whose patches are as wide in closed form."""
    period = round(width + gap)
    assert math.isclose(period, width + gap)
    amplitude = 1e-2 / repeats
    wave = 1 - np.cos(2 * np.pi * np.arange(period * repeats) / period)
    full = math.pi * amplitude * repeats
    load = full * math.sin(math.pi * width / period / 2) ** 2
    return solve(
        Scene(Layer(), MeasuredIndenter(amplitude * wave, convention="gap"), load, num_points=period * repeats),
        tolerance=1e-11,
    )


@pytest.mark.parametrize(
    ("least", "off", "period"),
    [(1.05, 0.013, 128), (3.0, 0.007, 128), (8.0, 0.003, 128), (30.0, 3e-4, 128), (56.2, 6e-3, 64), (118.0, 2e-3, 128)],
)
def test_ends_of_a_row_between_the_nodes(least, off, period):
    """Beside gaps of one spacing and more, and for patches of six and more, within 1.5 times the estimated error."""
    for more in np.linspace(0, 1.9, 7):
        gap = least + more
        solution = row(period - gap, gap)
        patches = Patches.of(solution.contact_pressure > 0)
        ends = on_half_space(patches, solution.contact_pressure[patches.nodes])
        wrong = abs(ends.width[0] - (period - gap))
        assert wrong < 2 * off
        assert wrong <= 1.5 * ends.end_errors.sum() < max(375 * off, 0.09)


@pytest.mark.parametrize(
    ("rule", "beside_one", "beside_ten"), [("grid", 0.012, 0.002), ("distance", 0.06, 0.02), ("alone", 0.5, 0.2)]
)
def test_what_other_rules_leave_beside_narrow_gaps(rule, beside_one, beside_ten):
    """The distance as the grid has it, the distance itself, and each end by itself: largest error of an end."""
    curve, period = half_space_curve(), 128
    for least, most in ((1.05, beside_one), (10.0, beside_ten)):
        wrong = []
        for gap in least + np.linspace(0, 1, 9):
            solution = row(period - gap, gap)
            patches = Patches.of(solution.contact_pressure > 0)
            pressure = solution.contact_pressure[patches.nodes]
            width = on_half_space(patches, pressure).width[0]
            if rule == "alone":
                theta = edge_formulas.edge_offset(curve, edge_formulas.ends(patches, pressure))[0]
                width = patches.size[0] - 1 - theta.sum()
            if rule == "distance":
                others = partial(edge_formulas.in_row, distance=lambda curve, theta: np.arange(3) - theta[..., None])
                theta, _, _ = edge_formulas.offsets(curve, patches, pressure, others)
                theta = theta + edge_formulas.by_load(curve, patches, theta, np.ones((2, 1), dtype=bool))
                width = patches.size[0] - 1 - theta.sum()
            wrong.append(abs(width - (period - gap)) / 2)
        assert max(wrong) == pytest.approx(most, rel=0.5)


def test_ends_are_not_moved_one_by_one_where_patches_share_the_load():
    """Each patch of eight has its nodes elsewhere. Alone each would have to carry its load, here they share it."""
    period, repeats, width = 37.125, 8, 20.3
    n = round(period * repeats)
    wave = 1 - np.cos(2 * np.pi * np.arange(n) / period)
    amplitude = 1e-2 / repeats
    load = math.pi * amplitude * repeats * math.sin(math.pi * width / period / 2) ** 2
    solution = solve(
        Scene(Layer(), MeasuredIndenter(amplitude * wave, convention="gap"), load, num_points=n), tolerance=1e-11
    )
    patches = Patches.of(solution.contact_pressure > 0)
    ends = on_half_space(patches, solution.contact_pressure[patches.nodes])
    assert patches.count == repeats
    assert abs(ends.width.mean() - width) < 6e-4
    assert ends.width.std() < 2.2e-3  # 3.2e-3 if each had to carry its load


def test_what_a_given_load_leaves_of_the_second_order():
    """pi/P (3 cot(pi A/P) + tan(pi A/P)) e/2: 3 e/w where the gap is wide, e/g where it is narrow."""
    curve = half_space_curve()
    theta = np.array([[-0.3, 0.1], [0.0, -0.6]])
    beta = theta + curve.shift
    e, everywhere = float(np.mean(beta**2 - beta + 1 / 6)) / 8, np.ones((2, 2), dtype=bool)
    wide = Patches(2**20, np.array([1000, 400000]), np.array([1299, 400399]))
    left = edge_formulas.by_load(curve, wide, theta, everywhere)
    np.testing.assert_allclose(left, np.broadcast_to(3 * e / (wide.size - 1 - theta.sum(axis=0)), (2, 2)), rtol=2e-3)
    narrow = Patches(2**20, np.array([0, 2**19]), np.array([2**19 - 11, 2**20 - 11]))
    gaps = np.array([[11 + theta[0, 0] + theta[1, 1], 11 + theta[0, 1] + theta[1, 0]]] * 2)
    gaps[1] = gaps[1, ::-1]
    np.testing.assert_allclose(edge_formulas.by_load(curve, narrow, theta, everywhere), e / gaps, rtol=1e-3)
    known = np.array([[True, False], [True, True]])  # the mean is over these, and the others stay
    of_known = np.mean((beta**2 - beta + 1 / 6)[known]) / 8
    some = edge_formulas.by_load(curve, narrow, theta, known)
    np.testing.assert_allclose(some, np.where(known, of_known / gaps, 0.0), rtol=1e-3)


def test_distance_of_the_last_nodes_as_the_grid_has_it():
    """Nearly the distance far away; 3/4 (1 - beta) at the last node, whatever the far field."""
    curve = half_space_curve()
    beta = np.array([0.02, 0.3, 0.7, 1.0])
    distance = edge_formulas.edge_distance(curve, beta - curve.shift)
    np.testing.assert_allclose(distance[:, 0], 0.75 * (1 - beta), atol=1e-9)
    np.testing.assert_allclose(distance[:, 2], 2 - (beta - curve.shift), atol=0.03)
    assert (np.diff(distance, axis=1) > 0.7).all()


@pytest.mark.parametrize("exponent", [1.1, 1.5, 2.0, 4.0])
def test_slope_of_a_power_profile_between_any_places(exponent):
    indenter = PowerIndenter(exponent, radius=0.7)
    x = (np.arange(10**6) + 0.5) / 10**6 * 30.6 - 12.3  # from the tip, in grid spacings
    squared = (np.abs(x) / 256 * 2.0 / 0.7) ** (2 * exponent - 2)
    found = indenter.squared_slope_between(np.array([128 - 12.3]), np.array([128 + 18.3]), 256, 2.0)
    assert found[0] == pytest.approx(squared.mean() * 30.6, rel=1e-4)
    inside, beyond = ([0.0, 255.0], [256.0, 257.0]), ([256.0, -1.0], [512.0, 1.0])  # the period begins anywhere
    for left, right in (inside, beyond):
        whole = indenter.squared_slope_between(np.array(left), np.array(right), 256, 2.0)
        assert whole[0] == pytest.approx(256 * (1 / 0.7) ** (2 * exponent - 2) / (2 * exponent - 1), rel=1e-12)
        assert whole[1] == pytest.approx(indenter.squared_slope_between(*np.array([[255.0], [257.0]]), 256, 2.0)[0])


@pytest.mark.parametrize("exponent", [1.2, 1.35, 1.5])
def test_kappa_of_sharp_tips_is_as_well_known_as_their_area(exponent):
    """The slope's sum over the nodes would be wrong by 2e-3 to 2e-5 on the coarser of these grids."""
    scenes = (Scene(Layer(), PowerIndenter(exponent), 2e-3, num_points=n) for n in (2**12, 2**16))
    coarse, fine = (solve(scene).observables for scene in scenes)
    assert abs(coarse.kappa_subgrid / fine.kappa_subgrid - 1) < 1e-4
    assert abs(coarse.kappa_subgrid - fine.kappa_subgrid) <= coarse.kappa_error


@pytest.mark.parametrize("size", [2**12, 2**16, 2**20])
def test_wide_patches_are_well_known(size):
    """Also where the fourth power of their nodes is no 64-bit integer."""
    x = np.arange(float(size))
    pressure = np.sqrt((x + 0.3) * (size - 0.6 - x))
    found = on_half_space(Patches(4 * size, np.array([9]), np.array([size + 8])), pressure)
    assert 0 < found.end_errors.sum() < 0.02


@pytest.mark.parametrize("seed", range(8))
def test_the_kernel_has_the_formulas(seed):
    """On patches of every size in every order, whose pressures look like edges or do not, under any curve."""
    rng = np.random.default_rng(seed)
    n = 4096
    contact = np.repeat(rng.random(n // 8) < 0.5, rng.integers(1, 9, n // 8))[: n // 2]
    patches = Patches.of(np.append(contact, np.zeros(n - contact.size, dtype=bool)))
    from_ends = np.minimum(patches.step + rng.random(), patches.size[patches.label] - patches.step - rng.random())
    pressure = np.sqrt(np.maximum(from_ends, 0)) * (1 + 0.1 * (seed % 3) * rng.random(patches.nodes.size))
    curves = half_space_curve(), layer_on_grid(Layer(3 / n, 0.5), n, 1.0).edge_curve
    for curve in curves:
        theta, spread, alone = pressed_ends(curve, patches, pressure)
        expected, off, pressures = edge_formulas.offsets(curve, patches, pressure, edge_formulas.in_patch)
        np.testing.assert_allclose(alone, pressures, rtol=1e-9)
        np.testing.assert_allclose(theta, expected, atol=1e-9)
        np.testing.assert_allclose(spread, off, rtol=1e-6, atol=1e-9)
    told = patches.size > 2
    theta, spread, _ = pressed_ends(curves[0], patches, pressure, told)
    expected, off, _ = edge_formulas.offsets(curves[0], patches, pressure, edge_formulas.in_row)
    known = told & (off < edge_formulas.ALIKE)
    assert known.any()
    expected = expected + edge_formulas.by_load(curves[0], patches, expected, known)
    np.testing.assert_allclose(theta, expected, atol=1e-9)
    np.testing.assert_allclose(spread, off, rtol=1e-6, atol=1e-9)
