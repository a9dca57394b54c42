"""Studies that are killed or interrupted at any moment: nothing is lost, or done twice."""

import contextlib
import os
import random
import signal
import sys
import time
from pathlib import Path

import dummy_tasks
import pytest
from dummy_tasks import Square
from linecontact.studies.files import records, writing
from linecontact.studies.runner import ensemble, executors, tasks
from running import PATIENCE, begin, begun, command, data, finish, program, task_files, wait_until

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX"),
    pytest.mark.usefixtures("dummies"),
]


def test_kills_lose_only_what_was_in_flight(tmp_path, folder):
    """At random moments after the first new task is begun, or after the start of the process."""
    todo, rng = [Square(i, pause=0.01) for i in range(100)], random.Random(1)
    kept, lost, kills = {}, 0, 0
    while kills < 5:
        known = len(dummy_tasks.log())
        process = begin(program(todo, folder))
        try:
            if kills % 5 and not wait_until(lambda known=known: len(dummy_tasks.log()) > known, process):
                break  # finished already, on a machine that leaves this process waiting
            time.sleep(rng.uniform(0, 0.1 if kills % 5 else 0.5))
        finally:
            process.kill()
            process.wait(PATIENCE)
        kills += 1
        now = task_files(folder)
        assert kept.items() <= now.items()  # neither lost nor written again
        gone = len(dummy_tasks.log()) - known - (len(now) - len(kept))
        assert 0 <= gone <= 1
        kept, lost = now, lost + gone
    done = len(task_files(folder))
    result = finish(program(todo, folder))
    assert result.returncode == 0, result.stderr
    if done < 100:
        assert f"continuing: {done} of 100 tasks are done" in result.stderr
    assert kept.items() <= task_files(folder).items()
    assert sum(begun().values()) == 100 + lost
    assert command(todo, tmp_path / "undisturbed") == 0
    assert data(folder / "dummy.h5") == data(tmp_path / "undisturbed" / "dummy.h5")


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="sees Linux' processes only")
def test_a_kill_ends_the_workers_and_frees_the_folder(folder):
    """Two workers have done four tasks, are at two that wait, and the next two are submitted."""
    todo = [Square(i, gate="gate" if i > 3 else "") for i in range(10)]
    process = begin(program(todo, folder, "--workers", "2"))
    try:
        assert wait_until(lambda: len(begun()) == 6 and len(task_files(folder)) == 4, process)
    finally:
        process.kill()
        process.wait(PATIENCE)
    workers = {worker for _, worker in dummy_tasks.log()}
    assert len(workers) == 2
    assert process.pid not in workers
    wait_until(lambda: not any(alive(worker) for worker in workers))
    kept = task_files(folder)
    dummy_tasks.note("gate")
    assert command(todo, folder) == 0
    assert kept.items() <= task_files(folder).items()
    assert begun() == {number: 2 if number in (4, 5) else 1 for number in range(10)}


def alive(process):
    """Neither gone nor a zombie that nobody waits for."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def kill_at_line(number):
    """Kill this process at this line, counted from now on, within the modules that write records."""
    left = number

    def trace(frame, event, _):
        nonlocal left
        if frame.f_code.co_filename in (writing.__file__, records.__file__, tasks.__file__):
            left -= event == "line"
            if left < 0:
                os.kill(os.getpid(), signal.SIGKILL)
        return trace

    sys.settrace(trace)


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_killed_at_any_line_a_record_is_there_whole_or_not_at_all(folder):
    """A moment that random ones seldom hit. The task has failed before: its record follows on that."""
    task, record = Square(3), Square(3).run(None)
    results, found, status = tasks.TaskFolder(folder), [], None
    while status != 0:
        results.forget([task])
        results.save_failure(task, "reason")
        child = os.fork()
        if not child:
            kill_at_line(len(found))
            results.save(task, record)
            sys.settrace(None)
            os._exit(0)
        status = os.waitpid(child, 0)[1]
        assert status in (0, signal.SIGKILL)
        found.append(results.load(task))
        endings = {path.suffix for path in folder.iterdir()}
        assert ".damaged" not in endings
        assert (".json" in endings) == bool(found[-1])
        assert not (found[-1] and ".failed" in endings)
    assert len(found) > 15
    whole = found.index(record)
    assert whole > 0  # first never there, then always
    assert found == [None] * whole + [record] * (len(found) - whole)


def test_half_written_files_are_removed_by_the_next_run(folder):
    (folder / "tasks").mkdir(parents=True)
    left = [folder / ".dummy.h5.abc.part", folder / "tasks" / ".0123456789abcdef.json.abc.part"]
    for path in left:
        path.write_bytes(b"half")
    assert command([Square(1)], folder) == 0
    assert not any(path.exists() for path in left)


def test_a_signal_that_interrupts_another_s_handler():
    """It waited for ever for a lock that the other held."""

    def give_up(*_):
        raise TimeoutError

    def send_another(frame, event, _):
        nonlocal moment
        if event in ("call", "return") and moment >= 0:
            moment -= 1
            if moment < 0:
                signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGALRM, give_up)
    ignored = signal.signal(signal.SIGINT, signal.default_int_handler)  # perhaps, in the background of a script
    signal.alarm(10)
    executor = executors.Processes(1, None)
    try:
        for after in range(12):  # calls and returns
            moment = after
            with ensemble._flag_for_ctrl_c(executor) as interrupted, contextlib.suppress(KeyboardInterrupt):
                try:
                    sys.setprofile(send_another)
                    signal.raise_signal(signal.SIGINT)
                finally:
                    sys.setprofile(None)
            assert interrupted.is_set
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
        signal.signal(signal.SIGINT, ignored)
