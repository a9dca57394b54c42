"""Means over random surfaces: the estimator on made-up samples, what is solved next, and the command."""

import itertools
import math
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from linecontact import ensemble_mean
from linecontact.solver import Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene, solve
from linecontact.studies.command_line import main
from linecontact.studies.files.study_files import load_study
from linecontact.studies.multilevel import allocation, estimator, foundation, study, tasks
from linecontact.studies.multilevel.allocation import PILOT, Wanted
from linecontact.studies.multilevel.samples import FOUNDATION, Samples
from linecontact.studies.scenes import kinds

pytestmark = pytest.mark.once

SIZES = (256, 512, 1024, 2048)
COSTS = {size: size / 256 for size in SIZES} | {FOUNDATION: 0.02}  # [s]
TRUTH = 1.7
"""Mean of the made-up observable on an infinitely fine grid."""


def made_up(seed, size, scatter=0.05, change=20.0, told=0.9):
    """kappa of a surface on a grid: a scatter of its own, and an error that falls like 1/N. On a foundation, which
    tells that share of the variance, it is something else, and not on a straight line with it.
    """
    own, error, other = np.random.default_rng(seed).standard_normal(3)
    if size == FOUNDATION:
        return 3 + np.exp(0.3 * (math.sqrt(told) * own + math.sqrt(1 - told) * other))
    return TRUTH + scatter * own + change * (1 + 0.5 * error) / size


def solved(batches, **options):
    return [
        {"status": "converged", "seed": seed, "num_points": size, "seconds.total": COSTS[size]}
        | {"kappa_subgrid": made_up(seed, size, **options), "contact_area_subgrid": 0.0}
        for batch in batches
        for seed in range(batch.first, batch.first + batch.count)
        for size in batch.sizes
    ]


def sampled(wanted, seed=0, sizes=SIZES, **options):
    """All rows and the last state of a made-up ensemble."""
    rows = []
    while (now := allocation.state(rows, sizes, wanted, seed)).batches:
        new = solved(now.batches, **options)
        assert not {(row["seed"], row["num_points"]) for row in new} & {(r["seed"], r["num_points"]) for r in rows}
        rows += new
    return rows, now


def wanted(error, relative=False, seconds=math.inf, most=10**9):
    return Wanted(("kappa",), error, relative, seconds, most)


def test_the_terms_add_up_to_the_mean_on_the_finest_grid():
    """With the same surfaces for every term the sum is the plain mean, and so is its error."""
    rows = solved([allocation.Batch(0, 50, SIZES)])
    found = estimator.estimate(Samples(rows, "kappa"), SIZES, SIZES)
    plain = np.array([made_up(seed, SIZES[-1]) for seed in range(50)])
    assert found.mean == pytest.approx(plain.mean(), rel=1e-12)
    assert found.standard_error == pytest.approx(plain.std(ddof=1) / math.sqrt(50), rel=0.05)  # as 49/47 has it
    assert found.plain_variance == pytest.approx(plain.var(ddof=1))


def test_a_foundation_leaves_the_mean_of_the_same_surfaces_alone():
    """What it adds to the sum it takes away; so it does from the error."""
    sizes = (FOUNDATION, *SIZES)
    samples = Samples(solved([allocation.Batch(0, 50, sizes)]), "kappa")
    with_it, without = (estimator.estimate(samples, s, s) for s in (sizes, SIZES))
    assert with_it.mean == pytest.approx(without.mean, rel=1e-12)
    assert with_it.standard_error == pytest.approx(without.standard_error, rel=0.05)
    assert with_it.bias == without.bias
    assert with_it.plain_variance == without.plain_variance


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


SURFACE = RoughIndenter(0.8, 5, cut_off_ratio=1 / 8)
SCENE = Scene(Layer(0.1), SURFACE, 0.02, num_points=2**11)


def test_grids_that_hold_the_surface():
    assert allocation.grid_sizes(SCENE) == (256, 512, 1024, 2048)
    assert allocation.grid_sizes(replace(SCENE, num_points=3 * 2**8)) == (384, 768)
    assert allocation.grid_sizes(Scene(indenter=RoughIndenter(cut_off_ratio=1), num_points=2**7)) == (2**7,)


def test_where_there_is_a_foundation():
    """On a compressible layer; and where there are several grids."""
    assert allocation.levels(SCENE) == (FOUNDATION, 256, 512, 1024, 2048)
    for layer in (Layer(), Layer(0.1, 0.5)):
        assert allocation.levels(replace(SCENE, layer=layer)) == (256, 512, 1024, 2048)
    assert allocation.levels(replace(SCENE, num_points=256)) == (256,)


