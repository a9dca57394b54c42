"""Store, studies and figures: round trips, resuming, damaged files."""

import dataclasses
import json
import math
from pathlib import Path

import h5py
import numpy as np
import pytest
from linecontact.solver import Layer, Scene, closed_forms, solve
from linecontact.studies import figures, hertz, store

SMALL = hertz.Configuration(
    num_points=256, poisson_ratios=(0.0, 0.5), reduced_thicknesses=(1.0, 0.3, 0.1), line_points=4
)


def open_small(path, anew=False, **changes):
    return store.open_study("hertz", dataclasses.asdict(dataclasses.replace(SMALL, **changes)), path, anew)


@pytest.fixture(scope="module")
def solution():
    return solve(Scene(Layer(0.1, 0.25), num_points=256))


def test_solution_round_trip(solution, tmp_path):
    path = tmp_path / "run.h5"
    store.save_solution(path, solution)
    fields, attributes = store.load_solution(path)
    np.testing.assert_array_equal(fields["x"], np.arange(256) / 256)
    np.testing.assert_array_equal(fields["profile"], solution.scene.profile)
    np.testing.assert_array_equal(fields["displacement"], solution.displacement)
    np.testing.assert_array_equal(fields["contact_pressure"], solution.contact_pressure)
    for name, value in store.flatten(solution.to_dict()).items():
        assert attributes[name] == value
    assert store.file_kind(path) == "solution"
    with h5py.File(path) as file:
        assert file["contact_pressure"].attrs["unit"] == "pressure"
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


def test_a_failed_write_leaves_the_old_file(solution, tmp_path, monkeypatch):
    path = tmp_path / "run.h5"
    store.save_solution(path, solution)
    before = path.read_bytes()
    monkeypatch.setattr(store, "flatten", lambda record: {"bad": object()})
    with pytest.raises(TypeError):
        store.save_solution(path, solution)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


def test_targets_are_checked_before_the_work(tmp_path):
    (tmp_path / "there.h5").touch()
    with pytest.raises(store.StoreError, match=r"there\.h5 exists"):
        store.check_target(tmp_path / "there.h5", overwrite=False)
    store.check_target(tmp_path / "there.h5", overwrite=True)
    with pytest.raises(store.StoreError, match="does not exist"):
        store.check_target(tmp_path / "no" / "run.h5", overwrite=False)
    with pytest.raises(store.StoreError, match="is a folder"):
        store.check_target(tmp_path, overwrite=True)


@pytest.mark.parametrize("content", [b"", b"not HDF5", None])
def test_damaged_files_are_named(tmp_path, solution, content):
    path = tmp_path / "run.h5"
    if content is None:
        store.save_solution(path, solution)
        path.write_bytes(path.read_bytes()[:1000])
    else:
        path.write_bytes(content)
    for read in (store.file_kind, store.load_study, store.load_solution):
        with pytest.raises(store.StoreError, match=r"run\.h5"):
            read(path)


def test_study_round_trip(tmp_path):
    runs = [{"status": "converged", "commit": "12345678", "iterations": 3, "d": 0.5, "t": "inf", "x.ok": True}]
    runs.append({**runs[0], "commit": "1e5", "t": 0.25})
    lines = {"nu=0": {"a": np.arange(3.0)}}
    study = store.StudyFile("hertz", {"tolerance": 1e-8, "list": [1, 2.5]}, runs, lines)
    path = tmp_path / "study.h5"
    store.save_study(path, study)
    back = store.load_study(path)
    assert back.runs == [{**runs[0], "t": math.inf}, {**runs[1]}]
    assert back.configuration == study.configuration
    np.testing.assert_array_equal(back.lines["nu=0"]["a"], np.arange(3.0))
    assert not back.complete


