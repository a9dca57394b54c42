"""Whoever extends the program writes one file: a layer, an indenter and a method, each added from this file alone.

They go all the way: `solve`, nested grids, certificate, accuracy, the stored file, the command line and the figure.
"""

import json
import math
import re
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
import pytest
from linecontact.solver import (
    INDENTERS,
    LAYERS,
    METHODS,
    ElasticLayer,
    Indenter,
    Layer,
    Method,
    MethodKind,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    solve,
)
from linecontact.solver.grid.cached import forget
from linecontact.solver.units import unit
from linecontact.studies.command_line import main
from linecontact.studies.curve import study as curve_study
from linecontact.studies.extremes import cells
from linecontact.studies.files import solution_files
from linecontact.studies.tradeoff import choices
from linecontact.studies.tradeoff import study as tradeoff


@dataclass(frozen=True)
class GivenLayer(ElasticLayer):
    """The bonded layer with nu = 0.25, but given by K(q) alone; it knows nothing for shortcuts."""

    thickness: float = 0.1
    """d > 0 [length]."""
    contact_modulus: float = 1.0
    """E* > 0 [pressure]."""

    name: ClassVar[str] = "given"

    def stiffness(self, wave_numbers, period):
        return Layer(self.thickness, 0.25).stiffness(wave_numbers, period)

    def foundation_modulus(self, period):
        return 1.125 * period / self.thickness


@dataclass(frozen=True)
class CosineIndenter(Indenter):
    """h = D (1 - cos(2 pi m x/L)), m waves in the period."""

    amplitude: float = 0.01
    """D > 0 [length]."""
    waves: int = 1
    """m >= 1."""

    name: ClassVar[str] = "cosine"
    units: ClassVar[dict[str, str]] = {"amplitude": "length"}

    def profile(self, num_points, period):
        x = np.arange(num_points) / num_points
        return self.amplitude / period * (1 - np.cos(2 * np.pi * self.waves * x))

    def shortest_wave(self, num_points):
        return self.waves


class ProjectedGradient(Method):
    """Steepest descent in the free nodes' force, projected onto the wall: the simplest method that there is."""

    iteration = 0
    transform_pairs = 0.0
    residual = math.inf
    stopped = False
    patience = None

    def __init__(self, problem, setting):
        self.problem, self.tolerance = problem, setting.tolerance
        self._step = 1 / float(problem.stiffness.max())
        self.start(np.minimum(problem.height, 0.0))

    def start(self, displacement):
        self._u = displacement.copy()

    def start_from_pressure(self, pressure):
        self.start(self.problem.displacement_under(pressure))

    def step(self):
        force = self.problem.net_force(self._u)
        free = (self._u < self.problem.height) | (force <= 0)
        self.residual = float(np.sqrt(np.mean(force[free] ** 2)))
        self.stopped = self.residual <= self.tolerance
        if not self.stopped:
            self._u = np.minimum(self._u + self._step * force, self.problem.height)
        self.iteration += 1
        self.transform_pairs += 1

    @property
    def displacement(self):
        return self._u

    @property
    def contact_pressure(self):
        return self.problem.wall_pressure(self._u)


PROJECTED = MethodKind(
    "projected-gradient", "projected gradient", ProjectedGradient, max_iterations=20_000, nested=True, grows=True
)


@pytest.fixture(autouse=True)
def new_kinds(monkeypatch):
    """One line in each list."""
    monkeypatch.setitem(LAYERS, "given", GivenLayer)
    monkeypatch.setitem(INDENTERS, "cosine", CosineIndenter)
    monkeypatch.setitem(METHODS, "projected-gradient", PROJECTED)


def test_a_layer_given_by_its_stiffness_is_the_layer():
    """Known by K(q) alone, to the last bit where layers are thick on the grid's scale."""
    for indenter, load in ((PowerIndenter(), 2e-3), (RoughIndenter(0.8, 0, 1 / 8, 1 / 16), 1e-2)):
        given, bonded = (
            solve(Scene(layer, indenter, load, num_points=2**12)) for layer in (GivenLayer(0.1), Layer(0.1, 0.25))
        )
        assert given.status is Status.CONVERGED
        np.testing.assert_array_equal(given.contact, bonded.contact)
        np.testing.assert_allclose(given.contact_pressure, bonded.contact_pressure, rtol=1e-6)
        assert given.levels
        assert given.observables.contact_area_subgrid == pytest.approx(bonded.observables.contact_area_subgrid)
        assert given.observables.approach == pytest.approx(bonded.observables.approach)


