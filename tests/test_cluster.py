"""Studies on a Dask cluster, through the loss of workers and of the scheduler."""

import json
import os
import signal
import subprocess
import sys
from types import SimpleNamespace

import dummy_tasks
import pytest
from dummy_tasks import Square
from running import PATIENCE, begin, begun, command, data, finish, program, task_files, wait_until

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX"),
    pytest.mark.usefixtures("dummies"),
]


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
    ["nonsense://127.0.0.1", "127.0.0.1", pytest.param("tcp://127.0.0.1:1", marks=pytest.mark.slow)],
)
def test_a_wrong_scheduler_is_one_line_and_status_2(folder, address):
    """Where nobody listens, the client waits for 10 seconds."""
    pytest.importorskip("distributed")
    result = finish(program([Square(0)], folder, "--scheduler", address))
    assert result.returncode == 2, result.stderr
    assert result.stderr.startswith((f"linecontact: scheduler is {address}", f"linecontact: scheduler is '{address}'"))
    assert result.stderr.count("\n") == 1
