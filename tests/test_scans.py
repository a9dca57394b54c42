"""Profiles from files: every format and convention, what is done to them, and what is refused."""

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from linecontact.solver import CoatedHalfSpace, Layer, MeasuredIndenter, Scene, SlidingLayer, Status, solve
from linecontact.studies.scans import preparation
from linecontact.studies.scans.reading import Options, read_scan
from linecontact.studies.scans.reading import read as read_options

REAL = Path(__file__).parents[2] / "shared" / "data"


AS_IT_IS = {"profile_convention": "gap", "detrend": "none", "window": "none"}
"""The file holds one period of h."""


def read(path, **options):
    """In the scene's own unit, unless a test is about units; heights without positions are one unit long."""
    options = {"scene_units": True} | options
    if "scan_length" not in options:
        try:
            return read_options(Options(path, **options))
        except ValueError as error:
            if "scan_length is missing" not in str(error):
                raise
    return read_options(Options(path, **{"scan_length": 1.0} | options))


@pytest.fixture
def heights():
    x = np.arange(64) / 64
    return 1e-3 * (np.sin(2 * np.pi * x) + 0.3 * np.cos(6 * np.pi * x))


def write(folder, suffix, columns):
    path = folder / f"profile{suffix}"
    table = np.stack(columns, axis=1)
    if suffix == ".npy":
        np.save(path, table if len(columns) > 1 else columns[0])
    elif suffix == ".h5":
        with h5py.File(path, "w") as file:
            file["line"] = table
    else:
        np.savetxt(path, table, delimiter="," if suffix == ".csv" else " ")
    return path


@pytest.mark.parametrize("suffix", [".npy", ".csv", ".txt", ".h5"])
def test_formats(tmp_path, heights, suffix):
    x = 0.5 * np.arange(64)
    for columns, length in (([heights], 1.0), ([x, heights], 32.0)):
        indenter, period, n = read(write(tmp_path, suffix, columns), num_points=64, **AS_IT_IS)
        assert (period, n) == (length, 64)
        np.testing.assert_allclose(indenter.heights, heights - heights.min(), atol=1e-18)
        assert indenter.description["profile_values"] == 64
        assert "shifted to h >= 0" in indenter.description["profile_steps"]


@pytest.mark.parametrize(("values", "points", "wave"), [(41, 123, 4), (64, 256, 3), (101, 202, 50)])
def test_any_number_of_values_and_points(tmp_path, values, points, wave):
    """A band-limited profile keeps its heights, whether taken as it is or resampled, up to the highest wave."""
    x, fine = np.arange(values) / values, np.arange(points) / points
    z, exact = (np.cos(2 * np.pi * at) + 0.1 * np.cos(2 * wave * np.pi * at) for at in (x, fine))
    path = write(tmp_path, ".npy", [z])
    whole, _, n = read(path, num_points=values, **AS_IT_IS)
    assert n == values
    np.testing.assert_allclose(whole.heights, z - z.min(), atol=1e-14)
    found, period, n = read(path, num_points=points, scan_length=2.0, **AS_IT_IS)
    assert (period, n) == (2.0, points)
    there = slice(
        None, None, points // values if wave == 50 else 1
    )  # straight lines between values of the highest wave
    np.testing.assert_allclose((found.heights - found.heights[0])[there], (exact - exact[0])[there], atol=1e-12)
    assert f"resampled from {values} to {points}" in found.description["profile_steps"]
    assert solve(Scene(indenter=found, period=2.0, num_points=points)).status is Status.CONVERGED


@pytest.mark.parametrize("values", [100, 64])
def test_tilt_and_window(tmp_path, values):
    tilted = 0.01 * np.arange(values) + np.random.default_rng(0).standard_normal(values)
    path = write(tmp_path, ".csv", [tilted])
    mirrored, period, n = read(path, num_points=2 * values, scan_length=3.0)
    assert (period, n) == (6.0, 2 * values)  # the mirror image is as long again
    assert "the period is twice the scan" in mirrored.description["profile_steps"]
    np.testing.assert_allclose(mirrored.heights, mirrored.heights[::-1], atol=1e-12)
    indenter, period, n = read(path, window="none", detrend="linear")
    assert (period, n >= 4 * values) == (1.0, True)
    assert "tilt of" in indenter.description["profile_steps"]
    as_it_is, _, _ = read(path, num_points=values, **AS_IT_IS)
    np.testing.assert_allclose(as_it_is.heights, tilted - tilted.min())
    for degree, how in enumerate(("mean", "linear", "curvature")):
        asked, _, _ = read(path, num_points=values, **AS_IT_IS | {"detrend": how})
        of_rest = np.polyfit(np.linspace(-1, 1, values), asked.heights, degree)[:-1]
        np.testing.assert_allclose(of_rest, 0, atol=1e-12)
        assert degree or np.ptp(asked.heights) == pytest.approx(np.ptp(tilted))


