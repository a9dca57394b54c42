"""What people see of scenes and solutions: printed lines, tables in notebooks, the figure of a solution."""

import dataclasses
import itertools
import math
import operator
import pydoc
import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import h5py
import linecontact
import matplotlib
import numpy as np
import pytest
from linecontact import Layer, PowerIndenter, RoughIndenter, Scene, load, plot, read_scan, solve, studies
from linecontact.solver import CoatedHalfSpace, SlidingLayer
from linecontact.solver.display import rounded_up
from linecontact.studies.command_line import main
from linecontact.studies.curve import figures as curve_figures
from linecontact.studies.figures import solution as solution_figure
from linecontact.studies.figures import titles
from linecontact.studies.figures.style import ONE_COLUMN, STYLE, TWO_COLUMNS, panels
from linecontact.studies.figures.ticks import few_ticks, in_plain_text
from linecontact.studies.files.hdf5 import new_file
from linecontact.studies.files.study_files import load_study
from linecontact.studies.multilevel import figures as ensemble_figures
from linecontact.studies.multilevel import report as ensemble_report
from linecontact.studies.multilevel import tasks as ensemble_tasks
from linecontact.studies.multilevel.estimator import Estimate, Term
from linecontact.studies.multilevel.samples import FOUNDATION, Samples
from linecontact.studies.runner.study import find
from matplotlib import pyplot as plt
from matplotlib.figure import Figure


@pytest.fixture(scope="module")
def solution():
    return solve(Scene(Layer(0.1 / 3, 0.25), num_points=256))


def digits(text):
    """The numbers in a text, without sign, point and exponent."""
    return ["".join(c for c in word.partition("e")[0] if c.isdigit()) for word in text.split() if word[0].isdigit()]


def test_printed_results_are_short_and_have_units(solution):
    things = [solution, solution.scene, solution.observables, solution.certificate, solution.patches, *solution.levels]
    things += [Layer(1 / 3, 0.1), Layer(), Scene(num_points=64), PowerIndenter(4 / 3), RoughIndenter(0.3, 5)]
    things += [Estimate("mean-gap", 4 / 3, 0.01 / 3, 1 / 3, (Term(256, None, 32, 1 / 3, 0.1, 0.01),), 0.1, 0.02)]
    for thing in things:
        text = repr(thing)
        assert text.startswith(type(thing).__name__)
        assert text.count("\n") < 9
        assert max(map(len, text.split("\n"))) <= 110
        assert all(len(number.lstrip("0")) <= 6 for number in digits(text))
        assert "array" not in text
        assert "thickness inf" not in text
    assert "thickness 0.0333333 [length]" in repr(solution)
    assert "status converged" in repr(solution)
    assert f"{solution.observables.contact_area_subgrid:.6g} +- " in repr(solution)
    known = [name for name, value in dataclasses.asdict(solution.certificate).items() if value is not None]
    assert all(f"{name} " in repr(solution.certificate) for name in known)


