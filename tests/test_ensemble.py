"""Studies as tasks: through kills, failures, damage, full disks and lost workers nothing is lost, or done twice."""

import contextlib
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import BrokenExecutor, Executor, Future
from pathlib import Path
from types import SimpleNamespace

import dummy_tasks
import pytest
from dummy_tasks import Kills, Raises, Square
from linecontact.studies.files import records, study_files, writing
from linecontact.studies.runner import ensemble, executors, study, tasks

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX")

PATIENCE = 120  # seconds for what takes a second or two on an idle machine


@pytest.fixture(autouse=True)
def surroundings(tmp_path, monkeypatch):
    """Where the dummies log, for this process and its children; and what children import."""
    (tmp_path / "dummies").mkdir()
    monkeypatch.setenv("DUMMY_FOLDER", str(tmp_path / "dummies"))
    path = [str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(path))
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):  # they may change the last bit
        monkeypatch.setenv(name, "1")


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "study"


def command(todo, folder, **options):
    """The study of these tasks in this process; returns the exit status."""
    return dummy_tasks.command([dummy_tasks.plan(todo)], study.Options(folder, **{"workers": 1, **options}))


def program(todo, folder, *options):
    """The same as a program of its own."""
    plans = todo if isinstance(todo, str) else f"[plan({todo})]"
    text = "import sys, dummy_tasks; sys.exit(dummy_tasks.main(*sys.argv[1:]))"
    workers = [] if "--workers" in options else ["--workers", "1"]
    return [sys.executable, "-c", text, plans, "--folder", str(folder), *workers, *options]


def finish(arguments, **options):
    return subprocess.run(arguments, capture_output=True, text=True, timeout=PATIENCE, **options)


def begin(arguments, **options):
    return subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)


def wait_until(condition, process=None):
    """False if the process ended before."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline
        if process and process.poll() is not None:
            return False
        time.sleep(0.002)
    return True


def task_files(folder):
    """Name, content and time of every record there is; each must be whole."""
    files = {path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in (folder / "tasks").glob("*.json")}
    for content, _ in files.values():
        head, _, body = content.partition(b"\n")
        assert hashlib.sha256(body).hexdigest().encode() == head
    return files


def data(path):
    """Everything in a study's file but times."""
    file = study_files.load_study(path)
    assert file.complete
    names = sorted({name for run in file.runs for name in run if not name.startswith("seconds")})
    lines = {(line, name): v.tobytes() for line, columns in file.lines.items() for name, v in columns.items()}
    return {name: file.column(name).tobytes() for name in names}, lines, file.configuration


def begun():
    """How often each task was begun."""
    return Counter(number for number, _ in dummy_tasks.log())


# where and in what order


def test_two_processes_give_the_same_data_as_one(tmp_path):
    for workers in ("1", "2"):
        result = finish(program("real_plans()", tmp_path / workers, "--workers", workers))
        assert result.returncode == 0, result.stderr
    for plan in dummy_tasks.real_plans():
        one, two = (data(plan.path(tmp_path / workers)) for workers in ("1", "2"))
        assert one == two
        assert {"task", "contact_area_subgrid", "certificate.free_residual"} < set(one[0])
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


def test_overwrite_does_everything_again(folder):
    todo = [Square(i) for i in range(3)]
    assert command(todo, folder) == command(todo, folder, overwrite=True) == 0
    assert begun() == {0: 2, 1: 2, 2: 2}


def test_a_killed_overwrite_continues(folder):
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
    assert dummy_tasks.command(plans, study.Options(folder, workers=1)) == 0
    assert begun() == {1: 1, 2: 1, 3: 1}
    assert [run["number"] for run in study_files.load_study(folder / "other.h5").runs] == [2, 3]


def test_another_configuration_is_refused(folder, capsys):
    assert command([Square(1)], folder) == 0
    assert command([Square(2)], folder) == 2
    assert "another study, configuration or version" in capsys.readouterr().err
    assert study_files.load_study(folder / "dummy.h5").column("number") == [1]


# kills


def test_twenty_kills_lose_only_what_was_in_flight(tmp_path, folder):
    """At random moments after the first new task is begun, or after the start of the process."""
    todo, rng = [Square(i, pause=0.01) for i in range(200)], random.Random(1)
    kept, lost, kills = {}, 0, 0
    while kills < 20:
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
    if done < 200:
        assert f"continuing: {done} of 200 tasks are done" in result.stderr
    assert kept.items() <= task_files(folder).items()
    assert sum(begun().values()) == 200 + lost
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