@pytest.mark.parametrize(("values", "accuracy", "points"), [(3001, None, 2**15), (3001, 1e-3, 48000), (40, 1e-2, 640)])
def test_the_grid_goes_as_far_as_the_scan(tmp_path, values, accuracy, points):
    z = np.random.default_rng(3).standard_normal(values)
    assert read(write(tmp_path, ".npy", [z]), accuracy=accuracy).num_points == points


@pytest.mark.parametrize("unit", ["m", "nm"])
def test_heights_of_any_size_are_a_profile(tmp_path, heights, unit):
    scan = read_scan(write(tmp_path, ".csv", [heights]), scan_length=1e-3, z_unit=unit, **AS_IT_IS)
    assert scan.indenter.heights.max() == pytest.approx(np.ptp(heights) * {"m": 1.0, "nm": 1e-9}[unit], rel=0.1)


def test_uneven_positions_are_interpolated(tmp_path):
    rng = np.random.default_rng(1)
    x = np.sort(rng.random(200))
    path = write(tmp_path, ".txt", [x, (x - 0.5) ** 2])
    indenter, period, _ = read(path, num_points=200, **AS_IT_IS)
    assert "interpolated linearly" in indenter.description["profile_steps"]
    h = (np.linspace(x[0], x[-1], 200) - 0.5) ** 2
    np.testing.assert_allclose(indenter.heights, h - h.min(), atol=2e-3)  # gaps of up to 0.03 between positions
    assert period == pytest.approx((x[-1] - x[0]) * 200 / 199)
    rounded = np.round(0.156 * np.arange(200), 1)
    indenter, period, _ = read(write(tmp_path, ".txt", [rounded, x]), num_points=200, **AS_IT_IS)
    assert "taken as even" in indenter.description["profile_steps"]
    assert period == pytest.approx(0.156 * 200, rel=2e-3)
    shaken = np.arange(200) + 0.4 * rng.uniform(-1, 1, 200)  # uneven, not rounded
    clustered = np.cumsum(np.tile([1e-300, 1.0], 100))
    for uneven in (shaken, clustered, np.cumsum(rng.uniform(0.5, 1.5, 200))):
        found = preparation.evenly_spaced(uneven, x)
        assert found.z.size == 200
        assert "interpolated linearly" in found.steps[0]


def doubts(path, **options):
    scan = read_scan(path, **{"scene_units": True, **options})
    warnings = solve(scan.scene(Layer(contact_modulus=1.0), pressure=1e-3)).warnings
    return [warning.text for warning in warnings if warning.kind == "profile"]


