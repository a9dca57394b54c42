"""How the search of the active set ends: on extreme scenes, given up, handed over, limited, interrupted."""

import itertools
import math
import time

import numpy as np
import pytest
from linecontact.solver import (
    CoatedHalfSpace,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    solve,
)
from linecontact.solver.endings import Cause
from linecontact.solver.grid.problem import foundation_pressure
from linecontact.solver.methods import ExecutionConfig, active_set
from linecontact.solver.methods.active_set.active_set import ActiveSet
from linecontact.solver.strategy import run as attempts
from linecontact.solver.strategy.run import Run


@pytest.mark.parametrize("num_points", [2**12, 2**14])
def test_beyond_rounding_the_search_ends_soon_and_keeps_its_contact(num_points):
    """Conjugate gradients diverged for hundreds of iterations, and then every node was taken for a contact."""
    scene = Scene(indenter=RoughIndenter(0.8, 0, cut_off_ratio=4096 / num_points), pressure=0.01, num_points=num_points)
    usual, beyond = solve(scene), solve(scene, tolerance=1e-12)
    assert (usual.status, beyond.status) == (Status.CONVERGED, Status.STAGNATED)
    assert beyond.iterations < usual.iterations + 60
    np.testing.assert_array_equal(beyond.contact, usual.contact)


