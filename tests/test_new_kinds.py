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


def sliding(y):
    """K(q) over its limit for q = 0 of a layer that slides on its base without friction, y = q d."""
    e = np.exp(-2 * y)  # (sinh 2y + 2y)/(cosh 2y - 1), all times it
    return y / 2 * (-np.expm1(-4 * y) + 4 * y * e) / np.expm1(-2 * y) ** 2


@dataclass(frozen=True)
class FrictionlessLayer(ElasticLayer):
    """A layer that rests on its base without friction, given by its K(q); it knows nothing for shortcuts."""

    thickness: float = 0.1
    """d > 0 [length]."""
    contact_modulus: float = 1.0
    """E* > 0 [pressure]."""

    name: ClassVar[str] = "frictionless"

    def stiffness(self, wave_numbers, period):
        return sliding(wave_numbers * self.thickness / period) * self.foundation_modulus(period)

    def foundation_modulus(self, period):
        return period / self.thickness


@dataclass(frozen=True)
class GivenLayer(FrictionlessLayer):
    """The bonded layer with nu = 0.25, but given by K(q) alone."""

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
    monkeypatch.setitem(LAYERS, "frictionless", FrictionlessLayer)
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
    class Listed(FrictionlessLayer):
        notes: list[str] = field(default_factory=list)

    listed, plain = (solve(Scene(kind(1e-4), num_points=2**10)).observables for kind in (Listed, FrictionlessLayer))
    assert listed.contact_area_subgrid == plain.contact_area_subgrid


def test_a_thin_layer_has_its_own_edges():
    """Few grid spacings thick: they follow from its stiffness alone."""
    scene = Scene(FrictionlessLayer(1 / 2**12), num_points=2**12)
    o = solve(scene).observables
    fine = solve(Scene(FrictionlessLayer(1 / 2**12), num_points=2**15)).observables
    assert abs(o.contact_area_subgrid - fine.contact_area_subgrid) < o.contact_area_edges_error < 0.1 / 2**12


@dataclass(frozen=True)
class Membrane(FrictionlessLayer):
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
    scene = Scene(FrictionlessLayer(thickness), num_points=2**12)
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


def test_a_cosine_indenter_has_westergaard_s_area():
    o = solve(Scene(Layer(), CosineIndenter(), 0.01, num_points=2**12)).observables
    share = 2 * math.asin(math.sqrt(0.01 / (math.pi * 0.01))) / math.pi
    assert abs(o.contact_area_subgrid - share) < 0.02 / 2**12
    assert o.kappa_ratio is None


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


def test_what_is_no_layer_or_indenter_is_refused():
    class Half:
        name = "half"

        def profile(self, num_points, period):
            return np.zeros(num_points)

    with pytest.raises(ValueError, match=r"indenter is .*Half.*; allowed: a PowerInd.*inherits from `Indenter`"):
        Scene(indenter=Half())
    with pytest.raises(ValueError, match="layer is 3; allowed: a Layer"):
        Scene(layer=3)

    class Unfinished(ElasticLayer):
        name = "unfinished"
        contact_modulus, thickness = 1.0, 0.1

    with pytest.raises(TypeError, match="stiffness"):
        Unfinished()


def test_a_class_without_fields_is_refused():
    class Plain(Indenter):
        name = "plain"

        def profile(self, num_points, period):
            return np.zeros(num_points)

        def shortest_wave(self, num_points):
            return 0

    with pytest.raises(ValueError, match="Plain is not a dataclass; allowed: one, as its fields describe it, or its"):
        Scene(indenter=Plain())


def test_the_command_line_names_what_is_missing(monkeypatch, capsys):
    @dataclass(frozen=True)
    class Unfinished(Indenter):
        """An indenter without a profile."""

        name: ClassVar[str] = "unfinished"

        def shortest_wave(self, num_points):
            return 1

    monkeypatch.setitem(INDENTERS, "unfinished", Unfinished)
    assert main.main(["solve", "--profile", "unfinished"]) == 2
    said = "linecontact: profile unfinished lacks profile; allowed: one that offers what it must\n"
    assert capsys.readouterr().err == said