def test_a_file_whose_texts_are_not_utf_8_is_read_and_printed(solution, tmp_path):
    solution.save(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5") as old, new_file(tmp_path / "odd.h5") as new:
        for field in old:
            old.copy(field, new)
        for known, value in old.attrs.items():
            new.attrs[known] = value
        new.attrs.create(b"warnings.\xff", np.array(b"\xff"), dtype=h5py.string_dtype("utf-8", 1))
    found = load(tmp_path / "odd.h5")
    assert "warning, \ufffd: \ufffd" in repr(found)
    assert repr(found).encode()
    assert found == load(tmp_path / "odd.h5") != load(tmp_path / "run.h5")


def test_a_warning_is_printed_with_the_solution():
    solution = solve(Scene(pressure=0.5, num_points=64))
    (warning, *_) = solution.warnings
    assert f"warning, {warning.kind}: {warning.text}" in repr(solution)
    assert warning.kind in solution._repr_html_()


def test_what_comes_of_a_scan_is_printed_with_its_unit(tmp_path):
    file = tmp_path / "<script>alert('x')<script> & more.csv"
    np.savetxt(file, np.random.default_rng(0).random((40, 1)), header="z [um]")
    scan = read_scan(file, scan_length=1 / 3, length_unit="mm")
    assert repr(scan).startswith("Scan: period 0.666667 [mm], num_points 512; MeasuredIndenter: 512 heights, 0 to ")
    assert repr(scan).endswith(f" [mm], from {file.name}")
    scene = scan.scene(Layer(1 / 3, contact_modulus=1.0), 1e-6)
    assert "thickness 0.333333 [mm]" in repr(scene)
    solve(scene).save(tmp_path / "run.h5")
    assert "scene.thickness 0.333333 [mm]" in repr(load(tmp_path / "run.h5"))
    table = scene._repr_html_()
    assert '<td style="text-align: left">mm</td>' in table
    assert "&lt;script&gt;alert(&#x27;x&#x27;)&lt;script&gt; &amp; more" in table
    assert "<script>" not in table


def texts(figure):
    """Everything that is written in a figure."""
    parts = [*figure.axes, *figure.legends]
    found = [figure.get_suptitle()]
    found += [text.get_text() for part in parts for text in part.findobj(lambda artist: hasattr(artist, "get_text"))]
    return " | ".join(found)


def bars(axes):
    """Left and right ends of the bars at the foot of a panel."""
    (found,) = (c for c in axes.collections if c.get_transform() != axes.transData and c.get_zorder() == 3)
    return sorted((path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in found.get_paths())


def check_places(figure):
    """No legend and no label lies on a panel, or on another panel's label, and no number at an axis on another."""
    in_plain_text(figure)
    figure.draw_without_rendering()
    panels = [axes.get_window_extent() for axes in figure.axes]
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
    outside = [legend.get_window_extent() for legend in legends]
    for axes in figure.axes:
        labels = (axes.xaxis.label, axes.yaxis.label, axes.title)
        outside += [label.get_window_extent() for label in labels if label.get_text()]
        for axis, low, high in ((axes.xaxis, "x0", "x1"), (axes.yaxis, "y0", "y1")):
            numbers = [*axis.get_majorticklabels(), *axis.get_minorticklabels()]
            boxes = [number.get_window_extent() for number in numbers if number.get_text()]
            boxes = sorted((box for box in boxes if box.width), key=operator.attrgetter(low))
            assert all(getattr(a, high) < getattr(b, low) for a, b in itertools.pairwise(boxes))
    for k, one in enumerate(outside):
        assert not any(one.overlaps(panel) for panel in panels)
        assert not any(one.overlaps(other) for other in outside[:k])
        assert one.x0 >= 0
        assert one.x1 <= figure.bbox.x1
    if title := figure._suptitle:
        width = title.get_window_extent()
        assert 0 <= width.x0 <= width.x1 <= figure.bbox.x1


def test_the_figure_holds_the_solution(solution, tmp_path):
    before = plt.get_fignums()
    figure = solution.plot(tmp_path / "run.png")
    assert isinstance(figure, Figure)
    assert plt.get_fignums() == before  # a notebook would show it twice
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    assert figure._repr_png_().startswith(b"\x89PNG")
    heights, pressure, *near = figure.axes
    h, u = (line.get_ydata() for line in heights.get_lines()[:2])
    np.testing.assert_array_equal(h[:-1], solution.scene.profile)
    np.testing.assert_array_equal(u[:-1], solution.displacement)
    np.testing.assert_array_equal(pressure.get_lines()[0].get_ydata()[:-1], solution.contact_pressure)
    ends = [(solution.patches.left[0], solution.patches.right[0])]
    for axes in (heights, pressure):
        np.testing.assert_allclose(bars(axes), ends)
    for axes in near:  # enlarged, about the middle of the patch
        (left, right), size = bars(axes)[0], 10.0 ** round(np.log10(ends[0][1] - ends[0][0]) - 0.5)
        assert right - left == pytest.approx((ends[0][1] - ends[0][0]) / size)
        assert left == pytest.approx(-right)
        edges = [line.get_xdata()[0] for line in axes.get_lines() if line.get_linestyle() == "--"]
        assert edges == pytest.approx([left, right])
    check_places(figure)


def test_a_figure_from_the_file_is_the_same(solution, tmp_path):
    solution.save(tmp_path / "run.h5")
    stored = load(tmp_path / "run.h5")
    assert len(repr(stored)) < 300
    assert f"contact_area_error {rounded_up(solution.observables.contact_area_error)} [-]" in repr(stored)
    (drawn,) = solution_figure.draw(tmp_path / "run.h5").values()
    expected = solution.plot()
    with matplotlib.rc_context(STYLE):
        drawn.draw_without_rendering()  # ticks have no text before
    for figure in (plot(stored), drawn):
        assert texts(figure) == texts(expected)
        for axes, others in zip(figure.axes, expected.axes, strict=True):
            for line, other in zip(axes.get_lines(), others.get_lines(), strict=True):
                np.testing.assert_array_equal(line.get_xydata(), other.get_xydata())


def test_a_figure_of_many_patches_shows_each_and_the_largest_pressure():
    scene = Scene(indenter=RoughIndenter(cut_off_ratio=1 / 64), pressure=0.05, num_points=2**14)
    solution = solve(scene)
    figure = solution.plot()
    shown, patches = bars(figure.axes[1]), solution.patches
    assert patches.left.size > 10
    within = [(a + k, b + k) for a, b in zip(patches.left, patches.right, strict=True) for k in (-1, 0)]
    np.testing.assert_allclose(shown, sorted((a, b) for a, b in within if b > 0))
    line = figure.axes[1].get_lines()[0]
    assert line.get_ydata().max() == solution.observables.peak_pressure
    assert line.get_xdata().size <= 4001
    assert f"in {patches.left.size} patches" in texts(figure)
    check_places(figure)


def test_a_scan_is_drawn_in_its_units_with_its_mirror_image(tmp_path):
    x = np.arange(300)
    scan = np.stack([0.5 * x, 20 * np.sin(x / 20) + np.random.default_rng(0).standard_normal(300)], axis=1)
    np.savetxt(tmp_path / "scan.csv", scan, delimiter=",", header="x [um], z [nm]")
    solution = solve(read_scan(tmp_path / "scan.csv").scene(Layer(2e-3, 0.49, 1e6), 50.0))
    figure = solution.plot()
    text = texts(figure)
    assert "position $x$ (\u00b5m)" in text
    assert "height (nm)" in text
    assert "$d=2$ mm" in text
    assert "mirror image of the scan" in text
    assert "Patches of the mirror image are counted, too." in text
    assert text.startswith("scan.csv\n")
    heights, pressure = figure.axes[:2]
    assert heights.get_xlim() == pytest.approx((0, 300))
    assert heights.get_lines()[1].get_ydata().max() == pytest.approx(1e9 * solution.displacement.max())
    shaded = [patch.get_extents().transformed(pressure.transData.inverted()) for patch in pressure.patches]
    assert [(box.x0, box.x1) for box in shaded] == [pytest.approx((150, 300))]
    for axes in (heights, pressure):  # the hatch lies over the bodies and below the curves
        bodies = [filled.get_zorder() for filled in axes.collections if filled.get_zorder() < 0]
        assert all(below < axes.patches[0].get_zorder() < axes.get_lines()[0].get_zorder() for below in bodies)
    check_places(figure)


@pytest.mark.parametrize(
    ("options", "x", "z", "size", "thickness"),
    [
        ({"length_unit": "mm"}, "mm", "mm", 1e-3, "$d=0.002$ mm"),
        ({"x_unit": "um", "z_unit": "nm"}, "\u00b5m", "nm", 1.0, "$d=2$ \u00b5m"),
        ({"scene_units": True}, "own unit", "own unit", 1.0, "$d=2$ own unit"),
    ],
)
def test_a_scan_is_drawn_in_the_unit_that_is_asked_for(tmp_path, options, x, z, size, thickness):
    heights = np.sin(np.arange(300) / 20) + 0.05 * np.random.default_rng(0).standard_normal(300)
    named = "x [um],z [um]" if "length_unit" in options else ""
    np.savetxt(tmp_path / "scan.csv", np.stack([0.5 * np.arange(300), heights], axis=1), delimiter=",", header=named)
    scan = read_scan(tmp_path / "scan.csv", **options)
    scene = scan.scene(Layer(2 * scan.period / 300, 0.49, 3.0), 1e-3)
    figure = solve(dataclasses.replace(scene, pressure_unit="MPa")).plot()
    text = texts(figure)
    assert f"position $x$ ({x})" in text
    assert f"height ({z})" in text
    assert f"{thickness}, " in text
    assert "pressure (MPa)" in text
    assert "$p=0.001$ MPa" in text
    assert "Dimensionless" not in text
    assert figure.axes[0].get_xlim() == pytest.approx((0, 300 * size))
    check_places(figure)


def curve_of(folder, *words):
    """The figure of a curve."""
    assert main.main(["curve", "--folder", str(folder), "--workers", "1", *map(str, words)]) == 0
    (figure,) = curve_figures.draw(folder / "curve.h5").values()
    return figure


def test_the_curve_of_a_scan_names_its_file_and_has_its_unit(tmp_path):
    file = tmp_path / f"a $scan  of {'W' * 60}.csv"
    x = 0.5 * np.arange(200)
    np.savetxt(file, np.stack([x, 40 * np.sin(x / 7)], axis=1), delimiter=",", header="x [um],z [nm]")
    words = ["--profile", "file", "--profile-file", file, "--contact-modulus", 1e6, "--num-points", "2^10"]
    over_load = curve_of(tmp_path / "load", *words, "--thickness", "2mm", "--points", 3)
    assert re.match(r"a \\\$scan  of W+\.\.\.,\s\$d=2\$ mm, ", over_load.get_suptitle())
    check_places(over_load)
    over_thickness = curve_of(
        tmp_path / "d", *words, "--pressure", 1e3, "--over", "thickness", "--from", "1um", "--to", "5um", "--points", 3
    )
    panel = over_thickness.axes[-1]
    assert panel.get_xlabel() == "thickness (\u00b5m)"
    assert panel.get_lines()[0].get_xdata() == pytest.approx([1, 3, 5])
    check_places(over_thickness)


def test_the_curve_of_a_layer_names_its_thickness_over_the_period(tmp_path):
    words = ["--thickness", 0.2, "--num-points", "2^9"]
    figure = curve_of(tmp_path / "nu", *words, "--period", 2, "--over", "poisson_ratio", "--values", "0,0.4")
    assert "profile: power, $n=2$, $d=0.1\\,L$, $p=0.002\\,E^*$, 512 points" in figure.get_suptitle()
    assert figure.axes[-1].get_xlabel() == "Poisson ratio (dimensionless)"
    figure = curve_of(tmp_path / "period", *words, "--over", "period", "--values", "1,2")
    assert "$d=0.2$" in figure.get_suptitle()


def test_error_bars_too_long_for_a_panel_are_left_out():
    axes = Figure().subplots()
    x, y = np.arange(4.0), np.array([1.0, 1.1, 1.2, 1.3])
    assert curve_figures._panel(axes, x, y, np.array([0.1, 5.0, 0.1, np.nan]), joined=True) == 2
    assert axes.get_ylim()[0] == pytest.approx(0.87)
    (bars,) = axes.collections
    ends = np.array([path.vertices[:, 1] for path in bars.get_paths()])
    assert np.ptp(ends, axis=1).max() == pytest.approx(0.2)
    assert axes.get_ylim()[0] < ends.min() < ends.max() < axes.get_ylim()[1]


COATED = Scene(CoatedHalfSpace(0.1, 2.5, 0.4, 0.3, contact_modulus=5.0), num_points=512)


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        (Scene(num_points=256), "half-space, "),
        (Scene(Layer(0.002), num_points=2**12), "$d=0.002\\,L$"),
        (COATED, "coated, $d=0.1\\,L$, $\\nu=0.4$,\nbase: $E_2^*=0.5\\,E^*$, $\\nu_2=0.3$, $p="),
        (Scene(SlidingLayer(0.1), num_points=256), "sliding, $d=0.1\\,L$"),
        (Scene(pressure=1.0, num_points=256), "in 1 patch"),
        (Scene(pressure=0, num_points=64), "in 0 patches"),
        (Scene(Layer(0.1), RoughIndenter(0.3, 70236, cut_off_ratio=1 / 8), 1e-2, num_points=512), "seed 70236"),
        (Scene(Layer(0.1, 0.49999), RoughIndenter(cut_off_ratio=1 / 64), 0.05, num_points=2**12), "$\\nu=0.49999$"),
        (Scene(indenter=RoughIndenter(cut_off_ratio=1 / 8, rms_gradient=0.5), num_points=2**12), "h'=0.5$"),
    ],
)
def test_what_a_figure_says(scene, said):
    figure = solve(scene).plot()
    text = texts(figure)
    assert said.lower() in text.lower()
    assert "peaks point down" in text
    assert ("contact patches" in text) == (scene.pressure > 0)
    assert "inf" not in text
    assert "[" not in text
    check_places(figure)


