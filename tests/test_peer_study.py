"""The study of the nearest peers, with and without them: the yardstick, the comparison, the table and the figure."""

import importlib.util
import io
import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from linecontact.solver import Layer, PowerIndenter, RoughIndenter, Scene, solve
from linecontact.studies.files import study_files
from linecontact.studies.peers import areas, figures, report
from linecontact.studies.peers import solvers as peer_solvers
from linecontact.studies.peers import study as peers
from linecontact.studies.runner import drawing
from rich.console import Console
from running import run_plans

TINY = {"sizes": (10, 11), "hertz": (math.inf,), "rough": (0.01,), "hursts": (0.8,)}


def text(part):
    output = io.StringIO()
    Console(file=output, width=80).print(part)
    return output.getvalue()


def rows_of(table):
    lines = (line.strip() for line in text(table).splitlines())
    return [line.split() for line in lines if line.startswith(("Hertz", "H=", "2^"))]


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The study's file where no peer is installed."""
    folder = tmp_path_factory.mktemp("peers")
    plan = peers.Configuration(**TINY, peers=()).plan()
    assert run_plans(peers.STUDY, [plan], folder) == 0
    return plan.path(folder)


@pytest.fixture
def made_up(alone):
    """A peer that agrees in the first half of the scenes, ten times slower, and has 3 nodes more in the others."""
    study = study_files.load_study(alone)
    study.configuration["peers"] = ["tamaas"]
    for k, run in enumerate(list(study.runs)):
        seconds = {f"seconds.{what}": factor * run[f"seconds.{what}"] for what, factor in (("solve", 10), ("total", 5))}
        theirs = {"solver": "tamaas", "version": "0"} | seconds
        study.runs.append(run | theirs | {"nodes": run["nodes"] + (3 if k % 2 else 0)})
    return study


@pytest.mark.parametrize("layer", [Layer(math.inf), Layer(0.01, 0.4, 3.0)])
def test_gap_of_a_known_pressure(layer):
    """Under sigma = p (1 + cos qx), contact everywhere, the surface is p cos(qx)/K(q) plus a constant."""
    n, k, p, period = 256, 3, 0.02, 2.0
    scene = Scene(layer, PowerIndenter(), p, period, n)
    q = 2 * np.pi * k / period
    wave = np.cos(q * scene.x)
    stiffness = layer.contact_modulus * q / 2
    if math.isfinite(layer.thickness):
        y, nu = q * layer.thickness, layer.poisson_ratio
        bracket = (3 - 4 * nu) * np.cosh(2 * y) + 2 * y**2 - 4 * nu * (3 - 2 * nu) + 5
        stiffness *= bracket / ((3 - 4 * nu) * np.sinh(2 * y) - 2 * y)
    pressure = p * (1.001 + wave)
    gap = scene.profile + p * wave / stiffness
    gap -= (pressure @ gap) / pressure.sum()
    expected = np.sqrt(np.mean(gap**2)) / scene.profile.std()
    assert peer_solvers.gap_rms(scene, pressure) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("scene", [Scene(num_points=1024), Scene(Layer(0.01), num_points=1024)])
def test_gap_of_a_solution_and_of_what_is_none(scene):
    pressure = solve(scene).contact_pressure
    assert peer_solvers.gap_rms(scene, pressure) < 5e-9
    wrong = pressure * (1 + 1e-6 * np.cos(np.arange(1024)))
    assert peer_solvers.gap_rms(scene, wrong) > 1e3 * peer_solvers.gap_rms(scene, pressure)
    other = Scene(Layer(0.1), num_points=1024)
    assert peer_solvers.gap_rms(other, pressure) > 1e-5  # the layer counts
    assert peer_solvers.gap_rms(scene, 0 * pressure) == math.inf
    for bad in (pressure[1:], np.full(1024, np.nan)):
        with pytest.raises(ValueError, match=r"contact_pressure .* allowed: 1024 finite"):
            peer_solvers.gap_rms(scene, bad)


