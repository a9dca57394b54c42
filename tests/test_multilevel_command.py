"""Means over random surfaces by the command: what it says, stores, refuses, and goes on with."""

import itertools
import math
from dataclasses import replace

import pytest
from linecontact import ensemble_mean
from linecontact.solver import Layer, RoughIndenter, Scene, solve
from linecontact.solver.display import rounded_up
from linecontact.studies.command_line import main
from linecontact.studies.files.study_files import load_study
from linecontact.studies.multilevel import allocation, study, tasks
from linecontact.studies.multilevel.allocation import PILOT
from linecontact.studies.multilevel.samples import on_finest
from linecontact.studies.scenes import kinds
from made_up_ensembles import SCENE, SIZES, solved

pytestmark = pytest.mark.once

SMALL = ("--cut-off-ratio", "0.125", "--num-points", "2^13")


def ensemble(folder, *words):
    start = ["ensemble", "--folder", str(folder), "--workers", "1", "--profile", "rough"]
    load = [] if "--pressure" in words else ["--pressure", "0.02"]
    return main.main([*start, *load, *words])


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


def test_warnings_of_the_surfaces_are_counted(tmp_path, capsys):
    """Of those on the finest grid, as their solutions have them; small slopes and strains have none."""
    words = ("--standard-error", "0.05", "--relative")
    assert ensemble(tmp_path / "steep", *SMALL, *words) == 0
    said = " ".join(capsys.readouterr().out.split())
    finest = on_finest(load_study(tmp_path / "steep" / "ensemble.h5").runs)
    assert {run["warnings"] for run in finest} == {"strain, slope"}
    surfaces = f"{len(finest)} surfaces on {finest[0]['num_points']} points"
    assert f"Warnings of the {surfaces}, and how many have them: strain ({len(finest)}), slope ({len(finest)});" in said
    flat = ("--rms-gradient", "0.01", "--pressure", "0.0002")
    assert ensemble(tmp_path / "flat", *SMALL, *words, *flat) == 0
    assert "Warnings" not in capsys.readouterr().out
    scene = Scene(indenter=RoughIndenter(cut_off_ratio=1 / 8), pressure=0.02, num_points=2**10)
    assert "; warnings: strain (" in repr(ensemble_mean(scene, 0.05, relative=True))


def test_too_coarse_a_grid_is_said(tmp_path, capsys):
    """The error is small, and the bias is not."""
    words = ("--cut-off-ratio", "0.125", "--num-points", "2^9", "--standard-error", "0.03")
    assert ensemble(tmp_path, *words) == 3
    assert "is not reached: a finer grid is needed; allowed: more num_points" in capsys.readouterr().err


def test_full_contact_does_not_scatter(tmp_path, capsys):
    """So that there is nothing to draw, but of the peak pressure, which does."""
    words = ("--pressure", "100", "--standard-error", "0.1", "--observable")
    assert ensemble(tmp_path, *SMALL, *words, "contact-area") == 0
    assert "all surfaces have the same value" in " ".join(capsys.readouterr().out.split())
    assert not list(tmp_path.glob("*.png"))
    assert ensemble(tmp_path, *SMALL, *words, "contact-area,peak-pressure") == 0
    assert rows_of(tmp_path) == ["peak-pressure: scatter and change\n(pressure)"]


def rows_of(folder):
    """What the rows of the figure of a stored ensemble are of."""
    (figure,) = study.draw(folder / "ensemble.h5").values()
    assert figure.get_suptitle().startswith("profile: rough, $H=0.8$, $\\lambda_s/\\lambda_r=0.125$, ")
    return [axes.get_ylabel() for axes in figure.axes[::2]]


def test_starting_anew_does_everything_again(tmp_path):
    words = (*SMALL, "--standard-error", "0.08")
    assert ensemble(tmp_path, *words) == 0
    done = {path: path.stat().st_mtime_ns for path in (tmp_path / "tasks").glob("*.json")}
    assert ensemble(tmp_path, *words, "--overwrite") == 0
    tasks_again = {run["task"] for run in load_study(tmp_path / "ensemble.h5").runs}
    for path in (tmp_path / "tasks" / f"{task}.json" for task in tasks_again):
        assert path.stat().st_mtime_ns > done.get(path, 0)