def test_a_title_names_what_its_points_share_of_the_base():
    numbers = {f"scene.{name}": value for name, value in COATED.to_dict().items()}
    assert titles.base(numbers, ["base_modulus"]) == titles.base(numbers, ["contact_modulus"]) == "base: $\\nu_2=0.3$"
    assert titles.base(numbers, ["base_poisson_ratio"]) == "base: $E_2^*=0.5\\,E^*$"


@dataclass(frozen=True)
class Membrane(SlidingLayer):
    """A layer with a number of its own."""

    name: ClassVar[str] = "membrane"
    tension: float = 0.01


def test_a_title_gives_an_own_number_to_neither_part():
    scene = Scene(Membrane(0.1), num_points=512)
    numbers = {f"scene.{name}": value for name, value in scene.to_dict().items()} | {"scene.profile_values": 3}
    assert titles.pressed(numbers) == "profile: power, $n=2$"
    assert titles.scene(numbers, ()).endswith("512 points, tension 0.01")
    assert "tension 0.01" in texts(solve(scene).plot()).splitlines()


def test_a_figure_says_that_a_solve_has_not_ended_well():
    assert "iteration limit" in texts(solve(Scene(num_points=256), nested=False, max_iterations=1).plot())


@pytest.mark.parametrize("ending", ["png", "pdf", "PNG"])
def test_a_figure_is_drawn_again_over_itself_and_over_no_other(solution, tmp_path, ending):
    path = tmp_path / f"run.{ending}"
    solution.plot(path)
    solution.plot(path)
    path.write_text("mine")
    with pytest.raises(ValueError, match="exists; allowed: a new name, or overwriting it"):
        solution.plot(path)
    assert path.read_text() == "mine"
    solution.plot(path, overwrite=True)
    Figure().savefig(path)
    with pytest.raises(ValueError, match="exists"):
        solution.plot(path)
    with pytest.raises(ValueError, match="solution is 'run'; allowed: a Solution"):
        plot("run")
    with pytest.raises(ValueError, match=r"run\.txt; allowed: a name that ends in .*\.png"):
        solution.plot(path.with_suffix(".txt"))


