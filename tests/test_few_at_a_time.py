"""Sets that are solved by elimination, and searches that begin anew with few nodes at a time."""

import math

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
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods import ExecutionConfig, active_set, relax
from linecontact.solver.methods.active_set import elimination, few_at_a_time, preconditioner
from linecontact.solver.methods.active_set.contact_set import ContactSet
from linecontact.solver.methods.active_set.few_at_a_time import FewAtATime, first_nodes
from linecontact.solver.methods.active_set.greens_function import GreensFunction, Tables
from linecontact.solver.methods.active_set.search import Search


def test_when_a_search_has_failed():
    """Where it ends far from a solution, after many updates, after fewer under a stiff coating if much of the set
    pulls, and where sets come back.
    """
    for updates, pulling, early, residual, ended, failed in (
        (3, 0.1, True, 1.0, True, True),
        (3, 0.5, True, 1.0, False, False),
        (3, 0.1, True, 1e-6, True, False),
        (3, 0.1, True, math.nan, True, True),
        (4, 0.1, True, 1.0, False, False),
        (4, 0.5, False, 1.0, False, False),
        (4, 0.5, True, 1.0, False, True),
        (4, 0.5, True, 1e-6, False, False),
        (21, 0.1, False, 1.0, False, True),
        (21, 0.1, False, 1e-6, False, False),
        (41, 0.1, False, 1e-3, False, True),
        (41, 0.1, False, 1e-6, False, False),
        (201, 0.1, False, 1e-6, False, True),
    ):
        search = Search(updates=updates, pulling=pulling, in_vain=1)
        assert search.has_failed(residual, 1e-8, ended, early) is failed
    assert not Search(updates=21, in_vain=0).has_failed(1.0, 1e-8, ended=False, early=False)  # it is getting on
    assert not Search().has_failed(0.01, 0.1, ended=True, early=True)
    assert Search(circling=True).has_failed(1e-12, 1e-8, ended=True, early=True)


def test_with_which_nodes_a_search_begins_anew():
    """Those that it has started with, or else the lowest one, on small grids or with few nodes in contact."""
    height = np.abs(np.arange(2**15) - 77.0)
    assert first_nodes(height, np.arange(9), 2**14).tolist() == list(range(9))
    assert first_nodes(height, None, 1025) is None
    assert first_nodes(height, None, 1024).tolist() == [77]
    assert first_nodes(height[: 2**14], None, 2**13).tolist() == [77]


def test_beginning_anew_on_a_large_grid():
    """With the nodes of the start, on all nodes, although the packed operator suits the few; and once only."""
    n = 2**17
    search = active_set.begin(Problem.from_scene(Scene(Layer(), num_points=n)), ExecutionConfig(1e-8))
    pressure = np.zeros(n)
    pressure[:5000] = 1
    search.start_from_pressure(pressure)
    assert not search._response.plain
    assert not search._begun_anew(ended=False)
    search._search.circling = True
    assert search._begun_anew()
    assert search._response.plain
    np.testing.assert_array_equal(search._now.nodes, np.arange(5000))
    search._search.circling = True
    assert not search._begun_anew()


def test_how_many_nodes_are_added_at_a_time():
    """None while nodes pull; the deepest, and fewer or more of them by how many of the last ones were dropped."""
    few, nodes, gap = FewAtATime(), np.arange(100), np.abs(np.arange(100) - 50.0)
    assert few.to_add(nodes, gap, 3, 40).size == 0
    assert few.to_add(nodes, gap, 0, 40).tolist() == list(range(45, 56))
    few.to_add(nodes, gap, 3, 51)
    assert few.to_add(nodes, gap, 0, 48).size == 4
    assert few.to_add(nodes, gap, 0, 48).size == 7
    assert few.to_add(nodes, gap, 0, 48).size == 13
    assert few.to_add(nodes, gap, 0, 48).size == 13
    assert few.to_add(nodes[:0], gap[:0], 0, 48).size == 0
    few.share, few.dropped = 1 / 48, 9
    assert few.to_add(nodes, gap, 0, 48).size == 2


