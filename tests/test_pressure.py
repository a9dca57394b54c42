"""The study of the area over the load, on small grids: what it stores, reads off, says and draws."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest
from linecontact.solver import Layer, RoughIndenter, Scene, solve
from linecontact.solver.grid.problem import Problem
from linecontact.solver.reference import closed_forms
from linecontact.studies.figures.style import NothingToDraw
from linecontact.studies.files.study_files import StudyFile, load_study, save_study
from linecontact.studies.pressure import analysis, figures, findings
from linecontact.studies.pressure.study import STUDY
from linecontact.studies.pressure.tasks import FIGURES, QUICK, line_name, plan
from linecontact.studies.rough_surfaces.means import Mean
from rich.console import Console
from running import run_plans

pytestmark = pytest.mark.once

SMALL = replace(
    QUICK,
    num_points=2**10,
    cut_off_ratio=0.5,
    hursts=(0.5, 0.8),
    pressures=(3e-3, 1e-2, 0.1, 1.0),
    realisations=(3, 3, 2, 1),
    half_space_areas=(0.05, 0.1, 0.3, 0.9),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pressure")
    assert run_plans(STUDY, [plan(SMALL)], folder) == 0
    return folder


@pytest.fixture(scope="module")
def file(folder):
    return load_study(folder / "pressure.h5")


def curve(file, rough, shape, thickness):
    return next(c for c in analysis.curves(file) if (c.rough, c.shape, c.thickness) == (rough, shape, thickness))


def test_every_layer_has_a_curve(file):
    every = analysis.curves(file)
    assert len(every) == (3 + 2) * (1 + 3)
    assert [c.rough for c in every] == [False] * 12 + [True] * 8
    assert all(c.is_half_space == (i % 4 == 0) for i, c in enumerate(every))
    assert all(len(c.points) == 4 for c in every)


def test_power_profiles_on_the_half_space(file):
    """The load makes the area that it was chosen for, and kappa is the closed form's."""
    for n in SMALL.exponents:
        points = curve(file, False, n, math.inf).points
        for point, area in zip(points, SMALL.half_space_areas, strict=True):
            assert point.area.value == pytest.approx(area, abs=max(2 * point.area.error, 1e-7))
            assert point.kappa.value == pytest.approx(point.exact_kappa, abs=max(2 * point.kappa.error, 1e-6))
        assert points[0].ratio.value == pytest.approx(1, abs=0.01)
        assert [p.pressure for p in curve(file, False, n, 0.1).points] == [p.pressure for p in points]


def test_means_over_the_surfaces(file):
    """Recomputed from solves of their own for one point."""
    point = curve(file, True, 0.8, 1e-2).points[1]
    areas, kappas, ratios = [], [], []
    for seed in range(3):
        indenter = RoughIndenter(0.8, seed, cut_off_ratio=0.5)
        own, thick = (solve(Scene(layer, indenter, 1e-2, num_points=2**10)) for layer in (Layer(1e-2, 0.25), Layer()))
        areas.append(own.observables.contact_area_subgrid)
        kappas.append(own.observables.kappa_subgrid)
        ratios.append(own.observables.kappa_subgrid / thick.observables.kappa_subgrid)
    for mean, values in ((point.area, areas), (point.kappa, kappas), (point.ratio, ratios)):
        assert mean.value == pytest.approx(np.mean(values), rel=1e-9)
        assert mean.error == pytest.approx(np.std(values, ddof=1) / math.sqrt(3), rel=1e-6)
    assert point.kappa_surface.value == pytest.approx(np.mean(areas) / 1e-2, rel=1e-9)
    assert point.reduced_thickness.value == pytest.approx(np.mean(1e-2 / np.array(areas)), rel=1e-9)


def test_persson_s_theory_beside_them(file):
    scene = Scene(Layer(1e-2, 0.25), RoughIndenter(0.5, 0, cut_off_ratio=0.5), 0.1, num_points=2**10)
    problem = Problem.from_scene(scene)
    rms = closed_forms.full_contact_rms_pressure(
        problem.stiffness * problem.layer.unit, problem.height * problem.length_unit
    )
    line = file.lines[line_name(0.5, 0.25, 1e-2)]
    np.testing.assert_allclose(line["contact_area"], [closed_forms.persson_area(p, rms) for p in line["pressure"]])
    assert curve(file, True, 0.5, 1e-2).points[2].persson == pytest.approx(
        closed_forms.persson_area(0.1, rms), rel=1e-3
    )