RESULTS = Path(studies.__file__).parent / "results"
# further files of the peers, of the edge curve and of the kernels
NOT_DRAWN = {"areas", "few-nodes", "kernel-variants", "transforms", "transforms-long"}


@pytest.mark.parametrize("name", sorted({path.stem for path in RESULTS.glob("*.h5")} - {"sharp", "blunt", *NOT_DRAWN}))
def test_nothing_hides_data_in_the_studies_figures(name):
    with matplotlib.rc_context(STYLE):
        for figure in find(name).draw(RESULTS / f"{name}.h5").values():
            check_places(figure)
            assert not re.search(r"\binf\b|\[length\]|\[pressure\]", texts(figure))
            assert figure.get_figwidth() in (ONE_COLUMN, TWO_COLUMNS)


@pytest.mark.parametrize(
    ("base", "limits", "labels"),
    [
        (2, (2**14, 2**18), ["2¹⁴", "2¹⁶", "2¹⁸"]),
        (10, (1e-3, 1e1), ["10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹"]),
        (10, (2e-4, 5e-4), ["2\u00d710⁻⁴", "3\u00d710⁻⁴", "4\u00d710⁻⁴"]),
    ],
)
def test_numbers_at_logarithmic_axes_are_plain_text(base, limits, labels):
    figure, grid = panels(1, 1, ONE_COLUMN, 2.0)
    grid[0, 0].set_xscale("log", base=base)
    grid[0, 0].set_xlim(*limits)
    in_plain_text(figure)
    figure.draw_without_rendering()
    shown = [text.get_text() for which in ("major", "minor") for text in grid[0, 0].get_xticklabels(which=which)]
    assert set(labels) <= set(shown)
    assert not any("$" in text for text in shown)