def test_what_was_made_of_a_scan_is_doubted_where_it_may_be_wrong(tmp_path):
    x = np.arange(400.0)
    z, rng = np.cos(2 * np.pi * x / 50), np.random.default_rng(5)
    for hardly in (x, x[::-1], x + 0.01 * rng.uniform(-1, 1, 400)):
        assert doubts(write(tmp_path, ".txt", [hardly, z]), window="none") == []
    tilted = write(tmp_path, ".txt", [x, z + 0.01 * x])
    assert doubts(tilted) == []  # by its mirror image
    (text,) = doubts(tilted, window="none")
    step = 0.01 * 399 + z[-1] - z[0]
    assert f"a step {round(step / np.abs(np.diff(z + 0.01 * x)).max())} times as high as any in the scan" in text
    for there, share in ((x != 200, None), ((x < 200) | (x > 210), "2.8%"), (x % 20 > 1, "9.6%")):
        told = doubts(write(tmp_path, ".txt", [x[there], z[there]]))
        filled = f"{share} of the scan, where it has no values, were filled by straight lines"
        assert told == [filled] * bool(share)
    jittered = np.cumsum(rng.uniform(0.5, 1.5, 100))
    (text,) = doubts(write(tmp_path, ".txt", [jittered, np.sin(jittered)]))
    steps = np.diff(jittered)
    most = f"{np.abs(steps / steps.mean() - 1).max():.0%}"
    assert f"differ from their mean by up to {most}; heights were interpolated by straight lines" in text


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda z: np.put(z, [40, 41, 300], -9999), "3 of 512 values, the first -9999 in line 42, may stand for miss"),
        (lambda z: np.put(z, [0], 512), "1 of 512 values, the first 512 in line 2, may stand for missing"),
        (lambda z: np.put(z, [511], 99999), "1 of 512 values, the first 99999 in line 513, may stand for missing"),
        (lambda z: np.copyto(z, np.arange(512) % 40 < 3), ""),  # a grating
        (lambda z: np.copyto(z, z / 20 + 50 * (np.arange(512) % 40 < 3)), ""),  # a rough one
        (lambda z: np.copyto(z, np.arange(512) % 20 == 7), ""),  # hardly more than one digit
        (lambda z: np.copyto(z, np.where(np.arange(512) == 9, -9999, z + 20 * np.arange(512))), "1 of 512 values"),
        (lambda z: np.put(z, [7], 40), ""),  # a high peak
        (lambda z: np.put(z, range(100, 121), -500 * (1 - np.linspace(-1, 1, 21) ** 2)), ""),  # a deep scratch
    ],
)
def test_values_that_may_stand_for_missing_ones_are_doubted(tmp_path, change, said):
    z = np.random.default_rng(1).normal(0, 10, 512)
    change(z)
    (tmp_path / "scan.csv").write_text("x [um],z [nm]\n" + "".join(f"{i},{h}\n" for i, h in enumerate(z)))
    indenter = read_scan(tmp_path / "scan.csv", length_unit="um").indenter
    doubts = [doubt for doubt in indenter.doubts.split("; ") if doubt and not doubt.startswith("between")]
    assert [doubt.startswith(said) for doubt in doubts] == [True] * bool(said)


ROWS = "".join(f"{i} {i % 7}\n" for i in range(40))
Z = np.arange(40.0) % 7


@pytest.mark.parametrize(
    ("content", "options", "named"),
    [
        ("a b\nc d\n", {}, "no table of numbers"),
        ("1 2 3\n" * 40, {}, "columns is missing: .* has 3 columns of numbers, the first row 1 2 3"),
        ("1 2 3\n" * 40, {"columns": "1,4"}, "columns is '1,4'; allowed: 1, 2, 3, the columns of numbers"),
        ("1 2 3\n" * 40, {"columns": "height"}, "columns is 'height'"),
        (ROWS + "41 high\n", {}, "line 41: height is text or inf"),
        ("1\n2\n" * 20 + "3 4\n", {}, "line 41: height is text or inf"),
        ("1\n2\n", {}, "holds 2 values; allowed: at least 16"),
        ("1 5\n2 5\n" * 20, {}, "height ranges from 5.0 to 5.0"),
        (ROWS + "39 1\n", {}, "line 41: x goes from 39.0 to 39.0"),
        (ROWS + "38 1\n", {}, "line 41: x goes from 39.0 to 38.0; .* columns, like 2,1"),
        ("x z\n" + ROWS + "41 nan\n", {}, "line 42: a value is missing, and 1 of 41 in all; allowed: no missing"),
        (ROWS + "inf 3\n", {}, "line 41: x is text or inf in 'inf 3'; allowed: finite numbers up to 1e.100"),
        ("40 -1e101\n" + ROWS[:-5], {}, r"line 1: height is -1e\+101 in '40 -1e101'; .* \(1 of 40 are not\)"),
        (ROWS, {"num_points": 4096}, "num_points is 4096; allowed: up to 640, 16 for each value in the file"),
        (ROWS, {"num_points": 0}, "num_points is 0"),
        ("256\n0.5\n\n" + "1\n2\n" * 20, {}, "line 3 is empty; allowed: rows like '256' in line 1 to the end"),
        ("1\n2\n" * 20 + "\nRa = 3 nm\n", {}, "line 41 is empty; allowed: rows like"),
        (Z, {"scan_length": 0.0}, "scan_length is 0.0"),
        (Z, {"x_unit": "um"}, "x_unit is um"),
        (Z, {"profile_dataset": "z"}, "profile_dataset is z"),
        (np.append(Z, np.nan), {}, "row 41: a value is missing, and 1 of 41"),
        (np.arange(40.0), {}, "straight line"),
        (np.array(["a"] * 20), {}, "holds <U1"),
        (np.array([{}] * 20), {}, "not a plain array"),
    ],
)
def test_bad_files_are_named(tmp_path, content, options, named):
    path = tmp_path / "profile.txt"
    if isinstance(content, str):
        path.write_text(content)
    else:
        path = write(tmp_path, ".npy", [content])
    with pytest.raises(ValueError, match=named):
        read(path, **options)