@pytest.mark.parametrize(
    ("heights", "named"),
    [
        (lambda h: np.append(h, 0.0), r"is of type float64 and shape \(1025,\); allowed: 1024 finite floating"),
        (lambda h: h + 0.5, r"is from 0.5 to 0.52; allowed: 1024 finite floating-point heights, the lowest 0"),
        (lambda h: np.where(h > 0.01, np.nan, h), "is from nan to nan"),
        (lambda h: h.astype(int), "is of type int64"),
        (lambda h: None, "is of type object"),
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
        (lambda q: 0 * q, "is 0 at q L = 6.28319; allowed: finite numbers > 0"),
        (lambda q: np.where(q < 20, q, math.nan), "is nan at q L = 25.1327; allowed: finite numbers > 0"),
        (lambda q: np.where(q < 20, q, math.inf), "is inf at q L = 25.1327; allowed: finite numbers > 0"),
        (lambda q: q[:-1], rf"has shape \(511,\) and type float64; {_SHAPE}"),
        (lambda q: 1.0, rf"has shape \(\) and type float64; {_SHAPE}"),
        (lambda q: None, rf"has shape \(\) and type object; {_SHAPE}"),
        (
            lambda q: max(q, 1.0),
            r"fails \(ValueError: The truth value .*\); allowed: a function of an array of wave numb",
        ),
        (lambda q: q + 0j, rf"has shape \(512,\) and type complex128; {_SHAPE}"),
    ],
)
def test_a_stiffness_that_is_none_is_refused(monkeypatch, stiffness, named):
    forget()
    monkeypatch.setattr(FrictionlessLayer, "stiffness", lambda self, q, period: stiffness(q))
    monkeypatch.setattr(FrictionlessLayer, "foundation_modulus", lambda self, period: 0.0)
    with pytest.raises(ValueError, match=f"stiffness of layer frictionless {named}"):
        solve(Scene(FrictionlessLayer(), num_points=1024))


@pytest.mark.parametrize("modulus", [-1.0, math.nan, None, "soft"])
def test_numbers_of_a_layer_that_are_none_are_refused(monkeypatch, modulus):
    monkeypatch.setattr(FrictionlessLayer, "foundation_modulus", lambda self, period: modulus)
    with pytest.raises(ValueError, match=f"foundation_modulus of layer frictionless is {modulus!r}; allowed: a number"):
        Scene(FrictionlessLayer())


@pytest.mark.parametrize("factor", [0.0, 1e-4, 0.5, 20.0, math.inf])
def test_a_foundation_that_long_waves_do_not_find_is_refused(monkeypatch, factor):
    right = FrictionlessLayer().foundation_modulus(1.0)
    monkeypatch.setattr(FrictionlessLayer, "foundation_modulus", lambda self, period: factor * right)
    monkeypatch.setattr(FrictionlessLayer, "stiffness", lambda self, q, period: right * sliding(q * self.thickness))
    with pytest.raises(
        ValueError, match=f"foundation_modulus of layer frictionless is {factor * right:.6g}, and its st"
    ):
        Scene(FrictionlessLayer())


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
    monkeypatch.setattr(FrictionlessLayer, "foundation_modulus", lambda self, period: 10.0)
    monkeypatch.setattr(FrictionlessLayer, "stiffness", lambda self, q, period: stiffness(q))
    assert Scene(FrictionlessLayer(thickness)).layer.thickness == thickness


_WAVE, _ABOUT = "allowed: an integer >= 0, 0 f", "allowed: a dictionary with 'cosine' under 'profile'"


