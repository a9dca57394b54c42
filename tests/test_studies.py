"""Store, studies and figures: round trips, resuming, damaged files."""

import html
import math
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree
from dataclasses import asdict, replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from linecontact import load, studies
from linecontact.solver import Layer, RoughIndenter, Scene, solve
from linecontact.solver.layers.bonded import edge_shift
from linecontact.solver.reference import closed_forms
from linecontact.studies import hertz
from linecontact.studies.files import hdf5, records, solution_files, study_files, writing
from linecontact.studies.files.study_files import StudyFile
from linecontact.studies.paper import formulas, statements
from linecontact.studies.paper import study as paper
from linecontact.studies.power_profiles import figures as power_figures
from linecontact.studies.power_profiles import report as power_report
from linecontact.studies.rough_surfaces import figures as rough_figures
from linecontact.studies.rough_surfaces import means
from linecontact.studies.runner import drawing
from linecontact.studies.runner.study import find
from running import run_plans

ARRAYS = Path(__file__).with_name("figures.npz")
RESULTS = Path(studies.__file__).parent / "results"


@pytest.fixture(scope="module")
def solution():
    return solve(Scene(Layer(0.1, 0.25), num_points=256))


def test_solution_round_trip(solution, tmp_path):
    path = tmp_path / "run.h5"
    solution_files.save_solution(path, solution)
    fields = solution_files.load(path)
    attributes = fields.results
    np.testing.assert_array_equal(fields.x, np.arange(256) / 256)
    np.testing.assert_array_equal(fields.profile, solution.scene.profile)
    np.testing.assert_array_equal(fields.displacement, solution.displacement)
    np.testing.assert_array_equal(fields.contact_pressure, solution.contact_pressure)
    for name, value in records.flatten(solution.to_dict()).items():
        assert attributes[name] == value
    assert hdf5.file_kind(path) == "solution"
    with h5py.File(path) as file:
        assert file["contact_pressure"].attrs["unit"] == "pressure"
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


def test_the_patches_are_kept(solution, tmp_path):
    path = tmp_path / "run.h5"
    solution.save(path)
    for name, values in vars(solution.patches).items():
        np.testing.assert_array_equal(getattr(load(path).patches, name), values)
    with h5py.File(path) as file:
        assert file["patches/load"].attrs["unit"] == "pressure times length"


@pytest.mark.parametrize("left_out", ["patches", "patches/load"])
def test_a_file_without_patches(left_out, solution, tmp_path, monkeypatch):
    """As an earlier version has written it; one that lacks some of their columns is of no version."""
    whole, path = tmp_path / "whole.h5", tmp_path / "run.h5"
    solution.save(whole)
    with h5py.File(whole) as source, hdf5.new_file(path) as file:
        file.attrs.update(source.attrs)
        for name in source:
            source.copy(name, file)
        del file[left_out]
    monkeypatch.setattr(hdf5, "_written", set())  # as in another process
    if left_out == "patches":
        assert load(path).patches is None
    else:
        with pytest.raises(ValueError, match=r"run\.h5 is whole, but not as this version writes it"):
            load(path)


def test_a_failed_write_leaves_the_old_file(solution, tmp_path, monkeypatch):
    path = tmp_path / "run.h5"
    solution_files.save_solution(path, solution)
    before = path.read_bytes()
    monkeypatch.setattr(solution_files, "flatten", lambda record: {"bad": object()})
    with pytest.raises(TypeError):
        solution_files.save_solution(path, solution)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["run.h5"]


def test_targets_are_checked_before_the_work(tmp_path):
    (tmp_path / "there.h5").touch()
    with pytest.raises(writing.StoreError, match=r"there\.h5 exists"):
        writing.check_target(tmp_path / "there.h5", overwrite=False)
    writing.check_target(tmp_path / "there.h5", overwrite=True)
    for folder in (tmp_path / "there.h5", tmp_path / "there.h5" / "below"):
        with pytest.raises(writing.StoreError, match=r"there\.h5 is a file; allowed: a new or existing folder"):
            writing.make_folder(folder)
    with pytest.raises(writing.StoreError, match="does not exist"):
        writing.check_target(tmp_path / "no" / "run.h5", overwrite=False)
    with pytest.raises(writing.StoreError, match="is a folder"):
        writing.check_target(tmp_path, overwrite=True)


@pytest.mark.parametrize("content", [b"", b"not HDF5", None])
def test_damaged_files_are_named(tmp_path, solution, content):
    path = tmp_path / "run.h5"
    if content is None:
        solution_files.save_solution(path, solution)
        path.write_bytes(path.read_bytes()[:1000])
    else:
        path.write_bytes(content)
    for read in (hdf5.file_kind, study_files.load_study, solution_files.load):
        with pytest.raises(writing.StoreError, match=r"run\.h5"):
            read(path)