KINDS = ".csv, .txt, .dat, .asc, .tsv, .npy, .h5, .hdf5, and with `pip install SurfaceTopography` the formats"


@pytest.mark.filterwarnings("ignore:.*:ImportWarning")  # SurfaceTopography's own, where it is installed
@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("missing.txt", "missing.txt: this is not a file; allowed: an existing file$"),
        ("", "is not a file"),
        *((f"damaged.{suffix}", "damaged") for suffix in ("npy", "h5", "opdx")),
        ("damaged.xlsx", rf"damaged\.xlsx: it is damaged, or of no known kind.*allowed: {re.escape(KINDS)}"),
        ("none.h5", "holds no dataset"),
        ("one.h5", "not an array of numbers"),
    ],
)
def test_files_without_numbers_are_named(tmp_path, name, named):
    for path in tmp_path / "damaged.npy", tmp_path / "damaged.h5", tmp_path / "damaged.opdx", tmp_path / "damaged.xlsx":
        path.write_bytes(b"\x93NUMPY or not")
    with h5py.File(tmp_path / "one.h5", "w") as file, h5py.File(tmp_path / "none.h5", "w"):
        file["line"] = h5py.Empty("f8")
    with pytest.raises(ValueError, match=named):
        read(tmp_path / name)
    with pytest.raises(ValueError, match=r"'lime'; allowed: line$"):
        read(write(tmp_path, ".h5", [Z]), profile_dataset="lime")


def test_a_scan_that_names_its_unit(tmp_path, monkeypatch):
    """Converted once, to the scene's unit of length; a second unit is refused."""
    lines = [
        "import numpy as np",
        "class Scan:",
        "    dim, unit, nb_grid_pts = 1, 'µm', (64,)",
        "    positions = staticmethod(lambda: 0.5 * np.arange(64.0))",
        "    heights = staticmethod(lambda: np.sin(np.arange(64.0)))",
        "read_topography = lambda _: Scan",
    ]
    (tmp_path / "SurfaceTopography.py").write_text("\n".join(lines))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))  # of the process that reads
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "scan.xyz"
    path.touch()
    indenter, period, n = read(path, length_unit="mm", window="none", num_points=64)
    assert (period, n) == (pytest.approx(64 * 0.5e-3), 64)
    assert np.ptp(indenter.heights) == pytest.approx(2e-3, rel=0.1)  # tilt removed
    with pytest.raises(ValueError, match=r"z_unit is nm, but .* names um \('its format .µm.'\); allowed: um, or none"):
        read(path, z_unit="nm")


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"x_unit": "furlong"}, "x_unit is 'furlong'; allowed: m, cm, mm, um"),
        ({"length_unit": 1.0}, "length_unit is 1.0"),
        ({"scene_units": True, "scan_length": None}, "scan_length is missing: .*; allowed: .* a number alone in the"),
        ({"profile_convention": "gaps"}, "profile_convention is 'gaps'; allowed: heights, gap"),
        ({"decimal": ","}, "decimal is ','; allowed: point, comma"),
        ({"columns": (1, 2)}, r"columns is \(1, 2\); allowed: text, like '2,3'"),
        ({"num_points": "2^14"}, "num_points is '2\\^14'; allowed: an integer"),
        ({"accuracy": "x"}, "accuracy is 'x'"),
        ({"unit": "um"}, "option is 'unit'; allowed: num_points, x_unit"),
    ],
)
def test_wrong_options_are_named_in_python(tmp_path, options, named):
    path = write(tmp_path, ".csv", [np.random.default_rng(0).random(32)])
    with pytest.raises(ValueError, match=named):
        read_scan(path, **{"scan_length": 1.0, "z_unit": "um"} | options)
    for wrong, shown in ((None, "None"), (b"scan.csv", "b'scan.csv'"), ("", "''"), ("a\0b.csv", r"'a\\x00b.csv'")):
        with pytest.raises(ValueError, match=rf"^path is {shown}; allowed: text or a path"):
            read_scan(wrong)