@pytest.mark.parametrize(
    ("what", "given", "named"),
    [
        *(("shortest_wave", wave, f"is {wave!r}; {_WAVE}") for wave in (None, "short", -3, math.nan, 0.1)),
        *(("to_dict", about, f"gives {about}; {_ABOUT}") for about in (None, {}, {"profile": "sine"})),
        ("to_dict", {"profile": "cosine", "waves": [1, None]}, "has waves [1, None]; allowed: a number, a text, True"),
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


def methods_that_are_none():
    class Idle(ProjectedGradient):
        def step(self):
            pass

    class Short(ProjectedGradient):
        displacement = property(lambda self: self._u[1:])

    kind = MethodKind("own", "own", Idle, 1000)
    yield kind, "iteration of Idle is 0 after 1001 more steps; allowed: a number that grows"
    yield replace(kind, begin=Short), r"displacement of Short has shape \(255,\); allowed: \(256,\)"
    yield Idle, "method own in METHODS is .*Idle.*; allowed: a MethodKind"


@pytest.mark.parametrize(("kind", "named"), [*methods_that_are_none()])
def test_a_method_that_is_none_is_refused(monkeypatch, kind, named):
    monkeypatch.setitem(METHODS, "own", kind)
    with pytest.raises(ValueError, match=named):
        solve(Scene(num_points=256), method="own")


def test_lengths_and_moduli_of_a_layer_that_are_none_are_refused():
    with pytest.raises(ValueError, match="thickness is -1; allowed: a length > 0, or inf"):
        Scene(FrictionlessLayer(-1))
    with pytest.raises(ValueError, match="contact_modulus of layer frictionless is 0; allowed: a finite pressure > 0"):
        Scene(FrictionlessLayer(contact_modulus=0))
    for layer in (Layer(1e-300), Layer(5e-324, 0.4)):  # whose modulus of the foundation overflows
        with pytest.raises(ValueError, match=r"thickness/period is .*; allowed: from 1e-60"):
            Scene(layer)


def test_a_stiffness_that_is_none_is_refused_where_an_approach_is_given(monkeypatch):
    forget()
    monkeypatch.setattr(FrictionlessLayer, "stiffness", lambda self, q, period: 1.0)
    with pytest.raises(ValueError, match="stiffness of layer frictionless has shape"):
        solve(Scene(FrictionlessLayer(), approach=0.001, num_points=64))


@pytest.mark.parametrize(
    "options",
    [
        ["--layer", "frictionless", "--thickness", "0.05"],
        ["--profile", "cosine", "--amplitude", "0.02", "--waves", "3"],
        ["--method", "projected-gradient", "--tolerance", "1e-4"],
        ["--layer", "frictionless", "--profile", "cosine", "--accuracy", "0.1"],
    ],
)
def test_the_command_line_knows_them(tmp_path, capsys, options):
    """From its options to the stored file and the figure."""
    file = tmp_path / "solution.h5"
    words = ["solve", "--num-points", "2048", "--pressure", "0.01", *options, "--json", "--save", str(file), "--plot"]
    assert main.main(words) in (0, 3)
    record = json.loads(capsys.readouterr().out)
    assert record["status"] in ("converged", Status.INACCURATE)
    given = dict(zip(options[::2], options[1::2], strict=True))
    assert record["scene"]["layer"] == given.get("--layer", "bonded")
    assert record["scene"]["profile"] == given.get("--profile", "power")
    if "--amplitude" in given:
        assert (record["scene"]["amplitude"], record["scene"]["waves"]) == (0.02, 3)
        assert (unit("scene.amplitude"), unit("scene.waves")) == ("length", "1")
    fields = solution_files.load(file)
    attributes = fields.results
    assert attributes["scene.layer"] == record["scene"]["layer"]
    assert attributes["contact_area_subgrid"] == record["contact_area_subgrid"]
    assert fields.x.size == record["scene"]["num_points"]
    assert file.with_suffix(".png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("name", "units", "allowed"),
    [
        ("amplitude", {"amplitude": "metre"}, "units of amplitude is 'metre'; allowed: length, pressure, pressure/le"),
        ("radius", {"radius": "pressure"}, "units of radius is 'pressure'; allowed: length, as elsewhere"),
        ("hurst", {"hurst": "length"}, "units of hurst is 'length'; allowed: none, it is dimensionless, as elsewhere"),
        ("amplitude", {"amplitud": "length"}, "units names 'amplitud'; allowed: amplitude"),
        ("amplitude", ["amplitude"], "units is ['amplitude']; allowed: units of fields by name, like {'width'"),
    ],
)
def test_units_of_own_numbers_agree_with_all_others(name, units, allowed):
    with pytest.raises(ValueError, match=re.escape(allowed)):
        type("Own", (Indenter,), {"__annotations__": {name: float}, "units": units})


def test_own_numbers_are_printed_with_their_units():
    assert repr(CosineIndenter(0.02, 3)) == "CosineIndenter: amplitude 0.02 [length], waves 3 [-]"
    assert "    CosineIndenter: amplitude 0.01 [length]" in repr(solve(Scene(indenter=CosineIndenter(), num_points=64)))

    @dataclass(frozen=True)
    class WithHeights(CosineIndenter):
        heights: np.ndarray = field(default_factory=lambda: np.zeros(1000))

    assert repr(WithHeights()).endswith("heights 1000 values [-]")


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
    title = " ".join(figure.get_suptitle().split())
    assert title.startswith("profile: cosine, half-space")
    assert title.endswith("512 points, waves 1")
    capsys.readouterr()
    assert main.main(["solve", "--profile", "cosine", "--amplitude", "2um"]) == 2
    assert "amplitude is 2um" in capsys.readouterr().err.replace("'", "")


def test_options_of_another_kind_are_refused(capsys):
    assert main.main(["solve", "--layer", "frictionless", "--poisson-ratio", "0.3"]) == 2
    assert capsys.readouterr().err == (
        "linecontact: poisson_ratio is 0.3; allowed: only with --layer bonded or sliding or coated, not frictionless\n"
    )
    assert main.main(["solve", "--layer", "frictionles"]) == 2
    assert capsys.readouterr().err.startswith(
        "linecontact: layer is 'frictionles'; allowed: bonded, sliding, coated, file, frictionless"
    )


def test_studies_of_random_scenes_try_a_new_method():
    """The map of extremes and the trade-off take their methods from the list."""
    drawn = {cells.draw(0, k, k % cells.COLUMNS, k % cells.ROWS, "small").options.get("method") for k in range(300)}
    assert set(METHODS) <= drawn
    tried = {task.method for task in tradeoff.QUICK.plan().runs if isinstance(task, choices.Choice)}
    assert set(METHODS) <= tried
