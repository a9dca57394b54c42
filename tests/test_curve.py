"""`linecontact curve`: every number of a scene can be varied, and what is wrong is said before anything is solved."""

import itertools
import json
import math
import os
import re
from dataclasses import replace

import h5py
import numpy as np
import pytest
from linecontact import curve as curve_of
from linecontact import ensemble_mean
from linecontact.solver import Layer, RoughIndenter, Scene, Status, checks, solve
from linecontact.solver.display import rounded_up
from linecontact.studies.command_line import main
from linecontact.studies.curve import figures, number, study, tasks
from linecontact.studies.files.study_files import load_study, save_study


def curve(folder, *words):
    return main.main(["curve", "--folder", str(folder), "--workers", "1", *words])


def grid(words):
    """A small one, unless the grid is what varies."""
    return [] if "num_points" in words else ["--num-points", "2^9"]


def runs(folder):
    return load_study(folder / "curve.h5").runs


@pytest.fixture(scope="module")
def loads(tmp_path_factory):
    folder = tmp_path_factory.mktemp("loads")
    assert curve(folder, "--num-points", "2^10", "--points", "6", "--thickness", "0.1") == 0
    return folder


def test_over_the_load_from_first_touch_to_full_contact(loads, capsys):
    found = runs(loads)
    pressure, area = ([run[name] for run in found] for name in ("scene.pressure", "contact_area"))
    assert len(found) == 6
    assert pressure[-1] == pytest.approx(1e5 * pressure[0], rel=1e-8)
    assert area == sorted(area)
    assert area[0] < 0.01
    assert area[-1] == 1
    one = found[2]
    alone = solve(Scene(Layer(0.1), pressure=one["scene.pressure"], num_points=2**10))
    assert one["contact_area_subgrid"] == pytest.approx(alone.observables.contact_area_subgrid, rel=1e-12)
    assert one["contact_stiffness"] == pytest.approx(alone.contact_stiffness, rel=1e-9)
    # the stiffness is the slope of the curve: between two loads it lies between those at the loads
    for left, right in itertools.pairwise(found):
        slope = (right["scene.pressure"] - left["scene.pressure"]) / (right["approach"] - left["approach"])
        assert left["contact_stiffness"] < slope < right["contact_stiffness"]
    capsys.readouterr()
    assert curve(loads, "--num-points", "2^10", "--points", "6", "--thickness", "0.1") == 0
    assert "Finished before; nothing computed." in capsys.readouterr().out
    assert (loads / "curve.png").is_file()


def test_another_curve_does_not_replace_it(loads, capsys):
    assert curve(loads, "--num-points", "2^9", "--points", "2") == 2
    assert "holds results made with other options (scene, values); allowed: --folder and" in capsys.readouterr().err


def test_more_values_continue(tmp_path, capsys):
    """Values that are known are not solved again."""
    known = ["--num-points", "2^9", "--over", "thickness"]
    assert curve(tmp_path, *known, "--values", "0.1,0.2") == 0
    records = {file: file.stat().st_mtime_ns for file in (tmp_path / "tasks").iterdir()}
    os.remove(tmp_path / "curve.h5")
    assert "compare with no other" not in " ".join(capsys.readouterr().out.split())
    assert curve(tmp_path, *known, "--values", "0.1,0.2,inf") == 0
    said = capsys.readouterr()
    assert "continuing: 2 of 3 tasks are done" in said.err
    assert "half-space have another reference, and compare with no other" in " ".join(said.out.split())
    assert all(file.stat().st_mtime_ns == then for file, then in records.items())
    assert [run["scene.thickness"] for run in runs(tmp_path)] == [0.1, 0.2, math.inf]
    (figure,) = study.draw(tmp_path / "curve.h5").values()
    for axes in figure.axes[:2]:  # the half-space is seen; its stiffness has another reference
        (line,) = [line for line in axes.get_lines() if line.get_label() == "half-space"]
        low, high = axes.get_ylim()
        assert low < line.get_ydata()[0] < high