def test_study_round_trip(tmp_path):
    runs = [{"status": "converged", "commit": "12345678", "iterations": 3, "d": 0.5, "t": "inf", "x.ok": True}]
    runs.append({**runs[0], "commit": "1e5", "t": 0.25})
    lines = {"nu=0": {"a": np.arange(3.0)}}
    study = StudyFile("hertz", {"tolerance": 1e-8, "list": [1, 2.5]}, runs, lines)
    path = tmp_path / "study.h5"
    study_files.save_study(path, study)
    back = study_files.load_study(path)
    assert back.runs == [{**runs[0], "t": math.inf}, {**runs[1]}]
    assert back.configuration == study.configuration
    np.testing.assert_array_equal(back.lines["nu=0"]["a"], np.arange(3.0))
    assert not back.complete


@pytest.fixture(scope="module")
def paper_folder(tmp_path_factory):
    """The whole paper at 2^10 points with two surfaces, in this process."""
    folder = tmp_path_factory.mktemp("paper")
    assert run_plans(paper.STUDY, [*small_plans()], folder) == 0
    return folder


def small_plans():
    """The paper's, with few points on the lines of power profiles, which take most of the time."""
    for plan in paper.quick_plans(2**10, 2):
        yield replace(plan, lines={name: thinned(line) for name, line in plan.lines.items()})


def thinned(line):
    points = getattr(line, "reduced_thicknesses", ())
    return replace(line, reduced_thicknesses=points[::4]) if points else line


def drawn_data(folder):
    """x and y of every line of every figure of the paper, and the points of the error bars, by figure and place."""
    data = {}
    for kind, module in (*((k, power_figures) for k in ("sharp", "hertz", "blunt")), ("rough", rough_figures)):
        for suffix, figure in module.draw(folder / f"{kind}.h5").items():
            for a, axes in enumerate(figure.axes):
                for b, line in enumerate(axes.get_lines()):
                    xy = np.array([np.asarray(values, dtype=float) for values in line.get_data()])
                    if xy.size:
                        data[f"{kind}{suffix}.{a}.{b}"] = xy
    return data


def test_figures_hold_the_stored_numbers(paper_folder):
    """Data of the drawn artists, not pixels, against stored arrays; made by `python tests/test_studies.py`."""
    drawn = drawn_data(paper_folder)
    with np.load(ARRAYS) as stored:
        assert set(drawn) == set(stored.files)
        for name in stored.files:
            errors = ("accuracy" in name) * 2e-4  # differences from collocation: what the tolerance leaves of them
            np.testing.assert_allclose(drawn[name], stored[name], rtol=1e-5, atol=errors, err_msg=name)
    study = study_files.load_study(paper_folder / "hertz.h5")
    run = study.select("scene.poisson_ratio", 0.25).runs[0]
    points = drawn["hertz.0.4"]  # markers and collocation, then two limits and the published one, for each nu
    t = run["scene.thickness"] / run["contact_area_subgrid"]
    y = run["kappa_subgrid"] / closed_forms.kappa_half_space(2.0) / t
    assert any(np.allclose(xy[:, 0], (t, y)) for xy in drawn.values() if xy.shape == points.shape or xy.shape[1] == 6)


def test_figures_come_from_the_file_alone(paper_folder, tmp_path):
    """Of each kind; one is written anew, and the study itself has written all of them."""
    for plan in paper.quick_plans(2**10):
        file = tmp_path / f"{plan.kind}.h5"
        file.write_bytes((paper_folder / file.name).read_bytes())
        names = {f"{plan.kind}{s}.{end}" for s in plan.figures for end in ("png", "pdf")}
        assert names == {p.name for p in paper_folder.glob(f"{plan.kind}*.p*")}
        assert all((paper_folder / name).stat().st_size > 5000 for name in names)
        if plan.kind == "hertz":
            drawn = drawing.draw(file)
            assert {p.name for p in drawn} == names
            assert all(p.stat().st_size > 5000 for p in drawn)
        else:
            assert set(find(plan.kind).draw(file)) == set(plan.figures)


def test_what_is_not_ours_is_left_alone(tmp_path, solution):
    """Another program's file, another kind of linecontact's, and what was set aside before."""
    path = tmp_path / "hertz.h5"
    path.write_bytes(b"somebody's data " * 100)
    with pytest.raises(writing.StoreError, match="not one of linecontact's"):
        study_files.finished(path, "hertz", {})
    solution_files.save_solution(path, solution)
    with pytest.raises(writing.StoreError, match="holds another study"):
        study_files.finished(path, "hertz", {})
    for content in (b"", path.read_bytes()[:700]):
        path.write_bytes(content)
        assert study_files.finished(path, "hertz", {}) is None
    assert {p.name: p.stat().st_size for p in tmp_path.iterdir()} == {"hertz.h5.damaged": 0, "hertz.h5.damaged.2": 700}


