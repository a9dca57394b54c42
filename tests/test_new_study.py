"""A study of two tasks with a figure, added from this file alone by one line in the list, and run in every way.

And what is said to a study that does not offer what it must.
"""

import math
import subprocess
import sys
from dataclasses import asdict, dataclass, replace
from types import ModuleType, SimpleNamespace
from typing import ClassVar

import pytest
from linecontact.solver import Layer, Scene, solve
from linecontact.studies import STUDIES
from linecontact.studies.command_line import main as cli
from linecontact.studies.files import records, study_files
from linecontact.studies.runner import study
from linecontact.studies.runner.run import run_study
from linecontact.studies.runner.study import Plan, Study


@dataclass(frozen=True)
class Options(study.Options):
    """The contact area on a thick and on a thin layer: data, figure, sentence."""

    num_points: int = 64
    """Grid points."""


@dataclass(frozen=True)
class Task:
    """One solve."""

    kind: ClassVar[str] = "layer of the new study"

    thickness: float
    num_points: int

    def run(self, report):
        """The solution's record."""
        return records.run_record(solve(Scene(Layer(self.thickness), num_points=self.num_points), progress=report))


def plans(options):
    runs = [Task(thickness, options.num_points) for thickness in (math.inf, 0.01)]
    return [Plan("layers", {"num_points": options.num_points}, runs)]


def report(files, _):
    areas = files["layers"].column("contact_area_subgrid")
    return [f"a_r = {areas[0]:.3f} on the thick layer, {areas[1]:.3f} on the thin one."]


def draw(path):
    from linecontact.studies.figures.style import load
    from matplotlib import pyplot as plt

    file = load(path)
    figure, axes = plt.subplots()
    axes.plot(file.column("reduced_thickness"), file.column("contact_area_subgrid"), "o")
    return {"": figure}


STUDY = Study(name="layers", options=Options, plans=plans, report=report, draw=draw)


def command(options):
    return run_study(STUDY, options)


@pytest.fixture
def listed(monkeypatch):
    monkeypatch.setitem(STUDIES, "layers", __name__)


@pytest.mark.usefixtures("listed")
def test_a_new_study_runs_is_stored_drawn_and_finished(tmp_path, capsys):
    assert study.find("layers") is STUDY
    options = Options(folder=tmp_path, workers=1, num_points=128)
    assert command(options) == 0
    shown = capsys.readouterr().out
    assert "a_r = 0.101 on the thick layer, 0.0" in shown
    assert f"Data: {tmp_path / 'layers.h5'}" in shown
    file = study_files.load_study(tmp_path / "layers.h5")
    assert (file.kind, file.configuration, file.complete) == ("layers", {"num_points": 128}, True)
    assert list(file.column("scene.thickness")) == [math.inf, 0.01]
    assert len(list((tmp_path / "tasks").glob("*.json"))) == 2
    assert (tmp_path / "layers.png").stat().st_size > 5000
    assert command(options) == 0
    assert "Finished before; nothing computed." in capsys.readouterr().out
    with pytest.raises(ValueError, match=r"other options \(num_points\)"):
        command(replace(options, num_points=64))


@pytest.mark.usefixtures("listed")
def test_the_file_of_a_new_study_is_plotted(tmp_path, capsys):
    file = study_files.StudyFile("layers", {}, [asdict(Task(0.1, 64)) | {"status": "converged"}])
    file.runs[0] |= {"reduced_thickness": 1.0, "contact_area_subgrid": 0.1}
    study_files.save_study(tmp_path / "some.h5", file)
    assert cli.main(["plot", str(tmp_path / "some.h5")]) == 0
    assert capsys.readouterr().out.split() == [str(tmp_path / f"some{form}") for form in (".png", ".pdf")]


def test_a_file_of_a_study_that_is_not_listed_is_one_line(tmp_path, capsys):
    study_files.save_study(tmp_path / "some.h5", study_files.StudyFile("layers", {}, [{"status": "converged"}]))
    assert cli.main(["plot", str(tmp_path / "some.h5")]) == 2
    assert "is of kind 'layers'; allowed: hertz, sharp," in capsys.readouterr().err


def offered(**changes):
    return {"name": "layers", "options": Options, "plans": plans, "report": report, "draw": draw} | changes


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"report": None}, "study 'layers' does not offer report; allowed: a study with name, options, plans, report"),
        ({"plans": None, "draw": None}, "study 'layers' does not offer plans, draw; allowed: "),
        ({"draw": "layers.png"}, "draw of study layers is 'layers.png'; allowed: a function"),
        ({"options": SimpleNamespace}, "options of study layers is .*; allowed: a subclass of `Options`"),
    ],
)
def test_a_study_that_does_not_offer_what_it_must_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        Study(**offered(**changes))
    given = {name: value for name, value in offered(**changes).items() if value is not None}
    with pytest.raises(ValueError, match=message):
        Study(**given)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"plans": lambda _: None}, "result of plans of study layers is None; allowed: one `Plan` or more"),
        ({"plans": lambda _: []}, r"result of plans of study layers is \[\]"),
        ({"report": lambda *_: None}, "result of report of study layers is None; allowed: tables and texts, in a list"),
        ({"report": lambda *_: "done"}, "result of report of study layers is 'done'"),
    ],
)
def test_a_study_that_gives_something_else_is_refused(tmp_path, changes, message):
    with pytest.raises(ValueError, match=message):
        run_study(Study(**offered(**changes)), Options(folder=tmp_path, workers=1))


@pytest.mark.parametrize(
    ("module", "message"),
    [
        ({}, "study layers: module made_up does not offer STUDY, Options, command; allowed: a module with STUDY"),
        ({"STUDY": STUDY, "command": command}, "study layers: module made_up does not offer Options; allowed: "),
        ({"STUDY": 3, "Options": Options, "command": command}, "STUDY of module made_up is 3; allowed: a `Study`"),
    ],
)
def test_a_module_that_does_not_offer_a_study_is_refused(monkeypatch, module, message):
    made_up = ModuleType("made_up")
    vars(made_up).update(module)
    monkeypatch.setitem(sys.modules, "made_up", made_up)
    monkeypatch.setitem(STUDIES, "layers", "made_up")
    with pytest.raises(ValueError, match=message):
        study.find("layers")


def test_a_study_that_nobody_listed_is_refused():
    with pytest.raises(ValueError, match="study is 'layers'; allowed: hertz, sharp, "):
        study.find("layers")


def test_every_study_in_the_list_offers_what_it_must():
    for name in STUDIES:
        found = study.find(name)
        assert found.name == name
        assert found.options.__doc__
        module = sys.modules[STUDIES[name]]
        assert module.Options is found.options
        assert callable(module.command)


def test_studies_import_no_more_than_they_need():
    """Until they draw, compute or open a file, matplotlib, Warp and h5py are not needed."""
    text = (
        "import sys\n"
        "from linecontact.studies import STUDIES\n"
        "from linecontact.studies.runner.study import find\n"
        "for name in STUDIES:\n"
        "    find(name)\n"
        "print(*{'matplotlib', 'warp', 'h5py'} & sys.modules.keys())\n"
    )
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (0, "\n"), done.stderr
