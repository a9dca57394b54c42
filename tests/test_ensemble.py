"""Studies as tasks: where and in what order they are done, and what becomes of tasks that fail."""

import json
import os
import re
from concurrent.futures import BrokenExecutor, Executor, Future

import dummy_tasks
import pytest
from dummy_tasks import Kills, Raises, Square
from linecontact.studies.files import study_files
from linecontact.studies.runner import ensemble, executors, tasks
from linecontact.studies.runner.study import Options
from running import PATIENCE, begin, begun, command, data, finish, program, task_files, wait_until

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX"),
    pytest.mark.usefixtures("dummies"),
]


# where and in what order


def test_two_processes_give_the_same_data_as_one(tmp_path):
    for workers in ("1", "2"):
        result = finish(program("real_plans()", tmp_path / workers, "--workers", workers))
        assert result.returncode == 0, result.stderr
    for plan in dummy_tasks.real_plans():
        one, two = (data(plan.path(tmp_path / workers)) for workers in ("1", "2"))
        assert one == two
        assert {"task", "contact_area_subgrid", "certificate.equilibrium_residual"} < set(one[0])
        assert one[1]
    assert task_files(tmp_path / "1").keys() == task_files(tmp_path / "2").keys()


def test_a_finished_study_does_nothing(folder, capsys, monkeypatch):
    todo = [Square(i) for i in range(3)]
    assert command(todo, folder) == 0
    before = (folder / "dummy.h5").stat().st_mtime_ns
    monkeypatch.setattr(ensemble, "perform", None)
    monkeypatch.setattr(Square, "run", None)
    capsys.readouterr()
    assert command(todo, folder) == 0
    assert "Finished before; nothing computed." in capsys.readouterr().out
    assert (folder / "dummy.h5").stat().st_mtime_ns == before


def test_a_killed_overwrite_continues(folder):
    """It does everything again, but nothing a third time that it had done."""
    todo = [Square(0), Square(1, gate="gate")]
    gate = dummy_tasks.note("gate")
    assert command(todo, folder) == 0
    gate.unlink()
    process = begin(program(todo, folder, "--overwrite"))
    try:
        assert wait_until(lambda: begun() == {0: 2, 1: 2}, process)
    finally:
        process.kill()
        process.wait(PATIENCE)
    dummy_tasks.note("gate")
    assert command(todo, folder) == 0
    assert begun() == {0: 2, 1: 3}


def test_a_refused_overwrite_removes_nothing(folder):
    todo = [Square(0), Square(1)]
    assert command(todo, folder) == 0
    kept, whole = task_files(folder), data(folder / "dummy.h5")
    assert command(todo, folder, overwrite=True, workers=0) == 2
    assert task_files(folder) == kept
    assert data(folder / "dummy.h5") == whole


def test_a_task_in_two_studies_is_done_once(folder):
    plans = [dummy_tasks.plan([Square(1), Square(2)]), dummy_tasks.plan([Square(2), Square(3)], "other")]
    assert dummy_tasks.command(plans, Options(folder, workers=1)) == 0
    assert begun() == {1: 1, 2: 1, 3: 1}
    assert [run["number"] for run in study_files.load_study(folder / "other.h5").runs] == [2, 3]


def test_another_configuration_is_refused(folder, capsys):
    assert command([Square(1)], folder) == 0
    assert command([Square(2)], folder) == 2
    assert "holds results made with other options (numbers); allowed: --folder" in capsys.readouterr().err
    assert study_files.load_study(folder / "dummy.h5").column("number") == [1]


# failures


def test_tasks_that_kill_their_workers_fail_alone(folder):
    """Four are given to two workers at first; 2 is there when 1 kills its worker, and later kills one itself, once."""
    todo = [Square(0, pause=0.2), Kills(1), Kills(2, once=True), Kills(3), *map(Square, range(4, 9))]
    result = finish(program(todo, folder, "--workers", "2"))
    assert result.returncode == 4, result.stderr
    for task in (Kills(1), Kills(3)):
        why = f"its worker process died, killed or out of memory ({task})"
        assert f"linecontact: dummy: task {tasks.identity(task)} failed: {why}" in result.stderr.splitlines()
    file = study_files.load_study(folder / "dummy.h5")
    assert [run["number"] for run in file.runs] == [0, 2, 4, 5, 6, 7, 8]
    assert file.failures.keys() == {tasks.identity(Kills(1)), tasks.identity(Kills(3))}
    failed = {path.stem: json.loads(path.read_text())["reason"] for path in (folder / "tasks").glob("*.failed")}
    assert failed == file.failures


def test_a_run_whose_every_worker_dies_gives_up(folder):
    """Rather than starting two processes for each of thousands of tasks."""

    class Broken(Executor):
        def submit(self, *_):
            future = Future()
            future.set_exception(BrokenExecutor())
            return future

    run = ensemble.Ensemble([Square(i) for i in range(200)], tasks.TaskFolder(folder))
    with pytest.raises(executors.LostError, match="tasks in a row lost their worker"):
        run.run(Broken)
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (None, "None (not flat)"),
        ({"a": 1j}, "{'a': 1j} (Object of type complex is not JSON serializable)"),
        ({"rows": [{"a": None}]}, "{'rows': [{'a': None}]} (not flat)"),
    ],
)
def test_what_is_no_record_is_named(folder, capsys, monkeypatch, given, why):
    monkeypatch.setattr(Square, "run", lambda *_: given)
    assert command([Square(1, gate="g" * 1000)], folder) == 4
    line = capsys.readouterr().err
    said = f"run of the task gave {why}; allowed: a flat record of numbers, texts and lists"
    assert f" failed: ValueError: {said}" in line
    assert re.search(r"\(Square\(number=1, pause=0.0, gate='g+\.\.\.g+'\)\)\n$", line)
    assert len(line) < 600


@pytest.mark.parametrize("workers", [1, 2])
def test_a_task_that_raises_fails_alone_and_is_tried_again(folder, capsys, workers):
    todo = [Square(0), Raises(1), Square(2)]
    name = tasks.identity(Raises(1))
    for attempt in (1, 2):
        assert command(todo, folder, workers=workers) == 4
        stderr = capsys.readouterr().err
        line = re.search(rf"(?m)^linecontact: dummy: task {name} failed: (.*)$", stderr)
        why = r"ArithmeticError: no square of 1 today, in line \d+ of .*dummy_tasks.py \(Raises\(number=1, .*\)\)"
        assert re.fullmatch(why, line[1])
        assert "Traceback" not in stderr
        assert begun() == {0: 1, 1: attempt, 2: 1}
        file = study_files.load_study(folder / "dummy.h5")
        assert not file.complete
        assert file.failures == {name: line[1]}
        assert [run["number"] for run in file.runs] == [0, 2]
        (failed,) = (folder / "tasks").glob("*.failed")
        assert json.loads(failed.read_text())["reason"] == file.failures[name]
        assert failed.stem == name
    dummy_tasks.note("mended")
    assert command(todo, folder) == 0
    assert not list((folder / "tasks").glob("*.failed"))
    assert begun() == {0: 1, 1: 3, 2: 1}
    file = study_files.load_study(folder / "dummy.h5")
    assert file.complete
    assert not file.failures
    assert [run["number"] for run in file.runs] == [0, 1, 2]
