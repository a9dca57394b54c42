"""The active set: its parts against dense algebra, all methods against one another, and the ends of the search."""

import itertools
import json
import math
import time
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linecontact.solver import (
    METHODS,
    CoatedHalfSpace,
    Layer,
    MeasuredIndenter,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    certify,
    solve,
)
from linecontact.solver.grid.kept import forget
from linecontact.solver.grid.patches import Patches
from linecontact.solver.grid.problem import Problem, foundation_pressure, half_spectrum, typical_stiffness
from linecontact.solver.methods import Setting, active_set, relax
from linecontact.solver.methods.active_set import greens_function, local_inverses, search
from linecontact.solver.methods.active_set import preconditioner as deflation
from linecontact.solver.methods.active_set.active_set import ActiveSet
from linecontact.solver.methods.active_set.greens_function import GreensFunction, Tables, inverse_cholesky, patch_sums
from linecontact.solver.strategy import certification
from linecontact.solver.strategy.effort import Effort, Means
from linecontact.solver.transforms import plain, planned


def stiffness(num_points, thickness, nu):
    return half_spectrum(Layer(thickness, nu), num_points, 1.0)


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
    pressure = GreensFunction(Tables(stiffness(n, d, nu), n)).solve(nodes, height[nodes])
    assert pressure.sum() == pytest.approx(n)
    gap = height[nodes] + dense(n, d, nu)[np.ix_(nodes, nodes)] @ pressure
    assert np.ptp(gap) < 1e-9 * np.abs(pressure).max() * np.abs(dense(n, d, nu)).max()


@pytest.mark.parametrize(("d", "nu"), LAYERS)
def test_coarse_matrix_against_the_triple_product(d, nu):
    patches, n = Patches.of(PATCHES), PATCHES.size
    z = np.zeros((n, patches.count))
    z[patches.nodes, patches.label] = 1
    expected = z.T @ dense(n, d, nu) @ z
    found = patch_sums(Tables(stiffness(n, d, nu), n).second_sum, patches.first, patches.last)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize(("d", "nu"), LAYERS)
def test_one_factor_inverts_every_patch(d, nu):
    green = dense(512, d, nu)
    factor = inverse_cholesky(green[0], 100)
    for m in (1, 2, 17, 100):
        inverse = factor[:m, :m].T @ factor[:m, :m]
        np.testing.assert_allclose(inverse @ green[:m, :m], np.eye(m), atol=1e-9)


@pytest.mark.parametrize("longest", [256, 16])
@pytest.mark.parametrize("unknowns", [100, 3])
@pytest.mark.parametrize(("d", "nu"), LAYERS)
def test_preconditioner(d, nu, unknowns, longest, monkeypatch):
    """Symmetric, positive on loads of zero sum, near the inverse; long patches and shared unknowns included."""
    monkeypatch.setattr(local_inverses, "LONGEST_DENSE", longest)
    monkeypatch.setattr(local_inverses, "_FEW_PATCHES", 0)
    monkeypatch.setattr(deflation, "_unknowns", lambda n: unknowns)
    patches = Patches.of(PATCHES)
    check_preconditioner(d, nu, patches, 6 if unknowns == 100 else 60)


@pytest.mark.parametrize(("d", "nu"), LAYERS)
def test_preconditioner_of_a_contact_nearly_everywhere(d, nu, monkeypatch):
    """The same where K of all nodes stands for every patch."""
    monkeypatch.setattr(local_inverses, "_FEW_PATCHES", 0)
    patches = Patches.of(~contact_map(512, (20, 3), (70, 40), (130, 1), (300, 9), (310, 8), (505, 5)))
    green = GreensFunction(Tables(stiffness(512, d, nu), 512))
    stiff = nu == 0.5 and d < 0.1  # there every patch is inverted on its own
    assert isinstance(local_inverses.local_inverse(green, patches, None), local_inverses.Together) is not stiff
    check_preconditioner(d, nu, patches, 20)


