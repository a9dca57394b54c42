"""Profiles from files: every format and convention, what is done to them, and what is refused."""

import math
from pathlib import Path

import h5py
import numpy as np
import pytest
from linecontact.solver import Layer, Scene, Status, solve
from linecontact.studies.files import scans

REAL = Path(__file__).parents[2] / "shared" / "data"


def read(path, **options):
    return scans.read(scans.Options(path, **options))


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
        indenter, period, n = read(write(tmp_path, suffix, columns))
        assert (period, n) == (length, 64)
        np.testing.assert_allclose(indenter.heights, heights - heights.min(), atol=1e-18)
        assert indenter.description["profile_values"] == 64
        assert "shifted to h >= 0" in indenter.description["profile_steps"]


def test_conventions_and_units(tmp_path, heights):
    path = write(tmp_path, ".txt", [np.arange(64.0), heights])
    scan, period, _ = read(path, profile_convention="heights", x_unit="um", z_unit="nm", length_unit="mm")
    assert period == pytest.approx(64e-3)
    np.testing.assert_allclose(scan.heights, 1e-6 * (heights.max() - heights), atol=1e-18)
    only_z = read(path, z_unit="um", length_unit="m")
    assert only_z[1] == 64
    np.testing.assert_allclose(only_z[0].heights, 1e-6 * (heights - heights.min()), atol=1e-18)


def test_any_number_of_values_and_points(tmp_path):
    """A band-limited profile keeps its heights at odd numbers, whether taken as it is or resampled."""
    x = np.arange(41) / 41
    path = write(tmp_path, ".npy", [np.cos(2 * np.pi * x) + 0.1 * np.sin(8 * np.pi * x)])
    whole, _, n = read(path, num_points=41)
    assert n == 41
    fine, _, _ = read(path, num_points=123, detrend="none", window="none")
    np.testing.assert_allclose(fine.heights[::3] - fine.heights[0], whole.heights - whole.heights[0], atol=1e-13)
    assert solve(Scene(indenter=fine, num_points=123)).status is Status.CONVERGED


def test_resampling_keeps_a_band_limited_profile(tmp_path, heights):
    path = write(tmp_path, ".npy", [heights])
    indenter, _, n = read(path, num_points=256, detrend="none", window="none", period=2.0)
    assert n == 256
    x = np.arange(256) / 256
    exact = 1e-3 * (np.sin(2 * np.pi * x) + 0.3 * np.cos(6 * np.pi * x))
    np.testing.assert_allclose(indenter.heights, exact - exact.min(), atol=1e-15)
    assert "resampled from 64 to 256" in indenter.description["profile_steps"]
    assert read(path, num_points=256, period=2.0)[1] == 2.0


def test_the_highest_wave_of_an_odd_count_survives(tmp_path):
    i = np.arange(101)
    path = write(tmp_path, ".npy", [np.cos(2 * np.pi * 50 * i / 101)])
    indenter, _, _ = read(path, num_points=202, detrend="none", window="none")
    assert np.ptp(indenter.heights) == pytest.approx(2, rel=1e-2)


def test_tilt_and_window(tmp_path):
    tilted = 0.01 * np.arange(100.0) + np.random.default_rng(0).standard_normal(100)
    path = write(tmp_path, ".csv", [tilted])
    assert "mirror" in read(path)[0].description["profile_steps"]  # the default
    indenter, _, n = read(path, window="tukey")
    assert n == 128
    steps = indenter.description["profile_steps"]
    assert "tilt of" in steps
    assert "tukey" in steps
    assert "resampled from 100 to 128" in steps
    # the ends meet
    h = indenter.heights
    assert abs(h[0] - h[-1]) < 0.1 * np.ptp(h)
    hann, _, _ = read(path, window="hann")
    assert "hann" in hann.description["profile_steps"]
    mirrored, period, n = read(path, num_points=200, resample=True, window="mirror", period=3.0)
    assert (period, n) == (3.0, 200)
    assert read(path, window="mirror")[2] == 256
    assert read(write(tmp_path, ".txt", [np.arange(100.0), tilted]), window="mirror")[1] == pytest.approx(200)
    np.testing.assert_allclose(mirrored.heights, mirrored.heights[::-1], atol=1e-12)
    as_it_is, _, _ = read(path, num_points=100)
    np.testing.assert_allclose(as_it_is.heights, tilted - tilted.min())
    asked, _, _ = read(path, num_points=100, detrend="linear")
    slope = np.polyfit(np.arange(100.0), asked.heights, 1)[0]
    assert abs(slope) < 1e-12


