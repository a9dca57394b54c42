"""Edges of patches that follow each other: H. M. Westergaard's row, from wide gaps to gaps of one grid spacing."""

import math

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