def test_many_iterations_on_one_set_are_followed_by_more_coarse_unknowns(monkeypatch):
    few = FewAtATime()
    assert not few.takes_more(99, 2.0)
    assert not few.takes_more(2000, 1.0)  # each patch has its own
    assert few.takes_more(100, 2.0)
    assert not few.takes_more(100, 2.0)  # there are no more
    assert few.unknowns == 4096

    monkeypatch.setattr(few_at_a_time, "_MANY", 3)
    monkeypatch.setattr(preconditioner, "_unknowns", lambda num_points: 4)
    scene = Scene(CoatedHalfSpace(0.1, 0.1), RoughIndenter(0.8, 1, 1 / 8, 1 / 64), 1e-2, num_points=2**12)
    state = active_set.begin(Problem.from_scene(scene), ExecutionConfig(1e-8))
    state.start_cold()
    state._search = Search(few_at_a_time=FewAtATime(work=1e13, unknowns=4), forcing_term=few_at_a_time.FORCING_TERM)
    state.step()
    assert state._now.preconditioner.share > 1
    for _ in range(3):
        state.step()
    assert state._now.preconditioner.share == 1
    assert relax(state, 2000) is Status.CONVERGED
    np.testing.assert_array_equal(state.contact_pressure > 0, solve(scene).contact)


def test_nodes_that_pull_are_dropped_one_after_the_other_where_that_lowers_the_energy():
    """All at once first; where the energy is to be less than that gives, on a way down from the pressure before."""
    rough = RoughIndenter(0.5, 2, 1 / 8, 1 / 32)
    problem = Problem.from_scene(Scene(CoatedHalfSpace(1e-3, 5e-5), rough, 1e-5, num_points=2**11))
    green = GreensFunction(Tables(problem.rigidity.response))
    nodes = np.sort(np.argsort(problem.height)[:300])
    height, pressure = problem.height[nodes], np.full(300, 2**11 / 300)

    def energy(nodes, pressure):
        everywhere = np.zeros(2**11)
        everywhere[nodes] = pressure
        response = np.fft.irfft(np.append(0.0, 1 / problem.stiffness[1:]) * np.fft.rfft(everywhere), 2**11)
        return float(everywhere @ (response / 2 + problem.height))

    few = FewAtATime()
    quickly = few.without_pull(green, nodes, height, pressure)
    assert few.energy == pytest.approx(energy(*quickly), rel=1e-9)
    carefully = few.without_pull(green, nodes, height, pressure)
    assert carefully[0].size != quickly[0].size
    for some, found in (quickly, carefully):
        assert (found >= 0).all()
        assert found.sum() == pytest.approx(2**11, rel=1e-9)
        assert energy(some, found) < energy(nodes, pressure)
    with pytest.raises(np.linalg.LinAlgError):
        FewAtATime(work=1e13).without_pull(green, nodes, height, pressure)