def test_a_file_that_has_the_name_of_a_figure_is_left_alone(tmp_path, capsys):
    (tmp_path / "curve.pdf").write_text("mine, not linecontact's")
    known = ["--num-points", "2^9", "--over", "thickness", "--values", "0.1"]
    said = "curve.pdf has the name of a figure, and is not one that this version of linecontact has drawn; allowed: to"
    for _ in range(2):
        assert curve(tmp_path, *known) == 0
        told = capsys.readouterr()
        assert "Figures" not in told.out
    assert said in " ".join(told.err.split())
    assert not (tmp_path / "curve.png").exists()
    plot = ["plot", str(tmp_path / "curve.h5")]
    assert main.main(plot) == 2
    assert said in capsys.readouterr().err
    assert (tmp_path / "curve.pdf").read_text().startswith("mine")
    assert main.main([*plot, "--overwrite"]) == 0
    assert (tmp_path / "curve.pdf").read_bytes().startswith(b"%PDF")
    (tmp_path / "curve.pdf").write_text("mine")
    assert curve(tmp_path, *known, "--overwrite") == 0
    assert (tmp_path / "curve.pdf").read_bytes().startswith(b"%PDF")
    assert main.main(plot) == 0  # now it is its own


@pytest.mark.parametrize(
    ("words", "column", "values"),
    [
        ("--over approach --from 1e-4 --to 1e-2 --points 3", "approach", [1e-4, 1e-3, 1e-2]),
        ("--over poisson_ratio --from 0 --to 0.5 --points 3", "scene.poisson_ratio", [0, 0.25, 0.5]),
        ("--over exponent --values 1.5,2", "scene.exponent", [1.5, 2]),
        ("--over num_points --from 2^6 --to 2^8 --points 3 --spacing log", "scene.num_points", [64, 128, 256]),
        ("--layer coated --thickness 0.1 --over base_modulus --values 0.1,10", "scene.base_modulus", [0.1, 10]),
        ("--layer sliding --over thickness --values 0.1,inf", "scene.thickness", [0.1, math.inf]),
        ("--profile rough --cut-off-ratio 0.25 --over seed --from 3 --to 5", "scene.seed", [3, 4, 5]),
    ],
)
def test_over_any_number(tmp_path, monkeypatch, capsys, words, column, values):
    monkeypatch.chdir(tmp_path)
    assert main.main(["curve", "--workers", "1", *grid(words), *words.split()]) == 0
    over = words.partition("--over ")[2].split()[0].replace("_", "-")
    found = runs(tmp_path / "results" / f"curve-{over}")
    assert [float(run[column]) for run in found] == pytest.approx(values, rel=1e-9)
    assert {run["status"] for run in found} == {"converged"}
    if over == "seed":
        areas = np.array([run["contact_area_subgrid"] for run in found])
        told = f"a_r = {areas.mean():.6g} +- {rounded_up(areas.std(ddof=1) / 3**0.5)}"
        assert told in capsys.readouterr().out.replace("\n", " ")


