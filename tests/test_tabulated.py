"""A layer given by a table of K(q): what lies between the rows and beyond them, files, and bad tables."""

import math

import numpy as np
import pytest
from linecontact.solver import CoatedHalfSpace, Layer, RoughIndenter, Scene, SlidingLayer, TabulatedLayer, solve
from linecontact.studies.command_line import main
from linecontact.studies.scenes import stiffness_file

Q = np.geomspace(1.0, 1e5, 200)
WAVES = 2 * np.pi * np.arange(1.0, 2**11 + 1)


def tabulated(layer, q=Q, **more):
    return TabulatedLayer(tuple(q), tuple(layer.stiffness(q, 1.0) * layer.contact_modulus), **more)


@pytest.mark.parametrize(
    "layer",
    [Layer(0.1, 0.25), Layer(0.01, 0.45), Layer(0.01, 0.5), SlidingLayer(0.03, 2.0), CoatedHalfSpace(1e-3, 5.0)],
)
def test_a_table_of_a_layer_is_the_layer(layer):
    """Cubics in ln q: an error of the order of the step, ln(10)/40, to the fourth power, times what K bends."""
    table = tabulated(layer)
    np.testing.assert_allclose(
        table.stiffness(WAVES, 1.0) * table.contact_modulus, layer.stiffness(WAVES, 1.0) * layer.contact_modulus, 1e-3
    )
    assert table.contact_modulus == pytest.approx(layer.contact_modulus, rel=1e-6)
    foundation = layer.foundation_modulus(1.0)
    assert table.foundation_modulus(1.0) == pytest.approx(foundation, rel=1e-2)
    scene = Scene(layer, RoughIndenter(0.8, 0, cut_off_ratio=1 / 16), 0.02, num_points=2**12)
    exact, found = (solve(scene).observables, solve(Scene(table, scene.indenter, 0.02, num_points=2**12)).observables)
    assert found.contact_area_subgrid == pytest.approx(exact.contact_area_subgrid, rel=1e-3)
    assert found.approach == pytest.approx(exact.approach, rel=1e-3)


def test_beyond_the_ends_a_law_goes_on():
    half_space = tabulated(Layer(), np.geomspace(100, 1000, 10))
    np.testing.assert_allclose(half_space.stiffness(WAVES, 1.0), WAVES / 2, rtol=1e-12)
    assert half_space.foundation_modulus(1.0) == 0
    assert half_space.thickness == math.inf
    thin = Layer(1e-4, 0.3)  # on waves of 100 and more still the foundation
    table = tabulated(thin, np.geomspace(50, 1e6, 200))
    np.testing.assert_allclose(table.stiffness(WAVES, 1.0), thin.stiffness(WAVES, 1.0), rtol=1e-4)
    assert table.foundation_modulus(1.0) == pytest.approx(thin.foundation_modulus(1.0), rel=1e-4)


def test_other_units_are_the_same_layer():
    table = tabulated(Layer(0.1))
    scaled = table.in_units(1e3, 7.0)
    one = solve(Scene(table, num_points=2**10)).observables
    other = solve(Scene(scaled, Scene().indenter.in_units(1e3), 7 * 2e-3, 1e3, 2**10)).observables
    assert other.contact_area_subgrid == pytest.approx(one.contact_area_subgrid, rel=1e-9)
    assert scaled.thickness == pytest.approx(1e3 * table.thickness)


def test_missing_waves_are_named():
    middle = tabulated(Layer(1e-4, 0.5), np.geomspace(50, 1e6, 300))
    with pytest.raises(ValueError, match=r"stiffnesses lack the long waves of this scene, q = 6.283: the table begins"):
        solve(Scene(middle, num_points=64))
    short = tabulated(Layer(0.01, 0.25), np.geomspace(1, 300, 80))
    with pytest.raises(ValueError, match=r"lack the short waves of this scene, q = 3217: the table ends at 300"):
        solve(Scene(short, num_points=2**10))


