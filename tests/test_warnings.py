"""What a solution says of itself without being asked: warnings, patches, its width; and files by name alone."""

import json
import math
from dataclasses import replace
from pathlib import Path

import linecontact
import numpy as np
import pytest
from linecontact.solver import Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene, Status, solve
from linecontact.solver.warnings import WarningKind
from linecontact.studies.command_line import main

UNSETTLED = Scene(Layer(1e-3), RoughIndenter(seed=2, cut_off_ratio=1 / 64), 5e-6, num_points=2**11)
EXAMPLE = Path(__file__).parent.parent / "docs" / "examples" / "scan.csv"


def kinds(scene, **options):
    return [warning.kind for warning in solve(scene, **options).warnings]


def rough(**changes):
    given = {"cut_off_ratio": 1 / 16, "rms_gradient": 0.01, **changes}
    return Scene(indenter=RoughIndenter(**given), pressure=1e-4, num_points=2**14)


def test_a_resolved_contact_needs_no_warning():
    assert kinds(Scene(num_points=2**12)) == []
    assert kinds(rough()) == []


def test_each_kind_has_its_scene():
    assert WarningKind.GRID in kinds(Scene(num_points=64, pressure=1e-8, indenter=PowerIndenter(1.5)))  # one node
    assert WarningKind.ERROR in kinds(Scene(Layer(1e-3), num_points=64, pressure=1e-4))
    assert WarningKind.SLOPE in kinds(replace(rough(rms_gradient=1.0), pressure=1e-2))
    assert WarningKind.STRAIN in kinds(Scene(pressure=0.2, num_points=2**10))
    assert WarningKind.FULL in kinds(replace(rough(), pressure=0.02))
    assert WarningKind.ESTIMATE in kinds(UNSETTLED)


def test_an_approach_that_says_less_than_its_error_is_warned_of():
    for points, warned in ((2**11, True), (2**13, False)):
        solution = solve(UNSETTLED.on_grid(points))
        found = solution.observables
        assert (found.approach_error > found.approach) == warned
        said = [warning.text for warning in solution.warnings if warning.kind == WarningKind.ESTIMATE]
        assert len(said) == warned
        assert all("approach is larger than the value" in text and "more num_points" in text for text in said)
    unknown = solve(UNSETTLED, nested=False)
    assert unknown.observables.approach_error == math.inf  # which is said already, and no warning
    assert WarningKind.ESTIMATE not in {warning.kind for warning in unknown.warnings}