def test_a_layer_need_not_be_hashable():
    @dataclass(frozen=True)
    class Listed(GivenLayer):
        notes: list[str] = field(default_factory=list)

    listed, plain = (solve(Scene(kind(1e-4), num_points=2**10)).observables for kind in (Listed, GivenLayer))
    assert listed.contact_area_subgrid == plain.contact_area_subgrid


def test_a_thin_layer_has_its_own_edges():
    """Few grid spacings thick: they follow from its stiffness alone."""
    scene = Scene(GivenLayer(1 / 2**12), num_points=2**12)
    o = solve(scene).observables
    fine = solve(Scene(GivenLayer(1 / 2**12), num_points=2**15)).observables
    assert abs(o.contact_area_subgrid - fine.contact_area_subgrid) < o.contact_area_edges_error < 0.1 / 2**12


@dataclass(frozen=True)
class Membrane(GivenLayer):
    """A membrane of the tension G on a foundation, K(q) = k + G q^2: its short waves are no half-space's."""

    tension: float = 0.01

    def stiffness(self, wave_numbers, period):
        return 10 * period + self.tension * wave_numbers**2 / period

    def foundation_modulus(self, period):
        return 10 * period


@pytest.mark.parametrize("thickness", [1e-6, 0.1, math.inf])
@pytest.mark.parametrize("tension", [0.001, 0.01])
@pytest.mark.parametrize("num_points", [2**12, 2**14])
def test_a_layer_whose_short_waves_find_no_half_space(thickness, tension, num_points):
    """Under a parabola, on |x| < a: u = D - x^2/2 inside, k u = G u'' outside, u' continuous."""
    half, length = 0.0376, math.sqrt(tension / 10)
    depth = half * length + half**2 / 2
    pressure = 2 * (10 * (depth * half - half**3 / 6) + tension * half)
    scene = Scene(Membrane(thickness, tension=tension), pressure=pressure, num_points=num_points)
    found = solve(scene).observables
    assert abs(found.contact_area_subgrid - 2 * half) < 2 * found.contact_area_error < 0.05 / num_points


@pytest.mark.parametrize("thickness", [1e-9, 0.1, 100.0])
def test_no_shortcut_is_taken_that_a_layer_does_not_justify(thickness):
    """The bonded layer takes one on each of these."""
    scene = Scene(GivenLayer(thickness), num_points=2**12)
    solution = solve(scene, accuracy=5e-2)
    what = {choice.what: choice.chosen for choice in solution.choices}
    assert what["model"] == "grid"
    assert solution.status in (Status.CONVERGED, Status.INACCURATE)
    shortcut = solve(Scene(Layer(thickness), num_points=2**12), accuracy=5e-2)
    assert {choice.what: choice.chosen for choice in shortcut.choices}["model"] != "grid"


def test_an_indenter_is_resolved_only_where_it_says_so():
    """600 waves: grids of fewer than 1201 points see another surface, and are no answer however sure they seem."""
    scene = Scene(Layer(), CosineIndenter(1e-5, 600), 1e-3, num_points=2**16)
    solution = solve(scene, accuracy=0.1)
    assert solution.scene.num_points > 1200
    share = 2 * math.asin(math.sqrt(1e-3 / (math.pi * 600 * 1e-5))) / math.pi
    assert solution.status is Status.INACCURATE or solution.observables.contact_area_subgrid == pytest.approx(
        share, 0.1
    )
    assert "collocation" not in {choice.what for choice in solution.choices}


@pytest.mark.parametrize("indenter", [PowerIndenter(), CosineIndenter()])
def test_a_new_method_is_certified_like_any_other(indenter):
    scene = Scene(Layer(0.01), indenter, 2e-3, num_points=2**11)
    solution, usual = (solve(scene, method=name, tolerance=1e-6) for name in ("projected-gradient", "active-set"))
    assert solution.status is Status.CONVERGED
    assert solution.method == "projected-gradient"
    assert [level.num_points for level in solution.levels] == [512]
    assert solution.certificate.equilibrium_residual <= 1e-6
    np.testing.assert_array_equal(solution.contact, usual.contact)
    limited = solve(scene, method="projected-gradient", tolerance=1e-6, max_iterations=5)
    assert str(limited.reason).startswith("max_iterations is reached after 5; allowed: more")
    with pytest.raises(ValueError, match="precision is 'float32'; allowed: float64, for projected-gradient"):
        solve(Scene(num_points=64, precision="float32"), method="projected-gradient", tolerance=0.4)