def test_means_over_realisations(paper_folder):
    """Recomputed by hand for one point."""
    file = study_files.load_study(paper_folder / "rough.h5")
    point = next(p for p in means.points(file) if (p.hurst, p.poisson_ratio, p.thickness) == (0.8, 0.25, 1e-3))
    runs = [r for r in file.runs if r["scene.hurst"] == 0.8 and r["scene.poisson_ratio"] == 0.25]
    runs = [r for r in runs if r["scene.thickness"] == 1e-3]
    thick = [r for r in file.runs if r["scene.hurst"] == 0.8 and math.isinf(r["scene.thickness"])]
    assert [r["scene.seed"] for r in runs] == [r["scene.seed"] for r in thick] == [0, 1]
    ratios = [r["kappa_subgrid"] / t["kappa_subgrid"] for r, t in zip(runs, thick, strict=True)]
    assert point.kappa_ratio.value == pytest.approx(np.mean(ratios))
    assert point.kappa_ratio.error == pytest.approx(abs(ratios[0] - ratios[1]) / 2)
    slopes = [k * r["contact_area_subgrid"] / 1e-3 for k, r in zip(ratios, runs, strict=True)]
    assert point.slope.value == pytest.approx(np.mean(slopes))
    assert point.patches.value == np.mean([r["num_patches"] for r in runs])


def test_persson_s_limits():
    """Half-space, small load: kappa = sqrt(8/pi); full contact at high load."""
    surface = RoughIndenter(0.8, 0, cut_off_ratio=0.25)
    k = np.pi * np.arange(2**9 + 1)
    height = surface.profile(2**10, 1.0)
    rms = closed_forms.full_contact_rms_pressure(k, height)
    assert closed_forms.persson_area(1e-4, rms) / 1e-4 == pytest.approx(math.sqrt(8 / math.pi), rel=1e-3)
    assert closed_forms.persson_area(10.0, rms) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("values", "verdict"),
    [
        ((1.0, 1.01, 0.01), "holds"),
        ((2.2, 2.204, 0.0, 0.005), "holds"),
        ((1.0, 1.03, 0.01), "holds within 3 %"),
        ((1.0, 0.9, 0.01), "does not hold, off by 10 %"),
        ((1.0, math.nan, 0.01), "not measured"),
    ],
)
def test_verdicts(values, verdict):
    assert statements.judge(*values) == verdict


def test_report(paper_folder):
    files = {kind: study_files.load_study(paper_folder / f"{kind}.h5") for kind in ("sharp", "hertz", "blunt", "rough")}
    found = statements.statements(files)
    text, page = ((paper_folder / name).read_text() for name in ("report.md", "report.html"))
    assert len(found) >= 20
    plain = html.unescape(re.sub(r'<math [^>]*alttext="([^"]*)">.*?</math>', r"\1", page)).replace("\u00b1", "+-")
    for s in found:
        assert s.text in text
        assert s.measured in text
        assert s.text in plain
        assert s.measured in plain
    blunt = next(s for s in found if s.text.startswith("blunt: kappa_d = kappa_inf"))
    assert "0.902" in blunt.measured
    assert blunt.verdict.startswith("does not hold")
    assert page.count("data:image/png;base64,") == text.count("![") == 9
    assert "http" not in re.sub(r"http-equiv|base64,[^\"']*", "", page)  # nothing from elsewhere
    assert "kappa_inf" not in re.sub(r'alttext="[^"]*"', "", page)
    assert statements.statements({}) == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("y = (kappa_d/kappa_inf)/(d/a_r) at the least", ["y = (kappa_d/kappa_inf)/(d/a_r)"]),
        ("H = 0.3: alpha (1-2nu)/(1-nu)^2 d/a_r on", ["H = 0.3", "alpha (1-2nu)/(1-nu)^2 d/a_r"]),
        ("2.3562 +- 6e-05 (median over nu)", ["2.3562 +- 6e-05", "nu"]),
        ("of 2 sqrt(3)/kappa_inf = 2.036. Over", ["2 sqrt(3)/kappa_inf = 2.036"]),
        ("(n = 2), 2^18 points, p = 0.002 E*, so", ["(n = 2)", "2^18", "p = 0.002 E*"]),
        ("-7e-03", ["-7e-03"]),
        ("d = 1e-07 L, nu = -: 5 % of 32, 4/2022, commit cd09ad47498d, e2c8, a", ["d = 1e-07 L", "nu"]),
        ("((((nu", ["nu"]),
        ("a model, 3 of 4 <b>", []),
    ],
)
def test_formulas_are_found(text, found):
    shown = formulas.typeset(text)
    assert [html.unescape(plain) for plain in re.findall(r'alttext="([^"]*)"', shown)] == found
    assert "<b>" not in shown
    xml.etree.ElementTree.fromstring(f"<p>{shown}</p>")  # all elements are closed