def check_preconditioner(d, nu, patches, condition):
    m = patches.nodes.size
    preconditioner = deflation.PatchDeflation(GreensFunction(Tables(stiffness(512, d, nu), 512)), patches)
    matrix = np.stack([preconditioner.apply(e) for e in np.eye(m)], axis=1)
    size = np.abs(matrix).max()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-9 * size)
    np.testing.assert_allclose(matrix.sum(axis=0), 0, atol=1e-9 * size)  # keeps the load, ignores a constant
    green = dense(512, d, nu)[np.ix_(patches.nodes, patches.nodes)]
    values = np.sort(np.linalg.eigvals(matrix @ green).real)[1:]
    assert values[0] > 0
    # what deflation is for: a small condition number whatever the layer and the patches
    assert values[-1] / values[0] < condition


def test_a_coarse_inverse_serves_the_next_set():
    green = GreensFunction(Tables(stiffness(512, 0.1, 0.25), 512))
    first = deflation.PatchDeflation(green, Patches.of(PATCHES))
    moved = PATCHES.copy()
    moved[[63, 62, 61, 60, 504]] = [False, False, False, False, True]
    second = deflation.PatchDeflation(green, Patches.of(moved), first)
    assert second._factor is first._factor
    z = second.apply(np.random.default_rng(0).standard_normal(int(moved.sum())))
    assert abs(z.sum()) < 1e-9 * np.abs(z).max()
    more = deflation.PatchDeflation(green, Patches.of(moved | contact_map(512, (400, 2))), first)
    assert more._factor is not first._factor


def test_a_coarse_matrix_that_rounding_has_spoilt():
    coarse = np.array([[-0.02, 1.0], [1.0, 2.0]])
    factor = deflation._inverse_factor(coarse, np.array([0.5, 0.7]))
    assert factor.T @ factor == pytest.approx(np.diag([1 / 0.5, 1 / 2.0]))


def test_patches_that_share_an_unknown_take_longer(monkeypatch):
    """They were taken for a set that rounding does not let be solved: 2^21 of them went to FIRE, for hours."""
    monkeypatch.setattr(deflation, "_unknowns", lambda n: 16)
    monkeypatch.setattr("linecontact.solver.methods.active_set.contact_set.MOST_ITERATIONS", 20)
    teeth = MeasuredIndenter(2e-7 * (np.arange(4097) % 2))
    solution = solve(Scene(Layer(), teeth, 5e-15, num_points=4097))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.iterations < 200


@pytest.mark.parametrize("num_points", [2**12, 2**14])
def test_beyond_rounding_the_search_ends_soon_and_keeps_its_contact(num_points):
    """Conjugate gradients diverged for hundreds of iterations, and then every node was taken for a contact."""
    scene = Scene(indenter=RoughIndenter(0.8, 0, cut_off_ratio=4096 / num_points), pressure=0.01, num_points=num_points)
    usual, beyond = solve(scene), solve(scene, tolerance=1e-12)
    assert (usual.status, beyond.status) == (Status.CONVERGED, Status.STAGNATED)
    assert beyond.iterations < usual.iterations + 60
    np.testing.assert_array_equal(beyond.contact, usual.contact)


def scenes():
    """Layers of all kinds; power profiles, random roughness and random walks."""
    layers = st.builds(
        Layer,
        st.one_of(st.just(math.inf), st.floats(-3, 0).map(lambda x: 10.0**x)),
        st.floats(-0.9, 0.47),
    )
    rough = st.builds(RoughIndenter, st.floats(0.1, 1), st.integers(0, 99), st.just(0.25), st.floats(0.02, 0.2))
    power = st.builds(PowerIndenter, st.floats(1.3, 5))
    walk = st.integers(0, 99).map(
        lambda seed: MeasuredIndenter(1e-2 * np.random.default_rng(seed).standard_normal(1024).cumsum())
    )
    return st.builds(
        Scene,
        layers,
        st.one_of(power, rough, walk),
        st.floats(-4, -0.5).map(lambda x: 10.0**x),
        num_points=st.just(1024),
    )