def test_stored_ensembles_from_before_the_foundation_keep_their_grids():
    rows = [{"num_points": size} for size in (512, 256)]
    assert allocation.stored_levels(rows, [256, 512]) == (256, 512)
    assert allocation.stored_levels([*rows, {"num_points": FOUNDATION}], [256, 512]) == (FOUNDATION, 256, 512)


def test_a_foundation_that_scatters_by_rounding_tells_nothing():
    on = [1.0, np.nextafter(1.0, 2), 1.0, np.nextafter(1.0, 0)]
    rows = [
        {"num_points": size, "seed": seed, "status": "converged", "kappa_subgrid": value, "seconds.total": 1.0}
        for seed in range(4)
        for size, value in ((FOUNDATION, on[seed]), (256, 1.7 + 0.01 * seed))
    ]
    assert set(Samples(rows, "kappa").values[FOUNDATION].values()) == {0.0}


@pytest.mark.parametrize("unit", [1.0, 1e3])
def test_a_thin_layer_is_a_foundation(unit):
    """Solved on a layer a hundredth of the shortest wave thick, in whatever unit of length and pressure."""
    layer = Layer(1e-4, 0.25).in_units(unit, 2 / unit)
    scene = Scene(layer, SURFACE, 0.02 * 2 / unit, period=unit, num_points=2**13)
    found, solved_for = foundation.press(scene, scene.num_points), solve(scene).to_record()
    for name, value in found.items():
        assert value == pytest.approx(solved_for[name], rel=0.02)
    area, peak = found["contact_area_subgrid"], found["peak_pressure"]
    assert area * peak > scene.pressure > 0.1 * area * peak


def test_the_mean_of_surfaces_on_a_thin_layer():
    """Against plain sampling of other surfaces on the finest grid."""
    scene = replace(SCENE, layer=Layer(0.01, 0.25))
    found = ensemble_mean(scene, 0.015, relative=True)
    assert found.terms[0].num_points == FOUNDATION
    others = [replace(scene, indenter=replace(SURFACE, seed=10_000 + i)) for i in range(150)]
    plain = np.array([solve(other).observables.kappa_subgrid for other in others])
    error = math.hypot(found.standard_error, plain.std(ddof=1) / math.sqrt(150))
    assert abs(found.mean - plain.mean()) < 3.5 * error + found.bias
    assert sum(term.count for term in found.terms[1:]) < found.plain_variance / found.standard_error**2
    assert "on foundation" in repr(found)


def test_the_mean_of_real_surfaces():
    """Against plain sampling of other surfaces on the finest grid."""
    found = ensemble_mean(SCENE, 0.01)
    others = [replace(SCENE, indenter=replace(SURFACE, seed=10_000 + i)) for i in range(60)]
    plain = np.array([solve(scene).observables.kappa_subgrid for scene in others])
    error = math.hypot(found.standard_error, plain.std(ddof=1) / math.sqrt(60))
    assert found.standard_error <= 0.01
    assert abs(found.mean - plain.mean()) < 3.5 * error + found.bias


def test_one_grid_is_plain_sampling(tmp_path, capsys):
    scene = Scene(indenter=RoughIndenter(0.8, 0, cut_off_ratio=1 / 2), pressure=0.02, num_points=2**7)
    found = ensemble_mean(scene, 0.05, relative=True)
    assert len(found.terms) == 1
    assert math.isnan(found.bias)
    assert found.standard_error <= 0.05 * found.mean
    assert ensemble(tmp_path, "--cut-off-ratio", "0.5", "--num-points", "128", "--standard-error", "0.1") == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "this is plain sampling" in said
    assert "cheaper" not in said


def ensemble(folder, *words):
    start = ["ensemble", "--folder", str(folder), "--workers", "1", "--profile", "rough"]
    load = [] if "--pressure" in words else ["--pressure", "0.02"]
    return main.main([*start, *load, *words])


def test_too_coarse_a_grid_is_said(tmp_path, capsys):
    """The error is small, and the bias is not."""
    words = ("--cut-off-ratio", "0.125", "--num-points", "2^9", "--standard-error", "0.03")
    assert ensemble(tmp_path, *words) == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "is not reached: a finer grid is needed; allowed: more num_points" in said


def test_full_contact_does_not_scatter(tmp_path, capsys):
    words = ("--pressure", "100", "--observable", "contact-area", "--standard-error", "0.1")
    assert ensemble(tmp_path, *SMALL, *words) == 0
    assert "all surfaces have the same value" in " ".join(capsys.readouterr().out.split())