def test_the_scene_of_a_scan(tmp_path):
    scan = read_scan(write(tmp_path, ".csv", [np.random.default_rng(0).random(32)]), scan_length=1e-3, z_unit="nm")
    layer = Layer(1e-3, contact_modulus=1.0)
    scene = scan.scene(layer, 1e-6)
    assert (scene.period, scene.num_points, scene.pressure) == (scan.period, scan.num_points, 1e-6) == (2e-3, 256, 1e-6)
    assert scan.scene(layer, approach=1e-9).approach == 1e-9
    with pytest.raises(ValueError, match=r"^pressure \(or approach\) is missing; allowed: one of the two"):
        scan.scene(layer)
    for own in (Layer(1e-3), SlidingLayer(1e-3), CoatedHalfSpace(1e-3, 2.0)):
        with pytest.raises(ValueError, match=r"^contact_modulus of the layer is missing; allowed: its E\* must be"):
            scan.scene(own, 1e-6)
    with pytest.raises(ValueError, match=r"^period is 1; allowed: 0.002, for which the heights were given"):
        Scene(layer, scan.indenter, 1e-6, num_points=256)
    with pytest.raises(ValueError, match=r"^given_period is -1"):
        MeasuredIndenter(scan.indenter.heights, given_period=-1, convention="gap")
    assert scan.indenter.in_units(1e3).given_period == pytest.approx(2.0)


LAYER = Layer(thickness=2e-3, poisson_ratio=0.49, contact_modulus=3e6 / (1 - 0.49**2))


@pytest.mark.skipif(not REAL.exists(), reason="no instrument files here")
@pytest.mark.parametrize(
    ("name", "units", "length", "values", "area"),
    [
        ("dektak-1.csv", "um", 1.5e-3, 9600, (0.98964, 1e-4)),
        ("opdx-3.txt", "m", 5e-5, 3001, (0.8886, 2e-3)),
    ],
)
def test_real_scans(name, units, length, values, area):
    """A rubber layer of 2 mm under 0.05 MPa; the areas are those of as many points as are allowed."""
    with pytest.raises(ValueError, match="x_unit and z_unit are missing"):
        read_scan(REAL / name)
    scan = read_scan(REAL / name, x_unit=units, z_unit=units)
    assert scan.indenter.description["profile_values"] == values
    assert scan.period == pytest.approx(2 * length, rel=1e-3)  # mirrored
    assert "taken as even" in scan.indenter.description["profile_steps"]
    solution = solve(scan.scene(LAYER, 5e4))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.observables.contact_area_subgrid == pytest.approx(area[0], abs=area[1])
    assert solution.observables.contact_area_error < 2e-2


@pytest.mark.parametrize("spacing", [1.1, 1.3, 1.4, 2.3, 2.4, 3.4, 33.37])
def test_places_of_rounded_positions_of_which_some_are_missing(spacing):
    """Rounded to whole numbers."""
    x, z = np.rint(spacing * np.arange(400)), np.random.default_rng(7).standard_normal(400)
    there = np.delete(np.arange(400), [150, 151, 250])
    found = preparation.evenly_spaced(x[there], z[there])
    if spacing == 1.1:  # as whole numbers with gaps, which it cannot be told from
        assert "43 missing" in found.steps[0]
        assert found.doubts[0].startswith("9.8% of the scan")
        return
    if spacing < 3:  # a step of 2 may be one place or two
        assert "interpolated linearly" in found.steps[0]
        return
    assert found.z.size == 400
    assert " 3 missing" in found.steps[0]
    np.testing.assert_array_equal(found.z[there], z[there])
