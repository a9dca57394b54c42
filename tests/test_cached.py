"""What is kept of layers and indenters for the next solve: the same answers, nothing that may be changed, few grids."""

import concurrent.futures
import copy
import pickle
from dataclasses import dataclass, replace

import numpy as np
import pytest
from linecontact.solver import (
    CoatedHalfSpace,
    Indenter,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    solve,
)
from linecontact.solver.grid import cached as cached_module
from linecontact.solver.grid.cached import cached, forget
from linecontact.solver.grid.problem import Problem

ROUGH = RoughIndenter(0.8, 0, cut_off_ratio=1 / 32)
SCENES = [
    Scene(Layer(0.1, 0.3), ROUGH, pressure=0.01, num_points=2**16),
    Scene(Layer(), PowerIndenter(2.0, 1.0), pressure=2e-3, num_points=2**12),
    Scene(CoatedHalfSpace(0.01, 0.1), ROUGH, pressure=0.03, num_points=2**13),
]


@pytest.mark.parametrize("scene", SCENES)
def test_a_second_solve_gives_the_same_numbers(scene):
    forget()
    first, second = solve(scene), solve(scene)
    forget()
    third = solve(scene)
    for other in (second, third):
        np.testing.assert_array_equal(first.displacement, other.displacement)
        np.testing.assert_array_equal(first.contact_pressure, other.contact_pressure)
        assert first.observables == other.observables


def test_another_load_uses_what_is_kept():
    problem = Problem.from_scene(SCENES[0])
    loaded = Problem.from_scene(replace(SCENES[0], pressure=0.1))
    assert loaded.layer is problem.layer
    assert loaded.indenter is problem.indenter


@pytest.mark.parametrize("pressure", [0.01, 1.0])  # the unknown is the pressure, or the displacement of the free nodes
def test_fields_serve_one_solve_after_the_other(pressure):
    forget()
    scene = replace(SCENES[0], pressure=pressure)
    first = solve(scene)
    before = first.displacement.copy()
    reused = solve(replace(scene, pressure=1.1 * pressure))
    forget()
    fresh = solve(replace(scene, pressure=1.1 * pressure))
    np.testing.assert_array_equal(reused.contact_pressure, fresh.contact_pressure)
    np.testing.assert_array_equal(first.displacement, before)


def test_nothing_that_is_kept_can_be_changed():
    problem = Problem.from_scene(SCENES[0])
    for array in (problem.profile, problem.stiffness):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_solves_on_several_threads_share_what_is_kept():
    forget()
    scenes = [replace(SCENES[0], pressure=p) for p in np.geomspace(0.003, 0.1, 8)]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        together = list(pool.map(solve, scenes))
    for scene, found in zip(scenes, together, strict=True):
        alone = solve(scene)
        assert found.status is Status.CONVERGED
        np.testing.assert_array_equal(found.contact, alone.contact)
        np.testing.assert_array_equal(found.contact_pressure, alone.contact_pressure)


@dataclass
class NoHash:
    """A part that cannot be hashed."""

    name: str = "nothing"


def test_what_cannot_be_hashed_or_is_large_is_made_anew_and_few_grids_are_kept(monkeypatch):
    made = []

    @cached
    def make(part, num_points, period):
        made.append(num_points)
        return num_points

    for _ in range(2):
        assert make(NoHash(), 8, 1.0) == 8
        assert make(Layer(), cached_module.MOST_POINTS + 1, 1.0) == cached_module.MOST_POINTS + 1
    assert len(made) == 4
    for n in range(20):
        make(Layer(), n, 1.0)
    made.clear()
    make(Layer(), 19, 1.0)
    make(Layer(), 0, 1.0)
    assert made == [0]


COPIES = [copy.copy, copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))]
HEIGHTS = np.random.default_rng(0).random(2**10)


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize(
    "scene",
    [
        Scene(approach=0.01, num_points=2**10),
        Scene(Layer(0.1), MeasuredIndenter(HEIGHTS, convention="heights"), 0.1, num_points=2**10),
        Scene(CoatedHalfSpace(0.1, 2.0), approach=0.01, num_points=2**10),
    ],
)
def test_copies_are_equal_and_as_read_only(copied, scene):
    solution = solve(scene)
    _ = solution.warnings, solution.contact_stiffness  # computed on first use: no part of what is compared
    assert copied(scene) == scene
    assert hash(copied(scene)) == hash(scene)
    assert copied(solution) == solution
    assert copied(scene) != replace(scene, period=2.0)
    assert copied(Layer()).has_default_modulus
    if isinstance(scene.indenter, MeasuredIndenter):
        with pytest.raises(ValueError, match="read-only"):
            copied(scene.indenter).heights[0] = 1.0
        assert copied(scene.indenter) != MeasuredIndenter(HEIGHTS[::-1], convention="heights")


class Own(Indenter):
    """An indenter of one's own."""

    name = "own"

    def profile(self, num_points, period):
        return (self.heights - self.heights.min())[:: self.heights.size // num_points]

    def shortest_wave(self, num_points):
        return 0

    def to_dict(self):
        return {"profile": self.name}


@dataclass(frozen=True, eq=False)
class Frozen(Own):
    """Its array can be written to."""

    heights: np.ndarray


class Plain(Own):
    """Its attributes can be set."""

    def __init__(self, heights):
        self.heights = heights


def wave(depth):
    return depth * (1 - np.cos(2 * np.pi * np.arange(2**12) / 2**12))


@pytest.mark.parametrize("kind", [Frozen, Plain])
def test_an_indenter_that_is_changed_after_a_solve_is_solved_as_it_is_now(kind):
    indenter, found = kind(wave(0.1)), []
    scene = Scene(Layer(), indenter, 0.1, num_points=2**12)
    for depth in (0.1, 0.5):
        indenter.heights[:] = wave(depth)
        found.append(solve(scene).observables.contact_area_subgrid)
    westergaard = [2 / np.pi * np.arcsin(np.sqrt(0.1 / np.pi / depth)) for depth in (0.1, 0.5)]
    assert found == pytest.approx(westergaard, rel=1e-3)