@settings(max_examples=30, deadline=None)
@given(scenes())
def test_all_methods_agree(scene):
    solutions = [solve(scene, method=m, nested=n) for m, n in itertools.product(list(METHODS)[:2], (True, False))]
    if isinstance(scene.indenter, PowerIndenter):
        solutions.append(solve(scene, method="fire"))
    problem = Problem.from_scene(scene)
    for solution in solutions:
        assert solution.status is Status.CONVERGED
        certificate, _, _ = certify(problem, solution.displacement / problem.length_unit)
        assert certificate.free_residual <= 1.01e-8
        assert certificate.energy_error_bound < 1e-9
        assert certificate.force_balance < 1e-6
        # nodes whose pressure is nothing may count or not
        apart = solution.contact != solutions[0].contact
        assert (solution.contact_pressure[apart] < 1e-4 * scene.pressure).all()
        force = solution.contact_pressure - solutions[0].contact_pressure
        assert np.abs(force).max() < 1e-4 * scene.pressure
        assert solution.observables.num_patches >= 1


@pytest.mark.parametrize(("d", "nu"), [(math.inf, 0.25), (0.01, 0.25), (1e-4, -0.9), (1e-2, 0.49), (1e-3, 0.5)])
@pytest.mark.parametrize("indenter", [PowerIndenter(), PowerIndenter(4.0), RoughIndenter(0.8, 3, 0.25, 1 / 32)])
@pytest.mark.parametrize("small", [0, 384])
def test_few_pairs_without_help(d, nu, indenter, small, monkeypatch):
    """Nested, to 1e-8, not handed over, in a number of pairs that FIRE needs hundreds for; with elimination or not."""
    monkeypatch.setattr("linecontact.solver.methods.active_set.active_set._SMALL_SET", small)
    solution = solve(Scene(Layer(d, nu), indenter, 1e-2, num_points=2**12))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.transform_pairs < 60


@pytest.mark.parametrize("error", [np.linalg.LinAlgError, ZeroDivisionError, None])
def test_where_elimination_fails_conjugate_gradients_go_on(error, monkeypatch):
    def fail(self, nodes, height):
        if error:
            raise error
        return np.full(nodes.size, math.nan)

    scene = Scene(Layer(0.01), PowerIndenter(), 1e-2, num_points=2**11)
    expected = solve(scene)
    monkeypatch.setattr(GreensFunction, "solve", fail)
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    np.testing.assert_array_equal(solution.contact, expected.contact)


def test_pairs_do_not_grow():
    rough = RoughIndenter(0.8, 0, 1 / 8, 1 / 64)
    for indenter, load in ((PowerIndenter(), 2e-3), (rough, 1e-2)):
        pairs = [solve(Scene(indenter=indenter, pressure=load, num_points=n)).transform_pairs for n in (2**12, 2**16)]
        assert pairs[1] < 1.25 * pairs[0]


def test_backends_and_precisions():
    scene = Scene(Layer(0.05, 0.3), num_points=2**11)
    warp, twin = (solve(scene, backend=backend) for backend in ("warp", "numpy"))
    np.testing.assert_array_equal(warp.contact, twin.contact)
    np.testing.assert_allclose(warp.contact_pressure, twin.contact_pressure, atol=1e-7 * scene.pressure)
    single = solve(Scene(Layer(0.05, 0.3), num_points=2**11, precision="float32"))
    assert single.status is Status.CONVERGED
    assert single.observables.contact_area_subgrid == pytest.approx(warp.observables.contact_area_subgrid, rel=1e-4)


@pytest.mark.parametrize("threads", [1, 2])
def test_nested_grids_round_fire(threads):
    scene = Scene(indenter=RoughIndenter(0.8, 1, 0.25, 1 / 32), pressure=1e-2, num_points=2**12)
    single, nested = (
        solve(scene, method="mass-weighted-fire", nested=choice, threads=threads) for choice in (False, True)
    )
    assert nested.status is single.status is Status.CONVERGED
    assert nested.levels
    assert not single.levels
    assert nested.transform_pairs < single.transform_pairs
    assert nested.observables.contact_area == single.observables.contact_area