def test_formulas_are_read_as_they_are_meant():
    def shape(text):
        return re.sub(r"</?m(row|i|n|o)>", "", formulas.typeset(text).partition("<mrow>")[2].rpartition("</mrow>")[0])

    assert shape("(1-2nu)/(1-nu)^2") == "<mfrac>1\u22122\u03bd<msup>(1\u2212\u03bd)2</msup></mfrac>"
    assert shape("3 pi/4") == "<mfrac>3\u03c04</mfrac>"
    assert shape("d/a_r L") == "<mfrac>d<msub>ar</msub></mfrac>L"
    assert shape("d/(a_r L)") == "<mfrac>d<msub>ar</msub>L</mfrac>"
    assert shape("3e-05 +- 1e-7") == "3\u00d7<msup>10\u22125</msup>\u00b1<msup>10\u22127</msup>"


BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


@pytest.mark.skipif(BROWSER is None, reason="no browser here")
def test_report_in_a_browser(paper_folder, tmp_path):
    arguments = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={tmp_path}",
        "--virtual-time-budget=9999",
    ]
    count = "[...document.images].filter(i => i.complete && i.naturalWidth > 100).length"
    # on a page as narrow as a phone nothing is wider than it, long rows are restacked, formulas have their size
    phone = "const page = phone.contentDocument; "
    wide = "page.documentElement.scrollWidth - page.documentElement.clientWidth"
    stacked = "getComputedStyle(page.querySelector('table.long td')).display"
    formulas = "[...page.querySelectorAll('mfrac')].filter(f => f.getBoundingClientRect().height > 15).length > 30"
    look = f"{phone} document.title = [{count}, {wide}, {stacked}, {formulas}].join(' ')"
    inner = html.escape((paper_folder / "report.html").read_text())
    frame = (
        f"<iframe id='phone' style='width:360px;height:640px;border:0' onload=\"{look}\" srcdoc=\"{inner}\"></iframe>"
    )
    page = tmp_path / "page.html"
    page.write_text((paper_folder / "report.html").read_text().replace("</body>", f"{frame}</body>"))
    shown = subprocess.run(
        [BROWSER, *arguments, "--dump-dom", page.as_uri()], capture_output=True, text=True, timeout=120
    )
    assert "<title>9 0 block true</title>" in shown.stdout, re.findall("<title>.*?</title>", shown.stdout)
    assert shown.stdout.count("<table") == 5


def test_the_studies_that_were_asked_for_run_as_scripts(tmp_path):
    """From their files, started together; they get as far as looking at their options."""
    scripts = [Path(studies.__file__).with_name(f"{name}.py") for name in ("hertz", "sharp", "blunt", "rough")]
    options = {"stderr": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "cwd": tmp_path}
    started = [subprocess.Popen([sys.executable, script, "--workers", "0"], **options) for script in scripts]
    for process in started:
        _, said = process.communicate(timeout=120)
        assert (process.returncode, said.count("\n")) == (2, 1)
        assert said.startswith("linecontact: workers is 0; allowed: ")


def test_full_study_covers_the_published_range():
    full = hertz.CONFIGURATION
    assert full.num_points == 2**18
    assert min(full.reduced_thicknesses) < 0.01
    assert max(full.reduced_thicknesses) > 3
    assert len(full.reduced_thicknesses) >= 12
    assert set(full.poisson_ratios) == {0.0, 0.25, 0.4, 0.45, 0.49, 0.5}


def test_stored_reference_meets_the_goals():
    """The study's figures in the README are drawn from this file: 2^18 points, every (d, nu)."""
    study = power_report.layers(study_files.load_study(RESULTS / "hertz.h5"))
    full = hertz.CONFIGURATION
    assert study_files.finished(RESULTS / "hertz.h5", "hertz", asdict(full))
    assert len(study.runs) == len(full.poisson_ratios) * len(full.reduced_thicknesses) >= 72
    assert (study.column("status") == "converged").all()
    assert (study.column("certificate.equilibrium_residual") <= 1e-8).all()
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
        second = closed_forms.thin_layer_kappa_ratio(2.0, nu, t, edge_shift(nu))
        first = closed_forms.thin_layer_kappa_ratio(2.0, nu, t)
        counting = 3 / 2**18 / thin["oracle.contact_area"]
        assert abs(thin["kappa_ratio"] / second - 1) < 0.02 * abs(first / second - 1) + counting


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        where = Path(name)
        run_plans(paper.STUDY, [*small_plans()], where)
        np.savez_compressed(ARRAYS, **drawn_data(where))
