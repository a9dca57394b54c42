"""Means over random surfaces: the estimator on made-up samples, and what is solved next."""

import itertools
import math
from collections import Counter

import numpy as np
import pytest
from linecontact.studies.multilevel import allocation, estimator
from linecontact.studies.multilevel.allocation import PILOT, Wanted
from linecontact.studies.multilevel.samples import FOUNDATION, Samples
from made_up_ensembles import SIZES, TRUTH, made_up, sampled, solved, wanted

pytestmark = pytest.mark.once


@pytest.mark.parametrize("sizes", [SIZES, (FOUNDATION, *SIZES)])
def test_the_terms_add_up_to_the_mean_on_the_finest_grid(sizes):
    """With the same surfaces for every term the sum is the plain mean, with its error. A foundation takes away the part
    that it adds to the sum.
    """
    samples = Samples(solved([allocation.Batch(0, 50, sizes)]), "kappa")
    found = estimator.estimate(samples, sizes, sizes)
    plain = np.array([made_up(seed, SIZES[-1]) for seed in range(50)])
    assert found.mean == pytest.approx(plain.mean(), rel=1e-12)
    assert found.standard_error == pytest.approx(plain.std(ddof=1) / math.sqrt(50), rel=0.05)  # as 49/47 has it
    assert found.plain_variance == pytest.approx(plain.var(ddof=1))
    assert found.bias == estimator.estimate(samples, SIZES, SIZES).bias


def test_a_foundation_takes_a_share_of_the_scatter():
    """As much as a straight line tells: of kappa on the grid, from what it is on the foundation."""
    samples = Samples(solved([allocation.Batch(0, 2000, (FOUNDATION, 2048))]), "kappa")
    alone, left = (estimator.term(samples, 2048, coarser).variance for coarser in (None, FOUNDATION))
    values = [[made_up(seed, size) for seed in range(2000)] for size in (FOUNDATION, 2048)]
    assert left / alone == pytest.approx(1 - np.corrcoef(values)[0, 1] ** 2, rel=1e-6)
    assert left < 0.4 * alone


@pytest.mark.parametrize("order", [1.0, 1.5, 2.0])
def test_the_bias_is_what_the_finest_grid_is_off(order):
    """For an error like N^-order; of two grids alone the order is not known."""
    rows = solved([allocation.Batch(0, 9, SIZES)])
    rows = [row | {"kappa_subgrid": TRUTH + 20 / row["num_points"] ** order} for row in rows]
    for sizes in (SIZES, SIZES[:3]):
        assert estimator.bias(Samples(rows, "kappa"), sizes) == pytest.approx(20 / sizes[-1] ** order)
    assert estimator.bias(Samples(rows, "kappa"), SIZES[:2]) == pytest.approx(20 * (256**-order - 512**-order))
    assert math.isnan(estimator.bias(Samples(rows, "kappa"), SIZES[:1]))


def test_a_change_that_is_small_by_chance_is_not_believed():
    means = {256: 1.74, 512: 1.70, 1024: 1.70}
    rows = [row | {"kappa_subgrid": means[row["num_points"]]} for row in solved([allocation.Batch(0, 9, SIZES[:3])])]
    assert estimator.bias(Samples(rows, "kappa"), SIZES[:3]) == pytest.approx(0.02)
    rows = [row | {"kappa_subgrid": row["kappa_subgrid"] - 1e-6 * (row["num_points"] == 1024)} for row in rows]
    assert estimator.bias(Samples(rows, "kappa"), SIZES[:3]) == pytest.approx(0.04 / 4 / 3)  # the highest order


def test_the_best_number_of_surfaces():
    """Giles 2008, eq. 12: no other allocation with that variance takes less time."""
    found = [
        estimator.Term(size, None, 10**6, 0.0, variance, seconds)
        for size, variance, seconds in ((256, 0.04, 1.0), (512, 0.01, 3.0), (1024, 0.001, 6.0))
    ]
    numbers = np.array(estimator.counts(found, 1e-3))
    variances, seconds = (np.array([getattr(t, name) for t in found]) for name in ("variance", "seconds"))
    assert (variances / numbers).sum() == pytest.approx(1e-6, rel=1e-3)
    for direction in ([1, -1, 0], [0, 1, -1], [1, 0, -1]):
        other = numbers * (1 + 0.05 * np.array(direction))
        other *= (variances / other).sum() / 1e-6
        assert other @ seconds >= numbers @ seconds * (1 - 1e-3)