def test_hertz_study_in_processes_and_resumed(tmp_path, monkeypatch):
    path = tmp_path / "hertz.h5"
    kept = []
    keep = hertz._keep

    def interrupt_after_two(study, path, task, record):
        keep(study, path, task, record)
        kept.append(task)
        if len(kept) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(hertz, "_keep", interrupt_after_two)
    with pytest.raises(KeyboardInterrupt):
        hertz.run(open_small(path), SMALL, path, 2, "estimate")
    partial = store.load_study(path)
    assert len(partial.runs) == 2
    assert not partial.complete
    monkeypatch.setattr(hertz, "_keep", lambda *arguments: kept.append(arguments[2]) or keep(*arguments))
    study = open_small(path)
    hertz.run(study, SMALL, path, 2, "estimate")
    assert study.complete
    assert len(kept) == 6  # nothing was computed twice
    assert set(study.lines) == {"nu=0", "nu=0.5"}
    assert open_small(path).complete
    assert open_small(path, anew=True).runs == []
    assert (study.column("status") == "converged").all()
    error = study.column("contact_area") - study.column("oracle.contact_area")
    assert (abs(error) < 2 / 256).all()
    np.testing.assert_allclose(study.column("peak_pressure"), study.column("oracle.peak_pressure"), rtol=2e-2)
    assert hertz.summary(study).row_count == 2
    with pytest.raises(store.StoreError, match="another study or configuration"):
        open_small(path, num_points=512)
    drawn = figures.draw(path)
    assert {p.name for p in drawn} == {"hertz.png", "hertz.pdf", "hertz-accuracy.png", "hertz-accuracy.pdf"}
    assert all(p.stat().st_size > 5000 for p in drawn)


def test_figures_hold_the_stored_numbers(tmp_path):
    """Data of the drawn artists, not pixels."""
    record = hertz.run_task(hertz.Task(SMALL, 0.0, 1))[1]
    study = store.StudyFile("hertz", dataclasses.asdict(SMALL), [record], dict([hertz.oracle_line(SMALL, 0.0)]))
    figure = figures._hertz_ratio(study)
    lines = {line.get_label(): line for line in figure.axes[0].get_lines()}
    x, y = lines[r"$\nu=0$"].get_data()
    assert x == [record["reduced_thickness"]]
    assert y == [record["kappa_ratio"] / record["reduced_thickness"]]
    oracle = next(line for line in figure.axes[0].get_lines() if len(line.get_xdata()) == 4)
    np.testing.assert_array_equal(oracle.get_ydata() * oracle.get_xdata(), study.lines["nu=0"]["kappa_ratio"])


def test_full_study_covers_the_published_range():
    full = hertz.Configuration()
    assert full.num_points == 2**18
    assert min(full.reduced_thicknesses) < 0.01
    assert max(full.reduced_thicknesses) > 3
    assert len(full.reduced_thicknesses) >= 12
    assert set(full.poisson_ratios) == {0.0, 0.25, 0.4, 0.45, 0.49, 0.5}


def test_stored_reference_meets_the_goals():
    """The study's figures in the README are drawn from this file: 2^18 points, every (d, nu)."""
    study = store.load_study(Path(figures.__file__).parent / "results" / "hertz.h5")
    full = hertz.Configuration()
    assert study.complete
    assert study.configuration == json.loads(json.dumps(dataclasses.asdict(full)))
    assert len(study.runs) == len(full.poisson_ratios) * len(full.reduced_thicknesses) >= 72
    assert (study.column("status") == "converged").all()
    assert (study.column("certificate.free_residual") <= 1e-8).all()
    area, exact = study.column("contact_area"), study.column("oracle.contact_area")
    assert (np.abs(area - exact) < 1.5 / 2**18).all()
    np.testing.assert_allclose(study.column("peak_pressure"), study.column("oracle.peak_pressure"), rtol=1e-5)
    # layers of 20 grid spacings and more: 0.01 spacings an edge; thinner ones never worse than counting
    error = np.abs(study.column("contact_area_subgrid") - exact) * 2**18
    assert (error[study.column("scene.thickness") > 20 / 2**18] < 0.02).all()
    assert (error < 1.5).all()
    # the thin plateau: second order within what is left of it (1 % of the ratio) and one spacing at each edge
    for nu in full.poisson_ratios:
        thin = min(study.select("scene.poisson_ratio", nu).runs, key=lambda run: run["reduced_thickness"])
        t = thin["reduced_thickness"]
        second = closed_forms.thin_layer_kappa_ratio(2.0, nu, t, closed_forms.edge_shift(nu))
        first = closed_forms.thin_layer_kappa_ratio(2.0, nu, t)
        counting = 3 / 2**18 / thin["oracle.contact_area"]
        assert abs(thin["kappa_ratio"] / second - 1) < 0.02 * abs(first / second - 1) + counting