def test_starting_anew_does_everything_again(tmp_path):
    words = (*SMALL, "--standard-error", "0.03")
    assert ensemble(tmp_path, *words) == 0
    done = {path: path.stat().st_mtime_ns for path in (tmp_path / "tasks").glob("*.json")}
    assert ensemble(tmp_path, *words, "--overwrite") == 0
    tasks_again = {run["task"] for run in load_study(tmp_path / "ensemble.h5").runs}
    for path in (tmp_path / "tasks" / f"{task}.json" for task in tasks_again):
        assert path.stat().st_mtime_ns > done.get(path, 0)


def test_another_seed_is_another_ensemble():
    seeds = [{row["seed"] for row in sampled(wanted(0.005), seed=seed)[0]} for seed in range(5)]
    assert all(not one & other for one, other in itertools.combinations(seeds, 2))


SMALL = ("--cut-off-ratio", "0.125", "--num-points", "2^13")


def test_the_command(tmp_path, capsys):
    words = (*SMALL, "--thickness", "0.1", "--observable", "kappa,mean_gap", "--standard-error", "0.02", "--relative")
    assert ensemble(tmp_path, *words) == 0
    said = " ".join(capsys.readouterr().out.split())
    file = load_study(tmp_path / "ensemble.h5")
    asked, now = tasks.found(file)
    for name, found in now.estimates.items():
        assert f"{name} = {found.mean:.6g} +- {found.standard_error:.2g}" in said
        assert found.standard_error <= 0.02 * abs(found.mean)
    assert list(now.estimates) == list(asked.observables) == ["kappa", "mean-gap"]
    assert {path.name for path in tmp_path.glob("*.p*")} == {"ensemble.png", "ensemble.pdf"}
    one = next(row for row in file.runs if row["num_points"] == 1024)
    indenter = RoughIndenter(0.8, one["seed"], cut_off_ratio=0.125)
    alone = solve(Scene(Layer(0.1), indenter, 0.02, num_points=1024), tolerance=1e-10).observables
    assert one["kappa_subgrid"] == pytest.approx(alone.kappa_subgrid, rel=1e-4)
    assert ensemble(tmp_path, *words) == 0
    assert "Finished before" in capsys.readouterr().out
    assert main.main(["export", str(tmp_path / "ensemble.h5"), "--csv", str(tmp_path / "all.csv")]) == 0
    assert len((tmp_path / "all.csv").read_text().splitlines()) == len(file.runs) + 1
    assert main.main(["plot", str(tmp_path / "ensemble.h5")]) == 0


def test_what_is_out_of_reach(tmp_path, capsys):
    assert ensemble(tmp_path, *SMALL, "--standard-error", "1e-6", "--max-seconds", "10") == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "What was asked for is not reached: it takes about" in said
    assert "allowed: max_seconds of that, or a larger standard error" in said
    assert len(load_study(tmp_path / "ensemble.h5").runs) >= 3 * PILOT
    with pytest.raises(
        ValueError, match=r"standard_error is 1e-06: it takes about .* s of solving; allowed: max_seconds"
    ):
        ensemble_mean(SCENE, 1e-6, max_seconds=10)


def test_a_killed_ensemble_goes_on(tmp_path):
    """With what is solved, and without anything solved twice; killed when it has begun to decide."""
    words = [*SMALL, "--standard-error", "0.03", "--profile", "rough", "--pressure", "0.02", "--workers", "1"]
    program = [sys.executable, "-m", "linecontact.studies", "ensemble", "--folder", str(tmp_path), *words]
    killed = subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while killed.poll() is None and len(list((tmp_path / "tasks").glob("*.json"))) < 20:
        time.sleep(0.01)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    done = {path.name for path in (tmp_path / "tasks").glob("*.json")}
    assert subprocess.run(program, capture_output=True, timeout=300).returncode == 0
    file = load_study(tmp_path / "ensemble.h5")
    assert done <= {f"{name}.json" for name in {run["task"] for run in file.runs}}
    keys = [(run["seed"], run["num_points"]) for run in file.runs]
    assert len(keys) == len(set(keys))


