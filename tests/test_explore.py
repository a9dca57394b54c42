"""The page of `linecontact explore`: sliders, links, curves, and its document without a browser or a server."""

import math
import os
import queue
import re
import shlex
import threading
import time
from dataclasses import replace
from pathlib import Path
from urllib.parse import parse_qs

import numpy as np
import pytest
from bokeh.document import Document
from bokeh.models import ColumnDataSource, Div, VStrip
from linecontact import read_scan
from linecontact.solver import CoatedHalfSpace, Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene, solve
from linecontact.solver.display import rounded_up
from linecontact.studies.command_line import main
from linecontact.studies.explore import answers, page
from linecontact.studies.explore.controls import CONTROLS, LOAD, THICKNESS
from linecontact.studies.explore.curves import Curve, grid
from linecontact.studies.explore.newest import Newest
from linecontact.studies.explore.start import Scan, Start
from linecontact.studies.figures.thinning import extremes, merged

PATIENCE = 60  # seconds for what takes less than one on an idle machine
SMALL = Scene(Layer(thickness=0.1), num_points=2**10)


class Screen:
    """A page in a document that nobody serves; what would be done by the server's loop is done by `until`."""

    def __init__(self, first, values=None, scan=None):
        self.tasks = queue.Queue()
        self.start = Start(first, scan)
        self.page = page.Page(self.start, values or self.start.values(), "http://127.0.0.1:1/", self.tasks.put)
        self.document = Document()
        self.document.add_root(self.page.layout())

    def __getitem__(self, name):
        return self.document.get_model_by_name(name)

    def until(self, condition):
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline, self["answer"].value
            self.tasks.get(timeout=PATIENCE)()

    def settle(self):
        """Wait for the answer to the newest event."""
        self.until(lambda: not self["status"].value)

    def columns(self):
        found = self.document.select({"type": ColumnDataSource})
        return [np.asarray(column) for source in found for column in source.data.values()]


@pytest.fixture
def screen():
    made = Screen(SMALL)
    yield made
    made.page.end(PATIENCE)


@pytest.mark.parametrize("control", CONTROLS, ids=lambda control: control.name)
def test_a_slider_gives_back_the_number_that_it_shows(control):
    low, high = control.span([])
    for position in np.arange(low, high + control.step / 2, control.step):
        value = control.value(float(position), high)
        assert control.position(value, high) == pytest.approx(position, abs=0.3 * control.step)
    for given in (control.value(low, high) / 100, 100 * control.value(high, high)):
        lowest, highest = control.span([given])
        assert lowest <= control.position(given, high) <= highest
    if control.endless:
        assert control.position(math.inf, high) > high
        assert control.value(control.position(math.inf, high), high) == math.inf


def test_a_link_gives_back_its_scene():
    start = Start(Scene(Layer(0.0123, 0.41, 3.0), PowerIndenter(3.3, 2.0), 0.017, 2.0, 2**14))
    for more in ({"profile": "power", "exponent": 1.7}, {"profile": "rough", "hurst": 0.4, "seed": 7}):
        values = start.values() | {"thickness": math.inf} | more
        link = {name: [text.encode()] for name, (text,) in parse_qs(start.query(values)).items()}
        assert start.scene(start.read_link(link)) == start.scene(values)


@pytest.mark.parametrize(
    ("link", "message"),
    [
        ({"thickness": [b"thin"]}, "thickness is 'thin'; allowed: a number"),
        ({"thickness": [b"1e400"]}, "thickness is '1e400'; allowed: a number alone .length., below"),
        ({"profile": [b"file"]}, "profile is 'file'; allowed: power, rough"),
        ({"profile_file": [b"/etc/passwd"]}, "the link gives profile_file; allowed"),
        ({"profile": [b"rough"]}, "num_points is 1024"),
    ],
)
def test_a_bad_link_is_refused(link, message):
    with pytest.raises(ValueError, match=message):
        Start(SMALL).read_link(link)


def scene_of(command, monkeypatch):
    """The scene that a command line would have solved."""
    from linecontact.studies.command_line import solve as command_of_solve

    made = []
    monkeypatch.setattr(command_of_solve, "solve", lambda scene, **_: made.append(scene) or solve(scene))
    assert main.main(shlex.split(command)[1:]) == 0
    return made[0]