def test_a_scan_with_lengths_in_units(tmp_path, capsys):
    scan = tmp_path / "scan.csv"
    scan.write_text("x [um],z [nm]\n" + "\n".join(f"{a},{40 * math.sin(a / 7)}" for a in np.arange(200) * 0.5))
    words = [
        "--profile",
        "file",
        "--profile-file",
        str(scan),
        "--youngs-modulus",
        "5e9",
        "--num-points",
        "2^10",
        "--over",
    ]
    over = [*words, "thickness", "--pressure", "1e6", "--to", "0.1mm", "--points", "3", "--from"]
    assert curve(tmp_path / "out", *over, "1um") == 0
    assert re.search(r"thickness of the layer\W+varies\W+um", capsys.readouterr().out)
    assert [run["scene.thickness"] for run in runs(tmp_path / "out")] == pytest.approx([1e-6, 1e-5, 1e-4])
    with h5py.File(tmp_path / "out" / "curve.h5") as file:
        told = json.loads(json.loads(file.attrs["configuration"])["scene"])
    assert list(told["files"]) == ["scan.csv"]
    assert curve(tmp_path / "no", *over, "1") == 2
    assert "from is '1'; allowed: with its unit, like 1m, or --length-unit" in capsys.readouterr().err
    assert curve(tmp_path / "approach", *words, "approach", "--values", "10nm,20nm") == 0
    assert [run["approach"] for run in runs(tmp_path / "approach")] == pytest.approx([1e-8, 2e-8], rel=1e-6)
    scan.write_text(scan.read_text().replace("40", "41", 1) + "\n")
    os.remove(tmp_path / "out" / "curve.h5")
    assert curve(tmp_path / "out", *over, "1um") == 0
    assert len(list((tmp_path / "out" / "tasks").glob("*.json"))) == 6  # other contents are another scene


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--over thicknes", "over is 'thicknes'; allowed: pressure, approach, num_points, thickness"),
        ("--over hurst --from 0 --to 1", "over is 'hurst'; allowed: with --profile rough, or pressure, "),
        ("--over youngs_modulus --from 1 --to 10", "over is 'youngs_modulus'; allowed: contact_modulus, E/(1 - nu^2)"),
        ("--over thickness", "from is missing; allowed: a number, or --values, with --over thickness"),
        ("--over thickness --from 0.1", "to is missing; allowed: a number"),
        ("--values 0.2,0.1,1e-1", "values hold 1e-1 a second time; allowed: each once"),
        ("--values 1e-3,,2e-3", "values is ''; allowed: a number"),
        ("--approach 0.1", "approach is 0.1; allowed: none with --over pressure"),
        ("--over approach --pressure 1 --values 1e-3", "pressure is 1.0; allowed: none with --over approach"),
        ("--over thickness --thickness 0.5 --values 0.1", "thickness is 0.5; allowed: none with --over thickness"),
        ("--over thickness --from 0.1 --to 1mm", "to is '1mm'; allowed: a number alone, the lengths"),
        ("--from 1kPa --to 2kPa", "from is '1kPa'; allowed: a number alone, the pressures of this scene"),
        ("--over exponent --from 1,5 --to 2", "from is '1,5'; allowed: a number with a decimal point, like 1.5"),
        ("--from 0 --to 1 --spacing area", "from is 0, and to 1; allowed: 0 < from < to, with --spacing area"),
        ("--over thickness --from 1 --to 2 --spacing area", "spacing is 'area'; allowed: with --over pressure, not th"),
        ("--from 0 --to 1 --spacing log", "from is 0, and to 1; allowed: numbers > 0, with --spacing log"),
        ("--from 1 --to 1", "to is 1, and from 1; allowed: two numbers that differ; --values takes one\n"),
        ("--over thickness --values 1,1e400", "values is '1e400'; allowed: a number of 4.9e-324 to 1.8e+308 in size\n"),
        ("--from 1e-4 --to inf", "to is inf, and from 0.0001; allowed: finite numbers"),
        ("--points 1", "points is 1; allowed: an integer from 2 to 16384"),
        ("--values 1e-3 --from 1e-3", "from is '1e-3'; allowed: none with --values"),
        ("--values 1e-3,-1", "pressure is -1.0; allowed: a finite pressure >= 0"),
        ("--over num_points --from 2 --to 9", "from is 2; allowed: an integer from 4"),
        ("--over poisson_ratio --from 0 --to 0.7", "to is 0.7; allowed: -1 < nu <= 0.5\n"),
        ("--from 1e-3 --to 1e70", "to is 1e70, where pressure/contact_modulus is 1e+70; allowed: from 1e-60 to 1e"),
        ("--accuracy 2", "accuracy is 2.0; allowed: 1e-9 <= accuracy <= 0.1"),
        ("--accuracy 0.01 --over approach --values 1e-3", "accuracy is 0.01; allowed: none with an approach"),
        ("--accuracy 0.01 --over num_points --values 64", "accuracy is 0.01; allowed: none with --over num_points"),
        ("--youngs-modulus 3 --over poisson_ratio --values 0.1", "youngs_modulus is 3; allowed: none with --over po"),
        ("--over seed --profile rough --cut-off-ratio 0.25 --from 0.5 --to 3", "to is 3, and from 0.5; allowed: int"),
        ("--over approach --from 1e-3 --to 1", "to is 1; allowed: up to 0.041666"),
        ("--layer coated --thickness 0.1", "base_modulus (or base_youngs_modulus) is missing; allowed: one of the two"),
    ],
)
def test_what_is_wrong_is_said_before_anything_is_solved(tmp_path, capsys, words, said):
    assert curve(tmp_path / "out", *grid(words), *words.split()) == 2
    assert capsys.readouterr().err.startswith(f"linecontact: {said}")
    assert not (tmp_path / "out" / "tasks").exists()