def test_the_loosest_tolerance_that_keeps_the_gap(monkeypatch):
    """A made-up peer with an error of 3 times its tolerance; and one that never gets there."""
    scene, floor = Scene(num_points=1024), 0.0
    exact = solve(scene).contact_pressure
    wrong = exact * (1 + np.cos(np.arange(1024)))
    per_share = peer_solvers.gap_rms(scene, exact + 1e-6 * (wrong - exact)) / 1e-6

    def solve_badly(peer, scene, tolerance, progress=None):
        share = max(3 * tolerance, floor) / per_share
        return peer_solvers.PeerResult(exact + share * (wrong - exact), tolerance, 0.0, math.nan, "0")

    monkeypatch.setattr(peer_solvers, "solve", solve_badly)
    for limit in (1e-6, 1e-7):
        result, tolerance = peer_solvers.at_gap("tamaas", scene, limit)
        assert tolerance == limit / 4  # 3/4 of the limit; twice that is above it
        assert peer_solvers.gap_rms(scene, result.contact_pressure) <= limit
    floor = 1e-6
    result, tolerance = peer_solvers.at_gap("tamaas", scene, 1e-7)
    assert tolerance < 2e-12
    assert peer_solvers.gap_rms(scene, result.contact_pressure) > 1e-7


def test_without_peers(alone):
    study = study_files.load_study(alone)
    assert study.complete
    assert study.configuration["peers"] == []
    assert [run["scene.num_points"] for run in study.runs] == [2**10, 2**10, 2**11, 2**11]
    assert (study.column("gap_rms") < 5e-9).all()
    assert (study.column("nodes") == study.column("contact_area") * study.column("scene.num_points")).all()
    hertz = study.select("name", "Hertz")
    assert (np.abs(hertz.column("spacings_off.counted")) < 2).all()
    assert (np.abs(hertz.column("spacings_off.subgrid")) < 0.01).all()
    assert [row[-2:] for row in rows_of(report.summary(study))] == [["-", "-"]] * 2


def test_missing_peers_are_named(monkeypatch, capsys):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(peers, "run_study", lambda study, options: asked.extend(study.plans(options)) or 0)
    asked = []
    assert peer_solvers.available() == ()
    assert peers.command(peers.Options(quick=True)) == 0
    assert asked[0].configuration["peers"] == ()
    assert {task.solver for task in asked[0].tasks} == {peers.OURS}
    said = capsys.readouterr().err.splitlines()
    assert len(asked) == 1  # the lines only
    assert [line.split()[0] for line in said] == [*peer_solvers.PEERS, areas.ASPHER]
    assert all("pip install" in line for line in said)


@pytest.fixture
def made_up_areas(monkeypatch):
    """An ASPHER that has no more than its interface: it notes what it is given, and fails in double precision."""
    given = []

    def solve_nested(**arguments):
        given.append(arguments)
        good = arguments["precision"] != "double"
        return SimpleNamespace(status=f"Status.{'Converged' if good else 'IterationLimit'}", contact_area=0.02)

    monkeypatch.setitem(sys.modules, "aspher", SimpleNamespace(solve_nested=solve_nested))
    monkeypatch.setattr(areas, "version", lambda name: "0.1")
    monkeypatch.setattr(areas, "_REPEATS", 2)
    return given


def test_the_time_of_a_point_beside_that_of_areas(made_up_areas, tmp_path):
    plan = areas.Configuration(sizes=(12,)).plan()
    assert run_plans(peers.STUDY, [plan], tmp_path) == 3  # something did not converge
    study = study_files.load_study(plan.path(tmp_path))
    assert [run["status"] for run in study.runs] == ["converged", "stagnated", "converged"]
    for run in study.runs:
        assert run["points"] == 2**12
        assert run["microseconds_per_point"] == pytest.approx(run["seconds.total"] / 2**12 * 1e6)
    (gap, *more) = [arguments["gap"].reshape(64, 64) for arguments in made_up_areas]
    assert all((other == gap).all() for other in more)
    assert gap.min() == 0
    slopes = [np.fft.ifft(2j * np.pi * np.fft.fftfreq(64, 1 / 64) * np.fft.fft(g)).real for g in (gap, gap.T)]
    assert sum(np.mean(s**2) for s in slopes) == pytest.approx(1)
    table = text(report.report({areas.KIND: study}, tmp_path)[0])
    assert max(map(len, table.splitlines())) <= 80
    (row,) = rows_of(report.report({areas.KIND: study}, tmp_path)[0])
    ours, theirs = (study.runs[k]["microseconds_per_point"] for k in (0, 2))
    assert row[:5] == ["2^12", f"{ours:.2f}", "-", f"{theirs:.2f}", f"{theirs / ours:.2g}"]


