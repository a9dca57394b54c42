"""The map of extremes and the soak: a sample of cells, the judge of their answers, both studies with their figures."""

import math
from dataclasses import replace

import numpy as np
import pytest
from linecontact.solver import Reason, Scene, Status, solve
from linecontact.solver.endings import Cause
from linecontact.studies.extremes import cells, soak, verdicts
from linecontact.studies.extremes import study as extremes
from linecontact.studies.files import study_files
from linecontact.studies.files.study_files import StudyFile
from linecontact.studies.runner import drawing
from running import run_plans

pytestmark = pytest.mark.once


@pytest.fixture(scope="module")
def sample():
    """Records of some cells of the map."""
    return [task.run(None) for task in replace(extremes.QUICK, small=196, middle=4).plan().runs]


def test_a_sample_of_the_map(sample):
    assert len(sample) == 200
    assert not extremes.defects(StudyFile("extremes", {}, sample))
    plain = [run for run in sample if not run["asked"]]
    solved = sum(run["verdict"] == verdicts.CERTIFIED for run in plain)
    assert solved >= 0.97 * len(plain) > 130
    for run in sample:
        assert run["verdict"] == verdicts.CERTIFIED or " is " in run["why"]
        assert run["verdict"] == verdicts.CERTIFIED or "; allowed: " in run["why"]
    assert sum("off.subgrid" in run for run in sample) > 20  # known from elsewhere


def test_the_sample_covers_the_map(sample):
    points = {run["scene.num_points"] for run in sample}
    assert min(points) < 8
    assert max(points) > 2**16
    assert len({run["shape"] for run in sample}) == 12
    assert {run["precision"] for run in sample} == {"float64", "float32", "mixed"}
    assert {run["method"] for run in sample} == {"active-set", "mass-weighted-fire", "fire", "to an accuracy"}
    thickness = np.array([run["scene.thickness"] for run in sample])
    assert thickness.min() < 1e-11
    assert thickness[np.isfinite(thickness)].max() > 1e11
    assert np.isinf(thickness).any()
    place = {(math.floor(math.log10(t)) if math.isfinite(t) else 99) for t in thickness}
    assert len(place) == cells.COLUMNS


def falsified(solution):
    """Wrong answers given as converged, and what is wrong with them."""
    o, n = solution.observables, solution.scene.num_points
    lower = solution.displacement - 1e-3 * np.ptp(solution.displacement)
    moved = np.roll(solution.contact_pressure, 1)
    yield replace(solution, observables=replace(o, approach=math.nan)), "approach is nan"
    yield replace(solution, observables=replace(o, peak_pressure=math.inf)), "peak_pressure is inf"
    yield replace(solution, observables=replace(o, contact_area=1.5)), "a_r is 1.5"
    yield replace(solution, observables=replace(o, peak_pressure=0.5 * o.peak_pressure)), "not those of the fields"
    yield (
        replace(solution, observables=replace(o, contact_area_subgrid=o.contact_area + 9 / n)),
        "sub-grid edges are off",
    )
    yield replace(solution, observables=replace(o, contact_area_error=1e-12)), "estimated error 1e-12"
    yield replace(solution, contact_pressure=7 * solution.contact_pressure), "the load is off by 6"
    yield replace(solution, contact_pressure=moved, contact=moved > 0), "equilibrium residual"
    yield replace(solution, displacement=lower), "equilibrium residual"
    yield replace(solution, displacement=solution.displacement + 1.0), "above the wall"
    yield replace(solution, contact=~solution.contact), "off the contact"


def test_the_judge_finds_defects(monkeypatch):
    """A wrong answer given as converged, a traceback, and a reason that names nothing."""
    scene = Scene(pressure=2e-3, num_points=364)
    cell = cells.Cell(scene, "power", 1.0, 1.0, 1.0, {"method": "active-set"}, None)
    assert extremes.judge(cell)["verdict"] == verdicts.CERTIFIED
    for wrong, why in falsified(solve(scene)):
        monkeypatch.setattr(verdicts, "solve", lambda *_, wrong=wrong, **__: wrong)
        found = extremes.judge(cell)
        assert found["verdict"] == verdicts.DEFECT
        assert why in found["why"]

    def ends(outcome):
        def solve(*_, **__):
            if isinstance(outcome, Exception):
                raise outcome
            return outcome

        monkeypatch.setattr(verdicts, "solve", solve)
        return extremes.judge(cell)["verdict"]

    good = solve(scene)
    assert ends(ZeroDivisionError("by zero")) == ends(ValueError("bad")) == verdicts.DEFECT
    assert ends(ValueError("pressure is 0; allowed: > 0")) == verdicts.REFUSED
    reason = Reason(Cause.METHOD, "method", "fire, which does not settle here", "another")
    assert ends(replace(good, status=Status.STAGNATED, reason=reason)) == verdicts.REFUSED
    assert ends(replace(good, status=Status.STAGNATED)) == verdicts.DEFECT
    with pytest.raises(KeyboardInterrupt):
        ends(replace(good, status=Status.INTERRUPTED))
    monkeypatch.undo()
    units = iter([good, solve(scene, max_iterations=3)])
    monkeypatch.setattr(verdicts, "solve", lambda *_, **__: next(units))
    assert "in other units" in extremes.judge(cell)["why"]


def test_study_and_figure(tmp_path):
    plan = extremes.Configuration(6, 0, 0).plan()
    assert run_plans(extremes.STUDY, [plan], tmp_path) == 0
    assert run_plans(replace(extremes.STUDY, defects=lambda file: ["one"]), [plan], tmp_path) == 4
    assert [path.name for path in drawing.draw(tmp_path / "extremes.h5")] == ["extremes.png", "extremes.pdf"]


def test_soak(tmp_path):
    assert run_plans(soak.STUDY, [soak.Configuration(2, 0.3).plan()], tmp_path) == 0
    file = study_files.load_study(tmp_path / "soak.h5")
    assert all(run["certified"] > 0 == run["defect"] and run["open_files"] > 2 for run in file.runs)
    assert "0 defects" in soak.summary(file)
    with pytest.raises(ValueError, match="hours is 0"):
        soak.command(soak.Options(hours=0.0, folder=tmp_path))