@pytest.mark.parametrize(("length", "modulus"), [(1.0, 1.0), (3.7e-5, 2.1e11)])
def test_warm_start_from_a_displacement(length, modulus):
    layer = Layer(0.1 * length, 0.25, modulus)
    scene = Scene(layer, PowerIndenter(2.0, length), 2e-3 * modulus, length, 2**12)
    cold = solve(scene)
    warm = solve(scene, initial=cold.displacement)
    assert warm.iterations == 0
    assert warm.transform_pairs < 2
    assert not warm.levels
    np.testing.assert_array_equal(warm.contact, cold.contact)
    lifted = solve(scene, initial=cold.displacement - length)  # touches nowhere
    assert lifted.status is Status.CONVERGED


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
    solution = solve(Scene(Layer(d, 0.3), MeasuredIndenter(heights), load, num_points=2048), nested=nested)
    assert solution.status is Status.CONVERGED
    assert solution.contact_pressure.mean() == pytest.approx(load, rel=1e-6)
    assert (solution.displacement <= solution.scene.profile).all()
    assert 0 < solution.observables.contact_area_subgrid <= 1


def test_thousands_of_patches_share_unknowns():
    heights = 1e-4 * np.random.default_rng(0).standard_normal(2**14)
    solution = solve(Scene(indenter=MeasuredIndenter(heights), pressure=0.5, num_points=2**14), nested=False)
    assert solution.status is Status.CONVERGED
    assert solution.observables.num_patches > 1000
    assert not solution.handed_over


def test_memory_of_many_patches():
    """The coarse matrix grows with the patches, not with their square."""
    contact = np.random.default_rng(0).random(2**17) < 0.2
    green = GreensFunction(Tables(stiffness(2**17, 0.1, 0.25), 2**17))
    green.tables.response  # noqa: B018
    tracemalloc.start()
    preconditioner = deflation.PatchDeflation(green, Patches.of(contact))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert preconditioner.patches.count > 20_000
    assert peak < 250 * 2**17  # bytes a point


def test_tables_of_large_grids_make_room_for_each_other(monkeypatch):
    small = Tables(stiffness(4096, 0.1, 0.25), 4096)
    kept = {name: getattr(small, name) for name in ("compliance", "response", "second_sum")}
    monkeypatch.setattr(greens_function, "_KEPT", 0)
    large = Tables(stiffness(4096, 0.1, 0.25), 4096)
    for name in ("response", "second_sum", "response", "compliance", "second_sum"):
        np.testing.assert_array_equal(getattr(large, name), kept[name])
        assert len(large._kept.keys() & {"response", "second sum"}) <= 1
    large.rest()
    assert not large._kept
    large.second_sum  # noqa: B018
    assert "response" not in large._kept
    np.testing.assert_array_equal(large.factor(64), small.factor(64))
    assert "response" not in large._kept  # the values next to the node were enough


@pytest.mark.parametrize("precision", ["float64", "mixed", "float32"])
def test_a_method_that_rests_can_go_on(precision):
    problem = Problem.from_scene(Scene(indenter=RoughIndenter(0.8, 0, cut_off_ratio=1 / 32), num_points=2**12))
    found = []
    for rests in (False, True):
        state = active_set.begin(problem, Setting(1e-4, precision))
        assert relax(state, 200) is Status.CONVERGED
        if rests:
            state.rest()
        found.append(state.displacement)
        state.try_harder()
        if rests:
            state.rest()
        assert relax(state, 400) is Status.CONVERGED
        found.append(state.displacement)
    for before, after in zip(found[:2], found[2:], strict=True):
        np.testing.assert_array_equal(before, after)


