"""What is printed on terminals of any width, and in files: no digit is lost, and errors are rounded up."""

import io
import re
from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest
from linecontact.solver import Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene, solve
from linecontact.solver.display import rounded_up
from linecontact.studies.command_line.solution_tables import choices_table, solution_table
from linecontact.studies.explore import wording
from linecontact.studies.explore.answers import Answer
from linecontact.studies.files.study_files import StudyFile
from linecontact.studies.rough_surfaces import ensembles, means, report
from linecontact.studies.runner import study
from linecontact.studies.terminal import console
from running import run_plans


@pytest.fixture(scope="module")
def solution():
    return solve(Scene(Layer(0.1), RoughIndenter(cut_off_ratio=0.1), num_points=2**10), accuracy=1e-3)


def printed(thing, width, terminal=False):
    output = io.StringIO()
    console.Plain(file=output, width=width, force_terminal=terminal, color_system=None).print(thing)
    return output.getvalue()


def words(text):
    """Everything that is said but lines and blanks, wherever it is broken, in the order of the alphabet."""
    return sorted(re.sub(r"[^\x21-\x7e]", "", text))


def numbers(text):
    return sorted(re.findall(r"\d[\d.]*(?:e[+-]\d+)?", text))


@pytest.mark.parametrize("width", [20, 40, 60, 80])
def test_a_narrow_terminal_loses_nothing_of_a_table(solution, width):
    for table in (solution_table(solution), choices_table(solution)):
        wide, narrow = printed(table, 500), printed(table, width)
        assert not Counter(words(wide)) - Counter(words(narrow))
        cells = [cell for column in table.columns if column.no_wrap for cell in column.cells]
        assert all(cell in narrow for cell in cells)
        assert width < 40 or max(map(len, narrow.splitlines())) <= width


@pytest.mark.parametrize("width", [40, 80, 120])
def test_a_narrow_terminal_loses_nothing_of_a_progress_line(width):
    bar, state = console.Bar("solve"), "12 of 345 done, 0.12 a second, worst residual 1e-09"
    for done, left in ((0.0, ", time left unknown"), (1.0, "")):
        bar.show(lambda done=done: (done, state))
        shown = printed(bar._progress.get_renderable(), width, terminal=True)
        assert not Counter(words(f"solve {done:.0%} {state}{left} 0:00:00")) - Counter(words(shown))
        assert ("unknown" in shown) == (done < 1)
        assert max(map(len, shown.splitlines())) <= width
    assert shown.count("\u2501") == 10


@pytest.mark.parametrize(
    ("load", "options", "said"),
    [(2e-3, {"max_iterations": 1}, "(needs a result as asked) not computed"), (100.0, {}, "inf")],
)
def test_the_row_of_the_stiffness_is_always_there(load, options, said):
    found = solve(Scene(Layer(), RoughIndenter(cut_off_ratio=0.1), load, num_points=2**10), **options)
    text = " ".join(printed(solution_table(found), 200).replace("\u2502", "").split())
    assert f"contact stiffness dp/d(approach) {said} pressure/length" in text


def rows(solution):
    """The rows of the table of a solve: values and units by quantity."""
    quantities, values, units = (column.cells for column in solution_table(solution).columns)
    return {name.strip(): (value, unit) for name, value, unit in zip(quantities, values, units, strict=True)}


PRESSURE = "reduced pressure p* = p/(E* g_c)"


@pytest.mark.parametrize(
    "scene",
    [
        Scene(Layer(0.3, 0.4, 3.0), RoughIndenter(cut_off_ratio=0.1), 0.02, period=5.0, num_points=2**10),
        Scene(Layer(), RoughIndenter(cut_off_ratio=0.1), 10.0, num_points=2**10),  # full contact
        Scene(Layer(0.01), num_points=2**10),
    ],
)
def test_the_rows_of_a_solve_fit_together(scene):
    """p* = p/(E* g_c), kappa = a_r/p* and d/(a_r L) follow from the rows above them."""
    found = solve(scene)
    known = {name: float(value) for name, (value, _) in rows(found).items() if re.fullmatch(r"inf|[\d.e+-]+", value)}
    area, reduced, width = (known[name] for name in ("contact area a_r", PRESSURE, "contact width a_r L"))
    load = known["mean pressure p"] / known["contact modulus E*"]
    for shown, expected in (
        (reduced, load / known["rms gradient in contact g_c"]),
        (known["kappa = a_r/p*"], area / reduced),
        (width, area * scene.period),
        (known["thickness over width d/(a_r L)"], scene.layer.thickness / width),
        (known["by counting nodes: a_r"], found.contact.mean()),
        (known["by counting nodes: kappa"], found.observables.kappa),
    ):
        assert shown == pytest.approx(expected, rel=1e-6)
    assert ("kappa over kappa_inf of the half-space" in rows(found)) == isinstance(scene.indenter, PowerIndenter)


