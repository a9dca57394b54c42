"""Means over random surfaces that are solved: their grids, against plain sampling, and bad arguments."""

import math
from dataclasses import replace

import numpy as np
import pytest
from linecontact import ensemble_mean
from linecontact.solver import Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene, solve
from linecontact.studies.multilevel import allocation, foundation
from linecontact.studies.multilevel.samples import FOUNDATION
from made_up_ensembles import SCENE, SURFACE

pytestmark = pytest.mark.once


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


@pytest.mark.parametrize("indenter", [PowerIndenter(), MeasuredIndenter(np.arange(8.0) ** 2, convention="gap")])
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
