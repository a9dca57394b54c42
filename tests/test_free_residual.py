"""The active set knows from its contact nodes what free residual the certificate is going to find."""

import numpy as np
import pytest
from linecontact.solver import Layer, RoughIndenter, Scene, certify, solve
from linecontact.solver.grid.patches import Patches
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods import ExecutionConfig, active_set, relax
from linecontact.solver.methods.active_set import free_residual as module
from linecontact.solver.methods.active_set.free_residual import free_residual
from linecontact.solver.strategy import certification


def rough(hurst, d, seed=0, pressure=0.01):
    return Scene(Layer(d), RoughIndenter(hurst, seed, 1 / 8, 1 / 32), pressure=pressure, num_points=2**14)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
@pytest.mark.parametrize("pressure", [0.01, 0.5])
@pytest.mark.parametrize(("hurst", "d"), [(0.8, np.inf), (0.3, np.inf), (0.8, 0.01)])
def test_against_the_certificate(hurst, d, pressure, tolerance):
    problem = Problem.from_scene(rough(hurst, d, 3, pressure))
    state = active_set.begin(problem, ExecutionConfig(tolerance, "float64"))
    relax(state, 1000)
    now = state._now
    touching = state._response.touching(now)
    expected = free_residual(problem, now.patches, touching.mean() - touching)
    found = certify(problem, state.displacement)[0].free_residual
    assert 0.5 * expected < found < expected


def test_by_hand():
    """One node that is moved by 1, between two that stay: (K d)^2 is summed over all nodes, a straight K = q."""
    problem = Problem.from_scene(Scene(num_points=256))
    patches = Patches.of_nodes(np.array([9, 10, 11]), 256)
    slope = problem.stiffness[-1] / np.pi * np.sqrt(1 - 1 / 128**2)
    expected = 0.9 * slope * np.sqrt(2 / 253)
    assert module._FOUND == 0.9
    assert free_residual(problem, patches, np.array([0.0, 1.0, 0.0])) == pytest.approx(expected, rel=1e-3)
    alone = Patches.of_nodes(np.array([9, 20]), 256)  # what one patch does is no difference to the next
    assert free_residual(problem, alone, np.array([1.0, 1.0])) == pytest.approx(
        0.9 * slope * np.sqrt(4 / 254), rel=1e-3
    )


def test_nothing_is_known_where_long_waves_are_the_stiffest():
    problem = Problem.from_scene(Scene(Layer(1e-4, 0.5), pressure=1.0, num_points=1024))
    assert free_residual(problem, Patches.of_nodes(np.arange(9), 1024), np.arange(9.0)) == 0


def test_a_solve_is_certified_once(monkeypatch):
    """The residual of this one is as small as it should be when its free residual is not yet."""
    scene, calls = rough(0.8, np.inf, seed=17), []

    def counted(*given):
        calls.append(given)
        return certify(*given)

    monkeypatch.setattr(certification, "certify", counted)
    assert solve(scene).status == "converged"
    assert len(calls) == 1
    monkeypatch.setattr(active_set.active_set, "free_residual", lambda *_: 0.0)
    assert solve(scene).status == "converged"
    assert len(calls) == 3
