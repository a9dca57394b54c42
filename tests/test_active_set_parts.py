"""Parts of the active set against dense algebra, and its search for the set on made-up numbers."""

import math
import tracemalloc

import numpy as np
import pytest
from linecontact.solver import Layer
from linecontact.solver.grid import layer_on_grid as grid_response
from linecontact.solver.grid.layer_on_grid import LayerOnGrid
from linecontact.solver.grid.patches import Patches
from linecontact.solver.methods.active_set import preconditioner as deflation
from linecontact.solver.methods.active_set.greens_function import GreensFunction, inverse_cholesky, patch_sums


def stiffness(num_points, thickness, nu):
    return layer_response(num_points, thickness, nu).stiffness


def layer_response(num_points, thickness=0.1, nu=0.25):
    return LayerOnGrid(Layer(thickness, nu), num_points, 1.0)


def greens_function(num_points, thickness=0.1, nu=0.25):
    return GreensFunction(layer_response(num_points, thickness, nu))


def contact_map(n, *runs):
    contact = np.zeros(n, dtype=bool)
    for start, length in runs:
        contact[np.arange(start, start + length) % n] = True
    return contact


PATCHES = contact_map(512, (505, 12), (40, 3), (50, 1), (60, 100), (200, 35), (300, 7), (309, 5))


def dense(n, d, nu):
    """G without the mean mode, shape (n, n)."""
    k = stiffness(n, d, nu)
    column = np.fft.irfft(np.append(0, 1 / k[1:]), n)
    return column[(np.arange(n)[:, None] - np.arange(n)) % n]


LAYERS = [(math.inf, 0.25), (0.01, 0.25), (1e-4, 0.0), (0.02, 0.5)]


@pytest.mark.parametrize(("d", "nu"), LAYERS)
def test_elimination_against_the_gap(d, nu):
    """With that pressure the gap is one constant on the set, and the load is p."""
    n, nodes = PATCHES.size, np.flatnonzero(PATCHES)
    height = np.random.default_rng(0).random(n)
    pressure = greens_function(n, d, nu).solve(nodes, height[nodes])
    assert pressure.sum() == pytest.approx(n)
    gap = height[nodes] + dense(n, d, nu)[np.ix_(nodes, nodes)] @ pressure
    assert np.ptp(gap) < 1e-9 * np.abs(pressure).max() * np.abs(dense(n, d, nu)).max()


@pytest.mark.parametrize(("d", "nu"), LAYERS)
def test_coarse_matrix_against_the_triple_product(d, nu):
    patches, n = Patches.of(PATCHES), PATCHES.size
    z = np.zeros((n, patches.count))
    z[patches.nodes, patches.label] = 1
    expected = z.T @ dense(n, d, nu) @ z
    found = patch_sums(layer_response(n, d, nu).second_sum, patches.first, patches.last)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize(("d", "nu"), LAYERS)
def test_one_factor_inverts_every_patch(d, nu):
    green = dense(512, d, nu)
    factor = inverse_cholesky(green[0][:100])
    for m in (1, 2, 17, 100):
        inverse = factor[:m, :m].T @ factor[:m, :m]
        np.testing.assert_allclose(inverse @ green[:m, :m], np.eye(m), atol=1e-9)


@pytest.mark.parametrize(("longest", "unknowns"), [(256, 100), (16, 3)])
@pytest.mark.parametrize(("d", "nu"), LAYERS)
def test_preconditioner(d, nu, unknowns, longest, monkeypatch):
    """Symmetric, positive on loads of zero sum, near the inverse; long patches and shared unknowns included."""
    monkeypatch.setattr(deflation, "SMALL", longest)
    monkeypatch.setattr(deflation, "_unknowns", lambda n: unknowns)
    patches = Patches.of(PATCHES)
    check_preconditioner(d, nu, patches, 6 if unknowns == 100 else 60)


def check_preconditioner(d, nu, patches, condition):
    m = patches.nodes.size
    preconditioner = deflation.PatchDeflation(greens_function(512, d, nu), patches)
    matrix = np.stack([preconditioner(e) for e in np.eye(m)], axis=1)
    size = np.abs(matrix).max()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-9 * size)
    np.testing.assert_allclose(matrix.sum(axis=0), 0, atol=1e-9 * size)  # keeps the load, ignores a constant
    green = dense(512, d, nu)[np.ix_(patches.nodes, patches.nodes)]
    values = np.sort(np.linalg.eigvals(matrix @ green).real)[1:]
    assert values[0] > 0
    # what deflation is for: a small condition number whatever the layer and the patches
    assert values[-1] / values[0] < condition


def test_a_coarse_matrix_that_rounding_has_spoilt():
    coarse = np.array([[-0.02, 1.0], [1.0, 2.0]])
    factor = deflation._inverse_factor(coarse, np.array([0.5, 0.7]))
    assert factor.T @ factor == pytest.approx(np.diag([1 / 0.5, 1 / 2.0]))


def test_memory_of_many_patches():
    """The coarse matrix grows with the patches, not with their square."""
    contact = np.random.default_rng(0).random(2**17) < 0.2
    green = greens_function(2**17)
    green.layer.second_sum  # noqa: B018
    tracemalloc.start()
    preconditioner = deflation.PatchDeflation(green, Patches.of(contact))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert preconditioner.patches.count > 20_000
    assert peak < 250 * 2**17  # bytes a point


@pytest.mark.parametrize(("thickness", "nu"), [(math.inf, 0.25), (0.1, 0.25), (1e-3, 0.3), (0.03, 0.5), (0.01, 0.499)])
def test_a_long_patch_is_nearly_inverted(thickness, nu):
    """Also on thin and nearly incompressible layers, where K reaches far: 0.04 to 2 if it were taken for short."""
    size, green = 500, greens_function(4096, thickness, nu)
    matrix = np.take(green.layer.whole, np.arange(size)[:, None] - np.arange(size), mode="wrap")
    patch = deflation.LongPatch(green, size)
    inverse = np.stack([patch(unit) for unit in np.eye(size)])
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-12 * np.abs(inverse).max())
    values = np.linalg.eigvals(inverse @ matrix).real
    assert 0.4 < values.min() <= values.max() < 2.1


def test_what_is_kept_of_large_grids(monkeypatch):
    """The same values, and nothing after a rest; where G has two parts, its head does not need it on all nodes."""
    small = layer_response(4096)
    kept = {name: getattr(small, name) for name in ("compliance", "whole", "second_sum")}
    monkeypatch.setattr(grid_response, "MOST_POINTS", 0)
    large = layer_response(4096)
    for name, value in kept.items():
        np.testing.assert_array_equal(getattr(large, name), value)
    large.rest()
    assert not kept.keys() & vars(large).keys()
    parted = layer_response(2**16)
    parted.head(64), parted.second_sum
    assert parted.split
    assert kept.keys() & vars(parted).keys() == {"second_sum"}