def test_what_is_not_known_is_said():
    none = rows(solve(Scene(Layer(), approach=0.0, num_points=2**10)))
    assert none["contact area a_r"] == ("0", "-")
    assert none[PRESSURE] == none["kappa = a_r/p*"] == ("nan", "-")
    assert "by counting nodes: a_r" not in none
    single = solve(Scene(Layer(), num_points=2**10), nested=False)
    assert printed(solution_table(single), 200).count("not known") == 2  # approach and peak pressure
    assert "by counting nodes: a_r" in rows(single)
    heights = np.cos(np.arange(64) / 64 * 2 * np.pi)
    scan = MeasuredIndenter(heights, description={"profile_length_unit": "um"}, convention="gap")
    assert rows(solve(Scene(Layer(), scan, 0.1, num_points=64)))["contact width a_r L"][1] == "um"


@pytest.mark.parametrize("width", [20, 60])
def test_a_table_of_numbers_comes_in_parts(width):
    table = console.table(title="the title", caption="the caption")
    for i in range(9):
        table.add_column(f"column {i}", justify="right", no_wrap=True)
    for i in range(3):
        table.add_row(*(f"{i}.{k}23456" for k in range(9)))
    table.add_section()
    text = printed(table, width)
    assert set(numbers(text)) == set(numbers(printed(table, 500)))
    assert max(len(line.rstrip()) for line in text.splitlines()) <= max(width, 21)
    assert [text.count(said) for said in ("the title", "the caption")] == [1, 1]
    parts = text.count("column 0")
    assert parts > 1
    assert text.count("1.023456") == parts
    assert text.count("1.823456") == 1


def test_a_sentence_is_wrapped_on_a_terminal_only():
    said = " ".join(["some words of a long sentence"] * 5)
    assert max(map(len, printed(said, 40, terminal=True).splitlines())) <= 40
    assert printed(said, 40) == f"{said}\n"
    assert printed("a" * 100, 40) == "a" * 100 + "\n"


@pytest.mark.parametrize(
    ("value", "text"), [(0.0101, "0.011"), (0.1, "0.1"), (9.91e-8, "1e-07"), (float("inf"), "inf"), (-0.0149, "-0.014")]
)
def test_an_error_is_rounded_up(value, text):
    assert rounded_up(value) == text


def test_estimated_errors_are_rounded_up_wherever_they_are_shown(solution):
    found = solution.observables
    area = rounded_up(found.contact_area_error)
    relative = rounded_up(found.contact_area_error / found.contact_area_subgrid)
    table = printed(solution_table(solution), 200)
    assert f"+- {area} numerical error (relative {relative})" in table
    for error in (found.contact_area_error, found.kappa_error, found.approach_error, found.peak_pressure_error):
        assert re.search(rf"its numerical error, estimated +\S +{re.escape(rounded_up(error))} ", table)
    (choice,) = (choice for choice in solution.choices if choice.what == "grid")
    assert re.search(rf"grid +\S +\S+ points +\S +{rounded_up(choice.error)} ", printed(choices_table(solution), 200))
    assert f"error {rounded_up(choice.error)} [-]" in repr(choice)
    assert f"+- {area} [-]" in repr(solution)
    assert f"+- {area}" in solution._repr_html_()
    said = wording.said(Answer(solution.scene, solution, "", 0.1), 0.1)
    assert f"{area} (dimensionless, estimated relative error {relative})" in said
    assert f"{rounded_up(found.kappa_error)}, p*" in said
    mantissa, _, power = area.partition("e")
    assert rf"\pm {mantissa}\times10^{{{int(power)}}}$" in solution.plot().get_suptitle().replace("  ", " ")
    assert str(means.Mean(1.23456, 0.01497)) == "1.235 +- 0.015"


def test_what_is_not_reached_is_said_each_time_on_standard_error(tmp_path, capsys):
    plan = study.Plan("dummy", {}, [], figures=())
    missed = ["it takes longer; allowed: more"]
    one = study.Study(
        name="hertz",
        options=study.Options,
        plans=lambda _: [plan],
        report=lambda *_: [],
        draw=lambda _: {},
        missed=lambda _: missed,
    )
    for last in ("s in all.", "Nothing computed; all that may be done was done before."):
        assert run_plans(one, [plan], tmp_path) == 3
        said = capsys.readouterr()
        assert said.err == "linecontact: dummy: the goal is not reached: it takes longer; allowed: more\n"
        assert last in said.out
        assert "Finished" not in said.out


def test_points_of_rough_surfaces_that_are_out_of_reach_are_said(monkeypatch):
    file = StudyFile("rough", {"standard_error": 0.01}, [])
    states = {i: SimpleNamespace(out_of_reach=reason) for i, reason in enumerate(["too long", "", "too long", ""])}
    monkeypatch.setattr(ensembles, "states", lambda _: states)
    assert report.missed(file) == ["too long"]
    assert report.missed(StudyFile("rough", {}, [])) == []