def test_an_interrupted_run_does_not_replace_a_finished_one(tmp_path, capsys, monkeypatch):
    words, path = (*SMALL, "--standard-error"), tmp_path / "ensemble.h5"
    run, left = tasks.BatchTask.run, [5]

    def few(task, report):
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        return run(task, report)

    monkeypatch.setattr(tasks.BatchTask, "run", few)
    assert ensemble(tmp_path, *words, "0.1") == 130
    assert main.main(["plot", str(path)]) == 2  # nothing is known yet
    left[0] = PILOT - 5 + 2
    assert ensemble(tmp_path, *words, "0.008") == 130
    capsys.readouterr()
    assert main.main(["plot", str(path)]) == 0
    assert "does not hold all that was asked for; run its study again" in capsys.readouterr().err
    left[0] = 10**9
    assert ensemble(tmp_path, *words, "0.1") == 0
    assert "is the cheaper way here, by a factor of" in " ".join(capsys.readouterr().out.split())
    left[0] = 2
    assert ensemble(tmp_path, *words, "0.004") == 130
    file = load_study(path)
    assert (file.complete, file.configuration["standard_error"]) == (True, 0.1)
    capsys.readouterr()
    assert main.main(["plot", str(path)]) == 0
    assert not capsys.readouterr().err
    left[0] = 10**9
    assert ensemble(tmp_path, *words, "0.004") == 0
    assert load_study(path).configuration["standard_error"] == 0.004
    capsys.readouterr()
    left[0] = 0
    assert ensemble(tmp_path, *words, "0.02") == 0  # which it holds
    assert "is of standard_error 0.004, and holds all that is asked for" in capsys.readouterr().err
    assert load_study(path).configuration["standard_error"] == 0.004


def test_a_refused_run_does_not_replace_a_better_one(tmp_path, capsys):
    words, path = (*SMALL, "--standard-error"), tmp_path / "ensemble.h5"
    assert ensemble(tmp_path, *words, "0.02") == 0
    before = path.read_bytes()
    capsys.readouterr()
    assert ensemble(tmp_path, *words, "1e-6", "--max-seconds", "10") == 3
    said = capsys.readouterr()
    assert "What was asked for is not reached: it takes about" in " ".join(said.out.split())
    assert f"{path} is kept: it is finished, and holds more than this" in said.err
    assert path.read_bytes() == before
    assert ensemble(tmp_path, *words, "0.02") == 0
    assert "Finished before" in capsys.readouterr().out


def test_progress_is_the_time_of_solving_and_says_what_is_reached():
    records, shares, texts = {}, [], []
    given = {title: {} for title in kinds.titled()} | {kinds.title("profile", "rough"): {"cut_off_ratio": 1 / 8}}
    plan = study.plan(study.Options(pressure=0.02, num_points=SIZES[-1], standard_error=0.005), given)
    todo = plan.runs
    while todo:
        records |= {task: {"rows": solved([task.batch])} for task in todo}
        share, text = plan.outlook(records)
        shares.append(share)
        texts.append(text)
        todo = [task for task in plan.more(records) if task not in records]
    assert plan.outlook({}) == (0.0, "first surfaces")
    assert 0 < shares[0] < 0.3
    assert all(before < after + 0.1 for before, after in itertools.pairwise(shares))  # it becomes known on the way
    assert max(shares[:-1]) < shares[-1] == 1
    assert texts[-1].startswith("kappa 1.7")
    assert texts[-1].endswith("[dimensionless], 0.005 wanted")


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


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("", "standard_error is missing; allowed: a number > 0"),
        ("--standard-error 0", "standard_error is 0.0; allowed: a number of 1e-60 and more"),
        ("--standard-error 2 --relative", "standard_error is 2.0; allowed: 1e-60 to 1, over the mean"),
        (
            "--standard-error 0.1 --observable depth",
            "observable is 'depth'; allowed: kappa, contact-area, peak-pre",
        ),
        ("--standard-error 0.1 --max-seconds -1", "max_seconds is -1.0; allowed: a time > 0"),
        ("--standard-error 0.1 --max-samples 0", "max_samples is 0; allowed: an integer from 48 to"),
        ("--standard-error 0.1 --pressure 0", "pressure is 0; allowed: a pressure > 0"),
        ("--standard-error 0.1 --num-points 64", "which does not resolve the surface"),
    ],
)
def test_what_is_wrong_is_said(words, said, tmp_path, capsys):
    assert ensemble(tmp_path / "out", *words.split()) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("indenter", [PowerIndenter(), MeasuredIndenter(np.arange(8.0) ** 2)])
def test_what_is_not_random(indenter):
    with pytest.raises(ValueError, match=r"profile is .*; allowed: one with a seed, like rough"):
        ensemble_mean(Scene(indenter=indenter, num_points=8), 0.1)


def test_bad_arguments_in_python():
    with pytest.raises(ValueError, match=r"scene is 1; allowed: a Scene"):
        ensemble_mean(1, 0.1)
    with pytest.raises(ValueError, match=r"standard_error is nan; allowed: a number of 1e-60 and more"):
        ensemble_mean(SCENE, math.nan)
    with pytest.raises(ValueError, match=r"pressure is 0; allowed: a pressure > 0"):
        ensemble_mean(replace(SCENE, pressure=0.0), 0.1)
    with pytest.raises(ValueError, match=r"approach is 0.01; allowed: a scene with a pressure"):
        ensemble_mean(replace(SCENE, pressure=math.nan, approach=0.01), 0.1)
