"""The extremes: every defect that the map has found, each with the scene that showed it."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from linecontact.kernels import layout
from linecontact.solver import (
    METHODS,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    certify,
    solve,
)
from linecontact.solver.endings import Cause
from linecontact.solver.grid import edges
from linecontact.solver.grid.layer_on_grid import layer_on_grid
from linecontact.solver.grid.patches import Patches
from linecontact.solver.grid.problem import Problem
from linecontact.solver.methods.mass_weighted_fire import MassWeightedFire
from linecontact.solver.reference import closed_forms, collocation
from linecontact.solver.strategy import small_models
from linecontact.studies.extremes import study as extremes
from linecontact.studies.extremes import verdicts


def measured(heights, layer=None, pressure=1e-3, **changes):
    heights = np.asarray(heights, dtype=np.float64)
    return Scene(
        layer or Layer(), MeasuredIndenter(heights, convention="gap"), pressure, num_points=heights.size, **changes
    )


@pytest.mark.parametrize("num_points", [4, 5, 6, 7, 8, 9, 13, 27, 31, 64])
@pytest.mark.parametrize("layer", [Layer(), Layer(0.05, 0.3), Layer(0.01, 0.5)])
def test_small_and_odd_grids_against_every_contact_set(num_points, layer):
    """The dense problem, solved by dropping and adding nodes one at a time, which shares nothing with the methods."""
    rng = np.random.default_rng(num_points)
    scene = measured(rng.random(num_points), layer, 0.05)
    problem = Problem.from_scene(scene)
    # sigma = p - K u, with K as a matrix from the modes' definition
    k = np.fft.fftfreq(num_points, 1 / num_points).astype(int)
    waves = np.exp(2j * np.pi * np.outer(np.arange(num_points), k) / num_points)
    matrix = (waves * problem.stiffness[np.abs(k)]) @ waves.conj().T / num_points
    assert np.abs(matrix.imag).max() < 1e-12
    matrix, h = matrix.real, problem.height
    contact = h == 0
    for _ in range(100):
        u, free = h.copy(), ~contact
        if free.any():
            u[free] = np.linalg.solve(matrix[np.ix_(free, free)], 1 - matrix[np.ix_(free, contact)] @ h[contact])
        force = 1 - matrix @ u
        above, pulls = np.where(free, u - h, -1.0), np.where(contact, -force, -1.0)
        if max(above.max() / np.ptp(h), pulls.max()) < 1e-9:
            break
        if above.max() > 0:
            contact[above.argmax()] = True
        else:
            contact[pulls.argmax()] = False
    for method in ("active-set", "mass-weighted-fire", "fire"):
        solution = solve(scene, method=method, tolerance=1e-11)
        assert solution.status is Status.CONVERGED
        np.testing.assert_array_equal(solution.contact, contact)
        np.testing.assert_allclose(solution.contact_pressure / scene.pressure, np.where(contact, force, 0), atol=1e-8)


@pytest.mark.parametrize(
    ("method", "precision"),
    [*((name, "float64") for name in METHODS), *((name, "mixed") for name in ("mass-weighted-fire", "fire"))],
)
def test_start_from_another_scene(method, precision):
    scene = Scene(Layer(0.02, 0.45), RoughIndenter(0.8, 1, 1 / 2, 1 / 8), 0.02, num_points=243, precision=precision)
    cold = solve(scene, method=method)
    rng = np.random.default_rng(0)
    full = solve(Scene(pressure=10.0, num_points=243)).displacement
    for initial in (full, -1e35 * rng.random(243), 1e12 * rng.standard_normal(243), np.full(243, 1e-300)):
        warm = solve(scene, method=method, initial=initial)
        assert warm.status is Status.CONVERGED
        np.testing.assert_array_equal(warm.contact, cold.contact)


@pytest.mark.parametrize("gradient", [1e-30, 1e-8, 1e4, 1e30])
@pytest.mark.parametrize("pressure", [1e-30, 1e-6, 1e30])
def test_precisions_agree_far_from_one(gradient, pressure):
    """Heights and displacements that float32 does not hold: denormal, or beyond its largest number."""
    indenter = RoughIndenter(0.8, 2, 1 / 2, 1 / 8, gradient)
    double = solve(Scene(Layer(0.1, 0.3), indenter, pressure, num_points=128))
    other = solve(replace(double.scene, precision="float32"))
    assert other.status is double.status is Status.CONVERGED
    np.testing.assert_array_equal(other.contact, double.contact)
    peak = double.observables.peak_pressure
    np.testing.assert_allclose(other.contact_pressure, double.contact_pressure, atol=1e-3 * peak)


THIN = [
    # a set of three nodes, carried over from a coarser grid, where one touches: CG drowned in rounding
    Scene(Layer(4.1584257364427236e-10, 0.5 - 1e-15), pressure=1.606514420494921e-11, num_points=2048),
    Scene(Layer(1.87e-11, 0.5 - 1e-12), PowerIndenter(1.01, 532.0), 0.0616, num_points=4096),
    # displacements of 1e-31 p L/E*, velocities below what marks the wall
    Scene(Layer(1.9646154159209253e-12, 0.5), PowerIndenter(64.0), 2.381039245412806e-13, num_points=1048),
    # the stiffest mode beyond float32
    Scene(Layer(1.68e-12, 0.5), pressure=0.11, num_points=36, precision="mixed"),
    Scene(Layer(5.5e-12, 0.5), RoughIndenter(0.8, 994901, 0.179, 0.93, 2.65e-3), 0.23, 1.0, 150, "float32"),
    # a load that rounding had eaten
    Scene(Layer(6.7e-10, 0.5 - 1e-12), RoughIndenter(0.8, 704894, 0.0068, 0.22, 18.3), 6.2e-13, 1.0, 2048, "mixed"),
]  # fmt: skip


# on layers thinner than a grid spacing, whose response is hardly longer than that
MARCHES = [
    # the ends of a patch go outwards by one node with every second update
    Scene(Layer(6.93609e-06, 0.5), RoughIndenter(0.844309, 269, 0.5, 0.00403473), 2.24302e11, num_points=8000),
    # some ends go on when others have gone too far
    Scene(Layer(6.65189e-06, 0.5), RoughIndenter(0.397361, 158, 0.5, 0.0295064), 1.65073e11, num_points=7911),
    Scene(Layer(4.73122e-07, 0.5), PowerIndenter(2.0), 4.0838e15, num_points=7911),
]  # fmt: skip


@pytest.mark.parametrize(("scene", "most"), [*((scene, 50) for scene in THIN), *((scene, 2000) for scene in MARCHES)])
def test_thin_and_incompressible(scene, most):
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over or most > 50
    assert solution.iterations < most
    problem = Problem.from_scene(scene)
    assert math.isfinite(certify(problem, solution.displacement / problem.length_unit)[0].energy_error_bound)


def test_fire_that_bounces_off_the_wall_says_so():
    scene = Scene(Layer(6.3700430753034e-05, 0.5 - 1e-9), PowerIndenter(8.0), 0.08858624613056416, num_points=729)
    solution = solve(scene, method="mass-weighted-fire")
    assert solution.status is Status.STAGNATED
    assert str(solution.reason).endswith("which does not settle here; allowed: another")
    assert solve(scene).status is Status.CONVERGED


def test_heights_beyond_numbers():
    """Squares of heights of 1e-150 underflow; a steep profile overflowed, and heights beyond reach make no
    difference."""
    flat = solve(Scene(indenter=PowerIndenter(64.0, 250.0), num_points=16))
    coarse_grids_see_nothing = solve(Scene(Layer(), PowerIndenter(2, 1e16), 1.0, num_points=2**15))
    for full in (flat, coarse_grids_see_nothing):
        assert full.status is Status.CONVERGED
        assert full.observables.contact_area_subgrid == 1
    assert flat.certificate.energy_error_bound == 0
    scene = Scene(Layer(0.1), PowerIndenter(64.0, 2.8e-3), 1e-4, num_points=1001)
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    capped = solve(measured(np.minimum(scene.profile, 1e3), scene.layer, 1e-4))
    np.testing.assert_array_equal(solution.contact, capped.contact)


def test_edges_do_not_pass_each_other():
    """Contact except at one node: a_r between the edges was above 1."""
    pit = np.zeros(512)
    pit[100] = 1
    found = solve(measured(pit, Layer(1.8e-8, 0.4), 5e4)).observables
    assert found.contact_area == 511 / 512
    assert found.contact_area <= found.contact_area_subgrid <= 1
    contact = np.ones(16, dtype=bool)
    contact[[3, 9]] = False
    patches = Patches.of(contact)
    ends = edges.find_edges(patches, np.where(contact, 1.0, 0)[patches.nodes], layer_on_grid(Layer(), 16, 1.0))
    assert (np.roll(ends.left, -1)[:-1] >= ends.right[:-1]).all()
    assert ends.left[0] + 16 >= ends.right[-1]


def test_what_rounding_leaves():
    """A default tolerance gives way to rounding, says so, and one that was asked for does not."""
    scene = Scene(Layer(1e-7, 0.5), pressure=1e-12, num_points=2**15)
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    assert 1e-8 < solution.tolerance < 0.2
    assert solution.certificate.equilibrium_residual <= solution.tolerance
    asked = solve(scene, tolerance=1e-8)
    assert asked.status is Status.STAGNATED
    assert str(asked.reason).startswith("tolerance is 1e-08; allowed: above ")
    assert str(asked.reason).endswith("which rounding in float64 leaves")


def test_what_diverges_beyond_all_numbers_is_finite(monkeypatch):
    def burst(self):
        self.u[:] = np.nan
        self.state[:] = np.where(np.arange(self.state.size) == layout.STOPPED, 1.0, self.state)
        self.state[layout.RESIDUAL] = 1e31

    monkeypatch.setattr(MassWeightedFire, "step", burst)
    solution = solve(Scene(num_points=64), method="mass-weighted-fire")
    assert solution.status is Status.DIVERGED
    assert np.isfinite(solution.displacement).all()
    assert str(solution.reason).endswith(
        "mass-weighted-fire in precision float64, which does not settle here; allowed: another"
    )


@pytest.mark.parametrize("num_points", [5, 9, 365, 1021])
def test_an_asperity_on_an_odd_grid(num_points):
    """Its fields were sampled half a spacing beside the tip, and a narrow contact was missed."""
    solution = solve(Scene(pressure=1e-4, num_points=num_points), accuracy=1e-4)
    exact = closed_forms.periodic_half_space_area(2.0, 1.0, 1e-4)
    assert solution.observables.contact_area_subgrid == pytest.approx(exact, rel=1e-4)
    assert solution.contact_pressure.argmax() == num_points // 2


@pytest.mark.parametrize("exponent", [1.5, 2.0, 4.0])
@pytest.mark.parametrize("poisson_ratio", [0.3, 0.499, 0.5 - 1e-12, 0.5])
def test_guess_of_the_half_width(exponent, poisson_ratio):
    """For nu next to 1/2 it was that of a foundation nearly rigid, and collocation took half a minute to fail."""
    thickness = 1e-3
    guess = closed_forms.guessed_half_width(1e-4, exponent, 1.0, Layer(thickness, poisson_ratio))
    found = collocation.solve_layer(Layer(thickness, poisson_ratio), 1e-4, exponent, 1.0)
    assert 0.5 < found.half_width / guess < 1.5


def test_collocation_stays_cheap_on_long_contacts(monkeypatch):
    tried = []
    monkeypatch.setitem(small_models.MODELS, "collocation", lambda *given: tried.append(given))
    scene = Scene(Layer(1.1e-4, 0.5 - 1e-15), PowerIndenter(4.0), 2.9e-2, num_points=64)
    assert solve(scene, accuracy=1e-3).status is Status.INACCURATE
    assert not tried


# 297 patches, nu = 1/2 - 1e-12: a negative diagonal entry of the coarse matrix, of which the root was taken
SPOILT = pytest.param((2, 3_001_090, "middle"), verdicts.REFUSED, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("cell", "verdict"),
    [
        ((1, 9343, "small"), verdicts.CERTIFIED),  # a start from elsewhere, beyond float32
        ((1, 6770, "small"), verdicts.CERTIFIED),  # sampled fields above the wall by the rounding of units
        ((1, 175, "small"), verdicts.CERTIFIED),  # areas above 1
        ((1, 330, "small"), verdicts.CERTIFIED),
        ((1, 8436, "small"), verdicts.CERTIFIED),  # a patch where the surface has no curvature
        ((1, 13_805, "small"), verdicts.REFUSED),  # no contact on a foundation is off by all of it
        SPOILT,
    ],
)
def test_cells_that_were_defects(cell, verdict):
    record = extremes.Task(*cell).run(None)
    assert record["verdict"] == verdict, record["why"]


def test_a_default_tolerance_at_which_the_energy_is_unknown():
    """In float32 it was 0.16, the bound on the energy's error 0.13 of the energy; and the result converged."""
    cell = extremes.Task(2, 12_001_594, "small").cell()
    solution = solve(cell.scene, **cell.options)
    assert solution.certificate.equilibrium_residual <= solution.tolerance
    assert solution.status is Status.STAGNATED
    assert str(solution.reason).startswith("tolerance is 0.16, at which the energy may be off by 0.1")
    assert solve(cell.scene, method="fire", tolerance=solution.tolerance).status is Status.CONVERGED
    assert solve(replace(cell.scene, precision="mixed")).tolerance == 1e-8


def test_reasons_name_what_helps():
    """Another precision below rounding; more points are none where heights are given."""
    single = Scene(Layer(1e-8, 0.5), num_points=2**13, precision="float32")
    reason = solve(single, tolerance=0.5).reason
    assert str(reason).startswith("num_points is 8192, where rounding in float32 leaves")
    assert (reason.cause, reason.parameter) == (Cause.ROUNDING, "num_points")
    given = measured(1 - np.cos(2 * np.pi * np.arange(256) / 256))
    reason = solve(given, accuracy=1e-6).reason
    finer = "a finer grid: num_points above 256, with heights given there, as by a denser scan"
    assert re.fullmatch(rf"accuracy is 1e-06; allowed: above \d\.?\d?e-06, or {re.escape(finer)}", str(reason))
    assert (reason.cause, reason.parameter) == (Cause.GRID, "accuracy")