def test_what_is_no_indenter_is_refused():
    class Plain(Indenter):
        name = "plain"
        profile = shortest_wave = lambda *_: 0

    half = type("Half", (), {"name": "half", "profile": lambda *_: np.zeros(64)})()
    for indenter, said in (
        (half, r"indenter is .*Half.*; allowed: a PowerInd.*inherits from `Indenter`"),
        (Plain(), "Plain is not a dataclass; allowed: one, as its fields describe it, or its"),
    ):
        with pytest.raises(ValueError, match=said):
            Scene(indenter=indenter)


def test_the_command_line_names_what_is_missing(monkeypatch, capsys):
    unfinished = dataclass(frozen=True)(type("Unfinished", (Indenter,), {"name": "unfinished"}))
    monkeypatch.setitem(INDENTERS, "unfinished", unfinished)
    assert main.main(["solve", "--profile", "unfinished"]) == 2
    said = "linecontact: profile unfinished lacks profile, shortest_wave; allowed: one that offers what it must\n"
    assert capsys.readouterr().err == said


@pytest.mark.parametrize(
    ("heights", "named"),
    [
        (lambda h: np.append(h, 0.0), r"is of type float64 and shape \(1025,\); allowed: 1024 finite floating"),
        (lambda h: h + 0.5, r"is from 0.5 to 0.52; allowed: 1024 finite floating-point heights, the lowest 0"),
        (lambda h: np.where(h > 0.01, np.nan, h), "is from nan to nan"),
        (lambda h: h.astype(int), "is of type int64"),
        (lambda h: h[2000], r"fails \(IndexError: index 2000 is out of bounds .*\); allowed: 1024 finite floating"),
    ],
)
def test_heights_that_are_none_are_refused(monkeypatch, heights, named):
    forget()
    profile = CosineIndenter.profile
    monkeypatch.setattr(CosineIndenter, "profile", lambda self, n, period: heights(profile(self, n, period)))
    with pytest.raises(ValueError, match=f"profile of indenter cosine {named}"):
        solve(Scene(indenter=CosineIndenter(), num_points=1024))


_SHAPE = r"allowed: real numbers of the wave numbers' shape, \(512,\)"


@pytest.mark.parametrize(
    ("stiffness", "named"),
    [
        (lambda q: np.where(q < 20, q, -1.0), "is -1 at q L = 25.1327; allowed: finite numbers > 0"),
        (lambda q: np.where(q < 20, q, math.nan), "is nan at q L = 25.1327; allowed: finite numbers > 0"),
        (lambda q: q[:-1], rf"has shape \(511,\) and type float64; {_SHAPE}"),
        (lambda q: 1.0, rf"has shape \(\) and type float64; {_SHAPE}"),
        (
            lambda q: max(q, 1.0),
            r"fails \(ValueError: The truth value .*\); allowed: a function of an array of wave numb",
        ),
        (lambda q: q + 0j, rf"has shape \(512,\) and type complex128; {_SHAPE}"),
    ],
)
def test_a_stiffness_that_is_none_is_refused(monkeypatch, stiffness, named):
    monkeypatch.setattr(GivenLayer, "stiffness", lambda self, q, period: stiffness(q))
    monkeypatch.setattr(GivenLayer, "foundation_modulus", lambda self, period: 0.0)
    for load in ({"pressure": 2e-3}, {"approach": 1e-3}):
        forget()
        with pytest.raises(ValueError, match=f"stiffness of layer given {named}"):
            solve(Scene(GivenLayer(), num_points=1024, **load))


@pytest.mark.parametrize("modulus", [-1.0, math.nan, "soft"])
def test_numbers_of_a_layer_that_are_none_are_refused(monkeypatch, modulus):
    monkeypatch.setattr(GivenLayer, "foundation_modulus", lambda self, period: modulus)
    with pytest.raises(ValueError, match=f"foundation_modulus of layer given is {modulus!r}; allowed: a number"):
        Scene(GivenLayer())