def saves_killed_at_every_line(folder):
    """A task that failed before is done: the record afterwards and the endings of all files, line by line."""
    task, record = Square(3), Square(3).run(None)
    results = tasks.TaskFolder(folder)
    status, outcomes = None, []
    while status != 0:
        results.forget([task])
        results.save_failure(task, "reason")
        child = os.fork()
        if not child:
            kill_at_line(len(outcomes))
            results.save(task, record)
            sys.settrace(None)
            os._exit(0)
        status = os.waitpid(child, 0)[1]
        assert status in (0, signal.SIGKILL)
        outcomes.append((results.load(task), {path.suffix for path in folder.iterdir()}))
    assert len(outcomes) > 15
    assert outcomes[0][0] is None
    assert outcomes[-1][0] == record
    return outcomes


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
    """What random moments seldom hit."""
    outcomes = saves_killed_at_every_line(folder)
    found = [record for record, _ in outcomes]
    assert found == sorted(found, key=bool)  # first never there, then always
    assert {record["square"] for record in found if record} == {9}
    assert all((".json" in endings) == bool(record) for record, endings in outcomes)
    assert not any(".damaged" in endings for _, endings in outcomes)


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_killed_at_any_line_no_record_has_a_reason_of_failure_beside_it(folder):
    assert not any(record and ".failed" in endings for record, endings in saves_killed_at_every_line(folder))


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


# failures


def test_tasks_that_kill_their_workers_fail_alone(folder):
    """Four are given to two workers at first; 2 is there when 1 kills its worker, and later kills one itself, once."""
    todo = [Square(0, pause=0.2), Kills(1), Kills(2, once=True), Kills(3), *map(Square, range(4, 9))]
    result = finish(program(todo, folder, "--workers", "2"))
    assert result.returncode == 4, result.stderr
    for task in (Kills(1), Kills(3)):
        line = (
            f"linecontact: dummy: task {tasks.identity(task)} failed: its worker process died, killed or out of memory"
        )
        assert line in result.stderr.splitlines()
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


@pytest.mark.parametrize("workers", [1, 2])
def test_a_task_that_raises_fails_alone_and_is_tried_again(folder, capsys, workers):
    todo = [Square(0), Raises(1), Square(2)]
    name = tasks.identity(Raises(1))
    for attempt in (1, 2):
        assert command(todo, folder, workers=workers) == 4
        stderr = capsys.readouterr().err
        assert f"linecontact: dummy: task {name} failed: ArithmeticError: no square of 1 today\n" in stderr
        assert "Traceback" not in stderr
        assert begun() == {0: 1, 1: attempt, 2: 1}
        file = study_files.load_study(folder / "dummy.h5")
        assert not file.complete
        assert file.failures == {name: "ArithmeticError: no square of 1 today"}
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


# damage