def made_up(ratios, kappas=None):
    """A curve with these values, each at a tenfold load and a tenth of d/a_r."""
    none = Mean(math.nan, math.nan)
    points = [
        analysis.Point(10.0**i, Mean(0.1, 0.01), Mean(k, 0.01), Mean(r, 0.01), Mean(10.0**-i, 0), none, none, 0, 0)
        for i, (r, k) in enumerate(zip(ratios, kappas or ratios, strict=True))
    ]
    return analysis.Curve(True, 0.8, 0.25, 0.01, points)


def test_where_kappa_is_constant():
    found = made_up([1] * 6, [1.5, 1.6, 1.65, 1.68, 1.7, 1.2]).constant
    assert [point.pressure for point in found] == [1e2, 1e3, 1e4] or [p.pressure for p in found] == [1e1, 1e2, 1e3]
    assert made_up([1, 1], [0.0, 0.0]).constant == []
    assert len(made_up([1] * 3, [1, 2, 4]).constant) == 1


def test_where_the_layer_bends_kappa():
    """Half-way in the logarithm between two loads, where the ratio falls from above to as much below."""
    thick = 1 / 1.05
    assert analysis.bending_thickness(made_up([1, thick + 0.02, thick - 0.02])) == pytest.approx(10**-1.5)
    assert math.isnan(analysis.bending_thickness(made_up([1, 0.99, 0.98])))


def test_exponential_heights():
    """<a^m> with a the root of an exponentially distributed penetration."""
    penetration = np.random.default_rng(0).exponential(size=10**6)
    first, second, third = (float(np.mean(penetration ** (m / 2))) for m in (1, 2, 3))
    kappa = closed_forms.kappa_half_space(2) * math.sqrt(first * third) / second
    assert kappa == pytest.approx(math.sqrt(8 / math.pi), rel=5e-3)


def test_the_findings(file):
    found = findings.findings(file)
    assert len({s.text for s in found}) == len(found)
    hertz = next(s for s in found if s.text.startswith("n = 2, half-space"))
    # Hertz: kappa/kappa_inf = 1/1.05 near a_r = 0.34, by the periodic closed form
    load = closed_forms.periodic_line_load(0.17, lambda x: x)
    kappa = closed_forms.kappa_from_area(2, 0.34, 1, load) / closed_forms.kappa_half_space(2)
    assert kappa == pytest.approx(1 / 1.05, rel=3e-3)
    assert "up to a_r = 0.34" in hertz.measured
    bent = next(s for s in found if s.text.startswith("power profiles, nu = 0.25"))
    assert bent.verdict == "new"
    assert 1.5 < float(bent.measured.split()[2]) < 3
    thin = next(s for s in found if s.text.startswith("n = 2: kappa of thin layers"))
    assert thin.verdict.startswith("holds")
    full = next(s for s in found if s.text.startswith("H = 0.8, half-space, Persson's theory near"))
    point = curve(file, True, 0.8, math.inf).points[-1]
    assert full.published == f"{1 - point.persson:.4f}"


def test_the_report_names_every_layer(file, folder):
    output = io.StringIO()
    for part in STUDY.report({"pressure": file}, folder):
        Console(width=100, file=output).print(part)
    said = output.getvalue()
    assert said.count("half-space  ") >= 5
    assert "What holds" in said
    assert "rough surface, H = 0.8" in said


def test_the_figures_hold_the_stored_numbers(file, folder):
    drawn = figures.draw(folder / "pressure.h5")
    assert tuple(drawn) == tuple(FIGURES)
    points = curve(file, True, 0.5, math.inf).points
    line = drawn[""].axes[0].get_lines()[0]
    np.testing.assert_allclose(line.get_xydata(), [(p.pressure, p.kappa.value) for p in points])
    below = drawn["-collapse"].axes[2].get_lines()[0]
    own = curve(file, True, 0.5, 0.1).points
    np.testing.assert_allclose(below.get_xydata(), [(p.per_width.value, p.ratio.value) for p in own])


@pytest.mark.parametrize("share", [0.02, 0.4, 0.9])
def test_a_part_of_the_runs(file, share, tmp_path):
    """What is not done yet is left out."""
    runs = [run for i, run in enumerate(file.runs) if np.random.default_rng(i).random() < share]
    part = StudyFile(file.kind, file.configuration, runs, file.lines if share > 0.5 else {})
    for table in STUDY.report({"pressure": part}, tmp_path):
        Console(width=100, file=io.StringIO()).print(table)
    save_study(tmp_path / "part.h5", part)
    assert figures.draw(tmp_path / "part.h5")
    smooth = StudyFile(file.kind, file.configuration, [run for run in runs if run["scene.profile"] == "power"])
    save_study(tmp_path / "smooth.h5", smooth)
    with pytest.raises(NothingToDraw):
        figures.draw(tmp_path / "smooth.h5")