def test_columns_in_python():
    scene = Scene(Layer(0.1), num_points=2**9)
    found = curve_of(scene, "pressure", [1e-3, 2e-3])
    one = solve(Scene(Layer(0.1), pressure=2e-3, num_points=2**9))
    assert found["contact_area_subgrid"][1] == one.observables.contact_area_subgrid
    assert found["contact_stiffness"][1] == one.contact_stiffness
    assert found["status"].tolist() == ["converged", "converged"]
    assert {len(column) for column in found.values()} == {2}
    loaded = Scene(Layer(0.1), pressure=0.1, num_points=2**9)
    assert curve_of(loaded, "approach", [1e-3])["approach"] == pytest.approx([1e-3])
    assert curve_of(scene, "thickness", [math.inf])["reduced_thickness"].tolist() == [math.inf]
    for over, values, said in (
        ("depth", [1.0], "over is 'depth'; allowed: pressure, approach, num_points"),
        ("pressure", [], "values are none; allowed: numbers, one or more"),
        ("pressure", [1e-3, -1.0], "pressure is -1.0; allowed: a finite pressure >= 0"),
    ):
        with pytest.raises(ValueError, match=said):
            curve_of(scene, over, values)


def test_the_figure_of_a_curve_that_is_not_finished_says_so(loads, tmp_path):
    known = load_study(loads / "curve.h5")
    save_study(tmp_path / "curve.h5", replace(known, runs=known.runs[:2], complete=False))
    for path, said in ((loads, False), (tmp_path, True)):
        (figure,) = figures.draw(path / "curve.h5").values()
        assert ("Not finished: 2 of 6 values." in figure.get_suptitle()) == said


def test_ctrl_c_ends_a_curve(monkeypatch):
    """Not only the point at which it comes."""
    monkeypatch.setattr(tasks, "solve", lambda scene, **_: replace(solve(scene), status=Status.INTERRUPTED))
    with pytest.raises(KeyboardInterrupt):
        curve_of(Scene(num_points=64), "pressure", [1e-3, 2e-3])


@pytest.mark.parametrize("words", ["--num-points 2^10", "--num-points 2^13 --profile rough --cut-off-ratio 0.2"])
def test_loads_at_which_the_area_rises_evenly(words, tmp_path):
    assert curve(tmp_path, *words.split(), "--points", "6", "--spacing", "area", "--thickness", "0.1") == 0
    area = [run["contact_area_subgrid"] for run in runs(tmp_path)]
    np.testing.assert_allclose(np.diff(area), (area[-1] - area[0]) / 5, rtol=0.15)
    assert area[-1] > 0.999


def test_spacing():
    assert number.spaced(1.0, 3.0, 3, "auto", False) == (1.0, 2.0, 3.0)
    assert number.spaced(100.0, 1.0, 3, "auto", False) == (100.0, 10.0, 1.0)
    assert number.spaced(1.0, 4.0, 10, "linear", True) == (1.0, 2.0, 3.0, 4.0)


OVER = ["curve", "--over", "pressure", "--from", "1e-3", "--to", "1e-2", "--points", "2"]
MEANS = ["ensemble", "--hurst", "0.8", "--pressure", "0.01", "--standard-error", "0.1"]


@pytest.mark.parametrize("words", [OVER, MEANS])
def test_a_grid_that_does_not_fit_into_a_worker_is_refused_before_anything_starts(tmp_path, capfd, words):
    words = [*words, "--folder", str(tmp_path / "new"), "--num-points", "2^23"]
    assert main.main([*words, "--workers", "2", "--memory", "0.6"]) == 2
    said = capfd.readouterr().err
    assert said.startswith("linecontact: num_points is 8388608, needing about 0.9 GiB; allowed: as many as fit")
    assert said.endswith("or fewer workers\n")
    assert said.count("\n") == 1
    assert not (tmp_path / "new" / "tasks").exists()


def test_a_grid_that_does_not_fit_into_memory_is_refused_before_anything_is_solved(tmp_path, capfd, monkeypatch):
    monkeypatch.setattr(tasks, "solve", None)
    monkeypatch.setattr(checks, "available_memory", lambda: 2**20)
    assert curve(tmp_path, "--over", "num_points", "--values", "64,16384") == 2
    assert "num_points is 16384, needing about 0.0 GiB" in capfd.readouterr().err
    for run in (
        lambda: curve_of(Scene(num_points=64), "num_points", [64, 2**14]),
        lambda: ensemble_mean(Scene(indenter=RoughIndenter(), num_points=2**14), 0.1),
    ):
        with pytest.raises(ValueError, match=r"num_points is 16384, needing about 0\.0 GiB"):
            run()