@pytest.mark.parametrize("nu", [0.25, 0.45, 0.49, 0.499, 0.5])
def test_strains_of_thin_layers(nu):
    """A confined layer takes pressures beyond E*, but neither large compressions nor much shear at its base."""
    for load in np.geomspace(1e-3, 30, 8):
        scene = Scene(Layer(0.01, nu), PowerIndenter(), load, num_points=2**10)
        solution = solve(scene)
        warned = WarningKind.STRAIN in [warning.kind for warning in solution.warnings]
        compression = (solution.observables.approach - solution.displacement[scene.num_points // 2]) / 0.01
        assert warned or compression < 0.1
        assert not warned or compression > 0.01  # a hundredth, with ten times as much shear
    confined = solve(Scene(Layer(0.01, 0.4999), PowerIndenter(radius=1000.0), 0.2, num_points=2**12))
    assert confined.observables.peak_pressure > 0.5
    assert WarningKind.STRAIN not in [warning.kind for warning in confined.warnings]


def test_patches_of_few_nodes_whose_ends_are_known_need_no_warning():
    scene = Scene(Layer(), RoughIndenter(0.8, 1, 1 / 8, 1 / 16), 0.002, num_points=2**10)
    found = solve(scene)
    assert found.patches.nodes[found.patches.nodes < 3].sum() > 0.2 * found.patches.nodes.sum()
    assert WarningKind.GRID not in {warning.kind for warning in found.warnings}
    truth = solve(scene.on_grid(2**14)).observables.contact_area_subgrid
    assert found.observables.contact_area_subgrid == pytest.approx(truth, rel=0.01)


def test_what_a_scan_does_not_resolve():
    """White noise, resampled to eight points for every value: each peak carries load on its own."""
    values = np.random.default_rng(0).standard_normal(256)
    modes = np.zeros(1025, dtype=complex)
    modes[:128] = np.fft.rfft(values)[:128]
    heights = 1e-5 * np.fft.irfft(modes, 2048) * 8
    scene = Scene(indenter=MeasuredIndenter(heights, 256, convention="gap"), pressure=2e-4, num_points=2048)
    assert WarningKind.SCAN in kinds(scene)
    assert WarningKind.SCAN not in kinds(replace(scene, indenter=MeasuredIndenter(heights, 2048, convention="gap")))


def test_a_grid_coarser_than_the_scan():
    """A scan that was resampled to fewer points than it has values: what it lost may have carried the load."""
    heights = 1e-5 * RoughIndenter(0.8, 0, 1 / 8, 1 / 8).profile(256, 1.0)
    assert WarningKind.WAVES in kinds(
        Scene(indenter=MeasuredIndenter(heights, 1024, convention="gap"), pressure=1e-6, num_points=256)
    )
    assert WarningKind.WAVES not in kinds(
        Scene(indenter=MeasuredIndenter(heights, convention="gap"), pressure=1e-6, num_points=256)
    )


def test_patches_add_up():
    solution = solve(replace(rough(), period=3.0))
    patches, found = solution.patches, solution.observables
    assert patches.left.size == found.num_patches > 3
    np.testing.assert_allclose(patches.width, patches.right - patches.left)
    assert patches.width.sum() == pytest.approx(3.0 * found.contact_area_subgrid)
    assert patches.load.sum() / 3.0 == pytest.approx(1e-4)
    assert patches.nodes.sum() == solution.contact.sum()
    assert patches.peak_pressure.max() == found.peak_pressure
    assert (patches.left[1:] > patches.right[:-1]).all()


def test_a_patch_across_the_end_of_the_period():
    heights = 0.5 * (1 - np.cos(2 * np.pi * np.arange(512) / 512)) * 1e-2  # lowest at node 0
    patches = solve(Scene(indenter=MeasuredIndenter(heights, convention="gap"), pressure=1e-4, num_points=512)).patches
    assert patches.left.size == 1
    assert 0 < patches.left[0] < 1 < patches.right[0]
    assert patches.left[0] + patches.right[0] == pytest.approx(2)


@pytest.mark.parametrize("lowest", [0, 1, 511])
def test_patches_begin_within_the_period(lowest):
    heights = 0.5 * (1 - np.cos(2 * np.pi * (np.arange(512) - lowest) / 512)) * 1e-2
    patches = solve(Scene(indenter=MeasuredIndenter(heights, convention="gap"), pressure=1e-7, num_points=512)).patches
    assert (patches.left >= 0).all()
    assert (patches.left < 1).all()
    off = (patches.left + patches.right) / 2 - lowest / 512
    np.testing.assert_allclose((off + 0.5) % 1 - 0.5, 0, atol=1e-9)


def test_files_by_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    solution = linecontact.solve(Scene(num_points=2**10))
    solution.save("run.h5")
    stored = linecontact.load("run.h5")
    np.testing.assert_array_equal(stored.contact_pressure, solution.contact_pressure)
    assert stored.results["contact_width"] == solution.contact_width
    with pytest.raises(ValueError, match=r"run.h5 exists"):
        solution.save("run.h5")
    solution.save("run.h5", overwrite=True)
    with pytest.raises(ValueError, match=r"none.h5 does not exist"):
        linecontact.load("none.h5")
    (tmp_path / "text.h5").write_text("no HDF5")
    with pytest.raises(ValueError, match=r"text\.h5"):
        linecontact.load("text.h5")


def test_youngs_modulus_instead_of_the_contact_modulus():
    assert Layer(poisson_ratio=0.5, youngs_modulus=3.0).contact_modulus == 4.0
    assert replace(Layer(youngs_modulus=3.0), thickness=0.1).contact_modulus == 3.0 / (1 - 0.25**2)
    for modulus in (1.0, 2.0):
        with pytest.raises(ValueError, match=r"youngs_modulus is 3.0, and contact_modulus .*; allowed: one of the two"):
            Layer(youngs_modulus=3.0, contact_modulus=float(str(modulus)))
    with pytest.raises(ValueError, match=r"youngs_modulus is 0"):
        Layer(youngs_modulus=0.0)


def run(capsys, *words):
    status = main.main(["solve", *map(str, words)])
    return status, capsys.readouterr()


def test_a_file_keeps_the_warnings(tmp_path):
    solution = solve(Scene(indenter=PowerIndenter(1.5), num_points=2**8, pressure=1e-4))
    solution.save(tmp_path / "run.h5")
    found = linecontact.load(tmp_path / "run.h5")
    assert found.warnings.keys() == {"grid", "error"}
    assert found.warnings == {str(warning.kind): warning.text for warning in solution.warnings}
    assert "warning, grid: " in repr(found)
    assert "half-space" in repr(found)


def test_warnings_on_the_command_line(tmp_path, capsys):
    words = ("--exponent", "1.5", "--num-points", "2^8", "--pressure", "1e-4")
    status, shown = run(capsys, *words)
    assert status == 0
    assert "converged on its grid, a_r = " in " ".join(shown.out.split())
    assert "Warning, grid: " in shown.out
    status, shown = run(capsys, *words, "--strict")
    assert status == 3
    assert "linecontact: strict, and there are warnings: grid, error" in shown.err
    _, shown = run(capsys, *words, "--json")
    record = json.loads(shown.out)
    assert record["status"] == str(Status.CONVERGED)
    assert set(record["warnings"]) == {"grid", "error"}
    assert record["contact_width"] == record["contact_area_subgrid"]


def test_patches_as_a_file(tmp_path, capsys):
    words = ("--profile", "rough", "--pressure", 0.01, "--num-points", "2^13", "--cut-off-ratio", 0.05, "--json")
    status, shown = run(capsys, *words, "--patches", tmp_path / "patches.csv")
    assert status == 0
    head, *lines = (tmp_path / "patches.csv").read_text().splitlines()
    assert head.startswith("left [length],right [length],width [length],nodes [-],load [pressure times length]")
    assert len(lines) == json.loads(shown.out)["num_patches"]
    assert sum(float(line.split(",")[4]) for line in lines) == pytest.approx(0.01)
    (tmp_path / "mine.csv").write_text("left,right\n")
    for name, expected in (("patches.csv", 0), ("mine.csv", 2)):  # a table of linecontact's, and another one
        status, shown = run(capsys, *words, "--patches", tmp_path / name)
        assert status == expected
    assert "mine.csv exists" in shown.err
    scan = (
        "--profile",
        "file",
        "--profile-file",
        EXAMPLE,
        "--length-unit",
        "um",
        "--contact-modulus",
        1,
        "--pressure",
        1,
    )
    assert run(capsys, *scan, "--patches", tmp_path / "scan.csv")[0] == 0
    head, *_ = (tmp_path / "scan.csv").read_text().splitlines()
    assert head.startswith("left [um],right [um],width [um],nodes [-],load [pressure times um],peak_pressure [pressure")


def random_scene(rng):
    """A scene on a grid that may be fine enough for it or not: power, rough, noise or steps."""
    n = 2 * int(2 ** rng.uniform(7, 13))
    layer = Layer(
        float(rng.choice([math.inf, 10 ** rng.uniform(-5, 0.5)])), float(rng.choice([0, 0.25, 0.4, 0.49, 0.5]))
    )
    kind, load = rng.choice(["power", "rough", "noise", "steps"]), float(10 ** rng.uniform(-4, 0.3))
    if kind == "power":
        indenter = PowerIndenter(float(rng.choice([1.2, 1.5, 2, 3, 4, 6])), float(10 ** rng.uniform(-1, 1)))
        return Scene(layer, indenter, load, num_points=n)
    if kind == "rough":
        longest, gradient = float(rng.choice([1 / 2, 1 / 4, 1 / 8])), float(10 ** rng.uniform(-3, 0))
        shortest = max(4, int(n / rng.uniform(2.2, 64)))
        seed, cut_off = int(rng.integers(10**6)), min(1.0, 1 / shortest / longest)
        indenter = RoughIndenter(float(rng.uniform(0.2, 1)), seed, longest, cut_off, gradient)
        return Scene(layer, indenter, load * gradient, num_points=n)
    values = rng.standard_normal(int(n / rng.uniform(1, 8)) if kind == "noise" else n // 8)
    values = np.cumsum(values) if rng.random() < 0.5 else values
    values = values - np.linspace(values[0], values[-1], values.size)
    values = np.sign(values) if kind == "steps" else values
    modes = np.zeros(n // 2 + 1, dtype=complex)
    known = np.fft.rfft(np.concatenate([values, values[::-1]]))[: modes.size]
    modes[: known.size] = known
    heights, size = np.fft.irfft(modes, n), float(10 ** rng.uniform(-6, -2))
    indenter = MeasuredIndenter(size * heights / np.ptp(heights), min(n, 2 * values.size), convention="gap")
    return Scene(layer, indenter, 10 * size * load, num_points=n)


@pytest.mark.slow
def test_areas_that_are_off_carry_a_warning():
    """Against eight times as many points: nearly all that are off by more than 5 %, and few of those within 1 %.

    Of other seeds than those by which the limits were set.
    """
    off, good = [], []
    for seed in range(10_000, 10_500):
        scene = random_scene(np.random.default_rng(seed))
        found, fine = solve(scene), solve(scene.on_grid(8 * scene.num_points))
        if not found.status == fine.status == Status.CONVERGED:
            continue
        error = abs(found.observables.contact_area_subgrid / fine.observables.contact_area_subgrid - 1)
        warned = {warning.kind for warning in found.warnings} & {WarningKind.GRID, WarningKind.ERROR}
        if error > 0.05 or error < 0.01:
            (off if error > 0.05 else good).append(bool(warned))
    said = f"of the {len(off)} areas that were off by more than 5 %, {sum(off)} had a warning of grid or error, and so "
    said += f"had {100 * np.mean(good):.0f} % of the {len(good)} within 1 %"
    print(said)
    assert said in " ".join((Path(__file__).parent.parent / "docs" / "scans.md").read_text().split())
    assert np.mean(off) > 0.95
    assert np.mean(good) < 0.2
