"""Ends of narrow gaps: Westergaard's wave up to full contact, and gaps between patches of a layer."""

import math

import numpy as np
import pytest
from linecontact.solver import CoatedHalfSpace, Layer, MeasuredIndenter, PowerIndenter, Scene, SlidingLayer, solve
from linecontact.solver.grid.contact import contact_edges
from linecontact.solver.grid.problem import Problem
from linecontact.solver.reference.closed_forms import periodic_half_space_area

DEPTH = 0.01


def wave(num_points, beside, waves=1):
    """Heights DEPTH (1 - cos), the middle of a gap `beside` spacings from a node."""
    return MeasuredIndenter(
        DEPTH * (1 + np.cos(2 * np.pi * waves * (np.arange(num_points) - beside) / num_points)), convention="gap"
    )


def open_share(load, waves=1):
    """Share of the period that is open under a mean pressure over E* (H. M. Westergaard (1939))."""
    return 1 - 2 / math.pi * math.asin(math.sqrt(load / (math.pi * waves * DEPTH)))


@pytest.mark.parametrize("beside", [0.0, 0.2, 0.45, 100.3])
@pytest.mark.parametrize("nodes", [1.7, 2.6, 4.3, 8.1, 15.4, 30.2])
def test_a_gap_of_few_nodes_ends_where_westergaard_says(nodes, beside):
    n = 2**12
    load = math.pi * DEPTH * math.cos(math.pi * nodes / n / 2) ** 2
    assert open_share(load) == pytest.approx(nodes / n)
    solution = solve(Scene(indenter=wave(n, beside), pressure=load, num_points=n))
    found, patches = solution.observables, solution.patches
    gap = (1 - found.contact_area_subgrid) * n
    assert gap == pytest.approx(nodes, abs=2e-4)
    middle = (patches.right[0] * n + gap / 2 - beside + n / 2) % n - n / 2
    assert middle == pytest.approx(0, abs=1e-4)
    assert abs(gap - nodes) < found.contact_area_error * n < 0.2


def test_ends_deep_inside_their_patches_are_not_believed():
    """Beside a gap of 13 nodes under a profile that rises there to the 28th power."""
    found = solve(Scene(Layer(math.inf), PowerIndenter(exponent=27.85), pressure=5.789e-12, num_points=70)).observables
    off = abs(found.contact_area_subgrid - periodic_half_space_area(27.85, 1.0, 5.789e-12))
    assert off <= min(found.contact_area_error, 1 / 70)


@pytest.mark.parametrize("layer", [Layer(0.05), Layer(0.05, 0.5), SlidingLayer(0.03), CoatedHalfSpace(0.04, 0.1)])
def test_gaps_on_layers(layer):
    """Five waves, so that five gaps and five patches take turns, beside the grid of 16 times as many points."""
    n, waves = 2**10, 5
    full = math.pi * DEPTH * waves
    for share in (0.97, 0.99):
        load = share * full * float(layer.stiffness(np.array([2 * np.pi * waves]), 1.0)[0]) / (math.pi * waves)
        coarse, fine = (
            solve(Scene(layer, wave(points, points / n * 0.3, waves), load, num_points=points)).observables
            for points in (n, 16 * n)
        )
        assert fine.contact_area_subgrid < 1
        error = abs(coarse.contact_area_subgrid - fine.contact_area_subgrid)
        assert error < 5 * 1e-3 / n


@pytest.mark.parametrize("share", [1e-4, 0.01, 0.3, 0.9, 0.99, 0.999, 1 - 1e-4, 1 - 1e-5, 1 - 3e-6, 1 - 1e-6])
def test_the_curve_of_a_wave_from_first_touch_to_full_contact(share):
    n, load = 2**14, share * math.pi * DEPTH
    found = solve(Scene(indenter=wave(n, n // 2 + 0.3), pressure=load, num_points=n), tolerance=1e-11).observables
    assert found.contact_area_subgrid == pytest.approx(1 - open_share(load), abs=1e-8)


def test_gaps_tell_nothing_where_the_profile_is_not_known_between_the_nodes():
    """Noise from node to node: the ends are those that the pressures tell."""
    n = 2**10
    noisy = MeasuredIndenter(wave(n, 0.3, 5).heights + np.random.default_rng(2).uniform(0, 3e-4, n), convention="gap")
    solution = solve(Scene(indenter=noisy, pressure=0.6 * math.pi * 5 * DEPTH, num_points=n))
    problem = Problem.from_scene(solution.scene)
    _, _, patches, edges = contact_edges(problem, solution.contact_pressure, solution.displacement)
    by_pressures = contact_edges(problem, solution.contact_pressure).ends
    h = solution.scene.profile
    jagged = np.zeros(n, dtype=bool)
    for node in range(n):
        around = h[(node + np.arange(-2, 3)) % n]
        jagged[node] = abs(around @ [1, -4, 6, -4, 1]) > 1.9 * abs(around @ [0, 1, -2, 1, 0])
    middle = patches.last + (np.roll(patches.first, -1) - patches.last) // 2
    narrow = np.flatnonzero((patches.size >= 3) & (np.roll(patches.size, -1) >= 3) & (patches.gap[1] == 1))
    narrow = narrow[jagged[middle[narrow] % n] & ~edges.by_load[narrow]]
    assert narrow.size > 2
    np.testing.assert_array_equal(edges.right[narrow], by_pressures.right[narrow])


@pytest.mark.parametrize("nodes", [1.8, 3.1, 5.4, 16.2])
def test_contact_stiffness_beside_a_gap_of_few_nodes(nodes):
    """Westergaard: d(approach)/dp = -(2 L/(pi E*)) ln sin(pi a/L)."""
    n = 2**12
    load = math.pi * DEPTH * math.cos(math.pi * nodes / n / 2) ** 2
    exact = -math.pi / (2 * math.log(math.cos(math.pi * nodes / n / 2)))
    for beside in (0.0, 0.3, 0.45):
        solution = solve(Scene(indenter=wave(n, beside), pressure=load, num_points=n), tolerance=1e-11)
        assert solution.contact_stiffness == pytest.approx(exact, rel=1e-4)
