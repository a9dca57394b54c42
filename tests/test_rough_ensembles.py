"""`study rough --standard-error`: every point of Figure 5 as an ensemble of its own."""

import math
from dataclasses import replace

import numpy as np
import pytest
from linecontact.solver import Layer, RoughIndenter, Scene, solve
from linecontact.studies import rough
from linecontact.studies.command_line import main
from linecontact.studies.files.study_files import load_study
from linecontact.studies.rough_surfaces import ensembles, figures, means
from linecontact.studies.rough_surfaces.report import report
from linecontact.studies.rough_surfaces.tasks import Configuration
from running import run_plans

pytestmark = pytest.mark.once

SMALL = replace(
    Configuration(),
    num_points=2**11,
    cut_off_ratio=1 / 8,
    hursts=(0.8,),
    poisson_ratios=(0.25,),
    thicknesses=(0.1, 1e-3),
)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rough")
    assert run_plans(rough.STUDY, [ensembles.plan(SMALL, 0.04)], folder) == 0
    assert (folder / "rough.png").is_file()
    return load_study(folder / "rough.h5"), folder


def test_every_point_has_the_standard_error(stored):
    file, folder = stored
    found = ensembles.states(file)
    assert found.keys() == {(0.8, 0.0, math.inf), (0.8, 0.25, 0.1), (0.8, 0.25, 1e-3)}
    for state in found.values():
        assert not state.batches
        for estimate in state.estimates.values():
            assert estimate.standard_error <= 0.04 * estimate.mean
    table, compared = report({"rough": file}, folder)
    assert "s of solving; the points' finest grids alone would take about" in compared
    assert table.row_count == 2


def test_a_file_of_a_smaller_standard_error_is_enough(stored):
    file, _ = stored
    assert ensembles.plan(SMALL, 0.2).enough(file)
    assert not ensembles.plan(SMALL, 0.004).enough(file)


def test_the_points_are_those_of_plain_sampling(stored):
    """Forty surfaces of each point on the finest grid of the ensembles."""
    found = ensembles.states(stored[0])
    for point in ensembles.points(found):
        kappa, area, reference = [], [], []
        for seed in range(40):
            indenter = RoughIndenter(0.8, seed, 1 / 8, 1 / 8)
            for layer in (Layer(point.thickness, 0.25), Layer()):
                o = solve(Scene(layer, indenter, 0.01, num_points=2**12)).observables
                (reference if math.isinf(layer.thickness) else kappa).append(o.kappa_subgrid)
                if math.isfinite(layer.thickness):
                    area.append(o.contact_area_subgrid)
        slope = np.mean(kappa) / np.mean(reference) * np.mean(area) / point.thickness
        scatter = sum(np.var(v, ddof=1) / 40 / np.mean(v) ** 2 for v in (kappa, area, reference))
        assert point.slope.value == pytest.approx(slope, abs=4 * math.hypot(point.slope.error, slope * scatter**0.5))
        assert point.slope.error <= 0.08 * point.slope.value


def test_the_figure_shows_the_means(stored):
    file, _ = stored
    points = list(ensembles.points(ensembles.states(file)))
    figure = figures.ratio(file, points, {0.8: 1.7})
    (bars,) = [c for c in figure.axes[0].containers if len(c[0].get_xdata()) == len(points)]
    np.testing.assert_allclose(bars[0].get_ydata(orig=False), [p.slope.value for p in points])
    assert isinstance(points[0].slope, means.Mean)


def test_a_larger_error_goes_on_from_there_and_bad_input_is_one_line(stored, capsys):
    file, _ = stored
    assert file.configuration["standard_error"] == 0.04
    assert main.main(["study", "rough", "--standard-error", "0", "--folder", str(stored[1] / "x")]) == 2
    assert "standard_error is 0" in capsys.readouterr().err
    assert main.main(["study", "rough", "--standard-error", "2", "--folder", str(stored[1] / "x")]) == 2
    assert "allowed: 1e-60 to 1, over the mean" in capsys.readouterr().err.replace("\n", " ")
