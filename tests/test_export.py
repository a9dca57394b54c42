"""`linecontact export`: a stored file as a table, read back by the csv module and by pandas."""

import csv
import io
import math

import numpy as np
import pytest
from linecontact import Layer, MeasuredIndenter, Scene, solve
from linecontact.studies.command_line import export
from linecontact.studies.command_line import main as cli
from linecontact.studies.files import solution_files, study_files
from linecontact.studies.files.study_files import StudyFile

RUNS = [
    {
        "status": "converged",
        "file": '=HYPERLINK("x")',
        "note": 'with "quotes", commas\nand lines: \u00b5m',
        "scene.thickness": "inf",
        "contact_area": 1 / 3,
        "error": "nan",
        "seconds.total": 0.1 + 0.2,
        "iterations": 7,
        "handed_over": False,
    },
]
RUNS.append(RUNS[0] | {"file": "-1+1", "note": "", "scene.thickness": 1e-300, "error": "-inf", "handed_over": True})
RUNS += [RUNS[0] | {"file": text} for text in ("@sum", "+1", "a=b")]


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "study.h5"
    study_files.save_study(path, StudyFile("hertz", {}, RUNS))
    return path


def test_a_study_is_read_back_by_the_csv_module(study, capfdbinary):
    assert cli.main(["export", str(study)]) == 0
    written = capfdbinary.readouterr().out
    assert cli.main(["export", str(study), "--csv", "-"]) == 0
    assert capfdbinary.readouterr().out == written
    assert written.count(b"\r\n") == len(RUNS) + 1  # RFC 4180
    head, *rows = csv.reader(io.StringIO(written.decode(), newline=""))
    names = {name.partition(" [")[0]: name for name in head}
    assert names.keys() == RUNS[0].keys()
    assert names["scene.thickness"] == "scene.thickness [length]"
    assert names["seconds.total"] == "seconds.total [s]"
    assert names["contact_area"] == "contact_area [-]"
    assert names["note"] == "note"
    table = {name: [row[place] for row in rows] for place, name in enumerate(head)}
    assert table["note"] == [run["note"] for run in RUNS]
    assert table["file"] == ['\'=HYPERLINK("x")', "'-1+1", "'@sum", "'+1", "a=b"]
    for name in ("scene.thickness", "contact_area", "error", "seconds.total", "iterations"):
        np.testing.assert_array_equal(
            [float(cell) for cell in table[names[name]]], [float(run[name]) for run in RUNS], err_msg=name
        )
    assert table["handed_over [-]"] == [str(run["handed_over"]) for run in RUNS]


def test_a_study_is_read_back_by_pandas(study, tmp_path):
    pandas = pytest.importorskip("pandas")
    assert cli.main(["export", str(study), "--csv", str(tmp_path / "out.csv")]) == 0
    table = pandas.read_csv(tmp_path / "out.csv")
    assert table["contact_area [-]"].tolist() == pytest.approx([run["contact_area"] for run in RUNS], rel=1e-15)
    assert math.isinf(table["scene.thickness [length]"][0])
    assert math.isnan(table["error [-]"][0])
    assert table["error [-]"][1] == -math.inf
    assert table["handed_over [-]"].tolist() == [run["handed_over"] for run in RUNS]


@pytest.mark.parametrize(("about", "unit"), [({}, "length"), ({"profile_length_unit": "um"}, "um")])
def test_a_solution_s_fields_are_exported(tmp_path, about, unit):
    heights = np.cos(np.arange(64) / 64 * 2 * np.pi) / 100
    indenter = MeasuredIndenter(heights, description=about, convention="gap")
    solution = solve(Scene(Layer(0.5), indenter, 1e-3, num_points=64))
    solution_files.save_solution(tmp_path / "run.h5", solution)
    assert cli.main(["export", str(tmp_path / "run.h5"), "--csv", str(tmp_path / "out.csv")]) == 0
    head, *rows = csv.reader(io.StringIO((tmp_path / "out.csv").read_bytes().decode(), newline=""))
    assert head == [f"x [{unit}]", f"profile [{unit}]", f"displacement [{unit}]", "contact_pressure [pressure]"]
    fields = (solution.scene.x, solution.scene.profile, solution.displacement, solution.contact_pressure)
    np.testing.assert_array_equal(np.array(rows, dtype=float).T, fields)


def test_more_rows_than_are_written_at_a_time(tmp_path, monkeypatch, study):
    whole = tmp_path / "whole.csv", tmp_path / "parts.csv"
    export.command(export.Options(study, whole[0]))
    monkeypatch.setattr(export.csv_tables, "_BLOCK", 4)
    export.command(export.Options(study, whole[1]))
    assert whole[0].read_bytes() == whole[1].read_bytes()


def test_nothing_is_replaced_unasked(study, tmp_path, capsys):
    target = tmp_path / "out.csv"
    target.write_text("mine")
    words = ["export", str(study), "--csv", str(target)]
    assert cli.main(words) == 2
    assert target.read_text() == "mine"
    assert "out.csv exists" in capsys.readouterr().err
    assert cli.main([*words, "--overwrite"]) == 0
    assert target.read_text().startswith("contact_area [-],")
    before = study.read_bytes()
    assert cli.main(["export", str(study), "--csv", str(study), "--overwrite"]) == 2
    assert study.read_bytes() == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.csv", "study.h5"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["{study}", "--csv"], "csv has no value; allowed: a path"),
        ([], "file is missing; allowed: a path"),
        (["{folder}/none.h5"], "none.h5 does not exist"),
        ([__file__], "not one of linecontact's"),
        (["{empty}"], "holds no finished run yet"),
        (["{study}", "--csv", "{folder}/no/out.csv"], "does not exist"),
        (["{study}", "--csv", "{folder}/run.xlsx"], "run.xlsx; allowed: a name for comma-separated values, like "),
        (["{study}", "--tsv"], "option --tsv is unknown, perhaps meant as --csv"),
    ],
)
def test_bad_input_is_one_line_and_status_2(study, tmp_path, capsys, words, message):
    empty = tmp_path / "empty.h5"
    study_files.save_study(empty, StudyFile("hertz", {}, []))
    named = [word.format(study=study, folder=tmp_path, empty=empty) for word in words]
    assert cli.main(["export", *named]) == 2
    out, err = capsys.readouterr()
    assert message in err
    assert err.count("\n") == 1
    assert not out