def test_uneven_positions_are_interpolated(tmp_path):
    x = np.sort(np.random.default_rng(1).random(200))
    indenter, period, _ = read(write(tmp_path, ".txt", [x, (x - 0.5) ** 2]), num_points=200)
    assert "interpolated linearly" in indenter.description["profile_steps"]
    even = np.linspace(x[0], x[-1], 200)
    h = (even - 0.5) ** 2
    np.testing.assert_allclose(indenter.heights, h - h.min(), atol=2e-3)  # gaps of up to 0.03 between positions
    assert period == pytest.approx((x[-1] - x[0]) * 200 / 199)
    rounded = np.round(0.156 * np.arange(200), 1)
    indenter, period, _ = read(write(tmp_path, ".txt", [rounded, x]), num_points=200)
    assert "taken as even" in indenter.description["profile_steps"]
    assert period == pytest.approx(0.156 * 200, rel=2e-3)


def test_headers_and_line_ends(tmp_path):
    path = tmp_path / "scan.csv"
    rows = "".join(f"{0.1 * i:.1f},{math.sin(i):.5f},,\r\n" for i in range(32))
    path.write_bytes(b"Scan,Standard\r\nStylus,2.5 \xb5m\r\n7\r\nx,z\r\n" + rows.encode() + b"\r\n\r\n")
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())  # a byte order mark is no header
    indenter, period, n = read(path)
    assert n == 32
    assert period == pytest.approx(3.2)
    assert "4 lines of header" in indenter.description["profile_steps"]


def text(content):
    def make(folder):
        path = folder / "profile.txt"
        path.write_text(content)
        return path

    return make


def no_dataset(folder):
    h5py.File(folder / "profile.h5", "w").close()
    return folder / "profile.h5"


def empty_dataset(folder):
    with h5py.File(folder / "empty.h5", "w") as file:
        file["line"] = h5py.Empty("f8")
    return folder / "empty.h5"


ROWS = "".join(f"{i} {i % 7}\n" for i in range(40))