@pytest.mark.parametrize(
    ("q", "k", "said"),
    [
        (range(1, 8), range(1, 8), r"wave_numbers has shape \(7,\); allowed: 8 or more"),
        (range(1, 10), range(1, 9), "stiffnesses are 8; allowed: 9, as many as wave_numbers"),
        ([1, 2, 3, 3, 5, 6, 7, 8], range(1, 9), "wave_numbers are 3 after 3 in row 4; allowed: increasing ones"),
        (range(9), range(1, 10), "wave_numbers are 0 in row 1; allowed: 8 or more finite real numbers > 0"),
        (range(1, 9), [1, 2, 3, -4, 5, 6, 7, 8], "stiffnesses are -4 in row 4; allowed"),
        (range(1, 9), [1, 2, 3, math.nan, 5, 6, 7, 8], "stiffnesses are nan in row 4; allowed"),
        (range(1, 9), [1, 2, 3, 4j, 5, 6, 7, 8], "stiffnesses is .* allowed: 8 or more finite real numbers"),
        (range(1, 9), ["a"] * 8, "stiffnesses is .* allowed: 8 or more finite real numbers"),
        (
            range(1, 9),
            [1, 2, 3, 9, 5, 6, 7, 8],
            "every other row is left out, change by .* about q = 4",
        ),
    ],
)
def test_bad_tables_are_named(q, k, said):
    with pytest.raises(ValueError, match=said):
        TabulatedLayer(tuple(q), tuple(k))


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "graded.csv"
    k = Layer(0.1).stiffness(Q, 1.0)
    path.write_text("# q, K\n" + "\n".join(f"{a!r}, {b!r}" for a, b in zip(Q.tolist(), k.tolist(), strict=True)))
    return path


def test_from_a_file(file, capsys):
    assert main.main(["solve", "--layer", "file", "--stiffness-file", str(file), "--num-points", "2^10", "--json"]) == 0
    shown = capsys.readouterr().out
    assert '"stiffness_source": "graded.csv"' in shown
    area = solve(Scene(Layer(0.1), num_points=2**10)).observables.contact_area_subgrid
    assert f'"contact_area_subgrid": {area:.5f}'[:-1] in shown


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "which is not a file; allowed: an existing file, with two columns"),
        ("1 2 3\n4 5 6\n", "of 3 columns; allowed: two, q and K(q)"),
        ("1 2\n3\n", "which cannot be read ("),
        ("q K\n", "which cannot be read (could not convert string 'q'"),
        ("1 2\n2 3\n", "wave_numbers has shape (2,)"),
        ("", "which cannot be read (it has no rows)"),
        ("# nothing\n", "which cannot be read (it has no rows)"),
    ],
)
def test_bad_files_are_one_line_and_status_2(tmp_path, capsys, text, said):
    path = tmp_path / "k.txt"
    if text is not None:
        path.write_text(text)
    assert main.main(["solve", "--layer", "file", "--stiffness-file", str(path), "--num-points", "64"]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("header", "unit", "named"),
    [
        ("q [1/um], K [MPa/um]", "m", "um"),
        ("q in um^-1", "m", "um"),
        ("q (µm⁻¹)", "mm", "um"),
        ("q 1/m; K GPa/mm", "m", "mm"),
        ("q [1/um], K [MPa/um]", "um", ""),
        ("q [1/m], K [Pa/m], 3 rows of E/2", "m", ""),
        ("q [1/um], K [MPa/um]", "length", ""),
        ("graded layer, 1/q down to 1e-4", "m", ""),
        ("length unit: mm", "m", "mm"),
        ("units: um, MPa", "m", "um"),
        ("q [1/um], E = 2 N/m", "um", ""),
        ("q per micrometre", "m", "um"),
        ("q [1/um], K [MPa/um], E = 2000 N/mm^2", "um", ""),
        ("K [(N/mm²)/um]", "um", ""),
        ("K [(N/mm²)/um]", "m", "um"),
        ("density 1100 kg/m^3; cantilever 0.2 N/m; λ/μ = 2.5", "um", ""),
        ("thickness d/mm = 5, data/in/k.txt", "m", ""),
    ],
)
def test_a_unit_in_a_comment_is_that_of_the_scan(tmp_path, header, unit, named):
    q = np.logspace(-1, 5, 200)
    np.savetxt(tmp_path / "k.txt", np.stack([q, 0.5 * q], axis=1), header=header, encoding="utf-8")
    options = stiffness_file.Options(tmp_path / "k.txt")
    if not named:
        assert stiffness_file.read(options, unit).wave_numbers == tuple(q)
        return
    with pytest.raises(
        ValueError, match=f"names {named}, and the scene's lengths are in {unit}; allowed: q in 1/{unit}"
    ):
        stiffness_file.read(options, unit)