def test_the_command(tmp_path, capsys):
    words = (*SMALL, "--thickness", "0.1", "--observable", "kappa,mean_gap", "--standard-error", "0.05", "--relative")
    assert ensemble(tmp_path, *words) == 0
    said = " ".join(capsys.readouterr().out.split())
    file = load_study(tmp_path / "ensemble.h5")
    asked, now = tasks.found(file)
    for name, found in now.estimates.items():
        assert f"{name} = {found.mean:.6g} +- {rounded_up(found.standard_error)}" in said
        assert found.standard_error <= 0.05 * abs(found.mean)
    assert list(now.estimates) == list(asked.observables) == ["kappa", "mean-gap"]
    assert {path.name for path in tmp_path.glob("*.p*")} == {"ensemble.png", "ensemble.pdf"}
    assert rows_of(tmp_path) == [
        f"{name}: scatter and change\n({unit})" for name, unit in (("kappa", "dimensionless"), ("mean-gap", "length"))
    ]
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
    words = (*SMALL, "--standard-error", "1e-6", "--max-seconds", "10")
    for last in ("s in all.", "Nothing computed; all that may be done was done before."):
        assert ensemble(tmp_path, *words) == 3
        said = capsys.readouterr()
        assert "linecontact: ensemble: the goal is not reached: it takes at least" in said.err
        allowed = "allowed: max_seconds of that or more, or a larger standard error\n"
        assert f"s of solving, max_seconds is 10; {allowed}" in said.err
        assert "not reached" not in said.out
        assert last in said.out
    assert len(load_study(tmp_path / "ensemble.h5").runs) >= 3 * PILOT
    with pytest.raises(ValueError, match=r"standard_error is 1e-06: it takes at least .* s of solving, max_seconds is"):
        ensemble_mean(SCENE, 1e-6, max_seconds=10)
    coarse = replace(SCENE, num_points=2**10)  # which leaves no finer grid that may be needed
    with pytest.raises(ValueError, match=r"it takes about .* solves, max_samples is 100; allowed: max_samples of that"):
        ensemble_mean(coarse, 1e-4, max_samples=100)
    with pytest.raises(ValueError, match="relative is 'yes'; allowed: True or False"):
        ensemble_mean(SCENE, 0.1, relative="yes")
    with pytest.raises(ValueError, match=r"observable is \['kappa'\]; allowed: one of kappa, contact-area"):
        ensemble_mean(SCENE, 0.1, observable=["kappa"])


def test_an_interrupted_run_does_not_replace_a_finished_one(tmp_path, capsys, monkeypatch):
    words, path = (*SMALL, "--standard-error"), tmp_path / "ensemble.h5"
    run, left = tasks.BatchTask.run, [5]

    def few(task, report):
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        return run(task, report)

    monkeypatch.setattr(tasks.BatchTask, "run", few)
    monkeypatch.setattr(allocation, "_SECONDS", 0.0)  # a task for each surface, however long it takes
    assert ensemble(tmp_path, *words, "0.1") == 130
    assert main.main(["plot", str(path)]) == 2  # nothing is known yet
    before = {path.name for path in (tmp_path / "tasks").glob("*.json")}
    assert len(before) == 5
    left[0] = PILOT - 5 + 2
    assert ensemble(tmp_path, *words, "0.008") == 130
    capsys.readouterr()
    assert main.main(["plot", str(path)]) == 0
    assert "does not hold all that was asked for; run its study again" in capsys.readouterr().err
    left[0] = 10**9
    assert ensemble(tmp_path, *words, "0.1") == 0
    assert "Plain sampling on 1024 points takes about" in " ".join(capsys.readouterr().out.split())
    left[0] = 0
    assert ensemble(tmp_path, *words, "0.006") == 130
    file = load_study(path)
    assert (file.complete, file.configuration["standard_error"]) == (True, 0.1)
    capsys.readouterr()
    assert main.main(["plot", str(path)]) == 0
    assert not capsys.readouterr().err
    left[0] = 10**9
    assert ensemble(tmp_path, *words, "0.006") == 0
    file = load_study(path)
    assert file.configuration["standard_error"] == 0.006
    keys = [(run["seed"], run["num_points"]) for run in file.runs]
    assert len(keys) == len(set(keys))  # nothing is solved twice
    assert before <= {path.name for path in (tmp_path / "tasks").glob("*.json")}
    assert before <= {f"{run['task']}.json" for run in file.runs}  # and all that was solved serves
    capsys.readouterr()
    left[0] = 0
    assert ensemble(tmp_path, *words, "0.03") == 0  # which it holds
    assert "is of standard_error 0.006, and holds all that is asked for" in capsys.readouterr().err
    assert load_study(path).configuration["standard_error"] == 0.006


def test_a_refused_run_does_not_replace_a_better_one(tmp_path, capsys):
    words, path = (*SMALL, "--standard-error"), tmp_path / "ensemble.h5"
    assert ensemble(tmp_path, *words, "0.05") == 0
    before = path.read_bytes()
    capsys.readouterr()
    assert ensemble(tmp_path, *words, "1e-6", "--max-seconds", "10") == 3
    said = capsys.readouterr()
    assert "the goal is not reached: it takes at least" in said.err
    assert f"{path} is kept: it is finished, and holds more than this" in said.err
    assert path.read_bytes() == before
    assert ensemble(tmp_path, *words, "0.05") == 0
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


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("", "standard_error is missing; allowed: a number of 1e-60 and more"),
        ("--standard-error 0", "standard_error is 0.0; allowed: a number of 1e-60 and more"),
        ("--standard-error 1 --observable kappa,kappa", "observable holds kappa a second time; allowed: each once"),
        ("--standard-error 2 --relative", "standard_error is 2.0; allowed: 1e-60 to 1, over the mean"),
        ("--standard-error 0.1 --observable depth", "observable is 'depth'; allowed: kappa, contact-area, peak-pre"),
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
