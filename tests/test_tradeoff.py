"""The study of speed against accuracy: fronts, a tiny study, the stored one's cheap points again; no time is judged."""

import math
from pathlib import Path

import numpy as np
import pytest
from linecontact import studies
from linecontact.solver import solve
from linecontact.studies.files import records, study_files
from linecontact.studies.files.study_files import StudyFile
from linecontact.studies.tradeoff import choices, families, front, measuring, report
from linecontact.studies.tradeoff import study as tradeoff
from linecontact.studies.tradeoff.ensembles import ALONE, ENSEMBLES, MANY
from running import run_plans

pytestmark = pytest.mark.once

STORED = Path(studies.__file__).parent / "results" / "tradeoff.h5"
HERTZ, ROUGH = "Hertz, half-space", "rough, half-space"


def run(method, seconds, error, **more):
    """A made-up run; its counted area is ten times worse."""
    errors = {"area": error, "area_counted": 10 * error, "kappa": error, "peak": error, "field": error}
    made = {"kind": "choice", "family": HERTZ, "status": "converged", "method": method, "precision": "float64"}
    made |= {"tolerance": 1e-5, "tolerance.asked": "1e-05", "nested": True, "threads": 1, "log2_points": 10}
    return made | {"seconds.total": seconds} | {f"error.{k}": v for k, v in errors.items()} | more


def made_up(*runs):
    return StudyFile("tradeoff", {"paper": 10, "peers": []}, list(runs))


def test_dominated_points_are_out():
    places = [(1.0, 1e-2), (2.0, 1e-3), (2.5, 0.95e-3), (3.0, 1e-3), (3.0, 1e-5), (1.0, 2e-2), (4.0, 1e-4)]
    points = [front.Point(*place, False, {}) for place in places]
    best = front.front(points)
    assert [(p.seconds, p.error) for p in best] == [(1.0, 1e-2), (2.0, 1e-3), (3.0, 1e-5)]  # 5 % better is the same
    assert front.over_front(points[3], best) == 1.5
    assert front.over_front(points[6], best) == pytest.approx(4 / 3)
    assert front.over_front(points[5], best) == 1
    assert math.isnan(front.over_front(front.Point(1.0, 1e-9, False, {}), best))
    assert front.front([]) == []


def test_sentences_come_from_the_data():
    def never(*runs):
        return next(report.never_worth(front.worth(made_up(*runs))))

    slow = never(run("fire", 10.0, 1e-3), run("active-set", 1.0, 1e-3))
    assert slow.startswith("Never worth it")
    assert "plain FIRE (off by 10:" in slow
    assert "active set" not in slow
    fast = never(run("fire", 1.0, 1e-3), run("active-set", 2.0, 1e-3))
    assert "plain FIRE" not in fast
    assert "active set (off by 2:" in fast
    assert "counting nodes (off by 10:" in fast
    both = never(run("fire", 1.0, 1e-2), run("active-set", 2.0, 1e-3, precision="mixed"))
    assert "FIRE" not in both
    assert "active set" not in both
    without = list(report.never_worth(front.worth(made_up(run("fire", 1.0, 1e-2), run("active-set", 5.0, 1e-3)))))
    assert any(line.startswith("plain FIRE") and "Without: up to 5 times as long" in line for line in without)
    assert any(line.startswith("active set") and "some errors are out of reach" in line for line in without)
    lucky = never(run("fire", 1.0, 1e-2, **{"error.area_counted": 1e-3}))
    assert lucky.startswith("Nothing is never worth it") or "counting" not in lucky


def test_published_choice_in_words():
    paper = run("fire", 30.0, 2e-6, nested=False)
    quick = run("collocation", 0.01, 1e-12, kind="accuracy", accuracy=1e-6) | {"seconds.pair": 0.002}
    lines = list(report.published(made_up(paper, run("active-set", 0.1, 1e-5), quick)))
    assert "off by 2.0e-05 after 30 s; --accuracy gets there in 0.01 s, 3000 times faster" in lines[0]
    assert "by hand gets there in 0.1 s, 300 times faster" in lines[0]
    assert "takes 0.01 s, 5 transform pairs" in lines[1]


def test_misses_are_listed():
    scene = {f"scene.{k}": 1.0 for k in ("exponent", "thickness", "poisson_ratio", "pressure", "num_points")}
    common = {"kind": "scene", "family": "power", "accuracy": 1e-3, "claimed": 2e-3} | scene
    common |= {"error.reference": 0.0, "seconds.decide": 1e-4, "method": "active-set"}
    runs = [{**common, "seed": k, "status": "converged", "error.area": e} for k, e in enumerate((1e-4, 5e-3, 1e-3))]
    runs.append({**common, "seed": 3, "status": measuring.REFUSED, "reason": "because"})
    first, *misses, last = report.random_scenes(made_up(*runs))
    assert "4 random scenes" in first
    assert "2 meet the accuracy" in first
    assert "estimated error holds in 2" in first
    assert [line.split(" (")[0] for line in misses] == ["  missed: power 1", "  missed: power 3"]
    assert "because" in misses[1]
    assert "100 us (median" in last


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """The study at 2^8 points, which the rough surface does not fit on."""
    folder = tmp_path_factory.mktemp("tradeoff")
    small = tradeoff.Configuration((8,), 8, 13, (-2.0, -6.0), -4.0, (8, 32), 1, (10, 10), (1 / 8, 12, 0.08), ())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tradeoff, "TOLERANCES", (1e-5, 1e-10))
        plan = small.plan()
    assert run_plans(tradeoff.STUDY, [plan], folder) == 0
    return folder