@pytest.mark.parametrize(
    "scene",
    [
        Scene(Layer(0.0123, 0.41, 3.0), PowerIndenter(3.3, 2.0), 0.017, 2.0, 2**10),
        Scene(Layer(), RoughIndenter(0.4, 7, cut_off_ratio=1 / 16), 0.017, num_points=2**10),
    ],
)
def test_the_command_line_solves_the_scene_on_the_screen(scene, monkeypatch, capsys):
    assert scene_of(Start(scene).command(scene), monkeypatch) == scene


def write_scan(folder, header="x [um],z [nm]"):
    """A file that holds a scan, whose name needs quotes."""
    x = 0.5 * np.arange(300)
    z = 20 * np.random.default_rng(0).standard_normal(300).cumsum() / 30
    file = folder / "a scan.csv"
    np.savetxt(file, np.stack([x, z], axis=1), delimiter=",", header=header)
    return file


@pytest.mark.parametrize(
    ("header", "given"),
    [("x [um],z [nm]", {"window": "none", "num_points": 1024}), ("", {"scene_units": True})],
)
def test_the_command_line_reads_the_scan_on_the_screen(tmp_path, monkeypatch, capsys, header, given):
    file = write_scan(tmp_path, header)
    scene = read_scan(file, **given).scene(Layer(2e-6, contact_modulus=1e9), 5e5)
    again = scene_of(Start(scene, Scan.of(file, {"profile_file": file, **given})).command(scene), monkeypatch)
    assert again.to_dict() == scene.to_dict()
    assert np.array_equal(again.indenter.heights, scene.indenter.heights)


@pytest.mark.parametrize("count", [1, 5, 100, 101, 4096, 5003])
def test_thinning_keeps_the_extremes_of_every_pixel(count):
    values, pixels = np.random.default_rng(0).standard_normal(count), 50
    places = extremes(values, pixels)
    assert places.size <= min(count, 2 * pixels + 4)
    assert (np.diff(places) > 0).all()
    assert {0, count - 1} <= set(places)
    size = math.ceil(count / pixels)
    for begin in range(0, count, size):
        block = values[begin : begin + size]
        assert {begin + int(block.argmin()), begin + int(block.argmax())} <= set(places)


def test_patches_of_one_pixel_are_drawn_as_one():
    left, right = np.array([0.1, 0.15, 0.31, 0.9]), np.array([0.12, 0.18, 0.85, 1.0])
    found = merged(left, right, 0.1)
    assert [side.tolist() for side in found] == [[0.1, 0.31, 0.9], [0.18, 0.85, 1.0]]
    assert all(side.size == 0 for side in merged(left[:0], right[:0], 0.1))


def test_the_newest_request_wins():
    done, begun, go_on = [], threading.Event(), threading.Event()

    def work(request):
        begun.set()
        assert go_on.wait(PATIENCE)
        done.append((request, newest.outdated()))

    newest = Newest(work)
    newest.ask(0)
    assert begun.wait(PATIENCE)
    for request in range(1, 100):
        newest.ask(request)
    go_on.set()
    while len(done) < 2:
        time.sleep(0.001)
    assert done == [(0, True), (99, False)]
    newest.end(PATIENCE)
    newest.ask(100)
    assert newest.outdated()
    assert len(done) == 2


def test_a_slider_changes_the_area_on_the_page(screen):
    screen.settle()
    first = screen["answer"].value
    found = solve(SMALL).observables
    assert f"a_r = {found.contact_area_subgrid:.6g} \N{PLUS-MINUS SIGN} {rounded_up(found.contact_area_error)}" in first
    numbers = r"a_r = (\S+) .*kappa = (\S+) .*p\* = (\S+), d/\(a_r L\) = (\S+),"
    area, kappa, pressure, thickness = map(float, re.search(numbers, first, re.DOTALL).groups())
    assert area / pressure == pytest.approx(kappa, rel=1e-3)
    assert thickness * area == pytest.approx(SMALL.layer.thickness / SMALL.period, rel=1e-3)
    screen["thickness"].value = -3
    screen["exponent"].value = 4
    assert "Solving" in screen["status"].value
    assert "d/L = 0.1," in screen["answer"].value  # an answer names its own scene while a newer one is solved
    screen.settle()
    expected = solve(Scene(Layer(thickness=1e-3), PowerIndenter(4), num_points=2**10)).observables
    assert f"a_r = {expected.contact_area_subgrid:.6g}" in screen["answer"].value
    assert "d/L = 0.001" in screen["answer"].value
    assert "thickness=0.001" in screen["link"].value
    assert "--exponent 4" in screen["command"].value
    screen["thickness"].value = screen["thickness"].end
    screen.settle()
    assert "half-space" in screen["answer"].value
    assert "thickness=inf" in screen["link"].value