@pytest.mark.parametrize("layer", [Layer(), Layer(0.01, 0.3)])
def test_what_saves_memory_on_large_grids_changes_nothing(layer, monkeypatch):
    scene = Scene(layer, RoughIndenter(0.8, 1), 0.01, num_points=2**16)
    usual = solve(scene)
    forget()
    for module, name in ((greens_function, "_KEPT"), (planned, "_IN_PLACE"), (plain, "_KEPT_UP_TO")):
        monkeypatch.setattr(module, name, 2**12)
    saving = solve(scene)
    forget()
    np.testing.assert_array_equal(saving.contact, usual.contact)
    np.testing.assert_allclose(
        saving.contact_pressure, usual.contact_pressure, atol=1e-8 * usual.contact_pressure.max()
    )


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


def test_stiff_coating_on_which_the_search_does_not_settle():
    """Its sets fall into ever more patches; the true contact is one patch, and the certificate, which no method shares,
    is met. A limit of one's own is kept, and what the search does not need of it is the other method's.
    """
    scene = Scene(CoatedHalfSpace(20 / 2**14, base_modulus=1e-4), PowerIndenter(2), pressure=1e-4, num_points=2**10)
    solution = solve(scene)
    assert solution.handed_over
    assert solution.status is Status.CONVERGED
    assert solution.certificate.free_residual <= solution.tolerance == 1e-8
    assert solution.observables.num_patches == 1
    limited = solve(scene, max_iterations=2000)
    assert limited.status is Status.ITERATION_LIMIT
    assert limited.iterations == 2000
    assert solve(scene, max_iterations=20_000).iterations == solution.iterations
    mixed = solve(replace(scene, precision="mixed"))
    assert mixed.status is Status.CONVERGED
    assert not any(choice.what == "precision" for choice in mixed.choices)


def test_grids_that_were_not_solved_do_not_count_in_a_claim():
    """Under this coating the search does not settle on the coarser grid either."""
    coating = CoatedHalfSpace(2**-8, base_modulus=1e-4)
    fine, coarse = (solve(Scene(coating, pressure=1e-3, num_points=n)).observables for n in (2**12, 2**10))
    assert fine.contact_area_error < 1e-4
    off = abs(fine.contact_area_subgrid - coarse.contact_area_subgrid)
    assert off < 2 * (fine.contact_area_error + coarse.contact_area_error)


def test_a_hand_over_in_vain_is_bounded(monkeypatch):
    scene = Scene(CoatedHalfSpace(20 / 2**14, base_modulus=1e-4), PowerIndenter(2), pressure=1e-4, num_points=2**10)
    monkeypatch.setattr(certification, "_MOST_WORK", 200 * 2**10)
    assert solve(scene).iterations == 2200
    monkeypatch.setattr(certification, "_MOST_POINTS", 2**9)
    assert solve(scene).iterations == 2000


def test_every_grid_of_an_accuracy_begins_with_the_search_s_own_limit():
    found = []
    effort = Effort(Scene(num_points=64), active_set.KIND, Means())
    for iterations in (20_000, 2000):  # those of a hand-over, then the next grid's
        effort.allow(iterations)
        found.append(effort.left)
    assert found == [20_000, 2000]


def test_hand_over_keeps_the_limit(monkeypatch):
    monkeypatch.setattr(ActiveSet, "_update_set", lambda self: setattr(self, "stopped", True) or True)
    solution = solve(Scene(Layer(0.1), num_points=2**10), nested=False, max_iterations=9)
    assert solution.status is Status.ITERATION_LIMIT
    assert solution.iterations == 9


@pytest.mark.parametrize("where", ["start_cold", "step", "start_from_pressure"])
@pytest.mark.parametrize("nested", [True, False])
def test_interrupted_anywhere(monkeypatch, where, nested):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(ActiveSet, where, interrupt)
    solution = solve(Scene(num_points=2**12), nested=nested)
    assert solution.status is Status.INTERRUPTED
    assert (solution.displacement <= solution.scene.profile).all()