def test_beside_a_scan_the_command_line_knows_the_unit(tmp_path, capsys):
    q = np.logspace(-1, 9, 400)
    np.savetxt(tmp_path / "k.txt", np.stack([q, 0.5 * q], axis=1), header="q [1/um]")
    np.savetxt(tmp_path / "scan.csv", np.stack([np.arange(64), np.arange(64) % 7], axis=1), header="x [um] z [nm]")
    words = [
        "--profile",
        "file",
        "--profile-file",
        str(tmp_path / "scan.csv"),
        "--length-unit",
        "mm",
        "--pressure",
        "1",
    ]
    table = ["--layer", "file", "--stiffness-file", str(tmp_path / "k.txt"), "--contact-modulus", "1e6"]
    assert main.main(["solve", *words, *table]) == 2
    assert "names um, and the scene's lengths are in mm" in capsys.readouterr().err


@pytest.mark.parametrize("layer", [Layer(0.1, 0.25), Layer(0.01, 0.49), Layer(0.05, 0.5), CoatedHalfSpace(1e-3, 5.0)])
def test_a_function_is_known_to_six_digits(layer):
    first = 0.1 if layer.foundation_modulus(1.0) == math.inf else 1e-4
    table = TabulatedLayer.from_function(
        lambda q: layer.stiffness(q, 1.0) * layer.contact_modulus, first, 1e7, layer.contact_modulus
    )
    np.testing.assert_allclose(table.stiffness(WAVES, 1.0), layer.stiffness(WAVES, 1.0), rtol=1e-6)
    scene = Scene(layer, RoughIndenter(0.8, 0, cut_off_ratio=1 / 16), 0.02, num_points=2**12)
    exact, found = (solve(scene).observables, solve(Scene(table, scene.indenter, 0.02, num_points=2**12)).observables)
    assert found.contact_area == exact.contact_area
    assert found.peak_pressure == pytest.approx(exact.peak_pressure, rel=1e-5)


@pytest.mark.parametrize(
    ("function", "first", "last", "message"),
    [
        (
            lambda q: np.where(q > 50, np.nan, q),
            1,
            1e4,
            r"stiffness\(q\) is nan at q = .*; allowed: finite numbers > 0",
        ),
        (lambda q: q - 10, 1, 1e4, r"stiffness\(q\) is -9 at q = 1; allowed"),
        (lambda q: 1.0, 1, 1e4, r"stiffness\(q\) has shape \(\) and type float64; allowed: real"),
        (
            lambda q: np.where(q > 50, 2 * q, q),
            1,
            1e4,
            r"changes by .* about q = [45]\d.*; allowed: below",
        ),
        (lambda q: q, 10, 1, r"last is 1; allowed: at least twice the first, which is 10"),
        (lambda q: q, 0, 1, "first is 0"),
        (lambda q: math.exp(-q), 1, 10, r"stiffness\(q\) fails .*; allowed: a function of an array of wave"),
    ],
)
def test_functions_that_are_no_stiffness_are_named_at_once(function, first, last, message):
    with pytest.raises(ValueError, match=message):
        TabulatedLayer.from_function(function, first, last)


def test_a_solution_on_a_table_is_drawn_saved_or_not(tmp_path):
    """A file does not hold the table, which tells where between the nodes a contact ends."""
    scene = Scene(tabulated(Layer(0.1)), num_points=2**10)
    solution = solve(scene)
    solution.save(tmp_path / "table.h5")
    assert main.main(["plot", str(tmp_path / "table.h5")]) == 0
    assert solution.plot().axes[1].get_lines()[0].get_ydata().max() == solution.observables.peak_pressure


def test_a_table_that_ends_before_the_scene_s_waves_is_refused():
    """As one in another unit of length."""
    q = np.geomspace(1e-9, 1e-5, 40)
    with pytest.raises(
        ValueError, match=r"stiffnesses end at q = 1e-05, and this scene's longest wave is q = 6.283; all"
    ):
        Scene(TabulatedLayer(tuple(q), tuple(0.5 * q)), num_points=256)


def test_a_table_that_begins_beyond_the_scene_s_waves_is_refused_on_the_command_line(tmp_path, capsys):
    q = np.geomspace(1e4, 1e9, 100)
    np.savetxt(tmp_path / "k.txt", np.stack([q, 0.5 * q], axis=1))
    words = ["solve", "--layer", "file", "--stiffness-file", str(tmp_path / "k.txt"), "--num-points"]
    assert main.main([*words, "2^9"]) == 2
    assert "stiffnesses begin at q = 1e+04, beyond all waves of this scene; allowed: a table" in capsys.readouterr().err
    assert main.main([*words, "2^13", "--accuracy", "0.01"]) == 0  # coarser grids than the scene's do not matter