def test_with_areas(tmp_path):
    pytest.importorskip("aspher")
    plan = areas.Configuration(sizes=(12,)).plan()
    assert run_plans(peers.STUDY, [plan], tmp_path) == 0
    runs = study_files.load_study(plan.path(tmp_path)).runs
    assert [run["status"] for run in runs] == ["converged"] * 3
    assert all(0.005 < run["contact_area"] < 0.05 for run in runs)


def test_a_missing_peer_is_refused(monkeypatch):
    monkeypatch.setattr(peer_solvers, "available", lambda: ())
    for peer in ("tamaas", "nobody"):
        with pytest.raises(ValueError, match=rf"peer is '{peer}'; allowed: .*pip install tamaas"):
            peer_solvers.solve(peer, Scene(num_points=64), 1e-8)


def test_a_disagreement_is_shown_and_its_ratio_is_not(made_up):
    first, second = (c for c in report.comparisons(made_up) if c.ours["scene.num_points"] == 2**11)
    assert first.agrees("tamaas")
    assert not second.agrees("tamaas")
    assert second.off("tamaas") == (3, 0.0)
    assert (first.fastest, second.fastest) == ("tamaas", None)
    table = text(report.summary(made_up))
    rows = rows_of(report.summary(made_up))
    assert [(row[3], *row[-2:]) for row in rows] == [("+0", "10", "5"), ("+3", "differ", "differ")]
    assert max(map(len, table.splitlines())) <= 80
    assert "…" not in table
    assert report.remarks(made_up)[0].startswith("Rms gap inside the contact over the rms height: at most ")
    lines = [line for line in report.remarks(made_up) if "disagrees" in line]
    assert len(lines) == 2  # on both grids
    assert all("tamaas disagrees on H=0.8, d/L = 0.01" in line and "+3 nodes" in line for line in lines)
    for name, value in (("peak_pressure", 1.001 * first.ours["peak_pressure"]), ("gap_rms", 1e-8)):
        for which in ("tamaas", peers.OURS):
            runs = {peers.OURS: dict(first.ours), "tamaas": dict(first.peers["tamaas"])}
            runs[which][name] = value
            assert not report.Comparison(runs.pop(peers.OURS), runs).agrees("tamaas")


def test_the_figure_holds_the_stored_times(made_up, tmp_path):
    path = tmp_path / "peers.h5"
    study_files.save_study(path, made_up)
    assert [file.suffix for file in drawing.draw(path)] == [".png", ".pdf"]
    (figure,) = figures.draw(path).values()
    for axes, name, hollow in zip(figure.axes, ("Hertz", "H=0.8"), (False, True), strict=True):
        lines = [line for line in axes.get_lines() if line.get_linestyle() == "-" and len(line.get_xdata())]
        for line, solver in zip(lines, (peers.OURS, "tamaas"), strict=True):
            runs = made_up.select("name", name).select("solver", solver)
            np.testing.assert_array_equal(line.get_xdata(), runs.column("scene.num_points"))
            np.testing.assert_array_equal(line.get_ydata(), runs.column("seconds.solve"))
        filled = [line for line in axes.get_lines() if line.get_linestyle() == "None" and len(line.get_xdata())]
        assert [any(line.get_markevery()) for line in filled] == [True, not hollow]


@pytest.mark.filterwarnings("ignore")  # the peers' own
@pytest.mark.parametrize("peer", peer_solvers.PEERS)
@pytest.mark.parametrize(
    "scene",
    [
        Scene(num_points=1024),
        Scene(Layer(0.1, 0.25, 2.0), PowerIndenter(2.0, 3.0), 5e-3, 2.0, 1024),
        Scene(Layer(0.01), RoughIndenter(0.8, cut_off_ratio=1 / 16), 1e-2, num_points=1024),
    ],
    ids=["half-space", "units", "rough"],
)
def test_with_a_peer(peer, scene):
    pytest.importorskip(peer)
    told = []
    result, tolerance = peer_solvers.at_gap(peer, scene, 5e-9, lambda *state: told.append(state))
    assert peer_solvers.gap_rms(scene, result.contact_pressure) <= 5e-9
    assert peer_solvers.gap_rms(scene, peer_solvers.solve(peer, scene, 2 * tolerance).contact_pressure) > 5e-9
    assert result.contact_pressure.mean() == pytest.approx(scene.pressure)
    ours = solve(scene)
    np.testing.assert_array_equal(result.contact_pressure > 0, ours.contact)
    assert result.contact_pressure.max() == pytest.approx(ours.observables.peak_pressure, rel=report.PEAK)
    assert result.iterations > 5
    assert result.seconds > 0