def test_json_is_strict():
    scene = Scene(pressure=1e-12, num_points=2**12)  # one node on every grid, with a slope of 0
    record = json.loads(json.dumps(solve(scene).to_dict(), allow_nan=False))
    assert (record["kappa"], record["reduced_pressure"]) == (0.0, "inf")


@pytest.mark.parametrize(("method", "tolerance"), [("mass-weighted-fire", 1e-2), ("active-set", 1e-3)])
def test_a_loose_tolerance_widens_the_error(method, tolerance):
    for points in (2**12, 2**14):
        o = solve(Scene(num_points=points), method=method, tolerance=tolerance).observables
        assert abs(o.contact_area_subgrid - 0.100714056833) < o.contact_area_error
    single = solve(Scene(num_points=2**14, precision="float32")).observables
    assert abs(single.contact_area_subgrid - 0.100714056833) < single.contact_area_error


def test_sets_that_come_back_are_noticed():
    """Alternating sets: decided on ever more accurate solutions, given up in the end."""
    problem = Problem.from_scene(Scene(num_points=256))
    state = active_set.begin(problem, Setting(1e-8))
    state.start_cold()
    state.step()
    state._search.moves_left, first = 0, np.sort(state._now.nodes)
    for turn in range(40):
        nodes = first if turn % 2 else first[1:]
        state._take_set(nodes, nodes, np.ones(nodes.size))
        state._response.renew(state._now)
        state._now.pressure[-1] = -1.0  # always one node to drop
        state._update_set()
        if state.stopped:
            break
    assert state.stopped
    assert state._search.forcing_term < 1e-6


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


@pytest.mark.slow
@pytest.mark.parametrize("hurst", [0.8, 0.3])
@pytest.mark.parametrize(("d", "limit"), [(math.inf, 50), (1e-2, 50), (1e-4, 30)])
def test_real_size_rough(hurst, d, limit):
    solution = solve(Scene(Layer(d, 0.25), RoughIndenter(hurst, 0), 1e-2, num_points=2**18))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.transform_pairs < limit
    assert abs(solution.observables.contact_area_subgrid / solution.observables.contact_area - 1) < 0.05


def test_sets_that_keep_changing_are_decided_on_more_accurate_solutions():
    sets = search.Search()
    for changed in (1000, 700, 500, *[500] * 7):
        sets.note(changed)
    assert sets.forcing_term == search._FORCING_TERM
    sets.note(500)
    assert sets.forcing_term == pytest.approx(0.1 * search._FORCING_TERM)
    for changed in (300, *[300] * 100):
        sets.note(changed)
    assert sets.forcing_term == search._TIGHT


@pytest.mark.slow
def test_thousands_of_patches_whose_sets_would_keep_changing():
    """Eight points to the shortest wave: seven thousand patches disturb each other."""
    n = 2**22
    solution = solve(Scene(indenter=RoughIndenter(0.8, 0, 1 / 8, 64 / n), pressure=1e-2, num_points=n))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.observables.num_patches > 5000


@pytest.mark.parametrize("hurst", [0.3, 0.8])
@pytest.mark.parametrize("thickness", [math.inf, 0.01])
def test_a_cold_start_has_not_much_more_contact_than_the_solution(hurst, thickness):
    scene = Scene(Layer(thickness, 0.25), RoughIndenter(hurst, 1, 1 / 8, 1 / 16), 0.01, num_points=2**12)
    problem, contact = Problem.from_scene(scene), solve(scene).contact.sum()
    typical, longest = typical_stiffness(problem), float(problem.stiffness[1])
    start, former = ((foundation_pressure(problem, modulus) > 0).sum() for modulus in (typical, longest))
    assert contact < start < 5 * contact
    assert start <= former


def test_the_typical_stiffness_is_at_least_the_longest_wave_s():
    wave = Problem.from_scene(
        Scene(indenter=MeasuredIndenter(1 - np.cos(2 * np.pi * np.arange(16) / 16)), num_points=16)
    )
    for problem in (wave, replace(wave, height=np.zeros(16))):
        assert typical_stiffness(problem) == problem.stiffness[1]
