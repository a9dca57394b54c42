"""Ends of narrow gaps: Westergaard's wave up to full contact, and gaps between patches of a layer."""

import math

import numpy as np
import pytest
from linecontact.solver import CoatedHalfSpace, Layer, MeasuredIndenter, Scene, SlidingLayer, solve

DEPTH = 0.01


def wave(num_points, beside, waves=1):
    """Heights DEPTH (1 - cos), the middle of a gap `beside` spacings from a node."""
    return MeasuredIndenter(DEPTH * (1 + np.cos(2 * np.pi * waves * (np.arange(num_points) - beside) / num_points)))


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