def flipped(content, rng):
    position = rng.randrange(8 * len(content))
    damaged = bytearray(content)
    damaged[position // 8] ^= 1 << position % 8
    return bytes(damaged)


def test_damaged_records_are_set_aside_and_done_again(folder, capsys):
    """20 flipped bits, 5 files cut short, one of them to nothing; 5 are sound."""
    todo, rng = [Square(i) for i in range(30)], random.Random(2)
    assert command(todo, folder) == 0
    whole, before = data(folder / "dummy.h5"), task_files(folder)
    (folder / "dummy.h5").unlink()
    damaged = {}
    for task in todo[:25]:
        path = folder / "tasks" / f"{tasks.identity(task)}.json"
        content = path.read_bytes()
        cut = 0 if task.number == 20 else rng.randrange(len(content))
        damaged[path.name] = flipped(content, rng) if task.number < 20 else content[:cut]
        path.write_bytes(damaged[path.name])
    capsys.readouterr()
    assert command(todo, folder) == 0
    stderr = capsys.readouterr().err
    assert all(f"{name} is damaged; it is set aside as {name}.damaged" in stderr for name in damaged)
    aside = {path.name.removesuffix(".damaged"): path.read_bytes() for path in (folder / "tasks").glob("*.damaged")}
    assert aside == damaged
    assert begun() == {number: 2 if number < 25 else 1 for number in range(30)}
    after = task_files(folder)
    assert after.keys() == before.keys()
    assert all(after[name] == before[name] for name in before.keys() - damaged.keys())
    assert data(folder / "dummy.h5") == whole


def test_a_damaged_study_is_collected_again_from_the_records(folder, capsys, monkeypatch):
    todo, rng = [Square(i) for i in range(4)], random.Random(3)
    assert command(todo, folder) == 0
    monkeypatch.setattr(Square, "run", None)
    path, aside = folder / "dummy.h5", folder / "dummy.h5.damaged"
    content, whole = path.read_bytes(), data(path)
    cuts = [b"", content[:1], content[:-1], content[: rng.randrange(len(content))], bytes(len(content))]
    for damaged in (*cuts, *(flipped(content, rng) for _ in range(10))):
        path.write_bytes(damaged)
        capsys.readouterr()
        assert command(todo, folder) == 0
        if aside.exists():
            assert aside.read_bytes() == damaged
            assert "dummy.h5 is damaged; it is set aside as dummy.h5.damaged" in capsys.readouterr().err
            aside.unlink()
        else:  # HDF5 does not use this byte
            assert damaged not in cuts
        assert data(path) == whole


def test_any_flipped_bit_in_a_study_is_noticed(folder):
    """In a process of its own: without a checksum of the bytes, one of about 1000 flips ends or hangs it."""
    assert command([Square(i) for i in range(4)], folder) == 0
    check = """
import sys
from pathlib import Path
from linecontact.studies.files import study_files, writing
path = Path(sys.argv[1])
content = path.read_bytes()
for position in range(0, len(content), 19):
    damaged = bytearray(content)
    damaged[position] ^= 1 << position % 8
    path.write_bytes(damaged)
    try:
        study_files.load_study(path)
    except writing.DamagedError:
        continue
    sys.exit(f"byte {position}")
"""
    result = finish([sys.executable, "-c", check, str(folder / "dummy.h5")])
    assert result.returncode == 0, result.stderr


# disks, locks and permissions


@pytest.mark.parametrize(("limit", "kept"), [(100, 0), (4096, 6)], ids=["record", "study"])
def test_a_full_disk_is_one_line_and_status_2(folder, limit, kept):
    """No record fits under the first limit; all of them, but not the collected study, under the second."""
    import resource

    todo = [Square(i) for i in range(6)]
    limits = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))}
    result = finish(program(todo, folder), **limits)
    assert result.returncode == 2, result.stderr
    assert result.stderr.startswith(f"linecontact: file {folder}")
    assert "could not be written" in result.stderr
    assert result.stderr.count("\n") == 1
    assert len(task_files(folder)) == kept
    assert not (folder / "dummy.h5").exists()
    assert not list(folder.rglob("*.part"))
    assert command(todo, folder) == 0
    assert data(folder / "dummy.h5")[2] == {"numbers": [0, 1, 2, 3, 4, 5]}
    assert sum(begun().values()) == (6 if kept else 7)


@pytest.mark.parametrize(
    "case",
    [
        "folder",
        "records",
        "damaged",
        "overwrite",
    ],
)
def test_a_read_only_folder_is_one_line_and_status_2(folder, case):
    unprivileged = []
    if os.geteuid() == 0:  # whom permissions do not bind, unless this is taken away
        unprivileged = ["setpriv", "--bounding-set", "-dac_override"]
        if not shutil.which("setpriv") or subprocess.run([*unprivileged, "true"], check=False).returncode:
            pytest.skip("permissions do not bind root")
    todo = [Square(i) for i in range(2)]
    assert command(todo, folder) == 0
    whole = data(folder / "dummy.h5")
    files = task_files(folder)
    closed = folder if case == "folder" else folder / "tasks"
    if case == "records":
        todo.append(Square(2))
        (folder / "dummy.h5").unlink()
    elif case == "damaged":
        (folder / "dummy.h5").unlink()
        (folder / "tasks" / next(iter(files))).write_bytes(b"damaged")
    closed.chmod(0o555)
    try:
        result = finish([*unprivileged, *program(todo, folder, *(["--overwrite"] if case == "overwrite" else []))])
    finally:
        closed.chmod(0o755)
    assert result.returncode == 2, result.stderr
    lines = [line for line in result.stderr.splitlines() if not line.startswith("continuing")]
    assert len(lines) == 1, result.stderr
    assert lines[0].startswith("linecontact: ")
    assert str(folder) in lines[0]
    assert "ermission denied" in lines[0]
    assert command(todo, folder) == 0
    if case != "records":
        assert data(folder / "dummy.h5") == whole