@pytest.mark.parametrize(
    ("make", "options", "named"),
    [
        (lambda folder: folder / "missing.txt", {}, "missing.txt, which is not a file"),
        (lambda folder: folder, {}, "is not a file"),
        (text(""), {}, "no table of numbers"),
        (text("a b\nc d\n"), {}, "no table of numbers"),
        (text("1 2 3\n" * 40), {}, "has 3 columns"),
        (text(ROWS + "41 high\n"), {}, "line 41: '41 high' is not 2 numbers"),
        (text(ROWS + "41\n"), {}, "line 41"),
        (text("1\n2\n"), {}, "holds 2 values; allowed: at least 16"),
        (text("1_0 2\n2_0 3\n" * 20), {}, "allowed: plain numbers"),
        (text("1 5\n2 5\n" * 20), {}, "every height is 5.0"),
        (text(ROWS + "39 1\n"), {}, "x goes from 39.0 to 39.0 at value 41"),
        (text(ROWS + "38 1\n"), {}, "x goes from 39.0 to 38.0"),
        (text(ROWS + "41 nan\n"), {}, "height number 41 is not finite"),
        (text(ROWS + "inf 3\n"), {}, "x number 41 is not finite"),
        (text(ROWS), {"num_points": 4096}, "num_points is 4096; allowed: up to 16 times the 40 values"),
        (text(ROWS), {"period": 3.0}, "period is 3.0; allowed: none"),
        (text(ROWS), {"num_points": 0}, "num_points is 0"),
        (text(ROWS), {"num_points": -4}, "num_points is -4"),
        (lambda folder: write(folder, ".npy", [np.arange(40.0) % 7]), {"period": 0.0}, "period is 0.0"),
        (lambda folder: write(folder, ".npy", [np.arange(40.0) % 7]), {"x_unit": "um"}, "x_unit is um"),
        (lambda folder: write(folder, ".npy", [np.append(np.arange(40.0), np.nan)]), {}, "height number 41 is not"),
        (lambda folder: write(folder, ".npy", [np.arange(40.0)]), {}, "straight line"),
        (empty_dataset, {}, "not an array of numbers"),
        (no_dataset, {}, "holds no dataset"),
        (lambda folder: write(folder, ".npy", [np.arange(40.0) % 7]), {"profile_dataset": "z"}, "profile_dataset is z"),
        (text("256\n0.5\n\n" + "1\n2\n" * 20), {}, "line 3 is empty"),
        (lambda folder: write(folder, ".npy", [np.array(["a"] * 20)]), {}, "holds <U1"),
        (lambda folder: write(folder, ".npy", [np.array([{}] * 20)]), {}, "not a plain array"),
        (
            lambda folder: write(folder, ".h5", [np.arange(20.0)]),
            {"profile_dataset": "lime"},
            "'lime'; allowed: line, of",
        ),
    ],
)
def test_bad_files_are_named(tmp_path, make, options, named):
    with pytest.raises(ValueError, match=named):
        read(make(tmp_path), **options)


@pytest.mark.filterwarnings("ignore:.*:ImportWarning")  # SurfaceTopography's own, where it is installed
@pytest.mark.parametrize("suffix", [".npy", ".h5", ".opdx"])
def test_damaged_files_are_named(tmp_path, suffix):
    path = tmp_path / f"damaged{suffix}"
    path.write_bytes(b"\x93NUMPY or not")
    with pytest.raises(ValueError, match="damaged"):
        read(path)


def test_a_scan_that_names_its_unit(tmp_path, monkeypatch):
    """Converted once, to the scene's unit of length; a second unit is refused."""
    heights = np.sin(np.arange(64.0))
    lines = [
        "import numpy as np",
        "class Scan:",
        "    dim, unit, nb_grid_pts = 1, 'µm', (64,)",
        "    positions = staticmethod(lambda: 0.5 * np.arange(64.0))",
        "    heights = staticmethod(lambda: np.sin(np.arange(64.0)))",
        "read_topography = lambda _: Scan",
    ]
    (tmp_path / "SurfaceTopography.py").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))  # of the process that reads
    path = tmp_path / "scan.xyz"
    path.touch()
    indenter, period, n = read(path, length_unit="mm", window="none")
    assert (period, n) == (pytest.approx(64 * 0.5e-3), 64)
    assert np.ptp(indenter.profile(64, period)) * period == pytest.approx(
        1e-3 * np.ptp(heights), rel=0.1
    )  # tilt removed
    with pytest.raises(ValueError, match=r"z_unit is nm; allowed: none, .* names its unit, um"):
        read(path, z_unit="nm")


@pytest.mark.skipif(not REAL.exists(), reason="no instrument files here")
@pytest.mark.parametrize(("name", "period", "values"), [("dektak-1.csv", 3000.0, 9600), ("opdx-3.txt", 1e-4, 3001)])
def test_real_scans(name, period, values):
    indenter, length, n = read(REAL / name, profile_convention="heights")
    assert indenter.description["profile_values"] == values
    assert length == pytest.approx(period, rel=1e-3)  # mirrored
    assert "taken as even" in indenter.description["profile_steps"]
    solution = solve(Scene(Layer(), indenter, 1e-4, length, n))
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert 0 < solution.observables.contact_area_subgrid < 0.5