@pytest.mark.parametrize("factor", [0.0, 1e-4, 0.5, 20.0, math.inf])
def test_a_foundation_that_long_waves_do_not_find_is_refused(monkeypatch, factor):
    wrong = factor * GivenLayer().foundation_modulus(1.0)
    monkeypatch.setattr(GivenLayer, "foundation_modulus", lambda self, period: wrong)
    with pytest.raises(ValueError, match=f"foundation_modulus of layer given is {wrong:.6g}, and its st"):
        Scene(GivenLayer())


@pytest.mark.parametrize(
    ("thickness", "stiffness"),
    [
        (math.inf, lambda q: 10 + q / 2),
        (0.1, lambda q: np.maximum(q, 2 * np.pi)),  # not known of longer waves than the scene's
        (0.1, lambda q: np.where(q < 1, np.nan, q)),
        (100.0, lambda q: 10 + q / 2),
    ],
)
def test_a_foundation_that_may_be_right_is_believed(monkeypatch, thickness, stiffness):
    monkeypatch.setattr(GivenLayer, "foundation_modulus", lambda self, period: 10.0)
    monkeypatch.setattr(GivenLayer, "stiffness", lambda self, q, period: stiffness(q))
    assert Scene(GivenLayer(thickness)).layer.thickness == thickness


@pytest.mark.parametrize(
    ("what", "given", "named"),
    [
        *(("shortest_wave", wave, f"is {wave!r}; allowed: an integer >= 0") for wave in (None, -3, math.nan, 0.1)),
        *(("to_dict", about, f"gives {about}; allowed: a diction") for about in (None, {}, {"profile": "sine"})),
        ("to_dict", {"profile": "cosine", "waves": None}, "has waves None; allowed: a number, a text, True or False"),
    ],
)
def test_what_an_indenter_says_of_itself_may_be_refused(monkeypatch, what, given, named):
    monkeypatch.setattr(CosineIndenter, what, lambda *_: given)
    with pytest.raises(ValueError, match=re.escape(f"{what} of indenter cosine {named}")):
        Scene(indenter=CosineIndenter())


@pytest.mark.parametrize(("name", "said"), [("power", "that of PowerIndenter; allowed: an"), ("", "''; allowed: a te")])
def test_a_name_that_is_none_or_another_s_is_refused(monkeypatch, name, said):
    monkeypatch.setattr(CosineIndenter, "name", name)
    with pytest.raises(ValueError, match=f"name of indenter is .*{said}"):
        Scene(indenter=CosineIndenter())


class Idle(ProjectedGradient):
    def step(self):
        pass


class Short(ProjectedGradient):
    displacement = property(lambda self: self._u[1:])


IDLE = MethodKind("own", "own", Idle, 1000)


@pytest.mark.parametrize(
    ("kind", "named"),
    [
        (IDLE, "iteration of Idle is 0 after 1001 more steps; allowed: a number that grows"),
        (replace(IDLE, begin=Short), r"displacement of Short has shape \(255,\); allowed: \(256,\)"),
        (Idle, "method own in METHODS is .*Idle.*; allowed: a MethodKind"),
    ],
)
def test_a_method_that_is_none_is_refused(monkeypatch, kind, named):
    monkeypatch.setitem(METHODS, "own", kind)
    with pytest.raises(ValueError, match=named):
        solve(Scene(num_points=256), method="own")


def test_lengths_and_moduli_of_a_layer_that_are_none_are_refused():
    with pytest.raises(ValueError, match="thickness is -1; allowed: a length > 0, or inf"):
        Scene(GivenLayer(-1))
    with pytest.raises(ValueError, match="contact_modulus of layer given is 0; allowed: a finite pressure > 0"):
        Scene(GivenLayer(contact_modulus=0))
    with pytest.raises(ValueError, match=r"thickness/period is .*; allowed: from 1e-60"):
        Scene(Layer(5e-324, 0.4))  # whose modulus of the foundation overflows


