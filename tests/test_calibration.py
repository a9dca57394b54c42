"""The study that fits the numbers in estimated errors, and the file that it writes."""

import json
import math
from dataclasses import asdict, replace

import numpy as np
import pytest
from linecontact.solver import QUANTITIES, Layer, PowerIndenter, Scene, Status, solve
from linecontact.solver.calibration import FILE, FITTED, Calibration
from linecontact.studies.calibration import fit, scenes, study

pytestmark = pytest.mark.once


def test_the_file_has_all_fitted_numbers_and_what_they_hold():
    stored = json.loads(FILE.read_text(encoding="utf-8"))
    assert Calibration(**stored["numbers"]) == FITTED
    assert len(stored["numbers"]) <= 20
    assert list(stored["held"]) == list(scenes.FAMILIES)
    told = [stored["held"][family][name].split() for family in scenes.FAMILIES for name in QUANTITIES]
    assert np.mean([int(kept) / int(of.rstrip(",")) for kept, _, of, *_ in told]) > 0.97


@pytest.mark.parametrize("family", scenes.FAMILIES)
def test_a_scene_and_its_reference(family):
    scene, reference = scenes.draw(family, 3)
    assert scene == scenes.draw(family, 3)[0]
    assert (scene.layer, scene.pressure) == (reference.layer, reference.pressure)
    assert reference.num_points == scene.num_points * (1 if family == scenes.UNFINISHED else 16)
    record = study.Task(family, 3).run(None)
    assert record["status"] == str(Status.CONVERGED)
    assert all(math.isfinite(record[name]) for name in QUANTITIES)


def test_estimates_too_small_are_made_larger_and_others_smaller(monkeypatch):
    """The half-space and a thin layer; the numbers in use are the same afterwards."""
    known = []
    for load in (1e-3, 2e-3, 3e-3):
        scene = Scene(Layer(0.05, 0.3), PowerIndenter(), load, num_points=2**12)
        true = fit.values(solve(scene.on_grid(2**15), tolerance=1e-10).observables)
        known.append(fit.Known("power", solve(scene), true, False))
    before = asdict(FITTED)
    monkeypatch.setattr(fit, "_FACTOR", 4.0)
    numbers = fit.fitted(known)
    assert asdict(FITTED) == before
    wide = {**before, "of_nodes_in_peak": 100 * before["of_nodes_in_peak"]}
    (good, poor) = (fit.held(known, one)["power"]["peak-pressure"] for one in (numbers, wide))
    assert good.startswith("3 of 3, median ")
    assert poor.startswith("3 of 3, median ")
    assert float(good.split()[-1]) < float(poor.split()[-1]) / 20
    assert replace(FITTED) == FITTED