def test_the_second_run_in_a_folder_is_refused_until_the_first_is_gone(folder, capsys):
    todo = [Square(0), Square(1, gate="gate")]
    first = begin(program(todo, folder))
    try:
        assert wait_until(lambda: len(begun()) == 2, first)
        assert command(todo, folder) == 2
        stderr = capsys.readouterr().err
        assert stderr.startswith(f"linecontact: folder {folder} is in use by another run")
        assert stderr.count("\n") == 1
    finally:
        first.kill()
        first.wait(PATIENCE)
    assert begun() == {0: 1, 1: 1}
    dummy_tasks.note("gate")
    assert command(todo, folder) == 0
    assert begun() == {0: 1, 1: 2}


# clusters


@pytest.fixture
def cluster(tmp_path):
    """A Dask scheduler and its address, with three workers of one thread each."""
    pytest.importorskip("distributed")
    file = tmp_path / "scheduler.json"
    options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(file)]
    worker += ["--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    commands = [[sys.executable, "-m", "distributed.cli.dask_scheduler", *options, "--scheduler-file", str(file)]]
    commands += [[*worker, "--local-directory", str(tmp_path / f"worker{i}")] for i in range(3)]
    processes = []
    try:
        for line in commands:
            processes.append(begin(line, cwd=tmp_path))
            assert wait_until(lambda: file.exists() and file.read_text().endswith("}"), processes[0])
        yield SimpleNamespace(scheduler=processes[0], address=json.loads(file.read_text())["address"])
    finally:
        for process in processes:
            process.kill()
        for process in processes:
            process.wait(PATIENCE)


def test_a_cluster_that_loses_a_worker_gives_the_same_data(cluster, tmp_path, folder):
    """When ten tasks are done and all three workers are at tasks that wait, one of them is killed."""
    todo = [Square(i, gate="gate" if i >= 10 else "") for i in range(30)]
    process = begin(program(todo, folder, "--scheduler", cluster.address))
    try:
        assert wait_until(lambda: len(task_files(folder)) == 10 and len(begun()) == 13, process)
        lost, worker = dummy_tasks.log()[-1]
        os.kill(worker, signal.SIGKILL)
        dummy_tasks.note("gate")
        assert process.wait(PATIENCE) == 0
    finally:
        process.kill()
        process.wait(PATIENCE)
    # Dask may also do again what the dead worker had done and still held
    assert lost in [number for number, times in begun().items() if times > 1]
    assert command(todo, tmp_path / "alone") == 0
    assert data(folder / "dummy.h5") == data(tmp_path / "alone" / "dummy.h5")


@pytest.mark.slow
def test_a_lost_scheduler_is_status_2_and_continues(cluster, folder):
    """The client waits for 10 seconds that it comes back."""
    todo = [Square(i, gate="gate" if i >= 3 else "") for i in range(9)]
    process = subprocess.Popen(program(todo, folder, "--scheduler", cluster.address), stderr=subprocess.PIPE, text=True)
    try:
        assert wait_until(lambda: len(task_files(folder)) == 3 and len(begun()) == 6, process)
        cluster.scheduler.kill()
        _, stderr = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
        process.wait(PATIENCE)
    assert process.returncode == 2
    assert "gone" in stderr.splitlines()[-1]
    assert not list((folder / "tasks").glob("*.failed"))
    dummy_tasks.note("gate")
    assert command(todo, folder) == 0
    assert all(begun()[number] == 1 for number in range(3))


@pytest.mark.parametrize(
    "address",
    [
        "nonsense://127.0.0.1",
        "127.0.0.1",
        pytest.param("tcp://127.0.0.1:1", marks=pytest.mark.slow),
    ],
)
def test_a_wrong_scheduler_is_one_line_and_status_2(folder, address):
    """Where nobody listens, the client waits for 10 seconds."""
    pytest.importorskip("distributed")
    result = finish(program([Square(0)], folder, "--scheduler", address))
    assert result.returncode == 2, result.stderr
    assert result.stderr.startswith((f"linecontact: scheduler is {address}", f"linecontact: scheduler is '{address}'"))
    assert result.stderr.count("\n") == 1