@pytest.mark.parametrize(
    "options",
    [
        ["--layer", "given", "--thickness", "0.05"],
        ["--profile", "cosine", "--amplitude", "0.02", "--waves", "3"],
        ["--method", "projected-gradient", "--tolerance", "1e-4"],
        ["--layer", "given", "--profile", "cosine", "--accuracy", "0.1"],
    ],
)
def test_the_command_line_knows_them(tmp_path, capsys, options):
    """From its options to the stored file and the figure."""
    file = tmp_path / "solution.h5"
    words = ["solve", "--num-points", "2048", "--pressure", "0.01", *options, "--json", "--save", str(file), "--plot"]
    assert main.main(words) in (0, 3)
    record = json.loads(capsys.readouterr().out)
    scene, given = record["scene"], dict(zip(options[::2], options[1::2], strict=True))
    assert record["status"] in ("converged", Status.INACCURATE)
    assert record["method"] == given.get("--method", "active-set")
    assert (scene["layer"], scene["profile"]) == (given.get("--layer", "bonded"), given.get("--profile", "power"))
    if "--amplitude" in given:
        assert (scene["amplitude"], scene["waves"]) == (0.02, 3)
        assert (unit("scene.amplitude"), unit("scene.waves")) == ("length", "1")
    fields = solution_files.load(file)
    assert fields.results["scene.layer"] == scene["layer"]
    assert fields.results["contact_area_subgrid"] == record["contact_area_subgrid"]
    assert fields.x.size == scene["num_points"]
    assert file.with_suffix(".png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("name", "units", "allowed"),
    [
        ("amplitude", {"amplitude": "metre"}, "units of amplitude is 'metre'; allowed: length, pressure, pressure/le"),
        ("radius", {"radius": "pressure"}, "units of radius is 'pressure'; allowed: length, as elsewhere"),
        ("amplitude", {"amplitud": "length"}, "units names 'amplitud'; allowed: amplitude"),
        ("amplitude", ["amplitude"], "units is ['amplitude']; allowed: units of fields by name, like {'width'"),
    ],
)
def test_units_of_own_numbers_agree_with_all_others(name, units, allowed):
    with pytest.raises(ValueError, match=re.escape(allowed)):
        type("Own", (Indenter,), {"__annotations__": {name: float}, "units": units})


@pytest.mark.parametrize("kind", ["f4", ">f8", list])
def test_own_heights_may_have_any_real_type(kind):
    class Own(CosineIndenter):
        def profile(self, num_points, period):
            heights = super().profile(num_points, period)
            return heights.tolist() if kind is list else heights.astype(kind)

    found, usual = (
        solve(Scene(indenter=of(), pressure=1e-4, num_points=256)).observables for of in (Own, CosineIndenter)
    )
    assert found.contact_area_subgrid == pytest.approx(usual.contact_area_subgrid, rel=1e-4)


def test_own_lengths_are_lengths_everywhere(tmp_path, capsys):
    assert CosineIndenter(0.02, 3).in_units(2.0) == CosineIndenter(0.04, 3)
    words = ["--over", "amplitude", "--values", "0.01,0.02", "--pressure", "0.01", "--num-points", "2^9"]
    assert main.main(["curve", "--profile", "cosine", *words, "--folder", str(tmp_path), "--workers", "1"]) == 0
    assert main.main(["export", str(tmp_path / "curve.h5"), "--csv", str(tmp_path / "curve.csv")]) == 0
    assert "scene.amplitude [length]" in (tmp_path / "curve.csv").read_text().splitlines()[0]
    (figure,) = curve_study.draw(tmp_path / "curve.h5").values()
    assert " ".join(figure.get_suptitle().split()).endswith("512 points, waves 1")
    capsys.readouterr()
    assert main.main(["solve", "--profile", "cosine", "--amplitude", "2um"]) == 2
    assert "amplitude is '2um'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--layer given --poisson-ratio 0.3", "poisson_ratio is 0.3; allowed: only with --layer bonded or sliding or"),
        ("--profile power --waves 3", "waves is 3; allowed: only with --profile cosine, not power"),
        ("--layer givn", "layer is 'givn'; allowed: bonded, sliding, coated, file, given"),
        ("--wave 3", "option --wave is unknown, perhaps meant as --waves;"),
    ],
)
def test_options_of_another_kind_are_refused(capsys, words, said):
    assert main.main(["solve", *words.split()]) == 2
    assert capsys.readouterr().err.startswith(f"linecontact: {said}")


def test_studies_of_random_scenes_try_a_new_method():
    """The map of extremes and the trade-off take their methods from the list."""
    drawn = {cells.draw(0, k, k % cells.COLUMNS, k % cells.ROWS, "small").options.get("method") for k in range(300)}
    assert set(METHODS) <= drawn
    tried = {task.method for task in tradeoff.QUICK.plan().runs if isinstance(task, choices.Choice)}
    assert set(METHODS) <= tried