def test_grids_that_do_not_pay_are_left_out():
    """Where the coarsest grid scatters as much as the change from it, it is no help."""
    rng = np.random.default_rng(0)
    rows = solved([allocation.Batch(0, 200, SIZES)])
    noise = {seed: rng.standard_normal() for seed in range(200)}
    rows = [
        row | {"kappa_subgrid": row["kappa_subgrid"] + noise[row["seed"]] * (row["num_points"] == 256)} for row in rows
    ]
    ladder = estimator.best_ladder([(Samples(rows, "kappa"), 1e-4)], SIZES)
    assert 256 not in ladder
    assert ladder[-1] == 2048


def test_a_foundation_that_tells_nothing_is_left_out():
    sizes, used = (FOUNDATION, *SIZES), []
    for told in (0.0, 0.9):
        rows = solved([allocation.Batch(0, 200, sizes)], told=told)
        used.append(FOUNDATION in estimator.best_ladder([(Samples(rows, "kappa"), 1e-3)], sizes))
    assert used == [False, True]


def test_surfaces_that_are_solved_keep_their_grids():
    """Grids that would be a little better from the beginning are worse than going on."""
    rows = solved([allocation.Batch(0, 20, SIZES), allocation.Batch(100, 400, (512,))])
    at_first, later = (Samples(some, "kappa") for some in (rows[: 20 * len(SIZES)], rows))
    assert estimator.best_ladder([(at_first, 0.0025)], SIZES)[0] == 1024
    assert estimator.best_ladder([(later, 0.0025)], SIZES)[0] == 512


def test_grids_suit_every_observable_in_whatever_order():
    """The other mean needs no more surfaces than there are first; it must not choose the grids by itself."""
    spent = []
    for names in (("kappa",), ("kappa", "contact-area"), ("contact-area", "kappa")):
        rows, now = sampled(Wanted(names, 0.003, False, math.inf, 10**9))
        assert now.estimates["kappa"].standard_error <= 0.003
        spent.append(sum(row["seconds.total"] for row in rows))
    assert spent[0] == spent[1] == spent[2]


def test_a_large_error_takes_few_solves():
    """The fewest surfaces of the mean itself count where grids are chosen."""
    rows, _ = sampled(wanted(0.1))
    assert max(Counter(row["num_points"] for row in rows).values()) <= estimator.FEWEST_SURFACES
    assert sum(row["num_points"] == SIZES[-1] for row in rows) < PILOT


@pytest.mark.parametrize(("error", "relative"), [(0.004, False), (0.004, True), (0.002, False)])
def test_the_standard_error_is_reached_with_a_small_bias(error, relative):
    rows, now = sampled(wanted(error, relative))
    found = now.estimates["kappa"]
    absolute = error * found.mean if relative else error
    assert 0.7 * absolute < found.standard_error <= absolute
    assert found.bias <= absolute / 3 or found.terms[-1].num_points == SIZES[-1]
    assert abs(found.mean - TRUTH) < 4 * absolute + 20 / SIZES[-1]
    assert not now.out_of_reach
    assert sum(row["seconds.total"] for row in rows) < found.plain_cost(absolute)


@pytest.mark.parametrize("sizes", [SIZES, (FOUNDATION, *SIZES)])
def test_the_error_is_honest(sizes):
    """Of 200 ensembles about 94 % lie within two standard errors of the mean on their finest grid, whatever decides."""
    off, used = [], 0
    for i in range(200):
        found = sampled(wanted(0.01), i, sizes)[1].estimates["kappa"]
        off.append((found.mean - TRUTH - 20 / found.terms[-1].num_points) / found.standard_error)
        used += found.terms[0].num_points == FOUNDATION
    assert 180 <= np.sum(np.abs(off) <= 2) <= 199
    assert 0.8 < np.std(off) < 1.2
    assert abs(np.mean(off)) < 0.2
    assert used in ((0,) if sizes == SIZES else range(100, 201))