def test_a_tiny_study_is_drawn(tiny):
    study = study_files.load_study(tiny / "tradeoff.h5")
    assert study.complete
    assert not study.failures
    names = [tiny / f"tradeoff{s}.{end}" for s in ("", "-field", "-ensembles") for end in ("png", "pdf")]
    assert all(path.stat().st_size > 5000 for path in names)
    assert {run["kind"] for run in study.runs} == {"choice", "accuracy", "oracle", "precisions", "scene", MANY, ALONE}
    assert all(records.unit(name) == "1" for name in study.runs[0] if name.startswith("error."))
    for point in front.points(front.runs_of(study, "choice", HERTZ), "a_r"):
        assert point.error < (2 / 256 / 0.1 if point.counted else 0.02)
        assert point.seconds > 0
    for accurate in front.runs_of(study, "accuracy"):
        assert accurate["error.area"] < accurate["accuracy"]
    words = [part for part in report.parts(study) if isinstance(part, str)]
    assert any("random scenes" in text for text in words)
    for family in ENSEMBLES:
        *_, last = front.runs_of(study, MANY, family)
        assert last["standard_error"] <= 0.08 * last["mean"]
        assert any(f"surfaces, {family}: {last['mean']:.4f}" in text for text in words)
        assert len(front.runs_of(study, ALONE, family)) >= 3
    for run in front.runs_of(study, "scene"):
        assert run["claimed.former"] > 0


def test_refused_tolerances_are_recorded(tiny):
    study = study_files.load_study(tiny / "tradeoff.h5")
    refused = [run for run in front.runs_of(study, "choice") if run["status"] == measuring.REFUSED]
    assert refused
    assert {run["precision"] for run in refused} == {"float32"}
    assert all(run["reason"].startswith("tolerance is") for run in refused)
    assert not any(point.run["status"] == measuring.REFUSED for point in front.points(refused, "a_r"))


def test_a_rough_choice():
    """Its errors are those of the first three surfaces against their references, by hand."""
    found = choices.Choice(ROUGH, "active-set", "float64", 1e-5, 12, 1, True, 14).run(None)
    errors = []
    for variant in range(found["repeats"]):
        area, truth = (
            solve(families.make_scene(ROUGH, k, variant=variant), tolerance=t).observables.contact_area_subgrid
            for k, t in ((12, 1e-5), (14, 1e-8))
        )
        errors.append(area / truth - 1)
    assert len(errors) == 3
    assert found["error.area"] == pytest.approx(np.sqrt(np.mean(np.square(errors))))


@pytest.mark.skipif(not STORED.exists(), reason="no stored study")
@pytest.mark.parametrize("family", families.FAMILIES)
def test_the_stored_front_again(family):
    """Within twice what the unfinished iteration may leave in the area, 0.25 of the residual; rough
    areas within their estimated error, which other ends of narrow patches may have changed since.
    """
    study = study_files.load_study(STORED)
    best = front.front(front.points(front.runs_of(study, "choice", family), "a_r"))
    cheap = [point.run for point in best if point.run["log2_points"] <= 14]
    assert cheap
    for stored in cheap:
        tolerance, rounding = stored["tolerance"], 1e-12
        keywords = {"method": stored["method"], "nested": bool(stored["nested"]), "tolerance": tolerance}
        solutions = [
            solve(families.make_scene(family, int(stored["log2_points"]), stored["precision"], v), **keywords)
            for v in range(1 if families.is_rough(family) else int(stored["repeats"]))
        ]
        again, allowed = solutions[0].observables, 0.5 * tolerance + rounding
        ends = again.contact_area_error / again.contact_area_subgrid if families.is_rough(family) else 0.0
        assert abs(again.contact_area_subgrid / stored["contact_area_subgrid"] - 1) <= max(allowed, ends)
        assert abs(again.contact_area - stored["contact_area"]) * 2 ** stored["log2_points"] < 1.5  # one node
        if not families.is_rough(family):
            exact = [families.exact(family, v, 0).contact_area for v in range(len(solutions))]
            errors = [s.observables.contact_area_subgrid / e - 1 for s, e in zip(solutions, exact, strict=True)]
            assert abs(np.sqrt(np.mean(np.square(errors))) - stored["error.area"]) <= allowed
