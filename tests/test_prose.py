"""What the pages say in words of stored results: every sentence here is composed from the results, and must stand in
the page, so a result that changes finds the sentences that it makes wrong."""

import math
from pathlib import Path

import numpy as np
import pytest
from linecontact.studies.files import study_files
from linecontact.studies.pressure import analysis
from linecontact.studies.rough_surfaces import means

pytestmark = pytest.mark.once

ROOT = Path(__file__).parent.parent


def stored(name):
    return study_files.load_study(ROOT / "studies" / "results" / f"{name}.h5")


def column(runs, name):
    return np.array([run[name] for run in runs])


def digits(value, count=2):
    return f"{value:.{count}g}"


def span(values, count=2):
    return f"{digits(min(values), count)} to {digits(max(values), count)}"


def curve_of_a_rough_surface():
    runs = stored("curve").runs
    pressure, kappa, patches = (column(runs, name) for name in ("scene.pressure", "kappa_subgrid", "num_patches"))
    flat = (pressure > 0.0025) & (pressure < 0.15)
    middle = (kappa[flat].max() + kappa[flat].min()) / 2
    off = math.ceil(100 * (kappa[flat].max() / middle - 1))
    many = round(patches[flat].max(), -2)
    yield (
        f"From {pressure[flat].min():.1g} to {digits(pressure[flat].max())} E*, with {patches[flat].min()} to {many} "
        f"patches, kappa stays within {off} % of {middle:.2f}."
    )
    yield f"down to {kappa[pressure < 0.003].min():.2f} where there is one"
    area, seconds = column(runs, "contact_area_subgrid"), column(runs, "seconds.total")
    times = round(np.median(seconds[area > 0.5]) / np.median(seconds[area < 0.1]))
    yield (
        f"The {len(runs)} loads of the figure take {digits(seconds.sum())} s of solving; where more than half is in "
        f"contact a solve takes about {times} times as long as where less than a tenth is."
    )


def kappa_over_the_load():
    curves = analysis.curves(stored("pressure"))
    rough = [c for c in curves if c.rough and c.is_half_space]
    small = [[point for point in curve.points if 0.0002 < point.pressure < 0.11] for curve in rough]
    kappa = [[point.kappa.value for point in points] for points in small]
    assert max(max(own) / min(own) - 1 for own in kappa) < 0.055
    areas = [point.area.value for points in small for point in points]
    yield f"to about 5 % from p = 0.0003 to 0.1 E*, which is a_r = {min(areas):.1g} to {digits(max(areas))}, if"
    falls = [100 * (1 - points[-1].kappa_surface.value / points[0].kappa_surface.value) for points in small]
    yield f"it falls by {min(falls):.0f} to {max(falls):.0f} % over these loads"
    theory = math.sqrt(8 / math.pi)
    above = [100 * (value / theory - 1) for own in kappa for value in own]
    yield f"Its value is {min(above):.0f} to {max(above):.0f} % above sqrt(8/pi) = {theory:.3f}"
    first = [curve.points[0].kappa_surface.value / theory for curve in rough]
    yield f"At the smallest loads {span(first)} times that is measured"
    at = [
        found
        for curve in curves
        if not curve.rough and not curve.is_half_space
        for found in [analysis.bending_thickness(curve)]
        if not math.isnan(found)
    ]
    yield f"a layer takes 5 % off it at d/a_r = {span(at)}."


def roughness_of_the_published_study():
    files = {name: stored(name) for name in ("sharp", "hertz", "blunt", "rough")}
    yield f"These are {sum(len(file.runs) for file in files.values())} solves, every one certified at 1e-8"
    kappa = [np.mean(list(means.half_space(files["rough"], hurst).values())) for hurst in (0.3, 0.5, 0.8)]
    yield f"edges kappa_inf is {min(kappa):.2f} to {max(kappa):.2f} and depends on H"
    assert not any(run["status"] != "converged" for file in files.values() for run in file.runs)
    points = [point for point in means.points(files["rough"]) if point.poisson_ratio <= 0.25]
    over_one_patch = [(p.per_width.value, p.per_patch.value / (2 * math.sqrt(3))) for p in points]
    near = [ratio for width, ratio in over_one_patch if width <= 0.25]
    assert max(ratio for width, ratio in over_one_patch if width > 0.25) < 0.7
    off = 10 * math.ceil(10 * max(abs(ratio - 1) for ratio in near))
    yield (
        f"for nu = 0 and 0.25 it is the single patch's value, to about {off} %, "
        "where the layer is at most a quarter as thick as a patch is wide."
    )
    blunt = next(run for run in files["blunt"].runs if math.isinf(run["scene.thickness"]))
    yield f"on the half-space kappa is {blunt['kappa_subgrid'] / 1.283305:.4f} kappa_inf"


@pytest.mark.parametrize(
    ("page", "sentences"),
    [
        ("curves", curve_of_a_rough_surface),
        ("pressure", kappa_over_the_load),
        ("paper", roughness_of_the_published_study),
    ],
)
def test_a_sentence_says_what_is_stored(page, sentences):
    text = " ".join((ROOT / "docs" / f"{page}.md").read_text().replace("**", "").replace("\\*", "*").split())
    for sentence in sentences():
        assert sentence in text