@pytest.mark.parametrize("even", [False, True])
@pytest.mark.parametrize(
    ("thickness", "base", "pressure"), [(3e-3, 1e-3, 1e-4), (3e-3, 1e-5, 1e-2), (1e-3, 1e-4, 1e-3)]
)
@pytest.mark.parametrize("num_points", [2**9, 2**11, 2**13])
def test_noise_under_a_stiff_coating(num_points, thickness, base, pressure, even):
    """Every node's pressure is felt by all others, and sets on the way are too ill-conditioned to be iterated on."""
    heights = 1e-3 * np.random.default_rng(num_points).standard_normal(num_points)
    if even:
        heights[num_points // 2 :] = heights[: num_points // 2][::-1]
    scene = Scene(
        CoatedHalfSpace(thickness, base), MeasuredIndenter(heights, convention="gap"), pressure, num_points=num_points
    )
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    assert solution.certificate.free_residual < 3e-8  # of which rounding leaves 1e-8
    assert solution.certificate.energy_error_bound < 1e-9


@pytest.mark.parametrize(("thickness", "base", "pressure", "hurst"), [(1e-3, 5e-5, 1e-5, 0.5), (2e-3, 1e-5, 1e-3, 0.8)])
def test_a_rough_surface_under_a_stiff_coating(thickness, base, pressure, hurst):
    """The coarser grid's few hundred nodes grow into thousands unless few are added at a time; the certificate is met
    at once, although the longest waves are a million times as compliant as the shortest.
    """
    scene = Scene(CoatedHalfSpace(thickness, base), RoughIndenter(hurst, 1), pressure, num_points=2**15)
    solution = solve(scene)
    assert (solution.status, solution.handed_over) == (Status.CONVERGED, False)
    assert solution.certificate.free_residual <= 1e-8
    assert solution.certificate.energy_error_bound < 1e-12


@pytest.mark.parametrize("most", [few_at_a_time._MOST, 0])
@pytest.mark.parametrize("even", [False, True])
def test_few_nodes_at_a_time_find_the_same_contact(even, most, monkeypatch):
    """Where the usual search has no difficulty, either; sets are eliminated, or iterated on."""
    heights = RoughIndenter(0.8, 1, 1 / 8, 1 / 8).profile(2**10, 1.0)
    if even:
        heights[2**9 :] = heights[: 2**9][::-1]
    indenter = MeasuredIndenter(heights - heights.min(), convention="gap")
    scenes = [Scene(Layer(d), indenter, 0.02, num_points=2**10) for d in (math.inf, 1e-3)]
    usual = [solve(scene).contact_pressure for scene in scenes]

    def begin(_):
        return Search(few_at_a_time=FewAtATime(), forcing_term=few_at_a_time.FORCING_TERM)

    monkeypatch.setattr(Search, "among", begin)
    for name in ("_MOST", "_MOST_HARD"):
        monkeypatch.setattr(few_at_a_time, name, most)
    for scene, pressure in zip(scenes, usual, strict=True):
        found = solve(scene, nested=False)
        assert found.status is Status.CONVERGED
        assert np.abs(found.contact_pressure - pressure).max() < 1e-6 * pressure.max()


def test_sets_that_are_hard_to_iterate_on_are_eliminated():
    nodes = np.arange(0, 1200, 2)
    now = ContactSet.of(nodes, np.ones(nodes.size), 2**12)
    assert not elimination.suits(now, Search())
    now.iterations = 41
    assert elimination.suits(now, Search())
    now.iterations = 0
    assert elimination.suits(now, Search(few_at_a_time=FewAtATime()))
    assert not elimination.suits(now, Search(few_at_a_time=FewAtATime(work=1e13)))  # as in any other search
    now.iterations, now.eliminated = 41, True
    assert not elimination.suits(now, Search())


@pytest.mark.parametrize("error", [np.linalg.LinAlgError, ZeroDivisionError, None])
def test_where_elimination_fails_conjugate_gradients_go_on(error, monkeypatch):
    def fail(self, nodes, height, load=1.0):
        if error:
            raise error
        return np.full(nodes.size, math.nan), math.nan

    scene = Scene(Layer(0.01), PowerIndenter(), 1e-2, num_points=2**11)
    expected = solve(scene)
    monkeypatch.setattr(GreensFunction, "solve", fail)
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    np.testing.assert_array_equal(solution.contact, expected.contact)


def test_refined_elimination():
    """What rounding of the longest waves has left in a pressure is taken from it."""
    rough = RoughIndenter(0.8, 1, 1 / 8, 1 / 64)
    problem = Problem.from_scene(Scene(CoatedHalfSpace(2e-3, 1e-5), rough, 1e-3, num_points=2**13))
    green = GreensFunction(Tables(problem.rigidity.response))
    modes = np.append(0.0, 1 / problem.stiffness[1:])

    def spread(now):
        touching = (problem.height + np.fft.irfft(modes * np.fft.rfft(everywhere(now)), 2**13))[now.nodes]
        return touching, np.ptp(touching)

    def everywhere(now):
        pressure = np.zeros(2**13)
        pressure[now.nodes] = now.pressure
        return pressure

    now = ContactSet.of(np.arange(0, 2**13, 64), np.ones(128), 2**13)
    now.pressure, _ = green.solve(now.nodes, problem.height[now.nodes])
    touching, before = spread(now)
    assert elimination.refine(now, green, touching, Search())
    assert spread(now)[1] < 0.01 * before
    assert now.pressure.sum() == pytest.approx(2**13, rel=1e-12)