@pytest.mark.parametrize(
    ("options", "thickness", "pressure_unit", "said"),
    [
        ({}, 1e-5, None, ("d [um] = 10", "mean pressure p/E* (dimensionless)", "position x [um]")),
        (
            {"length_unit": "nm", "window": "none"},
            1e4,
            "MPa",
            ("d [nm] = 10000", "mean pressure p [MPa]", "position x [nm]"),
        ),
    ],
)
def test_a_scan_s_page_speaks_its_units_and_marks_its_mirror_image(tmp_path, options, thickness, pressure_unit, said):
    answer, *titles = said
    scan = read_scan(write_scan(tmp_path), **options)
    scene = replace(scan.scene(Layer(thickness, contact_modulus=2.0), 2e-3), pressure_unit=pressure_unit)
    made = Screen(scene)
    made.settle()
    made.page.end(PATIENCE)
    fields, sliders = made.page._fields, {slider.name: slider for slider in made.page._sliders.values()}
    name, _, size = answer.partition(" = ")
    assert sliders["thickness"].title == f"thickness {name}"
    assert [sliders["pressure"].title, fields.pressure.xaxis.axis_label] == titles
    assert 10 ** sliders["thickness"].value == pytest.approx(float(size))
    assert 10 ** sliders["pressure"].value == pytest.approx(2e-3 if pressure_unit else 1e-3)
    assert answer in made["answer"].value
    with pytest.raises(ValueError, match=r"thickness is '5um'; allowed: a number alone \[n?m\], below"):
        made.start.read_link({"thickness": [b"5um"]})
    mirrored = "window" not in options
    drawn = [one.glyph for panel in (fields.shape, fields.pressure) for one in panel.renderers]
    strips = [strip.x0 for strip in drawn if isinstance(strip, VStrip)]
    assert strips == pytest.approx([150] * 2 * mirrored)
    assert ("mirror image" in [item.label.value for item in fields.shape.legend[0].items]) == mirrored


def test_the_surface_on_the_screen_is_the_solution_and_zooming_in_shows_every_point(screen):
    screen.settle()
    solution, fields = solve(SMALL), screen.page._fields
    shown = fields._found.data
    for name, values in {"u": solution.displacement, "p": solution.contact_pressure}.items():
        drawn = np.isfinite(shown[name])
        x, y = shown[f"{name}_x"][drawn], shown[name][drawn]
        assert np.array_equal(y, values[np.round(x * 2**10).astype(int)])
        assert y.max() == values.max()
    fields._resize(100)
    assert np.isfinite(fields._found.data["u_x"]).sum() <= 2 * 100 + 4
    fields.x_range.update(start=0.45, end=0.5)
    fields.thin()
    x = fields._indenter.data["x"]
    assert np.allclose(np.diff(x), 2.0**-10)
    assert x[0] <= 0.45 < 0.5 <= x[-1]


@pytest.mark.parametrize("trouble", ["refused", "not converged", "failed"])
def test_no_old_answer_stands_for_a_scene_without_one(screen, trouble, monkeypatch):
    screen.settle()
    assert any(column.size for column in screen.columns())
    if trouble == "refused":
        screen["profile"].active = 1  # 1024 points do not resolve the default surface
        message = "Refused: num_points is 1024"
    else:
        limited = (lambda scene, **_: solve(scene, max_iterations=1)) if trouble == "not converged" else None
        monkeypatch.setattr(answers, "solve", limited)
        screen["thickness"].value = -2
        message = "Not converged (iteration limit)" if limited else "Failed: TypeError"
    screen.settle()
    assert message in screen["doubts"].value
    assert "a_r =" not in screen["answer"].value
    assert not any(column.size for column in screen.columns())
    monkeypatch.undo()
    screen["profile"].active = 0
    screen["thickness"].value = -2.5
    screen.settle()
    assert "a_r =" in screen["answer"].value