def test_a_power_of_ten_stands_at_the_end_of_an_axis_in_plain_text():
    with matplotlib.rc_context({"axes.formatter.use_mathtext": True}):
        figure, grid = panels(1, 1, ONE_COLUMN, 2.0)
        grid[0, 0].plot([0, 1], [0, 3e-5])
        few_ticks(grid[0, 0])
        figure.draw_without_rendering()
    assert grid[0, 0].yaxis.get_offset_text().get_text() == "\u00d710⁻⁵"


def test_what_linecontact_has_made_it_makes_again_and_data_never(solution, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    solution.plot("run.png")
    solution.save("drawn.h5")
    Path("drawn.pdf").write_text("mine")
    assert main.main(["plot", "drawn.h5"]) == 2
    assert Path("drawn.pdf").read_text() == "mine"
    words = ["solve", "--num-points", "256", "--plot", "--patches", "patches.csv", "--save"]
    assert main.main([*words, "run.h5"]) == 0
    assert main.main([*words, "run.h5"]) == 2
    assert "run.h5 exists" in capsys.readouterr().err
    assert main.main([*words, "other.h5", "--pressure", "1kPa", "--contact-modulus", "1MPa"]) == 0
    assert main.main(["export", "run.h5", "--csv", "patches.csv"]) == 2
    assert main.main(["export", "run.h5", "--csv", "run.csv"]) == 0
    assert main.main(["export", "other.h5", "--csv", "run.csv"]) == 0
    assert (
        Path("run.csv").read_text().startswith("x [length],profile [length],displacement [length],contact_pressure [k")
    )
    Path("patches.csv").write_text("left,right\n0,1\n")
    assert main.main([*words, "third.h5"]) == 2
    assert Path("patches.csv").read_text() == "left,right\n0,1\n"


def test_an_infinite_stiffness_of_a_curve_is_drawn_at_the_top():
    with matplotlib.rc_context(STYLE):
        (figure,) = curve_figures.draw(RESULTS / "curve.h5").values()
    run = load_study(RESULTS / "curve.h5").runs[-1]
    assert math.isinf(run["contact_stiffness"])
    *_, panel = figure.axes
    triangle = next(line for line in panel.get_lines() if line.get_marker() == "^")
    assert triangle.get_xdata() == pytest.approx([run["scene.pressure"]])
    assert figure.get_suptitle().endswith("Triangle at the top: infinite, in full contact.")


def test_the_figure_of_an_ensemble_on_a_thin_layer_shows_the_foundation(tmp_path):
    words = ["--thickness", "0.01", "--standard-error", "0.2", "--cut-off-ratio", "0.125", "--num-points", "2^11"]
    assert main.main(["ensemble", "--folder", str(tmp_path), "--workers", "1", *words]) == 0
    (figure,) = ensemble_figures.draw(tmp_path / "ensemble.h5").values()
    labels = [line.get_label() for line in figure.axes[0].get_lines()]
    assert labels[-2:] == ["std on the foundation, times its factor", "std of the change from there to a grid"]
    level, change = figure.axes[0].get_lines()[-2:]
    samples = Samples(load_study(tmp_path / "ensemble.h5").runs, "kappa")
    assert level.get_ydata()[0] == pytest.approx(np.std([*samples.values[FOUNDATION].values()], ddof=1))
    size = int(change.get_xdata()[0])
    differences = [samples.values[size][seed] - samples.values[FOUNDATION][seed] for seed in samples.seeds(size, 0)]
    assert change.get_ydata()[0] == pytest.approx(np.std(differences, ddof=1))


def test_an_ensemble_says_which_way_is_cheaper_and_by_what_factor():
    file = load_study(RESULTS / "ensemble.h5")
    wanted, state = ensemble_tasks.found(file)
    ((observable, estimate),) = state.estimates.items()
    plain = estimate.plain_cost(estimate.standard_error)
    error = rounded_up(estimate.standard_error)
    for spent, said in (
        (plain / 4, f"takes about {plain:.3g} s to a standard error of {error}, 4 times as long."),
        (plain * 4, "is the cheaper way here, by a factor of 4, but does not tell the bias."),
    ):
        assert ensemble_report._sentences(observable, estimate, wanted, spent).endswith(said)


def test_help_names_the_fields():
    """Of every public dataclass, as its source has them; docstrings alone have none. The package's names all."""
    text = pydoc.plain(pydoc.render_doc(linecontact))
    about = text[: text.index("CLASSES")]
    for name in linecontact.__all__:
        assert name in about or name == "__version__"
        thing = getattr(linecontact, name)
        if dataclasses.is_dataclass(thing):
            text = pydoc.plain(pydoc.render_doc(thing))
            for field in dataclasses.fields(thing):
                assert re.search(rf"^ \|    {field.name}: \S+", text, re.MULTILINE), (name, field.name)


def test_a_loaded_solution_in_the_place_of_anything_is_shown_in_a_few_words(tmp_path):
    solve(Scene(num_points=64)).save(tmp_path / "run.h5")
    stored = linecontact.load(tmp_path / "run.h5")
    assert len(repr(stored)) > 160
    calls = [
        linecontact.solve,
        Layer,
        lambda one: linecontact.solve(Scene(num_points=64), accuracy=1e-3, method=one),
        lambda one: linecontact.solve(Scene(num_points=64), device=one),
        lambda one: linecontact.curve(Scene(), "pressure", [one]),
        lambda one: linecontact.save(one, tmp_path / "new.h5"),
        lambda one: linecontact.plot(solve(Scene(num_points=64)), one),
    ]
    shortened = r" is (StoredSolution: .* \.\.\.|of type StoredSolution); allowed: "
    for call in calls:
        with pytest.raises(ValueError, match=shortened) as caught:
            call(stored)
        shown = str(caught.value).partition(" is ")[2].partition("; allowed: ")[0]
        assert len(shown) <= 80
        assert "\n" not in str(caught.value)