@pytest.mark.parametrize("nested", [True, False])
@pytest.mark.parametrize(
    ("heights", "load"),
    [
        (np.abs(np.arange(2048) - 1024) / 2048.0, 1e-9),  # one node carries everything
        (np.where(np.arange(2048) == 77, 0.0, 1.0), 1e-3),  # a needle
        (np.where(np.arange(2048) % 2 == 0, 0.0, 1.0), 1e-3),  # 1024 patches of one node
        ((np.arange(2048) // 128 % 2).astype(float), 1e-3),  # flat punches: all nodes at one height
        (1e-3 * np.cos(2 * np.pi * np.arange(2048) / 2048), 1.0),  # full contact
        (np.where(np.arange(2048) == 5, 0.1, np.where(np.arange(2048) == 900, 0.0, 0.01)), 10.0),  # all but one node
        (np.random.default_rng(1).standard_normal(2048), 1.0),  # white noise, hundreds of patches
        (np.random.default_rng(2).integers(0, 2, 2048) * 1.0, 1e-4),  # random plateaus, where sets come back
    ],
)
@pytest.mark.parametrize("d", [math.inf, 0.01, 1e-5])
def test_every_search_ends(heights, load, d, nested):
    solution = solve(
        Scene(Layer(d, 0.3), MeasuredIndenter(heights, convention="gap"), load, num_points=2048), nested=nested
    )
    assert solution.status is Status.CONVERGED
    assert solution.contact_pressure.mean() == pytest.approx(load, rel=1e-6)
    assert (solution.displacement <= solution.scene.profile).all()
    assert 0 < solution.observables.contact_area_subgrid <= 1


def test_hand_over_is_said(monkeypatch):
    """A search that gives up leaves its last displacement to mass-weighted FIRE."""

    def give_up(self):
        self.stopped = True
        return True

    monkeypatch.setattr(ActiveSet, "_update_set", give_up)
    solution = solve(Scene(Layer(0.1), num_points=2**10), nested=False)
    assert solution.handed_over
    assert solution.status is Status.CONVERGED
    assert solution.to_dict()["handed_over"] is True
    assert solution.transform_pairs > 20


def test_a_search_without_any_solution_is_followed_by_fire_from_a_foundation(monkeypatch):
    """From a layer at rest it does not converge on this coating."""
    starts = []
    monkeypatch.setattr(ActiveSet, "step", lambda self: setattr(self, "stopped", True))
    monkeypatch.setattr(
        attempts, "foundation_pressure", lambda problem: starts.append(1) or foundation_pressure(problem)
    )
    scene = Scene(CoatedHalfSpace(0.01, 1e-3), RoughIndenter(0.8, 0, cut_off_ratio=1 / 32), 1e-3, num_points=2**10)
    solution = solve(scene, nested=False)
    assert (starts, solution.handed_over, solution.status) == ([1], True, Status.CONVERGED)


def where_no_search_is_cautious(monkeypatch):
    """As in single precision; and hard sets are iterated on."""
    monkeypatch.setattr(active_set.active_set, "HARD", 0)
    monkeypatch.setattr(active_set.active_set, "_SOFT", 0)


def test_stiff_coating_on_which_the_search_does_not_settle(monkeypatch):
    """Its sets fall into ever more patches; the true contact is one patch, and the certificate, which no method shares,
    is met: by a cautious search, or, where that is not tried, by the other method. There a limit of
    one's own is kept, and what the search does not need of it is the other method's.
    """
    scene = Scene(CoatedHalfSpace(3e-3, base_modulus=1e-5), PowerIndenter(2), pressure=1e-4, num_points=2**10)
    anew = solve(scene)
    assert (anew.status, anew.handed_over, anew.observables.num_patches) == (Status.CONVERGED, False, 1)
    where_no_search_is_cautious(monkeypatch)
    solution = solve(scene)
    np.testing.assert_array_equal(solution.contact, anew.contact)
    assert solution.handed_over
    assert solution.status is Status.CONVERGED
    assert solution.certificate.equilibrium_residual <= solution.tolerance == 1e-8
    assert solution.observables.num_patches == 1
    limited = solve(scene, max_iterations=2000)
    assert limited.status is Status.ITERATION_LIMIT
    assert limited.iterations == 2000
    assert solve(scene, max_iterations=20_000).iterations == solution.iterations


def test_grids_that_were_not_solved_do_not_count_in_an_estimated_error():
    """Under this coating the search does not settle on the coarser grid either."""
    coating = CoatedHalfSpace(2**-8, base_modulus=1e-4)
    fine, coarse = (solve(Scene(coating, pressure=1e-3, num_points=n)).observables for n in (2**12, 2**10))
    assert fine.contact_area_error < 1e-4
    off = abs(fine.contact_area_subgrid - coarse.contact_area_subgrid)
    assert off < 2 * (fine.contact_area_error + coarse.contact_area_error)


def test_after_a_hand_over_in_vain_the_status_is_the_first_method_s(monkeypatch):
    monkeypatch.setattr(ActiveSet, "_update_set", lambda self: setattr(self, "stopped", True) or True)
    monkeypatch.setattr(attempts, "_MOST_WORK", 2**10)  # one iteration more
    solution = solve(Scene(Layer(0.1), num_points=2**10), nested=False)
    assert solution.handed_over
    assert solution.status is Status.STAGNATED
    assert solution.reason.cause is Cause.METHOD


def test_every_grid_of_an_accuracy_begins_with_the_search_s_own_limit():
    found, run = [], Run(Scene(), active_set.KIND, ExecutionConfig())
    for iterations in (20_000, 2000):  # those of a hand-over, then the next grid's
        run.allow(iterations)
        found.append(run.left)
    assert found == [20_000, 2000]


@pytest.mark.parametrize("where", ["step", "start_from_pressure"])
@pytest.mark.parametrize("nested", [True, False])
def test_interrupted_anywhere(monkeypatch, where, nested):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(ActiveSet, where, interrupt)
    solution = solve(Scene(num_points=2**12), nested=nested)
    assert solution.status is Status.INTERRUPTED
    assert (solution.displacement <= solution.scene.profile).all()


def test_interrupted_on_a_coarse_grid(monkeypatch):
    def interrupt(iteration, residual):
        raise KeyboardInterrupt

    monkeypatch.setattr(time, "monotonic", itertools.count().__next__)  # a report in every iteration
    solution = solve(Scene(num_points=2**12), progress=interrupt)
    assert solution.status is Status.INTERRUPTED
    assert solution.displacement.shape == (2**12,)
    assert not solution.handed_over


def test_iteration_limit_on_a_coarse_grid():
    solution = solve(Scene(num_points=2**12), max_iterations=3)
    assert solution.status is Status.ITERATION_LIMIT
    assert solution.iterations == 3