def test_a_newer_event_cuts_a_solve_short(screen, monkeypatch):
    screen.settle()
    begun = threading.Event()

    def endless(scene, progress):
        while scene.layer.thickness == 0.01:
            begun.set()
            time.sleep(0.001)
            progress(0, 1.0)
        return solve(scene)

    monkeypatch.setattr(answers, "solve", endless)
    monkeypatch.setattr(page, "_SHOWN", PATIENCE)
    screen["thickness"].value = -2
    assert begun.wait(PATIENCE)
    screen["thickness"].value = -3
    screen.settle()
    assert "d/L = 0.001," in screen["answer"].value


def test_the_curves_follow_when_nothing_moves(screen):
    around = screen.page._around
    screen.until(lambda: len(around[THICKNESS]._curve.data["x"]) == 14)
    for control in (LOAD, THICKNESS):
        title, data = around[control].figure.title.text, around[control]._curve.data
        assert f"on {grid(SMALL)} points" in title
        assert (np.diff(data["y"]) >= -1e-14).all()  # but for rounding
        assert data["y"][-1] > 10 * data["y"][0]
    place = int(np.flatnonzero(around[LOAD]._curve.data["x"] > 1e-2)[0])
    load = around[LOAD]._curve.data["x"][place]
    expected = solve(Scene(Layer(0.1), pressure=float(load), num_points=grid(SMALL))).observables
    assert around[LOAD]._curve.data["y"][place] == expected.contact_area_subgrid
    kept = around[LOAD]._curve.data["x"]
    screen["pressure"].value = -2  # along the curve of the load, but off that of the thickness
    screen.settle()
    assert np.array_equal(around[LOAD]._curve.data["x"], kept)
    assert len(around[THICKNESS]._curve.data["x"]) == 0
    assert around[LOAD]._point.data["x"] == [0.01]


def test_curves_take_a_grid_that_holds_the_surface():
    rough = Scene(Layer(), RoughIndenter(), num_points=2**14)
    assert grid(rough) == 2**14
    assert grid(Scene(num_points=2**14)) == 2**12
    smooth = MeasuredIndenter(1 - np.cos(2 * np.pi * np.arange(2**14) / 2**14), convention="gap")
    assert grid(Scene(Layer(), smooth, num_points=2**14)) == 2**12
    curve = Curve(LOAD)
    curve.aim(rough)
    curve.found[1.0] = (0.5, 0.1)
    curve.aim(Scene(Layer(), RoughIndenter(), pressure=0.1, num_points=2**14))
    assert curve.found
    curve.aim(Scene(Layer(1.0), RoughIndenter(), num_points=2**14))
    assert not curve.found


def resident(process="self"):
    """Memory of a process [bytes]."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="sees Linux' memory only")
def test_memory_stays_flat(screen, monkeypatch):
    monkeypatch.setattr(page, "_PAINTED", 0.0)  # no browser paints here

    def move(count):
        rng = np.random.default_rng(count)
        for _ in range(count):
            screen["thickness"].value = rng.uniform(-4, 1)
            screen["pressure"].value = rng.uniform(-5, -1)
            screen.settle()

    move(200)
    before = resident()
    move(150)
    assert resident() - before < 20 * 2**20


def test_the_page_names_its_layer_and_the_base_of_a_coating():
    coated = CoatedHalfSpace(0.1, base_modulus=2.0, contact_modulus=4.0)
    for layer, said in ((Layer(0.1), "elastic layer bonded to a rigid base,"), (coated, "half-space,")):
        made = Screen(Scene(layer, num_points=2**8))
        made.settle()
        made.page.end(PATIENCE)
        assert any(said in model.text for model in made.document.select({"type": Div}))
    assert "base E2*/E* = 0.5, nu2 = 0.25, " in made["answer"].value


def test_only_layers_that_may_be_half_spaces_have_one_on_their_curve():
    for layer, has in ((Layer(0.1), True), (CoatedHalfSpace(0.1, base_modulus=2.0), False)):
        scene = Scene(layer, num_points=2**12)
        curve = Curve(Start(scene).controls()[0])
        curve.aim(scene)
        assert (curve.control.name, curve.control.endless) == ("thickness", has)
        assert (math.inf in curve.missing(scene, (-2, 1))) == has