def test_a_foundation_saves_time():
    """And the errors asked for are reached."""
    spent = []
    for sizes in (SIZES, (FOUNDATION, *SIZES)):
        rows, now = sampled(wanted(0.001), sizes=sizes)
        assert now.estimates["kappa"].standard_error <= 0.001
        spent.append(sum(row["seconds.total"] for row in rows))
    assert spent[1] < 0.7 * spent[0]


def test_it_never_stops_above_the_error_that_was_asked_for():
    """Also where surfaces that serve several terms make the error larger than the terms alone."""
    for i, error in enumerate(np.geomspace(0.003, 0.03, 40)):
        for change in (0.0, 20.0, 100.0):
            _, now = sampled(wanted(error), seed=i, change=change)
            assert now.estimates["kappa"].standard_error <= error


def test_the_finest_grid_is_used_only_if_the_bias_asks_for_it():
    rough, fine = (max(row["num_points"] for row in sampled(wanted(e), change=1.0)[0]) for e in (0.1, 1e-3))
    assert (rough, fine) == (1024, 2048)


def test_out_of_reach_is_said_before_the_time_is_spent():
    for limits in ({"seconds": 500.0}, {"most": 500}):
        rows, now = sampled(wanted(1e-4, **limits))
        assert "allowed: max_s" in now.out_of_reach
        assert len(rows) <= PILOT * (len(SIZES) + 2)


def test_surfaces_that_do_not_converge_are_left_out():
    rows = sampled(wanted(0.01))[0]
    lost = {row["seed"] for row in rows if row["seed"] % 7 == 0}
    rows = [row | {"status": "stagnated"} if row["seed"] in lost else row for row in rows]
    assert lost
    assert not lost & set(Samples(rows, "kappa").seeds(256, 512))
    again = allocation.state(rows, SIZES, wanted(0.01), 0)
    new = {seed for batch in again.batches for seed in range(batch.first, batch.first + batch.count)}
    assert not new & {row["seed"] for row in rows}  # other surfaces take their places


FIRST = allocation.Batch(allocation.first_seed(0, 0), PILOT, SIZES)


def test_where_too_few_converge():
    rows = [row | {"status": "stagnated"} for row in solved([FIRST])]
    now = allocation.state(rows, SIZES, wanted(0.01), 0)
    assert not now.batches
    assert "no more than 0 converge" in now.out_of_reach


def test_a_mean_of_0_has_no_relative_error():
    rows = [row | {"kappa_subgrid": 0.0} for row in solved([FIRST])]
    now = allocation.state(rows, SIZES, wanted(0.01, relative=True), 0)
    assert not now.batches
    assert "a mean is 0" in now.out_of_reach


def test_a_foundation_that_scatters_by_rounding_tells_nothing():
    on = [1.0, np.nextafter(1.0, 2), 1.0, np.nextafter(1.0, 0)]
    rows = [
        {"num_points": size, "seed": seed, "status": "converged", "kappa_subgrid": value, "seconds.total": 1.0}
        for seed in range(4)
        for size, value in ((FOUNDATION, on[seed]), (256, 1.7 + 0.01 * seed))
    ]
    assert set(Samples(rows, "kappa").values[FOUNDATION].values()) == {0.0}


def test_another_seed_is_another_ensemble():
    seeds = [{row["seed"] for row in sampled(wanted(0.005), seed=seed)[0]} for seed in range(5)]
    assert all(not one & other for one, other in itertools.combinations(seeds, 2))


def test_nothing_is_left_of_an_ensemble_out_of_reach():
    row = {"seconds.total": 2.0}
    done, unknown = allocation.State({}, (), 6.0), allocation.State({}, (), math.nan)
    given_up = allocation.State({}, (), math.nan, out_of_reach="it takes too long")
    assert allocation.share_done([([row], done), ([row], given_up)]) == 0.4
    assert allocation.share_done([([row], done), ([], unknown)]) == 2 / 16  # taken to be like the other one
    assert allocation.share_done([([row], done), ([row] * 9, unknown)]) == 20 / (20 + 6 + 18)  # with as much left
    assert allocation.share_done([([row], given_up), ([row], unknown)]) == 0
    assert allocation.share_done([([row], unknown)]) == 0
    assert allocation.share_done([]) == 0
